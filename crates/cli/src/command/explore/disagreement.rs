//! `corroborate explore --disagreement`: where formal model and bench part.

use crate::args::Format;
use crate::command::{Done, Setting, json};
use crate::outcome::Outcome;
use crate::problem::{Problem, write_whole};
use crate::study::Study;
use crate::technique::exploration::{
    Disagreement, DisagreementReport, Ended, Journal, OpenBench, Plan,
};
use std::path::Path;

/// What is searched.
pub struct Search<'a> {
    pub study: &'a Study,
    pub plan: &'a Plan,
    pub bench: &'a OpenBench,
    pub folder: &'a Path,
}

impl Search<'_> {
    /// Searches, and writes what was found.
    pub fn done(&self, format: Format, setting: &Setting) -> Result<Done, Problem> {
        let search = Disagreement::new(self.study, self.plan, self.bench, &setting.interrupt)?;
        let looked_at_by = super::inputs_of_all(self.study, self.plan, self.bench)?.hash();
        let journal = Journal::open(&self.folder.join("disagreement"), &looked_at_by)?;
        let stage = setting
            .talk
            .begin("looking for disagreement", search.episodes());
        let report = search.run(self.plan, &journal, &stage)?;
        drop(stage);
        let path = self.folder.join("disagreement.json");
        write_whole(&path, json(&report)?.as_bytes())?;
        setting.talk.say(&format!("{} is written", path.display()));
        Ok(Done {
            output: match format {
                Format::Json => json(&report)?,
                Format::Text => report.text(),
            },
            outcome: outcome(&report),
        })
    }
}

fn outcome(report: &DisagreementReport) -> Outcome {
    match report.ended {
        Ended::Interrupted => Outcome::Interrupted,
        _ if report.shares.differs > 0.0 => Outcome::Violated,
        Ended::Decided => Outcome::Holds,
        Ended::Budget => Outcome::Inconclusive,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_committed_schema_is_the_form_that_is_written() {
        let schema: serde_json::Value = schemars::schema_for!(DisagreementReport).into();
        crate::command::tests::assert_schema_is_committed("disagreement.schema.json", &schema);
    }
}
