//! Programs that a study names run only once the user of this machine has allowed them.
//!
//! A study may come from a stranger, and its ledger and scenes name programs. [`Consent`] is what every function needs that
//! starts one, and only this module can make it, so that no way leads around the question. It is given if one of these holds:
//!
//! 1. the user has said so for this call, or names a folder around the study ([`host::Trust`]);
//! 2. there is a record that this study is allowed whatever it contains: one's own;
//! 3. there is a record of this study with this content ([`Content`]): every file that could be a program, or name one.
//!
//! # Guarantee
//! No program of a study runs whose folder has another content than the one that was allowed, as far as files are part of the
//! content. A program that was allowed can do what its user can, which includes loading what is not part of it.
//!
//! # Assumes
//! Nobody else writes to the study's folder between the question and the start of the program.

mod content;
mod owner;
mod programs;
mod records;
mod store;

pub use content::Content;
pub use programs::{NamedProgram, programs};
pub use records::{Allowed, Record, allow, allowed, look, own, revoke};

use diagnostic::{Problem, Source};
use host::Host;
use std::ops::Range;
use std::path::{Path, PathBuf};
use study::{Study, placed::value_place};

/// That programs of a study may run. Whoever starts one asks for it.
#[derive(Clone, Debug)]
pub struct Consent {
    basis: Basis,
}

/// Why it was given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Basis {
    /// The user has typed the program.
    Typed,
    /// The study may run whatever it contains.
    Whole,
    /// The study may run with this content.
    Content,
}

/// The code of a problem that says that a study's programs are not allowed.
pub const NOT_ALLOWED: &str = "not-trusted";

/// What is to be started, for the message.
pub(crate) struct Wanted<'w> {
    /// Its words.
    pub(crate) words: &'w [String],
    /// The file of the study that names it, as it is named there.
    pub(crate) file: &'w Path,
    /// The text of that file, and where in it the words stand.
    pub(crate) source: &'w Source,
    pub(crate) place: Range<usize>,
}

/// A program with its arguments.
type Words = Vec<String>;

impl Consent {
    /// For what the user has typed on the command line, which is no study's.
    pub(crate) fn typed() -> Self {
        Self {
            basis: Basis::Typed,
        }
    }

    /// For a program that a study names, if it is allowed.
    ///
    /// # Errors
    /// `not-trusted`, with what has changed if the study was allowed before.
    pub(crate) fn to(study: &Path, wanted: &Wanted<'_>, host: &Host) -> Result<Self, Problem> {
        let why = match records::basis(study, wanted.file, host) {
            Ok(basis) => return Ok(Self { basis }),
            Err(why) => why,
        };
        let message = format!("`{}` would run: {why}", wanted.words.join(" "));
        let shown = study.display();
        Err(Problem::new(NOT_ALLOWED, message)
            .at(wanted.source, wanted.place.clone())
            .remedy(format!(
                "`corroborate trust {shown}` shows every program that it names, and allows them; `--trust` allows them for one call"
            )))
    }

    /// For a command of the ledger.
    ///
    /// # Errors
    /// `not-trusted`.
    pub(crate) fn to_command(
        study: &Study,
        words: &[String],
        host: &Host,
    ) -> Result<Self, Problem> {
        let named = |entry: &study::Entry| {
            let command = entry.work.simulated().and_then(study::Simulated::command);
            command.is_some_and(|it| it.command == words)
        };
        let number = study.ledger.iter().position(named).unwrap_or_default();
        let number = number.to_string();
        let wanted = Wanted {
            words,
            file: Path::new("ledger.toml"),
            source: &study.ledger_source,
            place: value_place(&study.ledger_source, &["evidence", &number, "command"]),
        };
        Self::to(&study.folder, &wanted, host)
    }

    /// For the programs of a scene, all of which its text has to name, with their words; `None` if it names none.
    ///
    /// # Errors
    /// `not-trusted`.
    pub(crate) fn to_scene(
        study: &Study,
        scene: &Path,
        source: &Source,
        host: &Host,
    ) -> Result<Option<(Self, Vec<Words>)>, Problem> {
        let named = programs::in_text(&source.text);
        let Some(first) = named.first() else {
            return Ok(None);
        };
        let wanted = Wanted {
            words: &first.words,
            file: scene,
            source,
            place: first.place.clone(),
        };
        let consent = Self::to(&study.folder, &wanted, host)?;
        Ok(Some((
            consent,
            named.into_iter().map(|it| it.words).collect(),
        )))
    }

    /// What a program is given in its environment so that it leaves the study as it was allowed: Python would write what it has
    /// compiled beside its modules, from where it would be run the next time.
    pub(crate) fn environment(&self) -> &'static [(&'static str, &'static str)] {
        match self.basis {
            Basis::Content => &[("PYTHONDONTWRITEBYTECODE", "1")],
            Basis::Typed | Basis::Whole => &[],
        }
    }
}

/// Where records are; a problem if there is no place for them.
fn records_of(host: &Host) -> Result<&PathBuf, Problem> {
    host.trust.records.as_ref().ok_or_else(|| {
        Problem::new(
            "no-records-of-trust",
            "there is no folder in which it could be kept which studies are allowed",
        )
        .remedy("set XDG_STATE_HOME or HOME to a folder of yours, or say `--trust` with each call")
    })
}
