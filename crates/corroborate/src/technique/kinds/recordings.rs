//! Recordings of the system, judged by the study's monitors, and judged again.

use super::{Asked, Kept, Prepared, Propositions, Technique, Working};
use crate::technique::Produced;
use crate::technique::counted::CountedConstant;
use crate::technique::files::Files;
use crate::technique::operation::{Recordings, verdicts_name};
use crate::verify::{Audit, check_intervals};
use diagnostic::Problem;
use host::store::Inputs;
use judging::verdicts::RunVerdicts;
use std::path::Path;
use study::RecordingFiles;

/// A folder of recordings.
pub(super) struct JudgeRecordings<'t> {
    pub(super) files: RecordingFiles<'t>,
}

/// Recordings that were found.
struct Ready<'a> {
    asked: Asked<'a>,
    recordings: Recordings,
}

impl Technique for JudgeRecordings<'_> {
    fn prepare<'a>(
        &self,
        asked: Asked<'a>,
        files: &Files<'_>,
    ) -> Result<Box<dyn Prepared + 'a>, Problem> {
        let recordings = Recordings::find(asked.study, self.files)?;
        for asset in recordings.assets() {
            files.was_read(asset);
        }
        Ok(Box::new(Ready { asked, recordings }))
    }

    fn is_computed_again_when_deep(&self) -> bool {
        true
    }

    fn verify(&self, asked: Asked<'_>, kept: &Kept<'_>, audit: &mut Audit) -> Result<(), Problem> {
        let (study, entry, host) = (asked.study, asked.entry, asked.host);
        if !kept.deep {
            check_intervals(study, kept.path, kept.produced, audit)?;
            audit.not_checked(&format!(
                "{}: recordings were not judged again (--deep does)",
                entry.id
            ));
            return Ok(());
        }
        let recordings = Recordings::find(study, self.files)?;
        let title = format!("{}: recordings", entry.id);
        let stage = host.events.begin(&title, recordings.count());
        let say = |line: &str| host.events.say(line);
        let (again, _) = recordings.produce(study, &entry.id, &host.cancel, &stage, &say)?;
        let what = "values of evidence follow from judging its recordings again";
        kept.is(again, what, audit)
    }
}

impl Prepared for Ready<'_> {
    fn settings(&self, _: &[CountedConstant], inputs: &mut Inputs) -> Result<(), Problem> {
        self.recordings.inputs(self.asked.study, inputs)?;
        judging::inputs_of(self.asked.study, inputs);
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

    /// Judges recordings; what each form says of each is kept for a diagnosis.
    fn produce(&self, working: &Working<'_>) -> Result<Produced, Problem> {
        let (study, id, host) = (self.asked.study, &self.asked.entry.id, self.asked.host);
        let title = format!("{id}: recordings");
        let stage = host.events.begin(&title, self.recordings.count());
        let say = |line: &str| host.events.say(line);
        let (produced, main) = self
            .recordings
            .produce(study, id, &host.cancel, &stage, &say)?;
        let forms = self.recordings.form_verdicts(study, &host.cancel)?;
        let verdicts = RunVerdicts { main, forms };
        working
            .store
            .keep(&verdicts_name(id), working.inputs, verdicts)?;
        Ok(produced)
    }

    fn kept_episodes(&self, _: &Path) -> Result<Option<u64>, Problem> {
        Ok(None)
    }
}
