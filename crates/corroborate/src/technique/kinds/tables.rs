//! Counts that are read from tables: of experiments, and of what others published.

use super::{Asked, Kept, Prepared, Propositions, Technique, Working};
use crate::technique::Produced;
use crate::technique::counted::CountedConstant;
use crate::technique::experiment::Tables;
use crate::technique::files::Files;
use crate::verify::Audit;
use diagnostic::Problem;
use host::store::Inputs;
use std::path::Path;
use study::TableFiles;

/// Tables, and as whose evidence they count.
pub(super) struct ReadTables<'t> {
    pub(super) technique: evidence::Technique,
    pub(super) files: TableFiles<'t>,
}

/// Tables that were read.
struct Ready<'a> {
    asked: Asked<'a>,
    technique: evidence::Technique,
    tables: Tables,
}

impl Technique for ReadTables<'_> {
    fn prepare<'a>(
        &self,
        asked: Asked<'a>,
        files: &Files<'_>,
    ) -> Result<Box<dyn Prepared + 'a>, Problem> {
        let tables = Tables::read_through(asked.study, self.files, files)?;
        for row in tables.more_than_attempts(asked.study) {
            asked
                .host
                .events
                .say(&format!("warning: {}", row.in_words()));
        }
        let unread = tables.unread_columns(asked.study);
        if let (Some(file), false) = (self.files.cohort, unread.is_empty()) {
            asked.host.events.say(&format!(
                "{}: no word of the vocabulary reads these columns of {}, which may be counts: {}",
                asked.entry.id,
                file.display(),
                unread.join(", ")
            ));
        }
        Ok(Box::new(Ready {
            asked,
            technique: self.technique,
            tables,
        }))
    }

    fn is_computed_again_when_deep(&self) -> bool {
        false
    }

    fn verify(&self, asked: Asked<'_>, kept: &Kept<'_>, audit: &mut Audit) -> Result<(), Problem> {
        let (study, entry) = (asked.study, asked.entry);
        let tables = Tables::read(study, self.files)?;
        let again = tables.produce(study, &entry.id, self.technique)?;
        kept.is(again, "values of evidence follow from tables", audit)
    }
}

impl Prepared for Ready<'_> {
    fn settings(&self, _: &[CountedConstant], inputs: &mut Inputs) -> Result<(), Problem> {
        self.tables.inputs(self.asked.study, inputs);
        Ok(())
    }

    fn constant(&self, _: &str) -> Option<f64> {
        None
    }

    fn propositions(&self) -> Option<Propositions<'_>> {
        None
    }

    fn obstacle(&self) -> Option<&Problem> {
        None
    }

    fn not_allowed(&self) -> Option<&Problem> {
        None
    }

    fn produce(&self, _: &Working<'_>) -> Result<Produced, Problem> {
        let (study, entry) = (self.asked.study, self.asked.entry);
        self.tables.produce(study, &entry.id, self.technique)
    }

    fn kept_episodes(&self, _: &Path) -> Result<Option<u64>, Problem> {
        Ok(None)
    }
}
