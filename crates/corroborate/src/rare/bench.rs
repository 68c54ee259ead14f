//! The rig of a file of rare events.

use super::file::{CODE, RareText};
use crate::rigs::{self, Opening};
use diagnostic::{Problem, Source};
use host::Host;
use rig::Rig;
use study::{PhysicsEngine, Study};

/// Opens what the file names, with the test that episodes enact. An estimate is a figure: it is of the full physics, however
/// long that takes.
pub fn open(
    study: &Study,
    source: &Source,
    text: &RareText,
    host: &Host,
) -> Result<Box<dyn Rig>, Problem> {
    let opening = Opening {
        test: Some(&text.test),
        joined: Some(", "),
        ..Opening::new(study, host)
    };
    let (scenario, scene) = (text.scenario.as_deref(), text.scene.as_deref());
    let (parameters, engine) = (text.parameters.as_deref(), PhysicsEngine::default());
    let of_files = rigs::of_files(scenario, parameters, scene, engine);
    let has_files = scenario.or(scene).or(parameters).is_some();
    match (&text.evidence, of_files) {
        (Some(evidence), None) if !has_files => {
            opening.open(rigs::simulated(study.entry(evidence)?)?)
        }
        (None, Some(simulated)) => opening.open(simulated),
        _ => Err(Problem::new(
            CODE,
            "the file names neither a scene alone nor a scenario with its parameters",
        )
        .at(source, 0..source.text.lines().next().map_or(0, str::len))
        .remedy("give `scene`, or `scenario` and `parameters`, or `evidence`")),
    }
}
