//! The values of all questions at one set of constants, without uncertainty.

use super::answer::{answer, explore};
use super::{Compiled, MAX_STATES};
use crate::problem::Problem;
use crate::study::{FormText, Method};
use evidence::Subject;
use std::collections::BTreeMap;

impl Compiled<'_> {
    /// The rate of each subject by the sound method, with other values for
    /// some constants; `None` where this model cannot be asked, or has no
    /// opportunity.
    pub fn values_at(
        &self,
        constants: &[(String, f64)],
        cancel: &(dyn Fn() -> bool + Sync),
    ) -> Result<BTreeMap<Subject, Option<f64>>, Problem> {
        let model = self.model_at(constants)?;
        let space = explore::<f64>(&self.source, &model, MAX_STATES, cancel)?;
        let mut known: BTreeMap<&str, f64> = BTreeMap::new();
        let mut values = BTreeMap::new();
        for question in &self.questions {
            if question.missing.is_some() {
                values.insert(question.subject.clone(), None);
                continue;
            }
            let solved = |text: &'_ FormText| -> Result<f64, Problem> {
                let property = self.property(&model, text)?;
                let answer = answer(&property, Method::Sound, &space, None, cancel)?;
                Ok(answer.value)
            };
            let mut parts = [None, None];
            let texts = [Some(question.property), question.opportunity];
            for (part, text) in parts.iter_mut().zip(texts) {
                let Some(text) = text else { continue };
                let value = match known.get(text.text.as_str()) {
                    Some(value) => *value,
                    None => solved(text)?,
                };
                known.insert(&text.text, value);
                *part = Some(value);
            }
            let value = match parts {
                [Some(occurs), Some(chance)] if chance > 0.0 => Some(occurs / chance),
                [occurs, None] => occurs,
                _ => None,
            };
            values.insert(question.subject.clone(), value);
        }
        Ok(values)
    }
}
