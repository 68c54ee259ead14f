//! Seeded episodes, judged by the study's monitors: of the handover, of a scene, or of a command.

use super::{Asked, Kept, Prepared, Propositions, Technique, Working};
use crate::rigs::Opening;
use crate::technique::Produced;
use crate::technique::campaign::{self, Intervals, Sampled, recount};
use crate::technique::counted::CountedConstant;
use crate::technique::files::Files;
use crate::technique::simulation::Seeds;
use crate::verify::{Audit, check_intervals, same_values};
use diagnostic::Problem;
use evidence::AssetRole;
use host::store::{Inputs, is_stage_of};
use rig::consent::NOT_ALLOWED;
use rig::{OutsideCommand, Rig};
use std::path::Path;
use study::Simulated;

/// What gives episodes, and how many of them.
pub(super) struct Episodes<'t> {
    pub(super) of: Simulated<'t>,
    pub(super) count: u64,
}

struct Ready<'a> {
    asked: Asked<'a>,
    /// What gives the episodes; an error if the physics library is missing, or programs that it starts are not allowed.
    rig: Result<Box<dyn Rig>, Problem>,
    count: u64,
}

impl Technique for Episodes<'_> {
    fn prepare<'a>(
        &self,
        asked: Asked<'a>,
        files: &Files<'_>,
    ) -> Result<Box<dyn Prepared + 'a>, Problem> {
        let (study, host) = (asked.study, asked.host);
        let read = |path: &Path| files.text(AssetRole::SystemModel, path);
        let opening = Opening {
            read: Some(&read),
            only_looked_at: true,
            ..Opening::new(study, host)
        };
        let is_obstacle = |code: &str| ["no-physics-library", NOT_ALLOWED].contains(&code);
        let rig = match opening.open(self.of) {
            Err(problem) if !is_obstacle(problem.code) => return Err(problem),
            rig => rig,
        };
        for asset in rig.iter().flat_map(|rig| rig.assets()) {
            files.was_read(asset);
        }
        Ok(Box::new(Ready {
            asked,
            rig,
            count: self.count,
        }))
    }

    fn is_computed_again_when_deep(&self) -> bool {
        false
    }

    /// Counts the journal again.
    fn verify(&self, asked: Asked<'_>, kept: &Kept<'_>, audit: &mut Audit) -> Result<(), Problem> {
        let (study, entry, produced) = (asked.study, asked.entry, kept.produced);
        check_intervals(study, kept.path, produced, audit)?;
        let folder = kept.results.join("episodes").join(&entry.id);
        let own_name = |number: u64| match self.of {
            Simulated::Command(command) => {
                OutsideCommand::name_of_recording(&command.leaves, number)
            }
            Simulated::Handover { .. } | Simulated::Scene { .. } => rig::episode_name(number),
        };
        let how = match entry.sampling.until {
            Some(_) => Intervals::Anytime,
            None => Intervals::Fixed,
        };
        let Some(again) = recount(
            (study, &own_name),
            &folder,
            self.count,
            how,
            &produced.findings,
        )?
        else {
            audit.not_checked(&format!(
                "{}: there is no journal of its episodes, so its counts were not counted again",
                entry.id
            ));
            return Ok(());
        };
        let place = "/content/findings";
        let mut values = same_values(kept.path, place, &again.findings, &produced.findings, audit)?;
        let place = "/content/failures";
        values += same_values(kept.path, place, &again.failures, &produced.failures, audit)?;
        audit.checked(
            values,
            "values of evidence follow from journals of episodes",
        );
        audit.checked(
            again.recordings,
            "recordings have the hash of what was judged",
        );
        for (file, fault) in again.faults {
            audit.fault(Path::new(&file), "", fault);
        }
        match kept.deep {
            true => self.run_again(asked, &folder, kept.sampled, audit),
            false => {
                audit.not_checked(&format!("{}: episodes were not simulated again", entry.id));
                Ok(())
            }
        }
    }
}

