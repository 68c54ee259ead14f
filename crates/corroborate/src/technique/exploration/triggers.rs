//! What triggers each requirement, as places of the formal model to which a
//! test is to lead.

use super::plan::Plan;
use requirement_lang::Sentence;
use requirement_lang::expression::Expression;
use requirement_lang::sentence::ScopeKind;
use study::{Rule, Study, SubjectForm};

/// A trigger, with all that it triggers.
#[derive(Clone, Debug, PartialEq)]
pub struct Trigger {
    /// What triggers, in the study's words.
    pub text: String,
    /// The requirements and failure modes that it triggers.
    pub of: Vec<String>,
    /// Its meaning to the model, or why it has none.
    pub model: Result<String, String>,
}

impl Trigger {
    /// What it is, in words.
    pub fn name(&self) -> String {
        format!("trigger of {}: {}", self.of.join(", "), self.text)
    }
}

/// The triggers of all requirements and failure modes that have a monitor,
/// each once.
pub fn triggers(study: &Study, plan: &Plan) -> Vec<Trigger> {
    let mut all: Vec<Trigger> = Vec::new();
    for form in &study.forms.subjects {
        let Some((text, model)) = trigger_of(study, plan, form) else {
            continue;
        };
        let id = form.subject.id().to_owned();
        match all.iter_mut().find(|known| known.text == text) {
            Some(known) => known.of.push(id),
            None => all.push(Trigger {
                text,
                of: vec![id],
                model,
            }),
        }
    }
    all
}

fn trigger_of(
    study: &Study,
    plan: &Plan,
    form: &SubjectForm,
) -> Option<(String, Result<String, String>)> {
    let meaning = |word: &str| {
        let found = plan.meaning_in_model(study, word);
        found.ok_or_else(|| format!("`{word}` has no meaning for the model"))
    };
    match &form.monitor.as_ref()?.rule {
        Rule::Staged(spec) => Some((spec.when.clone(), meaning(&spec.when))),
        Rule::Formula(rule) => {
            let text = rule.trigger_text.clone();
            match &form.sentence {
                Some(sentence) if form.monitor.as_ref().is_some_and(|m| m.from_sentence) => {
                    Some(of_sentence(&sentence.tree, &meaning))
                }
                _ => Some((
                    text.unwrap_or_else(|| rule.text.clone()),
                    Err("it is written as a formula, whose trigger is not a state".into()),
                )),
            }
        }
    }
}

/// The condition, in the mode of the scope; where there is no condition, the
/// mode itself.
fn of_sentence(
    sentence: &Sentence,
    meaning: &dyn Fn(&str) -> Result<String, String>,
) -> (String, Result<String, String>) {
    let condition = sentence.condition.as_ref().map(|c| c.triggering());
    let mode = sentence.scope.mode.clone();
    let expression = match (sentence.scope.kind, condition) {
        (ScopeKind::Global, condition) => condition.unwrap_or(Expression::True),
        (ScopeKind::In, None) => mode,
        (ScopeKind::In, Some(condition)) => Expression::And(vec![mode, condition]),
        (ScopeKind::NotIn, None) => mode.negation(),
        (ScopeKind::NotIn, Some(condition)) => Expression::And(vec![mode.negation(), condition]),
        _ => {
            let reason = "whether its scope applies depends on the way and not on a state";
            return (sentence_text(sentence), Err(reason.into()));
        }
    };
    (expression.to_string(), in_model(&expression, meaning))
}

fn sentence_text(sentence: &Sentence) -> String {
    let condition = sentence.condition.as_ref();
    condition.map_or_else(
        || sentence.scope.mode.to_string(),
        |c| c.expression.to_string(),
    )
}

/// An expression in the model's words.
fn in_model(
    expression: &Expression,
    meaning: &dyn Fn(&str) -> Result<String, String>,
) -> Result<String, String> {
    let joined = |all: &[Expression], operator: &str| {
        let parts = all.iter().map(|one| in_model(one, meaning));
        let parts = parts.collect::<Result<Vec<_>, _>>()?;
        Ok(format!("({})", parts.join(operator)))
    };
    let pair = |a: &Expression, b: &Expression, operator: &str| {
        let (a, b) = (in_model(a, meaning)?, in_model(b, meaning)?);
        Ok(format!("({a} {operator} {b})"))
    };
    match expression {
        Expression::True => Ok("true".into()),
        Expression::False => Ok("false".into()),
        Expression::Atom(atom) => Ok(format!("({})", meaning(&atom.text)?)),
        Expression::Not(inner) => Ok(format!("!({})", in_model(inner, meaning)?)),
        Expression::And(all) => joined(all, " & "),
        Expression::Or(all) => joined(all, " | "),
        Expression::Implies(a, b) => pair(a, b, "=>"),
        Expression::Iff(a, b) => pair(a, b, "<=>"),
        Expression::Missing => Err("its sentence is incomplete".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use requirement_lang::{Context, parse};

    fn trigger(sentence: &str) -> (String, Result<String, String>) {
        let tree = parse(sentence, &Context::default()).tree;
        of_sentence(&tree, &|word| match word {
            "unheard" => Err("unheard of".into()),
            word => Ok(format!("{word}=1")),
        })
    }

    #[test]
    fn a_sentence_gives_the_states_in_which_it_is_triggered() {
        let model = |sentence: &str| trigger(sentence).1;
        let of = |text: &str| Ok(text.to_owned());
        assert_eq!(
            model("When near, the robot shall immediately satisfy slow."),
            of("(near=1)")
        );
        assert_eq!(
            model("While lifting, when near & !seen, the robot shall eventually satisfy slow."),
            of("((lifting=1) & ((near=1) & !((seen=1))))")
        );
        assert_eq!(
            model("While lifting, the robot shall always satisfy slow."),
            of("(lifting=1)")
        );
        assert_eq!(model("The robot shall always satisfy slow."), of("true"));
        assert_eq!(
            model("When unheard, the robot shall immediately satisfy slow."),
            Err("unheard of".into())
        );
    }
}
