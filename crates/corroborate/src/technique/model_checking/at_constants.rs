//! A requirement's probability with other values for some constants.

use super::answer::answer;
use super::{Compiled, MAX_STATES};
use diagnostic::Problem;
use query::explore;
use study::Method;

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
        let Some(question) = question else {
            return Ok(None);
        };
        let model = self.model_at(constants)?;
        let space = explore::<f64>(&self.source, &model, MAX_STATES, cancel)?;
        let (rate, _) = question.rate_at(&mut |text| {
            let property = self.property(&model, text)?;
            Ok(answer(&property, Method::Sound, &space, None, cancel)?.value)
        })?;
        Ok(rate)
    }
}
