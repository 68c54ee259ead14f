//! What a calibration rests on, read and checked before anything runs.

use super::counts::Reality;
use super::file::CalibrationText;
use crate::test_bench::{begins, simulation_problem, stimulus_at};
use diagnostic::{Problem, Source};
use evidence::{FileReport, LineageReport};
use host::store::{Inputs, hash_of};
use rig::{Rig, tried};
use std::path::Path;
use stimulus::{Space, Stimulus};
use study::placed::quoted;
use study::{Simulated, Study, TableFiles};
use testbench::SimError;

/// What an episode's outcome depends on, besides its parameters and its number; not the counts, so
/// that other counts are fitted with the episodes that there are.
pub fn inputs(
    study: &Study,
    rig: &dyn Rig,
    space: &Space,
    reality: &Reality,
    build: &host::BuildId,
) -> Inputs {
    let modes: Vec<&str> = reality.observed.iter().map(|it| it.mode.as_str()).collect();
    let mut inputs = Inputs::default();
    rig.test_inputs(build, &mut inputs);
    inputs
        .add("space", format!("{space:?}").as_bytes())
        .add("modes", modes.join("\n").as_bytes())
        .add("study", format!("{:?}", study.forms).as_bytes());
    inputs
}

/// Seed and files that decide what comes out.
pub fn lineage(
    study: &Study,
    source: &Source,
    text: &CalibrationText,
    (simulated, rig): (Simulated<'_>, &dyn Rig),
) -> Result<LineageReport, Problem> {
    let entry = study.entry(&text.evidence)?;
    let file = |path: &Path| {
        let content = host::files::read_source(&study.folder.join(path))?;
        Ok::<_, Problem>(FileReport {
            file: path.display().to_string(),
            hash: hash_of(content.text.as_bytes()),
        })
    };
    let named = [simulated.file(), simulated.parameters()];
    let mut files: Vec<FileReport> = (named.into_iter().flatten())
        .map(file)
        .collect::<Result<_, _>>()?;
    files.extend(rig.assets().iter().map(|asset| FileReport {
        file: asset.path.clone(),
        hash: asset.hash.clone(),
    }));
    for path in entry.work.tables().into_iter().flat_map(TableFiles::paths) {
        files.push(file(path)?);
    }
    Ok(LineageReport {
        seed: study.about.seed.to_string(),
        calibration: FileReport {
            file: in_study(study, Path::new(&source.name)),
            hash: hash_of(source.text.as_bytes()),
        },
        files,
    })
}

/// A file as the study names it, or by its name alone where it lies elsewhere.
fn in_study(study: &Study, file: &Path) -> String {
    let whole = |path: &Path| std::fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    let (folder, path) = (whole(&study.folder), whole(file));
    let name = path.file_name().map(Path::new);
    let within = path.strip_prefix(&folder).ok().or(name);
    within.unwrap_or(file).display().to_string()
}

/// Fails unless the middle of the space can be simulated, and both ends of each parameter.
pub fn rig_accepts(rig: &dyn Rig, space: &Space, file: &Source) -> Result<(), Problem> {
    let middle = vec![0.5; space.dimensions()];
    for (place, parameter) in space.parameters.iter().enumerate() {
        for end in tried(&parameter.distribution) {
            let mut unit = middle.clone();
            unit[place] = end;
            let stimulus = stimulus_at(rig.stimulus(), space, &unit)?;
            let Err(error) = settable(rig, &stimulus).and_then(|()| begins(rig, &stimulus)) else {
                continue;
            };
            let SimError::Stimulus { reason } = error else {
                return Err(simulation_problem(error, 0));
            };
            let value = parameter.distribution.quantile(end);
            let message = format!("`{}` cannot be {value}: {reason}", parameter.name);
            return Err(Problem::new("bad-settings", message)
                .at(file, quoted(file, &parameter.name))
                .remedy("correct the keys that it sets, or its range"));
        }
    }
    Ok(())
}

/// A program of others may pass over a key that it does not know, which would look like a parameter without an effect; so its
/// stimulus has to set the key already.
fn settable(rig: &dyn Rig, stimulus: &Stimulus) -> Result<(), SimError> {
    if !rig.is_outside() {
        return Ok(());
    }
    let set = stimulus::apply(&mut rig.data().clone(), &stimulus.settings);
    set.map_err(|error| SimError::Stimulus {
        reason: error.to_string(),
    })
}
