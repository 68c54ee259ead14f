//! `corroborate calibrate`: simulator parameters from an evidence's counts.

mod conclusion;
mod counts;
pub mod file;
mod parameter_set;
mod text;
mod work;

use super::rare::bench::TestBench;
use super::{Done, Host, json, use_threads};
use crate::args::{Calibrate, Format};
use corroborate::kept::CALIBRATION;
use corroborate::outcome::Outcome;
use corroborate::technique::confidence;
use corroborate::technique::simulation::{SearchPhysics, Seeds, scenario_source};
use counts::Reality;
use diagnostic::{Problem, Source};
use evidence::{FileReport, Likeness, LineageReport};
use file::{CODE, CalibrationText, merge, quoted, written};
use host::files::write_whole;
use host::store::{Inputs, Store, hash_of};
use judging::Judges;
use rig::{check_units, tried};
use std::path::{Path, PathBuf};
use stimulus::Space;
use study::{Study, Work as Ledgered};
use testbench::SimError;
use toml::Table;
use work::Work;

/// Fits, checks, and writes the fitted set.
pub fn calibrate(arguments: &Calibrate, setting: &Host) -> Result<Done, Problem> {
    use_threads(arguments.threads)?;
    let study = Study::load(&arguments.study)?;
    let source = host::files::read_source(&arguments.file)?;
    let text = CalibrationText::read(&source)?;
    let level = confidence(text.confidence)?;
    let reality = Reality::read(&study, &source, &text)?;
    let base = base_parameters(&study, &source, &text)?;
    let scenario = scenario_source(&study.folder.join(&text.scenario))?;
    let library = setting.physics_library.as_deref();
    let bench = TestBench::new(&scenario, &base, &text.test, library)?;
    let fast =
        SearchPhysics::choose(text.physics, || bench.in_fast_physics()).map_err(|message| {
            let span = quoted(&source, "physics");
            let problem = Problem::new(CODE, message).at(&source, span);
            problem.remedy("leave `physics` out")
        })?;
    let space = text.space();
    check_units(&space, &source, CODE)?;
    bench_accepts(&bench, &space, &source)?;
    let folder = arguments.out.clone();
    let folder = folder.unwrap_or_else(|| study.folder.join("results/calibration"));
    let work = Work {
        judges: Judges::new(&study, |subject| {
            let mut modes = reality.observed.iter();
            modes.any(|it| it.mode == subject.id())
        })?,
        inputs: inputs(
            &study,
            fast.as_ref().unwrap_or(&bench),
            &space,
            &reality,
            &setting.build,
        )?,
        check_inputs: inputs(&study, &bench, &space, &reality, &setting.build)?,
        store: Store::open(&folder)?,
        seeds: Seeds::new(study.about.seed, &format!("calibration: {}", text.name)),
        text: &text,
        bench: fast.as_ref().unwrap_or(&bench),
        check_bench: &bench,
        reality,
        space,
        setting,
        agreement: confidence(study.about.agreement)?,
        lineage: lineage(&study, &source, &text)?,
    };
    let report = work.report(&base, level)?;
    write_whole(&folder.join(CALIBRATION), json(&report)?.as_bytes())?;
    if let Some(path) = &arguments.to {
        write_whole(path, report.parameter_set.as_bytes())?;
    }
    Ok(Done {
        outcome: match report.conclusion {
            Likeness::Equivalent => Outcome::Holds,
            Likeness::Different => Outcome::Violated,
            Likeness::Undecided | Likeness::Fit => Outcome::Inconclusive,
        },
        output: match arguments.format {
            Format::Json => json(&report)?,
            Format::Text => text::as_text(&report),
        },
    })
}

/// What an episode's outcome depends on, besides its parameters and its number; not the counts, so
/// that other counts are fitted with the episodes that there are.
fn inputs(
    study: &Study,
    bench: &TestBench,
    space: &Space,
    reality: &Reality,
    build: &host::BuildId,
) -> Result<Inputs, Problem> {
    let modes: Vec<&str> = reality.observed.iter().map(|it| it.mode.as_str()).collect();
    let mut inputs = Inputs::default();
    bench.inputs(&mut inputs, build)?;
    inputs
        .add("space", format!("{space:?}").as_bytes())
        .add("modes", modes.join("\n").as_bytes())
        .add("study", format!("{:?}", study.forms).as_bytes());
    Ok(inputs)
}

/// Seed and files that decide what comes out.
fn lineage(
    study: &Study,
    source: &Source,
    text: &CalibrationText,
) -> Result<LineageReport, Problem> {
    let entry = study.entry(&text.evidence)?;
    let mut paths = vec![text.scenario.clone(), text.parameters.clone()];
    if let Ledgered::Read {
        cohort,
        requirements,
        failure_modes,
        ..
    } = &entry.work
    {
        let tables = [cohort, requirements, failure_modes];
        paths.extend(tables.into_iter().flatten().cloned());
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
fn base_parameters(
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
fn bench_accepts(bench: &TestBench, space: &Space, file: &Source) -> Result<(), Problem> {
    let middle = vec![0.5; space.dimensions()];
    for (place, parameter) in space.parameters.iter().enumerate() {
        for end in tried(&parameter.distribution) {
            let mut unit = middle.clone();
            unit[place] = end;
            let stimulus = bench.stimulus(space, &unit)?;
            let Err(error) = bench.bench.world(&stimulus, 0) else {
                continue;
            };
            let SimError::Stimulus { reason } = error else {
                return Err(super::rare::bench::simulation_problem(error, 0));
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

#[cfg(test)]
mod tests {
    use evidence::CalibrationReport;

    #[test]
    fn the_committed_schema_is_the_form_that_is_printed() {
        let schema: serde_json::Value = schemars::schema_for!(CalibrationReport).into();
        crate::command::tests::assert_schema_is_committed("calibrate.schema.json", &schema);
    }
}
