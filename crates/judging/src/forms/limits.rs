//! The limits in a form: every duration and every quantity that is compared
//! with a constant, with units.

use super::path::{number_of, steps_of};
use super::roles::{Role, Standing};
use prism_lang::ast::{BinaryOp, Comparison, Expr, ExprKind, StepBound, TemporalOp, UnaryOp};
use requirement_lang::expression::Expression;
use requirement_lang::sentence::{Amount, Timing};
use study::{JudgingForm, Rule, SentenceForm, Study, is_name, quoted_names};
use temporal::formula::{AtomId, Formula, Parsed, TimeUnit};
use temporal::monitor::Stage;
use trace::units::Dimension;
use trace::{ComparisonOperator, Measure, ThresholdOrigin};

/// A limit in a form.
#[derive(Clone, Debug, PartialEq)]
pub struct Limit {
    /// The constant as it is written.
    pub text: String,
    /// Its value in SI units; in the unit of the signals if it has none.
    pub si_value: f64,
    /// Its value in the unit in which it is written.
    pub number: f64,
    /// What it measures; `None` for a number without a unit.
    pub dimension: Option<Dimension>,
    /// The parameter whose value it is, if it is one by name.
    pub parameter: Option<String>,
    /// What is compared with it; `None` for a duration.
    pub compared: Option<Compared>,
    /// The proposition in which it stands, if in one.
    pub proposition: Option<String>,
    /// Of a duration: the proposition that is waited for, or that lasts, if
    /// it is one.
    pub awaited: Option<String>,
    /// To which side the limit itself belongs, and the comparison that says so.
    pub boundary: Option<Boundary>,
    /// Of a duration: what it says of what it limits.
    pub role: Role,
    /// Of a duration: how many equal ones in the same role it stands behind, so that they add up.
    pub behind: usize,
    /// The same written otherwise: of whole numbers, `x < 31` is `x <= 30`.
    pub twin: Option<Box<Limit>>,
}

/// To which side of a limit the limit itself belongs: `x < c` and its negation
/// `x >= c` say above, `x <= c` and `x > c` below.
#[derive(Clone, Debug, PartialEq)]
pub struct Boundary {
    /// Whether it belongs to the side above.
    pub is_above: bool,
    /// The comparison, as it is written.
    pub text: String,
}

impl Boundary {
    fn of(operator: ComparisonOperator, text: String) -> Option<Self> {
        let is_above = match operator {
            ComparisonOperator::Less | ComparisonOperator::GreaterEqual => true,
            ComparisonOperator::LessEqual | ComparisonOperator::Greater => false,
            ComparisonOperator::Equal | ComparisonOperator::NotEqual => return None,
        };
        Some(Self { is_above, text })
    }
}

/// A quantity that is compared with a limit.
#[derive(Clone, Debug, PartialEq)]
pub struct Compared {
    /// As it is written.
    pub quantity: String,
    /// Of which kind it is.
    pub measure: Measure,
    /// The signals that it reads.
    pub signals: Vec<String>,
}

impl Limit {
    /// Whether it limits time itself, and no quantity.
    pub fn is_duration(&self) -> bool {
        self.compared.is_none() && self.dimension == Some(Dimension::TIME)
    }
}

/// The limits of a requirement's sentence.
pub fn of_sentence(study: &Study, sentence: &SentenceForm) -> Vec<Limit> {
    let mut limits = Vec::new();
    for stage in &sentence.tree.stages {
        if let Some(duration) = stage.timing.duration()
            && let Some(secs) = secs_of(study, duration.amount)
        {
            let is_parameter = study.parameters.values.get(&duration.text).is_some();
            let within = Boundary {
                is_above: false,
                text: format!("within {}", duration.text),
            };
            limits.push(Limit {
                parameter: is_parameter.then(|| duration.text.clone()),
                awaited: match &stage.response {
                    Expression::Atom(atom) => Some(atom.text.clone()),
                    _ => None,
                },
                boundary: matches!(stage.timing, Timing::Within(_)).then_some(within),
                role: role_of(&stage.timing),
                ..duration_limit(secs, duration.text.clone())
            });
        }
    }
    for text in sentence.tree.propositions() {
        limits.extend(of_proposition(study, text));
    }
    limits
}

