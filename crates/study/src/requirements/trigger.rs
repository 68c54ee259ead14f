//! What triggers a requirement, as a question to a formal model.
//!
//! # Definition
//! Traces count a requirement where its monitor was triggered. The same runs of a model are those that satisfy the path
//! formula of the trigger: what the study writes as `trigger`; else, of a monitor in stages, `F when`; of a formula `G
//! (a => b)`, `F a` (what the formula's monitor counts, [`Formula::trigger`]); of a monitor that is made from a sentence,
//! that the sentence's trigger is reached (`requirement_lang::compile::goal`); of a requirement that has neither, but a
//! property `P=? [ G (a => b) ]`, `F a` with the bound of its `G`. A failure mode is triggered by its
//! opportunity, and where none is written by what triggers its monitor.
//!
//! # Guarantee
//! A run of a model without deadlocks satisfies the formula exactly if the monitor is triggered on the run's trace of
//! propositions, as far as a proposition means the same to both.

use super::read::Reader;
use super::{FormText, SubjectForm, quoted_names};
use crate::Vocabulary;
use crate::judging_form::{JudgingForm, Rule};
use diagnostic::Problem;
use evidence::Subject;
use prism_lang::ast::{BinaryOp, Expr, ExprKind, TemporalOp};
use std::collections::BTreeSet;
use temporal::formula::{AtomText, Formula};
use toml::Spanned;

/// What triggers a requirement or failure mode, as far as a model can be asked for it.
#[derive(Clone, Debug)]
pub enum TriggerForm {
    /// Every run does, or counts as one that does.
    Always,
    /// Those that satisfy this property, which asks for a probability.
    Runs(FormText),
    /// Which do is not known to a model, for this reason.
    Unknown(String),
}

impl Reader<'_> {
    /// The trigger of a subject whose other forms are complete.
    pub(super) fn trigger(
        &self,
        form: &SubjectForm,
        written: Option<Spanned<String>>,
    ) -> Result<TriggerForm, Problem> {
        let Some(written) = written else {
            return Ok(form.monitored.clone());
        };
        let text = super::read::form_text(written);
        self.check_property_text(&text)?;
        Ok(TriggerForm::Runs(text))
    }

    /// What triggers a subject's monitor, or else its sentence.
    pub(super) fn monitored(&self, form: &SubjectForm) -> TriggerForm {
        let place = |text: String| {
            TriggerForm::Runs(FormText {
                text,
                span: form.span.clone(),
                from_sentence: true,
            })
        };
        let sentence = form.sentence.as_ref().map(|sentence| &sentence.trigger);
        let of_sentence = match &form.monitor {
            Some(monitor) if monitor.from_sentence => sentence,
            Some(_) => None,
            None => sentence,
        };
        match (of_sentence, &form.monitor) {
            (Some(Ok(text)), _) => place(text.clone()),
            (Some(Err(reason)), _) => TriggerForm::Unknown(reason.clone()),
            (None, Some(monitor)) => match of_monitor(monitor, self.vocabulary) {
                Ok(Some(path)) => place(format!("P=? [ F ({path}) ]")),
                Ok(None) => TriggerForm::Always,
                Err(reason) => TriggerForm::Unknown(reason),
            },
            (None, None) => match (&form.subject, &form.property) {
                (Subject::Requirement(_), Some(property)) => {
                    of_property(&property.text).map_or(TriggerForm::Always, place)
                }
                (Subject::Requirement(_), None) | (Subject::FailureMode(_), _) => {
                    TriggerForm::Always
                }
            },
        }
    }
}

/// That the premise of a property of the form `P=? [ G (a => b) ]` becomes true within the bound of its `G`, as a property; of
/// a conjunction, the premise that all have.
fn of_property(text: &str) -> Option<String> {
    let parsed = prism_lang::parse_properties(text);
    let property = parsed.tree.properties.first()?;
    let ExprKind::Probability {
        path,
        condition: None,
        ..
    } = &property.formula.kind
    else {
        return None;
    };
    Some(format!("P=? [ {} ]", premise(path)?))
}

