//! What gives the episodes of a ledger's entry, read and ready: a bench of ours, or a command.

use super::driver::Source;
use super::outside::OutsideCommand;
use crate::technique::simulation::Campaign;
use diagnostic::Problem;
use std::path::Path;
use study::{Entry, Simulated, Study};

/// What is simulated.
pub enum Simulator {
    /// A test bench of ours.
    Bench(Box<Campaign>),
    /// Another simulator, or a rig.
    Command(Box<OutsideCommand>),
}

impl Simulator {
    /// The simulator of an entry.
    pub fn of_entry(study: &Study, entry: &Entry, library: Option<&Path>) -> Result<Self, Problem> {
        let campaign = match entry.work.simulated() {
            Some(Simulated::Handover {
                scenario,
                parameters,
            }) => Campaign::new(study, scenario, parameters, library)?,
            Some(Simulated::Scene { scene, test }) => {
                Campaign::of_scene(study, scene, test, library)?
            }
            Some(Simulated::Command(command)) => {
                let command = OutsideCommand::new(study, command)?;
                return Ok(Self::Command(Box::new(command)));
            }
            None => {
                return Err(Problem::new(
                    "not-a-simulation",
                    format!("`{}` is no simulation of this study", entry.id),
                )
                .remedy("name an entry of the ledger with a scenario, a scene or a command"));
            }
        };
        Ok(Self::Bench(Box::new(campaign)))
    }

    /// As what gives episodes to a campaign.
    pub fn source(&self) -> Source<'_> {
        match self {
            Self::Bench(campaign) => Source::Bench(campaign),
            Self::Command(command) => Source::Command(command),
        }
    }
}
