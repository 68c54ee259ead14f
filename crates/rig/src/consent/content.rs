//! What a study contains that could be a program, or name one.
//!
//! # Definition
//! All files below the study's folder with the hashes of their bytes, but for
//!
//! 1. `results`, `regressions` and `looks.toml` of the study, which the engine writes itself, and `.git`, which changes with each
//!    commit;
//! 2. tables and recordings, by their extensions ([`DATA`]): they grow with each trial, may be larger than the memory, and are not
//!    programs. One that may be executed is taken in all the same.
//!
//! What a word of a command, or a name in the lists `files` and `assets` beside it, leads to is taken in wherever it lies, if it is
//! a relative path, so that a program does not hide under 1 or 2, or beside the study. An absolute path outside of the study
//! belongs to the machine and not to the study. A link is what it leads to, as well: the name that it has, and the bytes behind it.
//! A link to a folder elsewhere is refused, since its content could change unseen. Pipes, sockets and devices are named and
//! not opened.
//!
//! # Cost
//! Each byte is read once.
//!
//! # Guarantee
//! Two contents are the same if and only if all names and hashes (BLAKE3, 256 bits) are.

use super::programs::NamedProgram;
use diagnostic::Problem;
use host::store::hash_of;
use std::collections::{BTreeMap, BTreeSet};
use std::fs::FileType;
use std::path::{Path, PathBuf};

/// Extensions of tables and recordings.
pub const DATA: [&str; 7] = ["csv", "tsv", "jsonl", "parquet", "mcap", "bag", "db3"];
/// Names in the study's folder that the engine writes, and that of the version control.
const NOT_OF_IT: [&str; 4] = ["results", "regressions", "looks.toml", ".git"];
/// More files than a study has.
const MOST_FILES: usize = 100_000;

/// The files of a study that count, each with the hash of what it is.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Content {
    /// By their paths in the study.
    pub files: BTreeMap<String, String>,
}

impl Content {
    /// The content of a study, whose folder is given as the system knows it, without links on the way.
    ///
    /// # Errors
    /// `cannot-read`, `link-leads-out`, `too-many-files`.
    pub fn of(folder: &Path) -> Result<Self, Problem> {
        let mut content = Self::default();
        let mut folders = vec![folder.to_owned()];
        while let Some(below) = folders.pop() {
            let cannot = |error: std::io::Error| Problem::cannot_read(&below, &error);
            for entry in std::fs::read_dir(&below).map_err(cannot)? {
                let entry = entry.map_err(cannot)?;
                let (path, kind) = (entry.path(), entry.file_type().map_err(cannot)?);
                if below == folder && NOT_OF_IT.iter().any(|it| entry.file_name() == *it) {
                    continue;
                }
                match kind.is_dir() {
                    true => folders.push(path),
                    false => content.add(folder, &path, kind)?,
                }
            }
            content.is_of_a_study(folder)?;
        }
        for program in super::programs::programs(folder, &content)? {
            content.add_named(folder, &program)?;
        }
        Ok(content)
    }

    fn is_of_a_study(&self, folder: &Path) -> Result<(), Problem> {
        if self.files.len() <= MOST_FILES {
            return Ok(());
        }
        let message = format!("{} has more than {MOST_FILES} files", folder.display());
        Err(Problem::new("too-many-files", message)
            .remedy("move what the study does not need out of its folder, or allow it whatever it contains: `corroborate trust --always`"))
    }

    fn add(&mut self, folder: &Path, path: &Path, kind: FileType) -> Result<(), Problem> {
        let what = match (kind.is_symlink(), kind.is_file()) {
            (true, _) => Some(behind_link(folder, path)?),
            (_, true) if is_data(path) => None,
            (_, true) => Some(hash_of(&bytes_of(path)?)),
            _ => Some("neither a file nor a folder".to_owned()),
        };
        if let Some(what) = what {
            self.files.insert(named(folder, path), what);
        }
        Ok(())
    }

