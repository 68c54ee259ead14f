//! The built program, run as a user would run it, on studies made by its own `init`.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use tempfile::TempDir;

/// What a call gave.
#[derive(Debug)]
pub struct Said {
    /// The exit code.
    pub code: i32,
    /// What it printed.
    pub out: String,
    /// What it said beside: progress, warnings, errors.
    pub talk: String,
}

/// The program with arguments, in a folder, without the environment's settings for it and without physics; every study may run
/// its programs, so that nothing is recorded.
pub fn command(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_corroborate"));
    command
        .args(arguments)
        .current_dir(folder)
        .stdin(Stdio::null())
        .env("CORROBORATE_MUJOCO", "")
        .env("CORROBORATE_TRUST", "/");
    command
}

/// Runs the program to its end.
pub fn corroborate(folder: &Path, arguments: &[&str]) -> Said {
    said(&mut command(folder, arguments))
}

/// Runs a command to its end.
pub fn said(command: &mut Command) -> Said {
    let output = command.output().expect("the program starts");
    Said {
        code: output.status.code().unwrap_or(-1),
        out: String::from_utf8(output.stdout).expect("it prints text"),
        talk: String::from_utf8(output.stderr).expect("it says text"),
    }
}

/// The exit code that a report of `simulate` asks for by its verdicts.
pub fn code_of_verdicts(report: &serde_json::Value) -> i32 {
    let verdicts = report["verdicts"].as_array().expect("verdicts");
    let has = |names: &[&str]| {
        let mut all = verdicts.iter();
        all.any(|it| names.contains(&it["verdict"].as_str().expect("a verdict")))
    };
    match (has(&["violated"]), has(&["undecided", "not-covered"])) {
        (true, _) => 1,
        (_, true) => 3,
        _ => 0,
    }
}

/// A fresh study `study` in a folder of its own: a formal model and a table of experiments.
pub struct Study {
    folder: TempDir,
}

impl Study {
    /// The study that `corroborate init` makes.
    pub fn new() -> Self {
        Self::made_by(&["init", "study"])
    }

    /// The study that `corroborate init --template` makes.
    pub fn of_template(template: &str) -> Self {
        Self::made_by(&["init", "study", "--template", template])
    }

    fn made_by(arguments: &[&str]) -> Self {
        let study = Self {
            folder: TempDir::new().expect("a temporary folder"),
        };
        let said = study.run(arguments);
        assert_eq!(said.code, 0, "{said:?}");
        study
    }

    /// The folder in which the study lies.
    pub fn beside(&self) -> &Path {
        self.folder.path()
    }

    /// A file of the study.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join("study").join(name)
    }

    /// Runs the program beside the study.
    pub fn run(&self, arguments: &[&str]) -> Said {
        corroborate(self.folder.path(), arguments)
    }

    /// Replaces the first `old` in a file of the study by `new`.
    pub fn edit(&self, name: &str, old: &str, new: &str) -> &Self {
        let text = std::fs::read_to_string(self.path(name)).expect("the file can be read");
        assert!(text.contains(old), "{name} has no `{old}`");
        self.write(name, text.replacen(old, new, 1))
    }

    /// Writes a file of the study.
    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) -> &Self {
        let path = self.path(name);
        let folder = path.parent().expect("a folder");
        std::fs::create_dir_all(folder).expect("the folder can be made");
        std::fs::write(path, content).expect("the file can be written");
        self
    }

    /// All files beside and in the study with their contents.
    pub fn contents(&self) -> BTreeMap<PathBuf, Vec<u8>> {
        contents(self.folder.path())
    }
}

/// All files below a folder with their contents.
pub fn contents(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).expect("a folder can be listed") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let content = std::fs::read(&path).expect("a file can be read");
                found.insert(path, content);
            }
        }
    }
    found
}
