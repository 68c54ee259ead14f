//! Test goals: what a test generator should bring about, in the model and in the simulation.
//!
//! A test is worth its time only if the requirement's trigger is reached, so that is the first goal;
//! the second is to break the requirement. In a model both are questions for a path (a witness of
//! `F trigger`; a counterexample of the requirement). In simulation both are numbers to improve: the
//! robustness of the trigger is to become positive, then that of the requirement negative
//! (robustness-guided falsification: Y. Annpureddy and others, "S-TaLiRo: a tool for temporal logic
//! falsification for hybrid systems", TACAS 2011).

use temporal::formula::{Formula, Parsed};

use super::build::{ALL, Numbering, eventually, not};
use super::frame::Frame;
use super::property::{Model, path, text};
use super::{NotExpressible, check};
use crate::expression::Expression;
use crate::sentence::{Sentence, Stage, Timing};

/// Goals for a generator that searches the model.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelGoal {
    /// The probability that the trigger is reached: `P=? [ F trigger ]`.
    pub trigger_probability: String,
    /// Whether any run reaches the trigger: `P>0 [ F trigger ]`. A witness is a test.
    pub witness: String,
    /// The probability that the requirement is broken: `P=? [ !(requirement) ]`. A path that does
    /// is a test.
    pub falsify: String,
}

/// Goals for a generator that searches by simulation.
#[derive(Clone, Debug, PartialEq)]
pub struct TraceGoal {
    /// Holds of a trace in which the trigger is reached. Its robustness is to be made positive
    /// first.
    pub reach: Parsed,
    /// The requirement. Its robustness is to be made negative.
    pub objective: Parsed,
}

/// The goals in the model.
///
/// # Errors
/// [`NotExpressible`] if the sentence has no meaning, or none in steps or in the model.
pub fn model_goal(sentence: &Sentence, model: &Model<'_>) -> Result<ModelGoal, NotExpressible> {
    let (reached, propositions) = path(sentence, model, Frame::trigger_reached)?;
    let (whole, _) = path(sentence, model, Frame::without_past)?;
    let reached = text(&reached, &propositions);
    Ok(ModelGoal {
        trigger_probability: format!("P=? [ {reached} ]"),
        witness: format!("P>0 [ {reached} ]"),
        falsify: format!("P=? [ {} ]", text(&not(whole), &propositions)),
    })
}

/// The question for the probability that the trigger is reached, `P=? [ F trigger ]`, which a model may be able to answer
/// although it cannot be asked for the response, or not within its time.
///
/// # Errors
/// [`NotExpressible`] if the sentence has no meaning, or its trigger none in the model.
pub fn trigger_probability(
    sentence: &Sentence,
    model: &Model<'_>,
) -> Result<String, NotExpressible> {
    check(sentence)?;
    let trigger_alone = Sentence {
        stages: vec![Stage {
            timing: Timing::Immediately,
            response: Expression::True,
            ..sentence.stages[0].clone()
        }],
        ..sentence.clone()
    };
    let (reached, propositions) = path(&trigger_alone, model, Frame::trigger_reached)?;
    Ok(format!("P=? [ {} ]", text(&reached, &propositions)))
}

/// The goals in simulation.
///
/// # Errors
/// [`NotExpressible`] if the sentence has no meaning.
pub fn trace_goal(sentence: &Sentence) -> Result<TraceGoal, NotExpressible> {
    check(sentence)?;
    let mut numbering = Numbering::default();
    let frame = Frame::new(sentence, &mut numbering);
    let reach = eventually(ALL, without_rise(frame.trigger()));
    let objective = frame.with_past();
    let parsed = |formula| Parsed {
        formula,
        atoms: numbering.atoms.clone(),
    };
    Ok(TraceGoal {
        reach: parsed(reach),
        objective: parsed(objective),
    })
}

/// Something becomes true somewhere exactly if it is true somewhere; this is easier to search for.
fn without_rise(trigger: Formula) -> Formula {
    match trigger {
        Formula::Rise(inner) => *inner,
        other => other,
    }
}