    /// What the words of a program lead to.
    fn add_named(&mut self, folder: &Path, program: &NamedProgram) -> Result<(), Problem> {
        for word in program.words.iter().chain(&program.files) {
            let Ok(path) = program.folder.join(word).canonicalize() else {
                continue;
            };
            let belongs = Path::new(word).is_relative() || path.starts_with(folder);
            let name = named(folder, &path);
            if belongs && path.is_file() && !self.files.contains_key(&name) {
                self.files.insert(name, hash_of(&bytes_of(&path)?));
            }
        }
        Ok(())
    }

    /// Whether a file of the study is part of it.
    pub(super) fn has(&self, folder: &Path, file: &Path) -> bool {
        let path = folder.join(file).canonicalize();
        path.is_ok_and(|path| self.files.contains_key(&named(folder, &path)))
    }

    /// In what another content differs from this one, in words: the first files, and how many more.
    pub(super) fn changes_to(&self, now: &Self) -> String {
        const SHOWN: usize = 5;
        let names: BTreeSet<&String> = self.files.keys().chain(now.files.keys()).collect();
        let change = |name: &&String| match (self.files.get(*name), now.files.get(*name)) {
            (Some(old), Some(new)) if old == new => None,
            (Some(_), Some(_)) => Some(format!("{name} was changed")),
            (None, _) => Some(format!("{name} is new")),
            (_, None) => Some(format!("{name} is gone")),
        };
        let all: Vec<String> = names.iter().filter_map(change).collect();
        let shown = all
            .iter()
            .take(SHOWN)
            .cloned()
            .collect::<Vec<_>>()
            .join(", ");
        match all.len().saturating_sub(SHOWN) {
            0 => shown,
            more => format!("{shown}, and {more} more"),
        }
    }
}

/// Whether it is a table or a recording, and no more.
fn is_data(path: &Path) -> bool {
    let extension = path.extension().and_then(|it| it.to_str());
    extension.is_some_and(|it| DATA.contains(&it)) && !host::system::may_be_executed(path)
}

/// What a link is: where it leads to, and the bytes behind it if that is a file.
fn behind_link(folder: &Path, link: &Path) -> Result<String, Problem> {
    let cannot = |error: std::io::Error| Problem::cannot_read(link, &error);
    let to = std::fs::read_link(link).map_err(cannot)?;
    let leads = format!("leads to {to:?}");
    let Ok(whole) = link.canonicalize() else {
        return Ok(leads);
    };
    if whole.is_dir() {
        let is_of_it = whole.strip_prefix(folder).is_ok_and(|below| {
            let first = below.components().next();
            !first.is_some_and(|it| NOT_OF_IT.iter().any(|name| it.as_os_str() == *name))
        });
        return match is_of_it {
            true => Ok(leads),
            false => Err(leads_out(link, &whole)),
        };
    }
    match whole.is_file() {
        true => Ok(format!("{leads} {}", hash_of(&bytes_of(&whole)?))),
        false => Ok(leads),
    }
}

fn leads_out(link: &Path, to: &Path) -> Problem {
    let message = format!(
        "{} leads to {}, whose content would not be seen to change",
        link.display(),
        to.display()
    );
    Problem::new("link-leads-out", message).remedy(
        "put the folder itself into the study, or allow the study whatever it contains: `corroborate trust --always`",
    )
}

fn bytes_of(path: &Path) -> Result<Vec<u8>, Problem> {
    host::files::read_file(path, u64::MAX - 1)
}

/// Its path in the study; the whole path of what lies elsewhere. What is not UTF-8 is written so that no two are alike.
fn named(folder: &Path, path: &Path) -> String {
    let path = path.strip_prefix(folder).unwrap_or(path);
    match path.to_str() {
        Some(name) => name.to_owned(),
        None => format!("{path:?}"),
    }
}

/// The study's folder as the system knows it.
pub(super) fn whole(folder: &Path) -> Result<PathBuf, Problem> {
    let cannot = |error: std::io::Error| Problem::cannot_read(folder, &error);
    folder.canonicalize().map_err(cannot)
}