impl Episodes<'_> {
    /// Judges kept recordings again, and runs a sample of the episodes again.
    fn run_again(
        &self,
        asked: Asked<'_>,
        folder: &Path,
        sampled: Sampled,
        audit: &mut Audit,
    ) -> Result<(), Problem> {
        let Asked { study, entry, host } = asked;
        let rig = match Opening::new(study, host).open(self.of) {
            Ok(rig) => rig,
            Err(problem) => {
                let said = format!("{}: episodes were not simulated again: {problem}", entry.id);
                audit.not_checked(&said);
                return Ok(());
            }
        };
        let records = campaign::journal_of(folder, self.count)?;
        let of = (study, entry, rig.as_ref(), host);
        let found = campaign::again(of, folder, &records, sampled)?;
        audit.checked(
            found.judged,
            "recordings of episodes have the same verdicts, judged again",
        );
        audit.checked(
            found.run,
            "episodes came out the same, run again with their seeds",
        );
        for (number, fault) in &found.faults {
            let place = format!("episode {number}");
            audit.fault(&folder.join("journal"), &place, *fault);
        }
        if found.not_judged > 0 {
            audit.not_checked(&format!(
                "{}: {} of episodes that were cut short were not judged again",
                entry.id,
                diagnostic::counted(found.not_judged, "recording")
            ));
        }
        let rest = (records.len() as u64).saturating_sub(sampled.episodes);
        if rest > 0 {
            audit.not_checked(&not_run(&entry.id, records.len() as u64, sampled));
        }
        Ok(())
    }
}

/// What a sample of the episodes leaves open, and how probable it was to miss a change of a tenth of them.
fn not_run(id: &str, episodes: u64, sampled: Sampled) -> String {
    let (n, k) = (episodes as f64, sampled.episodes as f64);
    let missed = (1.0 - k / n).powf((n / 10.0).ceil());
    format!(
        "{id}: {} of {episodes} episodes were not simulated again (drawn from {}; a change of a tenth of all would be met with a probability of at least {:.0} %)",
        episodes - sampled.episodes,
        sampled.draw,
        (100.0 * (1.0 - missed)).floor()
    )
}

impl Ready<'_> {
    /// What gives the episodes.
    fn rig(&self) -> Result<&dyn Rig, Problem> {
        match &self.rig {
            Ok(rig) => Ok(rig.as_ref()),
            Err(problem) => Err(problem.clone()),
        }
    }

    /// Which program computes.
    fn program(&self) -> &str {
        self.asked.host.build.as_str()
    }
}

impl Prepared for Ready<'_> {
    /// What is simulated, and how episodes are drawn and judged.
    fn settings(&self, _: &[CountedConstant], inputs: &mut Inputs) -> Result<(), Problem> {
        let (study, rig) = (self.asked.study, self.rig()?);
        rig.own_inputs(inputs);
        rig.reading_inputs(inputs);
        judging::inputs_of(study, inputs);
        let entry = self.asked.entry;
        entry.sampling.inputs(inputs);
        if let Some(rule) = &entry.sampling.until {
            campaign::Until::new(study, entry, rule)?.inputs(inputs);
        }
        Ok(())
    }

    fn constant(&self, _: &str) -> Option<f64> {
        None
    }

    fn propositions(&self) -> Option<Propositions<'_>> {
        None
    }

    fn obstacle(&self) -> Option<&Problem> {
        self.rig.as_ref().err()
    }

    /// A scene's programs are asked what they send before anything is known of it; a command runs with its first episode.
    fn not_allowed(&self) -> Option<&Problem> {
        match &self.rig {
            Ok(rig) => rig.leaves().and_then(OutsideCommand::obstacle),
            Err(problem) => Some(problem).filter(|it| it.code == NOT_ALLOWED),
        }
    }

    fn produce(&self, working: &Working<'_>) -> Result<Produced, Problem> {
        let (study, entry, host) = (self.asked.study, self.asked.entry, self.asked.host);
        let (rig, program) = (self.rig()?, self.program());
        let inputs = campaign::episode_inputs(study, entry, rig, program);
        let folder = working
            .store
            .stage(&format!("episodes/{}", entry.id), &inputs.hash())?;
        let stage = host
            .events
            .begin(&format!("{}: episodes", entry.id), self.count);
        let plan = campaign::Campaigning {
            study,
            id: &entry.id,
            rig,
            seeds: Seeds::new(study.about.seed, entry.seeded_as()),
            numbers: 1..self.count + 1,
            keep: entry.sampling.keep,
            early_end: entry.sampling.early_end,
            on_failure: entry.sampling.on_failure,
            until: working.until,
            folder: &folder,
            judged_by: campaign::judged_by(study, rig, program),
            interrupt: &host.cancel,
            stage: &stage,
        };
        plan.produce()
    }

    fn kept_episodes(&self, results: &Path) -> Result<Option<u64>, Problem> {
        let Ok(rig) = self.rig() else {
            return Ok(None);
        };
        let (study, entry, program) = (self.asked.study, self.asked.entry, self.program());
        let folder = results.join("episodes").join(&entry.id);
        let inputs = campaign::episode_inputs(study, entry, rig, program);
        if !is_stage_of(&folder, &inputs.hash()) {
            return Ok(Some(0));
        }
        let judged_by = campaign::judged_by(study, rig, program);
        let records = campaign::records_judged_by(&folder, &judged_by)?;
        Ok(Some(records.len() as u64))
    }
}