fn premise(path: &Expr) -> Option<Expr> {
    match &path.kind {
        ExprKind::Temporal {
            operator: TemporalOp::Globally,
            bound,
            left: None,
            right: body,
        } => {
            let ExprKind::Binary(BinaryOp::Implies, premise, _) = &body.kind else {
                return None;
            };
            is_of_state(premise).then(|| Expr {
                kind: ExprKind::Temporal {
                    operator: TemporalOp::Finally,
                    bound: bound.clone(),
                    left: None,
                    right: premise.clone(),
                },
                span: path.span,
            })
        }
        ExprKind::Binary(BinaryOp::And, left, right) => {
            let (left, right) = (premise(left)?, premise(right)?);
            (left.to_string() == right.to_string()).then_some(left)
        }
        _ => None,
    }
}

/// Whether an expression of a property speaks of one state alone.
fn is_of_state(expr: &Expr) -> bool {
    match &expr.kind {
        ExprKind::Bool(_)
        | ExprKind::Int(_)
        | ExprKind::Double(_)
        | ExprKind::Name(_)
        | ExprKind::Label(_) => true,
        ExprKind::Unary(_, operand) => is_of_state(operand),
        ExprKind::Binary(_, left, right) => is_of_state(left) && is_of_state(right),
        ExprKind::IfThenElse(condition, then, otherwise) => [condition, then, otherwise]
            .into_iter()
            .all(|it| is_of_state(it)),
        ExprKind::Call(_, operands) => operands.iter().all(is_of_state),
        _ => false,
    }
}

/// What triggers a subject, in the words of the study: the proposition that has to become true, or the formula that a run has
/// to satisfy.
///
/// Where a trigger was written and the monitor waits for other propositions, the monitor's is said: it is what traces count.
pub(super) fn in_words(form: &SubjectForm) -> Option<String> {
    let said = match (&form.trigger, &form.monitored) {
        (TriggerForm::Runs(written), TriggerForm::Runs(monitored))
            if names(written) != names(monitored) =>
        {
            &form.monitored
        }
        (trigger, _) => trigger,
    };
    match said {
        TriggerForm::Always => None,
        // What becomes true in every run triggers nothing.
        TriggerForm::Runs(text) => text_in_words(&text.text)
            .filter(|words| *words != "F true")
            .map(str::to_owned),
        TriggerForm::Unknown(_) => match &form.monitor.as_ref()?.rule {
            Rule::Staged(spec) => Some(spec.when.clone()),
            Rule::Formula(rule) => rule.trigger_text.clone(),
        },
    }
}

/// What stands in the brackets of `P=? [ ... ]`, or the proposition that is all that it asks for.
#[must_use]
pub fn text_in_words(property: &str) -> Option<&str> {
    let (open, close) = (property.find('[')?, property.rfind(']')?);
    let path = property.get(open + 1..close)?.trim();
    Some(proposition(path).unwrap_or(path))
}

fn names(text: &FormText) -> BTreeSet<String> {
    let named = quoted_names(&text.text).into_iter();
    named.map(|(name, _)| name).collect()
}

/// The proposition of a path formula that asks for nothing but that it becomes true, such as `F ("near")`.
fn proposition(path: &str) -> Option<&str> {
    let mut inner = path.strip_prefix('F')?.trim();
    while let Some(bare) = inner.strip_prefix('(').and_then(|it| it.strip_suffix(')')) {
        inner = bare.trim();
    }
    let name = inner.strip_prefix('"')?.strip_suffix('"')?;
    (!name.contains('"')).then_some(name)
}

