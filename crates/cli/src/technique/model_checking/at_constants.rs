//! A requirement's probability with other values for some constants.

use super::answer::{answer, explore};
use super::{Compiled, MAX_STATES, unplaced};
use crate::problem::Problem;
use crate::study::Method;
use prism_lang::{Constants, Number, Value};

impl Compiled<'_> {
    /// The probability of the subject with identifier `id`, by the sound
    /// method; `None` if this model does not express it.
    pub fn probability_at(
        &self,
        id: &str,
        constants: &[(String, f64)],
        cancel: &(dyn Fn() -> bool + Sync),
    ) -> Result<Option<f64>, Problem> {
        let mut questions = self.questions.iter();
        let question = questions.find(|q| q.subject.id() == id && q.missing.is_none());
        let Some(question) = question.filter(|q| q.opportunity.is_none()) else {
            return Ok(None);
        };
        let mut overrides = Constants::new();
        for (name, value) in constants {
            overrides.set(
                name.clone(),
                Value::Double(Number::from_approximate(*value)),
            );
        }
        let model = prism_lang::resolve_with(&self.tree, &Constants::new(), &overrides)
            .map_err(|found| unplaced(&found))?;
        let space = explore::<f64>(&self.source, &model, MAX_STATES, cancel)?;
        let property = self.property(&model, question.property)?;
        let answer = answer(&property, Method::Sound, &space, None, cancel)?;
        Ok(Some(answer.value))
    }
}
