//! What is known of answers when probabilities were written with so few digits that they do not sum to 1.
//!
//! *Definition.* With `--sum-roundoff X`, the probabilities `p_i` of a command that miss the sum 1 by `e <= X` are divided by their
//! sum. What was meant may be any distribution that gives the missing `e` to the outcomes in any shares (or takes away what is too
//! much): `|q_i - p_i/sum| <= e` for all of them, and for each sum of some of them. With `m` modules that move together a
//! transition's probability differs by at most `m e`.
//!
//! *Method.* The answer is that of the divided probabilities. For a `dtmc` it is bounded over all chains whose transitions are
//! within `m e` ([`IntervalModel::around`]), for the largest `e` of the model. *Guarantee.* These bounds hold for all that may be
//! meant, at each visit of a state anew. Where there are none (choices, rewards, shares of time, transitions as improbable as
//! `m e`), the answer is an estimate.

use checker::interval_model::IntervalModel;
use checker::state_space::StateSpace;
use checker::{Answer, AnswerValue, CheckError, Guarantee, Options};
use prism_lang::{NamedProperty, resolved};

/// Probabilities of a model that were divided by their sums.
pub(crate) struct Rounded {
    commands: usize,
    largest: f64,
    /// All chains that may be meant, or why they are not known.
    chains: Result<IntervalModel, String>,
}

impl Rounded {
    /// Of a model; `None` if its probabilities sum to 1. `space` explores it.
    pub fn of<E>(
        model: &resolved::Model,
        space: impl FnOnce() -> Result<StateSpace<f64>, E>,
    ) -> Result<Option<Self>, E> {
        let largest = (model.rounded.iter()).fold(0.0, |most: f64, sum| most.max(sum.excess));
        if model.rounded.is_empty() {
            return Ok(None);
        }
        let chains = match model.model_type {
            resolved::ModelType::Dtmc => {
                let radius = (largest * model.modules.len() as f64).next_up();
                IntervalModel::around(space()?, radius).map_err(|why| why.to_string())
            }
            kind => Err(format!("a {} has no such bounds", kind.keyword())),
        };
        Ok(Some(Self {
            commands: model.rounded.len(),
            largest,
            chains,
        }))
    }

    /// The answer, with no more guaranteed than holds for all that may be meant.
    pub fn carry(
        &self,
        mut answer: Answer,
        property: &NamedProperty,
        options: &Options<'_>,
    ) -> Result<Answer, CheckError> {
        let (commands, largest) = (self.commands, self.largest);
        let of = if commands == 1 { "command" } else { "commands" };
        let divided = format!(
            "the probabilities of {commands} {of} sum to 1 up to {largest:.1e} and were divided by their sum"
        );
        let bounds = match &self.chains {
            Ok(chains) => match chains.check(&property.property, options) {
                Err(CheckError::Cancelled) => return Err(CheckError::Cancelled),
                Err(why) => Err(why.to_string()),
                Ok(over_all) => joined(&answer, &over_all),
            },
            Err(why) => Err(why.clone()),
        };
        match bounds {
            Ok(guarantee) => {
                answer.guarantee = guarantee;
                let note = format!("{divided}; the answer holds wherever in them the rest belongs");
                answer.notes.push(note);
            }
            Err(why) => {
                let reason =
                    format!("{divided}, which may change the answer by an unknown amount: {why}");
                answer.guarantee = Guarantee::Estimated { reason };
            }
        }
        // It is that of one of the chains.
        (answer.complement, answer.complement_bounds) = (None, None);
        Ok(answer)
    }
}

/// What holds for an answer and for those over all chains.
fn joined(answer: &Answer, over_all: &Answer) -> Result<Guarantee, String> {
    let own = match (&answer.guarantee, &answer.value) {
        (Guarantee::Bounded { low, high }, AnswerValue::Number(_)) => (*low, *high),
        (Guarantee::Exact, AnswerValue::Truth(truth)) => {
            return match &over_all.value {
                AnswerValue::Truth(other) if other == truth => Ok(over_all.guarantee.clone()),
                _ => Err("it is not the same for all of them".to_owned()),
            };
        }
        (Guarantee::Exact, AnswerValue::Number(value)) => (*value, *value),
        (Guarantee::Exact, AnswerValue::Exact(value)) => {
            let nearest = prism_lang::rational_to_f64(value);
            (nearest.next_down(), nearest.next_up())
        }
        (Guarantee::Estimated { reason }, _) => return Err(reason.clone()),
        (Guarantee::Bounded { .. } | Guarantee::Exact | Guarantee::Statistical { .. }, _) => {
            return Err("it is not a single number".to_owned());
        }
    };
    match (&over_all.guarantee, &over_all.value) {
        (Guarantee::Bounded { low, high }, AnswerValue::Number(_)) => Ok(Guarantee::Bounded {
            low: own.0.min(*low),
            high: own.1.max(*high),
        }),
        // The same whatever is meant.
        (Guarantee::Exact, AnswerValue::Number(value)) => Ok(match own == (*value, *value) {
            true => Guarantee::Exact,
            false => Guarantee::Bounded {
                low: own.0.min(*value),
                high: own.1.max(*value),
            },
        }),
        (
            Guarantee::Bounded { .. }
            | Guarantee::Exact
            | Guarantee::Statistical { .. }
            | Guarantee::Estimated { .. },
            _,
        ) => Err("it is not a single number".to_owned()),
    }
}
