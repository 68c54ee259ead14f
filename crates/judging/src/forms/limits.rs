//! The limits in a form: every duration and every quantity that is compared
//! with a constant, with units.

use super::path::{number_of, steps_of};
use prism_lang::ast::{BinaryOp, Expr, ExprKind};
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
                ..duration_limit(secs, duration.text.clone())
            });
        }
    }
    for text in sentence.tree.propositions() {
        limits.extend(of_proposition(study, text));
    }
    limits
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
            let mut limits: Vec<Limit> = spec.then.iter().filter_map(deadline).collect();
            for name in spec.propositions() {
                limits.extend(of_proposition(study, name));
            }
            limits
        }
        Rule::Formula(rule) => {
            let mut limits = Vec::new();
            durations(&rule.parsed, &rule.parsed.formula, &mut limits);
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
        step_bounds(study, &property.formula, &mut limits);
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
        ..duration_limit(secs, format!("{secs} s"))
    })
}

/// The ends of all intervals but 0, which limits nothing.
fn durations(parsed: &Parsed, formula: &Formula, limits: &mut Vec<Limit>) {
    if let Some(interval) = formula.interval() {
        let ends = [Some(interval.low), interval.high];
        for bound in ends.into_iter().flatten() {
            if bound.unit == TimeUnit::Seconds && bound.value > 0.0 {
                limits.push(Limit {
                    awaited: awaited(parsed, formula),
                    ..duration_limit(bound.value, format!("{} s", bound.value))
                });
            }
        }
    }
    for operand in formula.operands() {
        durations(parsed, operand, limits);
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

fn step_bounds(study: &Study, expr: &Expr, limits: &mut Vec<Limit>) {
    if let ExprKind::Temporal {
        bound: Some(bound), ..
    } = &expr.kind
        && let Some(step_secs) = study.about.model.step_secs()
        && let Some((low, high)) = steps_of(bound)
    {
        for steps in [Some(low), high].into_iter().flatten() {
            if steps > 0.0 {
                let text = format!("{steps} steps");
                limits.push(duration_limit(steps * step_secs, text));
            }
        }
    }
    for operand in operands(expr) {
        step_bounds(study, operand, limits);
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
            {
                limits.push(Limit {
                    boundary: Boundary::of(operator, format!("{variable} {operator} {number}")),
                    awaited: None,
                    text: format!("{variable} {number}"),
                    si_value: number * unit.si_value(),
                    number,
                    dimension: Some(unit.dimension()),
                    parameter: None,
                    compared: None,
                    proposition: Some(name.to_owned()),
                });
            }
        }
    }
    for operand in operands(expr) {
        of_variables(study, operand, name, limits);
    }
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