/// What the duration of a stage says.
fn role_of(timing: &Timing) -> Role {
    match timing {
        Timing::Within(_) => Role::Latest,
        Timing::For(_) => Role::Lasting,
        Timing::After(_) => Role::Earliest,
        Timing::Immediately
        | Timing::Next
        | Timing::Eventually
        | Timing::Always
        | Timing::Never
        | Timing::Until(_)
        | Timing::Before(_) => Role::Unknown,
    }
}

/// A duration in seconds; steps have the declared duration of the models'.
pub fn secs_of(study: &Study, amount: Amount) -> Option<f64> {
    match amount {
        Amount::Secs(secs) => Some(secs),
        Amount::Steps(count) => Some(f64::from(count) * study.about.model.step_secs()?),
        Amount::Missing => None,
    }
}

/// The limits by which traces are judged.
pub fn of_judging(study: &Study, form: &JudgingForm) -> Vec<Limit> {
    match &form.rule {
        Rule::Staged(spec) => {
            let mut standing = Standing::default();
            let mut limits: Vec<Limit> = Vec::new();
            for mut limit in spec.then.iter().filter_map(deadline) {
                limit.behind = standing.count(limit.role, limit.si_value);
                standing.is_behind(limit.role, limit.si_value);
                limits.push(limit);
            }
            for name in spec.propositions() {
                limits.extend(of_proposition(study, name));
            }
            limits
        }
        Rule::Formula(rule) => {
            let mut limits = Vec::new();
            let parsed = &rule.parsed;
            durations(parsed, &parsed.formula, &Standing::default(), &mut limits);
            for atom in &rule.parsed.atoms {
                limits.extend(of_proposition(study, &atom.text));
            }
            limits
        }
    }
}

/// The limits of a property: bounds in steps, and what its labels compare.
pub fn of_property(study: &Study, text: &str) -> Vec<Limit> {
    let mut limits = Vec::new();
    for property in prism_lang::parse_properties(text).tree.properties {
        step_bounds(study, &property.formula, &Standing::default(), &mut limits);
    }
    for (name, _) in quoted_names(text) {
        let proposition = study.vocabulary.propositions.get(&name);
        if let Some(binding) = proposition.and_then(|p| p.model.as_ref()) {
            let labelled = format!("P=? [ F ({}) ]", binding.text);
            for property in prism_lang::parse_properties(&labelled).tree.properties {
                of_variables(study, &property.formula, &name, &mut limits);
            }
        }
    }
    limits
}

fn duration_limit(secs: f64, text: String) -> Limit {
    Limit {
        text,
        si_value: secs,
        number: secs,
        dimension: Some(Dimension::TIME),
        parameter: None,
        compared: None,
        proposition: None,
        awaited: None,
        boundary: None,
        role: Role::Unknown,
        behind: 0,
        twin: None,
    }
}

fn deadline(stage: &Stage) -> Option<Limit> {
    let (awaited, secs) = match stage {
        Stage::WaitFor {
            proposition,
            within_secs,
        } => (proposition, *within_secs),
        Stage::Hold {
            until, within_secs, ..
        } => (until, *within_secs),
        Stage::Assert { .. } => return None,
    };
    let secs = secs?;
    Some(Limit {
        awaited: Some(awaited.clone()),
        role: Role::Latest,
        ..duration_limit(secs, format!("{secs} s"))
    })
}

