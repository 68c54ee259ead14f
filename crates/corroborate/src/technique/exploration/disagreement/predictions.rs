//! What the formal model predicts in contexts: it is checked anew for each set of constants, once.

use super::super::plan::{DisagreementData, Plan};
use crate::technique::model_checking::Compiled;
use diagnostic::Problem;
use host::Cancel;
use std::cell::RefCell;
use std::collections::BTreeMap;
use stimulus::{Point, Space};
use study::Study;

/// A model is checked for at most so many different contexts.
const MOST_CHECKS: usize = 3000;

/// The model's probabilities, each context's computed once.
pub struct Predictions<'a> {
    /// The ledger's entry.
    pub entry: String,
    compiled: Compiled<'a>,
    data: &'a DisagreementData,
    interrupt: &'a Cancel,
    known: RefCell<BTreeMap<Vec<u64>, f64>>,
    failed: RefCell<Option<Problem>>,
}

impl<'a> Predictions<'a> {
    /// Reads and compiles the model that the plan names.
    pub fn new(
        study: &'a Study,
        plan: &'a Plan,
        data: &'a DisagreementData,
        interrupt: &'a Cancel,
    ) -> Result<Self, Problem> {
        let entry = data.model.as_ref().or(plan.data.model.as_ref());
        let entry = entry.ok_or_else(|| {
            plan.mistake(
                "",
                "it names no model, so there is nothing to disagree with",
            )
        })?;
        let Some(model) = study.entry(entry)?.work.model() else {
            let message = format!("`{entry}` is not a formal model");
            return Err(
                (plan.mistake(entry, message)).remedy("name an entry of the ledger with a `model`")
            );
        };
        let compiled = Compiled::new(study, model)?;
        are_known(plan, data, &compiled)?;
        Ok(Self {
            entry: entry.clone(),
            compiled,
            data,
            interrupt,
            known: RefCell::default(),
            failed: RefCell::default(),
        })
    }

    /// The model's probability in a context; 0.5 once something has failed.
    pub fn at(&self, space: &Space, context: &Point) -> f64 {
        let values = self.constants(space, context);
        let key: Vec<u64> = values.iter().map(|(_, value)| value.to_bits()).collect();
        if let Some(known) = self.known.borrow().get(&key) {
            return *known;
        }
        if self.failed.borrow().is_some() {
            return 0.5;
        }
        match self.compute(&values) {
            Ok(value) => {
                self.known.borrow_mut().insert(key, value);
                value
            }
            Err(problem) => {
                *self.failed.borrow_mut() = Some(problem);
                0.5
            }
        }
    }

    /// The constants that follow a context.
    fn constants(&self, space: &Space, context: &Point) -> Vec<(String, f64)> {
        let values = self.data.constant.iter().map(|constant| {
            let place = space.index_of(&constant.parameter);
            let value = place.and_then(|p| context.0.get(p)).copied();
            let value = constant.offset + constant.factor * value.unwrap_or(0.0);
            (constant.name.clone(), value.clamp(0.0, 1.0))
        });
        values.collect()
    }

    fn compute(&self, constants: &[(String, f64)]) -> Result<f64, Problem> {
        if self.known.borrow().len() >= MOST_CHECKS {
            let message =
                format!("the model would be checked for more than {MOST_CHECKS} contexts");
            return Err(Problem::new("bad-exploration", message)
                .remedy("declare the parameters that constants follow as a `choice` of values"));
        }
        let cancel = || self.interrupt.is_cancelled();
        let id = &self.data.requirement;
        let found = self.compiled.probability_at(id, constants, &cancel)?;
        found.ok_or_else(|| {
            let message = format!("the model does not express requirement `{id}`");
            Problem::new("bad-exploration", message)
        })
    }

    /// What has failed, if anything has.
    pub fn check(&self) -> Result<(), Problem> {
        match self.failed.borrow_mut().take() {
            Some(problem) => Err(problem),
            None => Ok(()),
        }
    }
}

/// Fails unless the model has the constants, and the contexts the parameters that they follow.
fn are_known(plan: &Plan, data: &DisagreementData, compiled: &Compiled<'_>) -> Result<(), Problem> {
    for constant in &data.constant {
        if compiled.constant(&constant.name).is_none() {
            let message = format!("the model has no constant `{}`", constant.name);
            return Err(plan.mistake(&constant.name, message));
        }
        if !data.parameter.iter().any(|p| p.name == constant.parameter) {
            let message = format!("there is no parameter `{}`", constant.parameter);
            return Err(plan.mistake(&constant.parameter, message));
        }
    }
    Ok(())
}
