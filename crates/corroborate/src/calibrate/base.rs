//! The file whose numbers are fitted, as it is to begin with: the handover's parameter set, a scene, or the stimulus of a
//! command.

use super::file::{CODE, CalibrationText, merge, written};
use diagnostic::{Problem, Source};
use host::files::read_source;
use std::path::Path;
use stimulus::{Settings, VariedStimulus};
use study::placed::quoted;
use study::{CommandText, PhysicsEngine, Simulated, Study};
use toml::Table;

/// What is fitted.
pub struct Base<'a> {
    /// What is simulated.
    pub simulated: Simulated<'a>,
    /// The file that a fit changes, relative to the study.
    pub file: &'a Path,
    /// Its text, with what is known in it.
    pub source: Source,
    form: Form,
}

/// What kind of text it is.
#[derive(Clone, Copy)]
enum Form {
    /// A table on which settings act.
    Whole,
    /// A table that settings find under this key.
    Under(&'static str),
    /// A stimulus, which has settings of its own.
    Stimulus,
}

impl<'a> Base<'a> {
    /// Reads it, and refuses keys that are none of it.
    pub fn read(
        study: &'a Study,
        source: &Source,
        text: &'a CalibrationText,
    ) -> Result<Self, Problem> {
        let simulated = simulated(study, source, text)?;
        let base = match simulated {
            Simulated::Handover { parameters, .. } => Self {
                simulated,
                file: parameters,
                source: table_with_known(study, parameters, source, text)?,
                form: Form::Under("parameters"),
            },
            Simulated::Scene { scene, .. } => Self {
                simulated,
                file: scene,
                source: table_with_known(study, scene, source, text)?,
                form: Form::Whole,
            },
            Simulated::Command(command) => {
                let file = stimulus_of(command, source)?;
                Self {
                    simulated,
                    file,
                    source: stimulus_with_known(study, file, source, text)?,
                    form: Form::Stimulus,
                }
            }
        };
        base.has_all_keys(source, text)?;
        Ok(base)
    }

    fn has_all_keys(&self, source: &Source, text: &CalibrationText) -> Result<(), Problem> {
        let Form::Under(table) = self.form else {
            return Ok(());
        };
        let prefix = format!("{table}.");
        let mut keys = text.parameters_fitted.iter().flat_map(|it| &it.sets);
        match keys.find(|key| !key.starts_with(&prefix)) {
            None => Ok(()),
            Some(key) => {
                let message = format!("`{key}` is not a value of the parameter set");
                Err(Problem::new(CODE, message)
                    .at(source, quoted(source, key))
                    .remedy(format!("fit keys that begin with `{prefix}`")))
            }
        }
    }

    /// Its text with fitted values, as TOML.
    pub fn with(&self, settings: &Settings) -> Result<String, Problem> {
        match self.form {
            Form::Whole => {
                let mut table = self.table()?;
                stimulus::apply(&mut table, settings).map_err(bad_settings)?;
                written(&table)
            }
            Form::Under(key) => {
                let mut data = Table::from_iter([(key.to_owned(), self.table()?.into())]);
                stimulus::apply(&mut data, settings).map_err(bad_settings)?;
                match data.remove(key) {
                    Some(toml::Value::Table(table)) => written(&table),
                    _ => Ok(String::new()),
                }
            }
            Form::Stimulus => {
                let fitted = VariedStimulus::read(self.file, &self.source.text);
                let mut fitted = fitted.map_err(bad_settings)?;
                fitted.fix(settings);
                Ok(fitted.write(Path::new("stimulus.toml")))
            }
        }
    }

    fn table(&self) -> Result<Table, Problem> {
        toml::from_str(&self.source.text)
            .map_err(|error| study::placed::from_toml(&self.source, &error))
    }
}

fn bad_settings(error: impl std::fmt::Display) -> Problem {
    Problem::new("bad-settings", error.to_string())
}

/// What the file names.
fn simulated<'a>(
    study: &'a Study,
    source: &Source,
    text: &'a CalibrationText,
) -> Result<Simulated<'a>, Problem> {
    if let Some(id) = &text.simulator {
        let entry = study.entry(id)?;
        return crate::rigs::simulated(entry);
    }
    let (scenario, parameters) = (text.scenario.as_deref(), text.parameters.as_deref());
    let engine = PhysicsEngine::default();
    crate::rigs::of_files(scenario, parameters, None, engine).ok_or_else(|| {
        Problem::new(CODE, "the file names nothing that is simulated").at(source, 0..0)
    })
}

/// A file of TOML with the calibration's name, and with what is known in it.
fn table_with_known(
    study: &Study,
    path: &Path,
    file: &Source,
    text: &CalibrationText,
) -> Result<Source, Problem> {
    let source = text_of(study, path)?;
    let mut table: Table =
        toml::from_str(&source.text).map_err(|error| study::placed::from_toml(&source, &error))?;
    merge(&mut table, &text.known).map_err(|key| unknown(&key, &source, file))?;
    table.insert("name".into(), text.name.clone().into());
    Ok(Source {
        text: written(&table)?,
        name: named(&source),
    })
}

/// The stimulus of a command, which has to have one: its keys are what can be fitted.
fn stimulus_of<'a>(command: &'a CommandText, file: &Source) -> Result<&'a Path, Problem> {
    command.stimulus.as_deref().ok_or_else(|| {
        Problem::new(
            CODE,
            "the command has no stimulus whose settings could be fitted",
        )
        .at(file, quoted(file, "simulator"))
        .remedy("name a `stimulus` in the ledger that sets the keys to what they are now")
    })
}

/// A stimulus with what is known among its settings.
fn stimulus_with_known(
    study: &Study,
    path: &Path,
    file: &Source,
    text: &CalibrationText,
) -> Result<Source, Problem> {
    let source = text_of(study, path)?;
    let fail = |error| Problem::new("bad-stimulus", format!("{}: {error}", source.name));
    let mut stimulus = VariedStimulus::read(path, &source.text).map_err(fail)?;
    // Of what varies any number stands for its key.
    let all = stimulus.at(&|_, from| from.quantile(0.5)).settings;
    let mut table: Table = Table::try_from(&all)
        .map_err(|error| Problem::new("bad-stimulus", format!("{}: {error}", source.name)))?;
    merge(&mut table, &text.known).map_err(|key| unknown(&key, &source, file))?;
    let settings: Settings = table
        .try_into()
        .map_err(|error: toml::de::Error| Problem::new(CODE, error.to_string()))?;
    let known = settings.into_iter();
    let known = known.filter(|(key, value)| all.get(key) != Some(value));
    stimulus.fix(&known.collect());
    Ok(Source {
        text: stimulus.write(path),
        name: named(&source),
    })
}

fn named(source: &Source) -> String {
    format!("{} with what is known", source.name)
}

fn unknown(key: &str, source: &Source, file: &Source) -> Problem {
    let message = format!("{} has no `{key}` that could be known", source.name);
    let last = key.rsplit('.').next().unwrap_or_default();
    Problem::new(CODE, message)
        .at(file, quoted(file, last))
        .remedy("correct the key in [known]")
}

/// The text of a file that a calibration names.
fn text_of(study: &Study, path: &Path) -> Result<Source, Problem> {
    let full = study.folder.join(path);
    study.reach.check(&full)?;
    read_source(&full)
}