/// The ends of all intervals but 0, which limits nothing.
fn durations(parsed: &Parsed, formula: &Formula, standing: &Standing, limits: &mut Vec<Limit>) {
    let mut inner = standing.clone();
    if let Some(interval) = formula.interval() {
        let [low, high] = roles(formula);
        let ends = [(Some(interval.low), low), (interval.high, high)];
        for (bound, plain) in ends {
            let secs = bound.filter(|it| it.unit == TimeUnit::Seconds && it.value > 0.0);
            let Some(secs) = secs.map(|it| it.value) else {
                continue;
            };
            let role = standing.role(plain);
            inner.is_behind(role, secs);
            limits.push(Limit {
                awaited: awaited(parsed, formula),
                role,
                behind: standing.count(role, secs),
                ..duration_limit(secs, format!("{secs} s"))
            });
        }
    }
    match formula {
        Formula::Not(operand) => durations(parsed, operand, &inner.negated(), limits),
        Formula::Implies(left, right) => {
            durations(parsed, left, &inner.negated(), limits);
            durations(parsed, right, &inner, limits);
        }
        Formula::Iff(left, right) => {
            durations(parsed, left, &inner.either(), limits);
            durations(parsed, right, &inner.either(), limits);
        }
        other => {
            for operand in other.operands() {
                durations(parsed, operand, &inner, limits);
            }
        }
    }
}

/// What the ends of a formula's window say where nothing is negated.
fn roles(formula: &Formula) -> [Role; 2] {
    match formula {
        Formula::Eventually(..) | Formula::Until(..) => [Role::Earliest, Role::Latest],
        Formula::Always(..) => [Role::From, Role::Lasting],
        _ => [Role::Unknown; 2],
    }
}

/// The proposition that `eventually` waits for or that `always` has last.
fn awaited(parsed: &Parsed, formula: &Formula) -> Option<String> {
    let (Formula::Eventually(_, operand) | Formula::Always(_, operand)) = formula else {
        return None;
    };
    match operand.as_ref() {
        Formula::Atom(AtomId(place)) => parsed.atoms.get(*place).map(|atom| atom.text.clone()),
        _ => None,
    }
}

/// Whether a formula counts samples somewhere, whose duration is not known.
pub fn counts_samples(formula: &Formula) -> bool {
    let own = formula.interval().is_some_and(|interval| {
        let ends = [Some(interval.low), interval.high];
        let mut ends = ends.into_iter().flatten();
        ends.any(|end| end.unit != TimeUnit::Seconds && end.value > 0.0)
    });
    own || formula.operands().into_iter().any(counts_samples)
}

/// The limits of a proposition, or of a predicate that is written in its place.
pub fn of_proposition(study: &Study, text: &str) -> Vec<Limit> {
    let Ok(predicate) = study.vocabulary.signals.predicate(text) else {
        return Vec::new();
    };
    let comparisons = predicate.comparisons().into_iter();
    comparisons
        .map(|comparison| {
            let threshold = comparison.threshold;
            let (quantity, operator) = (&comparison.quantity, comparison.operator);
            let written = format!("{quantity} {operator} {}", threshold.text);
            Limit {
                role: Role::Unknown,
                behind: 0,
                twin: None,
                boundary: Boundary::of(operator, written),
                awaited: None,
                si_value: threshold.si_value.unwrap_or(threshold.number),
                number: threshold.number,
                dimension: threshold.dimension(),
                parameter: match threshold.origin {
                    ThresholdOrigin::Parameter(name) => Some(name),
                    _ => None,
                },
                text: threshold.text,
                compared: Some(Compared {
                    quantity: comparison.quantity,
                    measure: comparison.measure,
                    signals: comparison.signals.into_iter().collect(),
                }),
                proposition: is_name(text).then(|| text.to_owned()),
            }
        })
        .collect()
}

/// Whether a property has bounds of steps or time that are not written as numbers, or stands within a filter: their size is
/// not known here.
pub(super) fn has_other_bounds(text: &str) -> bool {
    any_part(text, |part| match part {
        ExprKind::Temporal {
            bound: Some(bound), ..
        } => steps_of(bound).is_none(),
        ExprKind::Filter(_) => true,
        _ => false,
    })
}

