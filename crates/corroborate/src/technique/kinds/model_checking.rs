//! Model checking as a technique: a formal model is solved, and solved again.

use super::{Asked, Kept, Prepared, Propositions, Technique, Working};
use crate::run::{check_constants, counted_constants};
use crate::technique::Produced;
use crate::technique::counted::{CountedConstant, counts_as_inputs};
use crate::technique::files::Files;
use crate::technique::model_checking::{Compiled, said_of_nothing};
use crate::verify::Audit;
use diagnostic::Problem;
use host::store::Inputs;
use std::path::Path;
use study::Method;

/// A formal model, and the methods by which it is solved.
pub(super) struct ModelChecking<'t> {
    pub(super) model: &'t Path,
    pub(super) methods: &'t [Method],
}

/// A model that was compiled.
struct Ready<'a> {
    asked: Asked<'a>,
    compiled: Compiled<'a>,
    methods: Vec<Method>,
}

impl Technique for ModelChecking<'_> {
    fn prepare<'a>(
        &self,
        asked: Asked<'a>,
        files: &Files<'_>,
    ) -> Result<Box<dyn Prepared + 'a>, Problem> {
        let compiled = Compiled::read(asked.study, self.model, files)?;
        let constants: Vec<&str> = compiled.constants().collect();
        let value_of = |name: &str| compiled.constant(name);
        let all = ("constants", constants.as_slice());
        check_constants(asked.study, asked.entry, all, &value_of)?;
        compiled.warn(&|line| asked.host.events.say(line));
        Ok(Box::new(Ready {
            asked,
            compiled,
            methods: self.methods.to_vec(),
        }))
    }

    fn is_computed_again_when_deep(&self) -> bool {
        true
    }

    fn verify(&self, asked: Asked<'_>, kept: &Kept<'_>, audit: &mut Audit) -> Result<(), Problem> {
        let (study, entry, host) = (asked.study, asked.entry, asked.host);
        if !kept.deep {
            let id = &entry.id;
            audit.not_checked(&format!(
                "{id}: the model was not solved again (--deep does)"
            ));
            return Ok(());
        }
        let compiled = Compiled::new(study, self.model)?;
        let value_of = |name: &str| compiled.constant(name);
        let counted = counted_constants(study, entry, kept.before, &value_of)?;
        let begin = |title: &str, total: u64| host.events.begin(title, total);
        let again = compiled.produce(&entry.id, self.methods, &counted, &host.cancel, &begin)?;
        let what = "values of evidence follow from solving its model again";
        kept.is(again, what, audit)
    }
}

impl Prepared for Ready<'_> {
    fn settings(&self, counted: &[CountedConstant], inputs: &mut Inputs) -> Result<(), Problem> {
        self.compiled.inputs(inputs);
        counts_as_inputs(counted, inputs);
        Ok(())
    }

    fn constant(&self, name: &str) -> Option<f64> {
        self.compiled.constant(name)
    }

    fn propositions(&self) -> Option<Propositions<'_>> {
        Some(self.compiled.propositions())
    }

    fn obstacle(&self) -> Option<&Problem> {
        None
    }

    fn not_allowed(&self) -> Option<&Problem> {
        None
    }

    fn produce(&self, working: &Working<'_>) -> Result<Produced, Problem> {
        let (id, host) = (&self.asked.entry.id, self.asked.host);
        let begin = |title: &str, total: u64| host.events.begin(title, total);
        let counted = working.counted;
        let produced = self
            .compiled
            .produce(id, &self.methods, counted, &host.cancel, &begin)?;
        for line in said_of_nothing(&produced) {
            host.events.say(&format!("{id}: {line}"));
        }
        Ok(produced)
    }

    fn kept_episodes(&self, _: &Path) -> Result<Option<u64>, Problem> {
        Ok(None)
    }
}
