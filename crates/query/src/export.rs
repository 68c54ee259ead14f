//! The model, written to files.

use crate::request::Exports;
use checker::formats::{Explicit, Written};
use checker::state_space::StateSpace;
use diagnostic::Problem;
use prism_lang::{Arithmetic, resolved};
use std::io;
use std::path::{Path, PathBuf};

/// The forms of a model's files.
pub(crate) const FORMS: [&str; 7] = ["tra", "sta", "lab", "srew", "trew", "dot", "drn"];

/// Takes bytes that are asked for as the file `stdout`.
pub type Print<'a> = &'a (dyn Fn(&[u8]) -> io::Result<()> + Sync);

/// Where files are written, and what is asked for as `stdout`.
#[derive(Clone, Copy)]
pub(crate) struct Output<'a>(pub Print<'a>);

/// Writes the model as it is asked for.
pub(crate) fn model<N: Arithmetic + Written>(
    exports: &Exports,
    model: &resolved::Model,
    space: &StateSpace<N>,
    output: Output<'_>,
) -> Result<(), Problem> {
    if exports.model.is_empty() && exports.labels.is_none() {
        // Putting the states in order takes longer than many a question.
        return Ok(());
    }
    let explicit = Explicit::new(space);
    let export = Export {
        model,
        space,
        explicit,
        output,
    };
    for asked in &exports.model {
        for (form, path) in files(asked)? {
            export.write(&form, &path)?;
        }
    }
    match &exports.labels {
        Some(path) => export.write("lab", path),
        None => Ok(()),
    }
}

impl Output<'_> {
    /// Writes a file whole; a device or a pipe, which must not be replaced, as it is; `stdout` is what the caller prints to, as
    /// in PRISM.
    pub fn write(self, path: &Path, bytes: &[u8]) -> Result<(), Problem> {
        let cannot = |error| Problem::cannot_write(path, &error);
        if ["stdout", "/dev/stdout"].map(Path::new).contains(&path) {
            return (self.0)(bytes).map_err(cannot);
        }
        host::files::write_whole_or_through(path, bytes)
    }
}

/// Writes the chain of a scheduler in one form.
pub(crate) fn chain<N: Arithmetic + Written>(
    model: &resolved::Model,
    space: &StateSpace<N>,
    form: &str,
    path: &Path,
    output: Output<'_>,
) -> Result<(), Problem> {
    let explicit = Explicit::new(space);
    let export = Export {
        model,
        space,
        explicit,
        output,
    };
    export.write(form, path)
}

/// The files that are asked for: `FORM=FILE`, `FILE.form,form` or `FILE.all`.
pub(crate) fn files(asked: &str) -> Result<Vec<(String, PathBuf)>, Problem> {
    if let Some((form, path)) = asked.split_once('=')
        && (FORMS.contains(&form) || form == "dot-plain")
    {
        return Ok(vec![(form.to_owned(), PathBuf::from(path))]);
    }
    let unknown = |what: &str| {
        Problem::new(
            "bad-form",
            format!("a model cannot be written in the form `{what}`"),
        )
        .remedy(format!(
            "the forms are {} and all, as the file's ending",
            FORMS.join(", ")
        ))
    };
    if let Some((_, options)) = asked.split_once(':') {
        return Err(unknown(options));
    }
    // Without an ending: the transitions.
    let Some((stem, endings)) = asked.rsplit_once('.') else {
        return Ok(vec![("tra".to_owned(), PathBuf::from(asked))]);
    };
    let endings: Vec<&str> = match endings {
        "all" => FORMS[..5].to_vec(),
        endings => endings.split(',').collect(),
    };
    let file = |ending: &&str| match FORMS.contains(ending) {
        true => Ok((
            (*ending).to_owned(),
            PathBuf::from(format!("{stem}.{ending}")),
        )),
        false => Err(unknown(ending)),
    };
    endings.iter().map(file).collect()
}

struct Export<'a, N> {
    model: &'a resolved::Model,
    space: &'a StateSpace<N>,
    explicit: Explicit<'a, N>,
    output: Output<'a>,
}

impl<N: Arithmetic + Written> Export<'_, N> {
    fn write(&self, form: &str, path: &Path) -> Result<(), Problem> {
        let cannot = |error: std::io::Error| Problem::cannot_write(path, &error);
        let mut bytes = Vec::new();
        match form {
            "tra" => self
                .explicit
                .write_transitions(&mut bytes)
                .map_err(cannot)?,
            "sta" => self.explicit.write_states(&mut bytes).map_err(cannot)?,
            "lab" => {
                let labels = self.labels()?;
                self.explicit
                    .write_labels(&labels, &mut bytes)
                    .map_err(cannot)?;
            }
            "dot" => self.explicit.write_dot(true, &mut bytes).map_err(cannot)?,
            "dot-plain" => self.explicit.write_dot(false, &mut bytes).map_err(cannot)?,
            "drn" => {
                let labels = self.labels()?;
                self.explicit
                    .write_drn(&labels, &mut bytes)
                    .map_err(cannot)?;
            }
            rewards => return self.rewards(rewards == "srew", path),
        }
        self.output.write(path, &bytes)
    }

    fn labels(&self) -> Result<Vec<(String, Vec<bool>)>, Problem> {
        let of = |(name, _): &(String, _)| match self.space.label(name) {
            Ok(states) => Ok((name.clone(), states)),
            Err(error) => Err(Problem::new("cannot-explore", error.to_string())),
        };
        self.model.labels.iter().map(of).collect()
    }

    /// One file for each structure, numbered if there are several.
    fn rewards(&self, of_states: bool, path: &Path) -> Result<(), Problem> {
        for index in 0..self.space.num_rewards() {
            let rewards = self.space.rewards(index);
            let rewards = rewards.map_err(|e| Problem::new("cannot-explore", e.to_string()))?;
            let file = match (self.space.num_rewards(), path.extension()) {
                (2.., Some(ending)) => {
                    let stem = path.with_extension("").display().to_string();
                    PathBuf::from(format!("{stem}{}.{}", index + 1, ending.display()))
                }
                _ => path.to_owned(),
            };
            let mut bytes = Vec::new();
            let written = match of_states {
                true => self
                    .explicit
                    .write_state_rewards(index, rewards, &mut bytes),
                false => self
                    .explicit
                    .write_transition_rewards(index, rewards, &mut bytes),
            };
            written.map_err(|error| Problem::cannot_write(&file, &error))?;
            self.output.write(&file, &bytes)?;
        }
        Ok(())
    }
}
