//! The values of all questions at one set of constants, without uncertainty.

use super::answer::answer;
use super::{Compiled, MAX_STATES};
use diagnostic::Problem;
use evidence::Subject;
use query::explore;
use std::collections::BTreeMap;
use study::{FormText, Method};

impl Compiled<'_> {
    /// The rate of each subject by the sound method, with other values for
    /// some constants; `None` where this model cannot be asked, or has no
    /// opportunity.
    pub fn values_at(
        &self,
        constants: &[(String, f64)],
        cancel: &(dyn Fn() -> bool + Sync),
    ) -> Result<BTreeMap<Subject, Option<f64>>, Problem> {
        Ok(self.values_and_deadlocks(constants, cancel)?.0)
    }

    /// The same, and in how many states nothing can happen.
    pub fn values_and_deadlocks(
        &self,
        constants: &[(String, f64)],
        cancel: &(dyn Fn() -> bool + Sync),
    ) -> Result<(BTreeMap<Subject, Option<f64>>, usize), Problem> {
        let model = self.model_at(constants)?;
        let space = explore::<f64>(&self.source, &model, MAX_STATES, cancel)?;
        let mut known: BTreeMap<String, f64> = BTreeMap::new();
        let mut value = |text: &FormText| -> Result<f64, Problem> {
            if let Some(value) = known.get(&text.text) {
                return Ok(*value);
            }
            let property = self.property(&model, text)?;
            let value = answer(&property, Method::Sound, &space, None, cancel)?.value;
            known.insert(text.text.clone(), value);
            Ok(value)
        };
        let mut values = BTreeMap::new();
        for question in &self.questions {
            let rate = match question.missing {
                Some(_) => None,
                None => {
                    let rate = self.unless_refused(question, question.rate_at(&mut value))?;
                    rate.and_then(|(rate, _)| rate)
                }
            };
            values.insert(question.subject.clone(), rate);
        }
        Ok((values, space.deadlocks().len()))
    }
}