/// The state in which a handwritten monitor is triggered, in the language of the model; nothing if it has no trigger.
fn of_monitor(monitor: &JudgingForm, vocabulary: &Vocabulary) -> Result<Option<String>, String> {
    match &monitor.rule {
        Rule::Staged(spec) => {
            let parameters = vocabulary.signals.parameters();
            let parsed = temporal::formula::parse(&spec.when, &|name| parameters.secs(name))
                .map_err(|_| not_in_model(&spec.when))?;
            in_model(&parsed.formula, &parsed.atoms, vocabulary).map(Some)
        }
        Rule::Formula(rule) => {
            let own = rule.trigger.as_ref().or(rule.parsed.formula.trigger());
            own.map(|trigger| in_model(without_rise(trigger), &rule.parsed.atoms, vocabulary))
                .transpose()
        }
    }
}

/// Something becomes true somewhere exactly if it is true somewhere.
fn without_rise(trigger: &Formula) -> &Formula {
    match trigger {
        Formula::Rise(inner) => inner,
        other => other,
    }
}

fn not_in_model(what: &str) -> String {
    format!("the model has no meaning for `{what}`, which triggers it on traces")
}

/// A formula about one instant with the vocabulary's propositions as labels.
fn in_model(
    formula: &Formula,
    atoms: &[AtomText],
    vocabulary: &Vocabulary,
) -> Result<String, String> {
    let of = |inner: &Formula| in_model(inner, atoms, vocabulary).map(|text| format!("({text})"));
    let all = |operands: &[Formula], sign: &str| {
        let texts: Result<Vec<_>, _> = operands.iter().map(of).collect();
        Ok(texts?.join(sign))
    };
    match formula {
        Formula::True => Ok("true".into()),
        Formula::False => Ok("false".into()),
        Formula::Atom(atom) => {
            let text = atoms.get(atom.0).map_or("", |atom| atom.text.as_str());
            let bound = vocabulary.propositions.get(text);
            match bound.is_some_and(|proposition| proposition.model.is_some()) {
                true => Ok(format!("\"{text}\"")),
                false => Err(not_in_model(text)),
            }
        }
        Formula::Not(inner) => Ok(format!("!{}", of(inner)?)),
        Formula::And(operands) => all(operands, " & "),
        Formula::Or(operands) => all(operands, " | "),
        Formula::Implies(left, right) => Ok(format!("{} => {}", of(left)?, of(right)?)),
        Formula::Iff(left, right) => Ok(format!("{} <=> {}", of(left)?, of(right)?)),
        other => Err(not_in_model(&other.display(atoms).to_string())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_property_of_a_response_is_triggered_by_its_premise() {
        for (property, trigger) in [
            ("P=? [ G (\"near\" => \"slow\") ]", Some("F \"near\"")),
            (
                "P=? [ G<=8 (\"a\" & !\"b\" => (F<=2 \"c\")) ]",
                Some("F<=8 (\"a\" & !\"b\")"),
            ),
            (
                "Pmin=? [ (G (\"a\" => (X \"b\"))) & (G (\"a\" => \"c\")) ]",
                Some("F \"a\""),
            ),
            ("P=? [ (G (\"a\" => \"b\")) & (G (\"c\" => \"d\")) ]", None),
            ("P=? [ G ((F \"a\") => \"b\") ]", None),
            ("P=? [ G (\"a\" => \"b\") || F \"c\" ]", None),
            ("P=? [ F (\"a\" => \"b\") ]", None),
            ("P=? [ G \"ok\" ]", None),
        ] {
            let expected = trigger.map(|path| format!("P=? [ {path} ]"));
            assert_eq!(of_property(property), expected, "{property}");
        }
    }

    #[test]
    fn a_trigger_that_is_one_proposition_is_called_by_its_name() {
        for (path, name) in [
            ("F \"near\"", Some("near")),
            ("F ((\"near\"))", Some("near")),
            ("F (\"near\" & \"fast\")", None),
            ("F ((\"near\") | (\"fast\"))", None),
            ("F<=3 \"near\"", None),
        ] {
            assert_eq!(proposition(path), name, "{path}");
        }
    }
}
