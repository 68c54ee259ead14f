//! What a calibration rests on, read and checked before anything runs.

use super::counts::Reality;
use super::file::{CODE, CalibrationText, merge, written};
use crate::test_bench::{begins, simulation_problem, stimulus_at};
use diagnostic::{Problem, Source};
use evidence::{FileReport, LineageReport};
use host::store::{Inputs, hash_of};
use rig::{Rig, tried};
use std::path::{Path, PathBuf};
use stimulus::Space;
use study::Study;
use study::placed::quoted;
use testbench::SimError;
use toml::Table;

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
) -> Result<LineageReport, Problem> {
    let entry = study.entry(&text.evidence)?;
    let mut paths = vec![text.scenario.clone(), text.parameters.clone()];
    if let Some(tables) = entry.work.tables() {
        paths.extend(tables.paths().map(Path::to_owned));
    }
    let file = |path: &PathBuf| {
        let content = host::files::read_source(&study.folder.join(path))?;
        Ok(FileReport {
            file: path.display().to_string(),
            hash: hash_of(content.text.as_bytes()),
        })
    };
    Ok(LineageReport {
        seed: study.about.seed.to_string(),
        calibration: FileReport {
            file: in_study(study, Path::new(&source.name)),
            hash: hash_of(source.text.as_bytes()),
        },
        files: paths.iter().map(file).collect::<Result<_, Problem>>()?,
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

/// The parameters to begin with, with what is known in them.
pub fn base_parameters(
    study: &Study,
    file: &Source,
    text: &CalibrationText,
) -> Result<Source, Problem> {
    let source = host::files::read_source(&study.folder.join(&text.parameters))?;
    let mut table: Table =
        toml::from_str(&source.text).map_err(|error| study::placed::from_toml(&source, &error))?;
    if let Err(key) = merge(&mut table, &text.known) {
        let message = format!("{} has no `{key}` that could be known", source.name);
        let last = key.rsplit('.').next().unwrap_or_default();
        return Err(Problem::new(CODE, message)
            .at(file, quoted(file, last))
            .remedy("correct the key in [known]"));
    }
    table.insert("name".into(), text.name.clone().into());
    Ok(Source {
        text: written(&table)?,
        name: format!("{} with what is known", source.name),
    })
}

/// Fails unless the middle of the space can be simulated, and both ends of each parameter.
pub fn rig_accepts(rig: &dyn Rig, space: &Space, file: &Source) -> Result<(), Problem> {
    let middle = vec![0.5; space.dimensions()];
    for (place, parameter) in space.parameters.iter().enumerate() {
        for end in tried(&parameter.distribution) {
            let mut unit = middle.clone();
            unit[place] = end;
            let stimulus = stimulus_at(rig.stimulus(), space, &unit)?;
            let Err(error) = begins(rig, &stimulus) else {
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