/// Whether this holds of any part of a property.
pub(super) fn any_part(text: &str, holds: fn(&ExprKind) -> bool) -> bool {
    fn any(expr: &Expr, holds: fn(&ExprKind) -> bool) -> bool {
        holds(&expr.kind) || operands(expr).into_iter().any(|it| any(it, holds))
    }
    let properties = prism_lang::parse_properties(text).tree.properties;
    let mut properties = properties.iter();
    properties.any(|property| any(&property.formula, holds))
}

fn step_bounds(study: &Study, expr: &Expr, standing: &Standing, limits: &mut Vec<Limit>) {
    let mut inner = standing.clone();
    if let ExprKind::Temporal {
        operator,
        bound: Some(bound),
        right,
        ..
    } = &expr.kind
        && let Some(step_secs) = study.about.model.step_secs()
        && let Some((low, high)) = steps_of(bound)
    {
        let [of_low, of_high] = roles_of(*operator);
        for (steps, plain) in [(Some(low), of_low), (high, of_high)] {
            let Some(steps) = steps.filter(|steps| *steps > 0.0) else {
                continue;
            };
            let (role, secs) = (standing.role(plain), steps * step_secs);
            inner.is_behind(role, secs);
            let limit = |secs: f64, steps: f64| Limit {
                awaited: match &right.kind {
                    ExprKind::Label(name) => Some(name.clone()),
                    _ => None,
                },
                role,
                ..duration_limit(secs, format!("{steps} steps"))
            };
            // What lasts through all steps before k lasts until k.
            let until = excluded_end(bound).filter(|_| role == Role::Lasting);
            limits.push(Limit {
                behind: standing.count(role, secs),
                twin: until.map(|end| Box::new(limit(end * step_secs, end))),
                ..limit(secs, steps)
            });
        }
    }
    match &expr.kind {
        ExprKind::Unary(UnaryOp::Not, operand) => {
            step_bounds(study, operand, &inner.negated(), limits);
        }
        ExprKind::Binary(BinaryOp::Implies, left, right) => {
            step_bounds(study, left, &inner.negated(), limits);
            step_bounds(study, right, &inner, limits);
        }
        ExprKind::Binary(BinaryOp::Iff, ..)
        | ExprKind::IfThenElse(..)
        | ExprKind::Probability { bound: Some(_), .. } => {
            for operand in operands(expr) {
                step_bounds(study, operand, &inner.either(), limits);
            }
        }
        _ => {
            for operand in operands(expr) {
                step_bounds(study, operand, &inner, limits);
            }
        }
    }
}

/// What the ends of an operator's window say where nothing is negated.
fn roles_of(operator: TemporalOp) -> [Role; 2] {
    match operator {
        TemporalOp::Finally | TemporalOp::Until => [Role::Earliest, Role::Latest],
        TemporalOp::Globally => [Role::From, Role::Lasting],
        TemporalOp::WeakUntil | TemporalOp::Release | TemporalOp::Next => [Role::Unknown; 2],
    }
}

/// The end of a bound that leaves it out.
fn excluded_end(bound: &StepBound) -> Option<f64> {
    match bound {
        StepBound::Compare(Comparison::Less, expr) => number_of(expr),
        StepBound::Compare(
            Comparison::LessEqual | Comparison::GreaterEqual | Comparison::Greater,
            _,
        )
        | StepBound::Exactly(_)
        | StepBound::Between(..) => None,
    }
}

