//! The property for the model checker: a path formula without past operators, in the PRISM language.
//!
//! A time becomes a number of steps by the declared duration of a step; without one, or if it is not
//! a whole number of steps, there is no property, and the reason is given. The probability is that
//! of a run meeting the whole requirement: `P>=0.95 [ whole ]`, not that of each response. (FRET's
//! probabilistic requirements put the probability inside, around the timed response; A. Mavridou and
//! others, "Automated formalization of probabilistic requirements from structured natural language",
//! 2025.) A requirement without a probability is one with `P>=1`.

use temporal::formula::{Formula, Interval};
use temporal::ltl::{Ltl, StepBound};

use super::build::Numbering;
use super::frame::Frame;
use super::{NotExpressible, check, whole_steps};
use crate::expression::is_name;
use crate::sentence::{Amount, Comparison, Duration, Sentence, Timing};

/// What a sentence needs to become a property.
#[derive(Clone, Copy)]
pub struct Model<'m> {
    /// The duration of a step in seconds, if it is declared.
    pub step_secs: Option<f64>,
    /// The model's text for a proposition, such as `"near"` (a label) or `(x=3)`; `None` if the
    /// model cannot express it. [`label_of_name`] makes labels of plain names.
    pub proposition: &'m dyn Fn(&str) -> Option<String>,
}

/// The label `"name"` for a plain name; nothing for any other text.
#[must_use]
pub fn label_of_name(text: &str) -> Option<String> {
    is_name(text).then(|| format!("\"{text}\""))
}

/// A sentence as a property in the PRISM language.
#[derive(Clone, Debug, PartialEq)]
pub struct Property {
    /// The path formula.
    pub path: String,
    /// The path formula as a tree over the numbers of [`Property::propositions`].
    pub ltl: Ltl,
    /// The model's texts of the propositions, by number.
    pub propositions: Vec<String>,
    /// What is required of the probability: the sign and the value, in text.
    pub bound: (Comparison, String),
}

impl Property {
    /// The question for the probability: `P=? [ path ]`.
    #[must_use]
    pub fn query(&self) -> String {
        format!("P=? [ {} ]", self.path)
    }

    /// The requirement: `P>=0.95 [ path ]`.
    #[must_use]
    pub fn requirement(&self) -> String {
        format!("P{}{} [ {} ]", self.bound.0.sign(), self.bound.1, self.path)
    }
}

/// The property of a sentence.
///
/// ```
/// use requirement_lang::compile::property::{Model, label_of_name, property};
/// use requirement_lang::{Context, parse};
/// let text = "Whenever cond, the robot shall with probability at least 95 % within 2 s satisfy resp";
/// let sentence = parse(text, &Context::default()).into_result().unwrap();
/// let model = Model { step_secs: Some(0.1), proposition: &label_of_name };
/// let text = property(&sentence, &model)?.requirement();
/// assert_eq!(text, r#"P>=0.95 [ G ("cond" => (F<=20 "resp")) ]"#);
///
/// let untimed = Model { step_secs: None, ..model };
/// assert!(property(&sentence, &untimed).is_err());
/// # Ok::<(), requirement_lang::compile::NotExpressible>(())
/// ```
///
/// # Errors
/// [`NotExpressible`] if the sentence has no meaning, or none in steps or in the model.
pub fn property(sentence: &Sentence, model: &Model<'_>) -> Result<Property, NotExpressible> {
    let (formula, propositions) = path(sentence, model, Frame::without_past)?;
    let bound = match &sentence.probability {
        Some(probability) => (probability.comparison, probability.decimal.clone()),
        None => (Comparison::AtLeast, "1".to_owned()),
    };
    Ok(Property {
        path: text(&formula, &propositions),
        ltl: ltl(&formula),
        propositions,
        bound,
    })
}

/// A formula made from the frame of a sentence in steps, and the model's propositions.
pub(super) fn path(
    sentence: &Sentence,
    model: &Model<'_>,
    make: impl FnOnce(&Frame) -> Formula,
) -> Result<(Formula, Vec<String>), NotExpressible> {
    check(sentence)?;
    let sentence = in_steps(sentence, model.step_secs)?;
    let mut numbering = Numbering::default();
    let formula = make(&Frame::new(&sentence, &mut numbering));
    let mut propositions = Vec::with_capacity(numbering.atoms.len());
    for atom in numbering.atoms {
        match (model.proposition)(&atom.text) {
            Some(text) => propositions.push(text),
            None => return Err(NotExpressible::Proposition { text: atom.text }),
        }
    }
    Ok((formula, propositions))
}

