//! The limits in a form: every duration and every quantity that is compared
//! with a constant, with units.

use super::path::{number_of, steps_of};
use crate::study::{JudgingForm, Rule, SentenceForm, Study, is_name, quoted_names};
use prism_lang::ast::{BinaryOp, Expr, ExprKind};
use requirement_lang::sentence::Amount;
use temporal::formula::{Formula, TimeUnit};
use temporal::monitor::Stage;
use trace::units::Dimension;
use trace::{Measure, ThresholdOrigin};

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

/// The limits of a requirement's sentence.
pub fn of_sentence(study: &Study, sentence: &SentenceForm) -> Vec<Limit> {
    let mut limits = Vec::new();
    for stage in &sentence.tree.stages {
        if let Some(duration) = stage.timing.duration()
            && let Some(secs) = secs_of(study, duration.amount)
        {
            let is_parameter = study.parameters.values.get(&duration.text).is_some();
            limits.push(Limit {
                parameter: is_parameter.then(|| duration.text.clone()),
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
            durations(&rule.parsed.formula, &mut limits);
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
    }
}

fn deadline(stage: &Stage) -> Option<Limit> {
    match stage {
        Stage::WaitFor { within_secs, .. } | Stage::Hold { within_secs, .. } => {
            within_secs.map(|secs| duration_limit(secs, format!("{secs} s")))
        }
        Stage::Assert { .. } => None,
    }
}

/// The ends of all intervals but 0, which limits nothing.
fn durations(formula: &Formula, limits: &mut Vec<Limit>) {
    if let Some(interval) = formula.interval() {
        let ends = [Some(interval.low), interval.high];
        for bound in ends.into_iter().flatten() {
            if bound.unit == TimeUnit::Seconds && bound.value > 0.0 {
                limits.push(duration_limit(bound.value, format!("{} s", bound.value)));
            }
        }
    }
    for operand in formula.operands() {
        durations(operand, limits);
    }
}

fn of_proposition(study: &Study, text: &str) -> Vec<Limit> {
    let Ok(predicate) = study.vocabulary.signals.predicate(text) else {
        return Vec::new();
    };
    let comparisons = predicate.comparisons().into_iter();
    comparisons
        .map(|comparison| {
            let threshold = comparison.threshold;
            Limit {
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
        for (variable, number) in [(left, right), (right, left)] {
            if let ExprKind::Name(variable) = &variable.kind
                && let Some(number) = number_of(number)
                && let Some(unit) = study.about.model.unit_of(variable)
            {
                limits.push(Limit {
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

fn operands(expr: &Expr) -> Vec<&Expr> {
    match &expr.kind {
        ExprKind::Unary(_, inner) => vec![inner],
        ExprKind::Binary(_, left, right) => vec![left, right],
        ExprKind::IfThenElse(first, second, third) => vec![first, second, third],
        ExprKind::Call(_, arguments) => arguments.iter().collect(),
        ExprKind::Probability { path, .. } => vec![path],
        ExprKind::Temporal { left, right, .. } => left
            .iter()
            .map(AsRef::as_ref)
            .chain([right.as_ref()])
            .collect(),
        _ => Vec::new(),
    }
}