/// Comparisons of a variable that has a unit with a number.
fn of_variables(study: &Study, expr: &Expr, name: &str, limits: &mut Vec<Limit>) {
    if let ExprKind::Binary(operator, left, right) = &expr.kind
        && matches!(
            operator,
            BinaryOp::Less | BinaryOp::LessEqual | BinaryOp::Greater | BinaryOp::GreaterEqual
        )
    {
        for (variable, number, operator) in [
            (left, right, comparison_of(*operator)),
            (right, left, turned(comparison_of(*operator))),
        ] {
            if let ExprKind::Name(variable) = &variable.kind
                && let Some(number) = number_of(number)
                && let Some(unit) = study.about.model.unit_of(variable)
                // That a time is above 0 limits nothing, as in windows.
                && !(unit.dimension() == Dimension::TIME && number <= 0.0)
            {
                let limit = |number: f64, operator: ComparisonOperator| Limit {
                    boundary: Boundary::of(operator, format!("{variable} {operator} {number}")),
                    proposition: Some(name.to_owned()),
                    number,
                    dimension: Some(unit.dimension()),
                    ..duration_limit(number * unit.si_value(), format!("{variable} {number}"))
                };
                let twin = otherwise(operator, number);
                limits.push(Limit {
                    twin: twin.map(|(operator, number)| Box::new(limit(number, operator))),
                    ..limit(number, operator)
                });
            }
        }
    }
    for operand in operands(expr) {
        of_variables(study, operand, name, limits);
    }
}

/// A comparison of a variable, which counts, written with the whole number beside: `x < 31` is `x <= 30`.
fn otherwise(operator: ComparisonOperator, number: f64) -> Option<(ComparisonOperator, f64)> {
    use ComparisonOperator::{Equal, Greater, GreaterEqual, Less, LessEqual, NotEqual};
    if number.fract() != 0.0 {
        return None;
    }
    Some(match operator {
        Less => (LessEqual, number - 1.0),
        LessEqual => (Less, number + 1.0),
        Greater => (GreaterEqual, number + 1.0),
        GreaterEqual => (Greater, number - 1.0),
        Equal | NotEqual => return None,
    })
}

fn comparison_of(operator: BinaryOp) -> ComparisonOperator {
    match operator {
        BinaryOp::Less => ComparisonOperator::Less,
        BinaryOp::LessEqual => ComparisonOperator::LessEqual,
        BinaryOp::Greater => ComparisonOperator::Greater,
        BinaryOp::GreaterEqual => ComparisonOperator::GreaterEqual,
        BinaryOp::NotEqual => ComparisonOperator::NotEqual,
        _ => ComparisonOperator::Equal,
    }
}

/// The comparison with its sides exchanged.
fn turned(operator: ComparisonOperator) -> ComparisonOperator {
    match operator {
        ComparisonOperator::Less => ComparisonOperator::Greater,
        ComparisonOperator::LessEqual => ComparisonOperator::GreaterEqual,
        ComparisonOperator::Greater => ComparisonOperator::Less,
        ComparisonOperator::GreaterEqual => ComparisonOperator::LessEqual,
        same => same,
    }
}

fn operands(expr: &Expr) -> Vec<&Expr> {
    match &expr.kind {
        ExprKind::Unary(_, inner) => vec![inner],
        ExprKind::Binary(_, left, right) => vec![left, right],
        ExprKind::IfThenElse(first, second, third) => vec![first, second, third],
        ExprKind::Call(_, arguments) => arguments.iter().collect(),
        ExprKind::Probability {
            path, condition, ..
        } => [Some(path), condition.as_ref()]
            .into_iter()
            .flatten()
            .map(AsRef::as_ref)
            .collect(),
        ExprKind::Temporal { left, right, .. } => left
            .iter()
            .map(AsRef::as_ref)
            .chain([right.as_ref()])
            .collect(),
        _ => Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::has_other_bounds;

    #[test]
    fn a_bound_that_is_no_number_is_of_unknown_size() {
        for text in [
            "P=? [ F<=K \"done\" ]",
            "P=? [ F<=3*10 \"done\" ]",
            "filter(avg, P=? [ F<=30 \"done\" ], s=1)",
        ] {
            assert!(has_other_bounds(text), "{text}");
        }
        for text in ["P=? [ F<=30 \"done\" ]", "P=? [ F \"done\" ]"] {
            assert!(!has_other_bounds(text), "{text}");
        }
    }
}