fn in_steps(sentence: &Sentence, step_secs: Option<f64>) -> Result<Sentence, NotExpressible> {
    let mut sentence = sentence.clone();
    for stage in &mut sentence.stages {
        if let Timing::Within(duration) | Timing::For(duration) | Timing::After(duration) =
            &mut stage.timing
        {
            *duration = Duration {
                amount: Amount::Steps(whole_steps(duration, step_secs)?),
                ..duration.clone()
            };
        }
    }
    Ok(sentence)
}

/// The bound of an interval in steps.
fn bound(interval: &Interval) -> StepBound {
    // Bounds come from whole numbers below 2^32.
    StepBound {
        lower: interval.low.value as u64,
        upper: interval.high.map(|high| high.value as u64),
    }
}

/// The formula as a tree of the model checker's logic. The frame without past has no other operators.
fn ltl(formula: &Formula) -> Ltl {
    let both = |left: &Formula, right: &Formula| (Box::new(ltl(left)), Box::new(ltl(right)));
    match formula {
        Formula::True => Ltl::True,
        Formula::Atom(atom) => Ltl::Ap(atom.0),
        Formula::Not(inner) => Ltl::negate(ltl(inner)),
        Formula::And(all) => (all.iter().map(ltl)).reduce(Ltl::and).unwrap_or(Ltl::True),
        Formula::Or(all) => (all.iter().map(ltl)).reduce(Ltl::or).unwrap_or(Ltl::False),
        Formula::Implies(left, right) => Ltl::implies(ltl(left), ltl(right)),
        Formula::Iff(left, right) => Ltl::iff(ltl(left), ltl(right)),
        Formula::Next(inner) => Ltl::next(ltl(inner)),
        Formula::Eventually(interval, inner) => Ltl::Finally(Box::new(ltl(inner)), bound(interval)),
        Formula::Always(interval, inner) => Ltl::Globally(Box::new(ltl(inner)), bound(interval)),
        Formula::Until(interval, left, right) => {
            let (left, right) = both(left, right);
            Ltl::Until(left, right, bound(interval))
        }
        Formula::WeakUntil(interval, left, right) => {
            let (left, right) = both(left, right);
            Ltl::WeakUntil(left, right, bound(interval))
        }
        Formula::Release(interval, left, right) => {
            let (left, right) = both(left, right);
            Ltl::Release(left, right, bound(interval))
        }
        Formula::False
        | Formula::Previous(_)
        | Formula::Once(..)
        | Formula::Historically(..)
        | Formula::Since(..)
        | Formula::Rise(_)
        | Formula::Fall(_) => Ltl::False,
    }
}

/// The formula in the PRISM language; everything but atoms is in parentheses.
pub(super) fn text(formula: &Formula, propositions: &[String]) -> String {
    let operand = |inner: &Formula| match inner {
        Formula::True | Formula::False | Formula::Atom(_) => text(inner, propositions),
        inner => format!("({})", text(inner, propositions)),
    };
    let joined = |all: &[Formula], sign: &str| {
        let texts: Vec<String> = all.iter().map(operand).collect();
        texts.join(sign)
    };
    let binary = |left: &Formula, sign: &str, right: &Formula| {
        format!("{} {sign} {}", operand(left), operand(right))
    };
    match formula {
        Formula::True => "true".to_owned(),
        Formula::Atom(atom) => propositions.get(atom.0).cloned().unwrap_or_default(),
        Formula::Not(inner) => format!("!{}", operand(inner)),
        Formula::And(all) => joined(all, " & "),
        Formula::Or(all) => joined(all, " | "),
        Formula::Implies(left, right) => binary(left, "=>", right),
        Formula::Iff(left, right) => binary(left, "<=>", right),
        Formula::Next(inner) => format!("X {}", operand(inner)),
        Formula::Eventually(interval, inner) => format!("F{} {}", bound(interval), operand(inner)),
        Formula::Always(interval, inner) => format!("G{} {}", bound(interval), operand(inner)),
        Formula::Until(interval, left, right) => {
            binary(left, &format!("U{}", bound(interval)), right)
        }
        Formula::WeakUntil(interval, left, right) => {
            binary(left, &format!("W{}", bound(interval)), right)
        }
        Formula::Release(interval, left, right) => {
            binary(left, &format!("R{}", bound(interval)), right)
        }
        Formula::False
        | Formula::Previous(_)
        | Formula::Once(..)
        | Formula::Historically(..)
        | Formula::Since(..)
        | Formula::Rise(_)
        | Formula::Fall(_) => "false".to_owned(),
    }
}
