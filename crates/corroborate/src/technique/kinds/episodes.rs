//! Seeded episodes, judged by the study's monitors: of the handover, of a scene, or of a command.

use super::{Asked, Kept, Prepared, Propositions, Technique, Working};
use crate::technique::Produced;
use crate::technique::campaign::{self, Intervals, OutsideCommand, Source, recount};
use crate::technique::counted::CountedConstant;
use crate::technique::files::Files;
use crate::technique::simulation::{Campaign, Seeds};
use crate::verify::{Audit, check_intervals, same_values};
use diagnostic::Problem;
use evidence::AssetRole;
use host::store::{Inputs, is_stage_of};
use std::path::Path;
use study::Simulated;

/// What gives episodes, and how many of them.
pub(super) struct Episodes<'t> {
    pub(super) of: Simulated<'t>,
    pub(super) count: u64,
}

/// What gives episodes, read and ready.
enum Simulator {
    /// A test bench of ours.
    Bench(Box<Campaign>),
    /// Another simulator, or a rig.
    Command(Box<OutsideCommand>),
    /// The physics library is missing.
    Missing(Problem),
}

struct Ready<'a> {
    asked: Asked<'a>,
    simulator: Simulator,
    count: u64,
}

impl Technique for Episodes<'_> {
    fn prepare<'a>(
        &self,
        asked: Asked<'a>,
        files: &Files<'_>,
    ) -> Result<Box<dyn Prepared + 'a>, Problem> {
        let (study, library) = (asked.study, asked.host.physics_library.as_deref());
        let simulator = match self.of {
            Simulated::Handover {
                scenario,
                parameters,
            } => of_bench(Campaign::read(scenario, parameters, library, files), files)?,
            Simulated::Scene { scene, test } => {
                files.text(AssetRole::SystemModel, scene)?;
                of_bench(Campaign::of_scene(study, scene, test, library), files)?
            }
            Simulated::Command(text) => {
                let command = OutsideCommand::new(study, text)?;
                for asset in command.assets() {
                    files.was_read(asset);
                }
                Simulator::Command(Box::new(command))
            }
        };
        Ok(Box::new(Ready {
            asked,
            simulator,
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
        let how = match entry.sampling.until {
            Some(_) => Intervals::Anytime,
            None => Intervals::Fixed,
        };
        let Some(again) = recount(study, &folder, self.count, how, &produced.findings)? else {
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
        audit.not_checked(&format!("{}: episodes were not simulated again", entry.id));
        Ok(())
    }
}

/// A bench of ours, or that simulations cannot run here.
fn of_bench(bench: Result<Campaign, Problem>, files: &Files<'_>) -> Result<Simulator, Problem> {
    match bench {
        Ok(bench) => {
            for asset in bench.assets() {
                files.was_read(asset);
            }
            Ok(Simulator::Bench(Box::new(bench)))
        }
        Err(problem) if problem.code == "no-physics-library" => Ok(Simulator::Missing(problem)),
        Err(problem) => Err(problem),
    }
}

impl Ready<'_> {
    /// What gives the episodes.
    fn source(&self) -> Result<Source<'_>, Problem> {
        match &self.simulator {
            Simulator::Bench(bench) => Ok(Source::Bench(bench)),
            Simulator::Command(command) => Ok(Source::Command(command)),
            Simulator::Missing(problem) => Err(problem.clone()),
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
        let (study, source) = (self.asked.study, self.source()?);
        source.inputs(inputs);
        source.reading_inputs(inputs);
        inputs.add("seed", &study.about.seed.to_le_bytes());
        inputs.add_json("episodes", &self.count);
        judging::inputs_of(study, inputs);
        self.asked.entry.sampling.inputs(inputs);
        Ok(())
    }

    fn constant(&self, _: &str) -> Option<f64> {
        None
    }

    fn propositions(&self) -> Option<Propositions<'_>> {
        None
    }

    fn obstacle(&self) -> Option<&Problem> {
        match &self.simulator {
            Simulator::Missing(problem) => Some(problem),
            Simulator::Bench(_) | Simulator::Command(_) => None,
        }
    }

    fn produce(&self, working: &Working<'_>) -> Result<Produced, Problem> {
        let (study, entry, host) = (self.asked.study, self.asked.entry, self.asked.host);
        let (source, program) = (self.source()?, self.program());
        let inputs = campaign::episode_inputs(study, entry, source, program);
        let folder = working
            .store
            .stage(&format!("episodes/{}", entry.id), &inputs.hash())?;
        let stage = host
            .events
            .begin(&format!("{}: episodes", entry.id), self.count);
        let plan = campaign::Campaigning {
            study,
            id: &entry.id,
            source,
            seeds: Seeds::new(study.about.seed, &entry.id),
            numbers: 1..self.count + 1,
            keep: entry.sampling.keep,
            early_end: entry.sampling.early_end,
            on_failure: entry.sampling.on_failure,
            until: working.until,
            folder: &folder,
            judged_by: campaign::judged_by(study, source, program),
            interrupt: &host.cancel,
            stage: &stage,
        };
        plan.produce()
    }

    fn kept_episodes(&self, results: &Path) -> Result<Option<u64>, Problem> {
        let Ok(source) = self.source() else {
            return Ok(None);
        };
        let (study, entry, program) = (self.asked.study, self.asked.entry, self.program());
        let folder = results.join("episodes").join(&entry.id);
        let inputs = campaign::episode_inputs(study, entry, source, program);
        if !is_stage_of(&folder, &inputs.hash()) {
            return Ok(Some(0));
        }
        let judged_by = campaign::judged_by(study, source, program);
        let records = campaign::records_judged_by(&folder, &judged_by)?;
        Ok(Some(records.len() as u64))
    }
}
