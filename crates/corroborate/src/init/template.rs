//! The templates: whole studies, each a folder in `templates/`, whose files explain themselves.

use super::NewFile;
use diagnostic::{Problem, did_you_mean};

/// A study to begin with.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Template {
    /// A formal model and a table of trials: the shortest.
    #[default]
    Docking,
    /// An arm beside a person.
    Cobot,
    /// A mobile robot among people.
    Mobile,
    /// A gripper that places a part.
    Gripper,
    /// Another simulator.
    Command,
    /// Formal model alone.
    Formal,
    /// Recordings.
    Recordings,
    /// A learned policy.
    Policy,
}

/// The files of a folder in `templates/`, by their places in it.
macro_rules! folder {
    ($folder:literal: $($file:literal)+) => {
        &[$(($file, include_str!(concat!("../../templates/", $folder, "/", $file)))),+]
    };
}

/// The client of `clients/python`, for studies whose robot is driven by a program: they run wherever this program is installed.
/// (In the repository its files are links to it.)
const CLIENT: &[(&str, &str)] = folder!("client":
    "corroborate_controller/__init__.py" "corroborate_controller/controller.py" "corroborate_controller/coverage.py"
    "corroborate_controller/loop.py" "corroborate_controller/reports.py");

impl Template {
    /// All, the one that is taken without a name first.
    pub const ALL: [Self; 8] = [
        Self::Docking,
        Self::Cobot,
        Self::Mobile,
        Self::Gripper,
        Self::Command,
        Self::Formal,
        Self::Recordings,
        Self::Policy,
    ];

    /// By its name.
    ///
    /// # Errors
    /// `unknown-study-template`, with the name that may be meant.
    pub fn named(name: &str) -> Result<Self, Problem> {
        let found = Self::ALL.into_iter().find(|known| known.name() == name);
        found.ok_or_else(|| {
            let names = Self::ALL.map(Self::name);
            let problem = Problem::new(
                "unknown-study-template",
                format!("there is no template `{name}`"),
            );
            match did_you_mean(name, names) {
                Some(meant) => problem.remedy(format!("did you mean `{meant}`?")),
                None => problem.remedy(format!("there are {}", names.join(", "))),
            }
        })
    }

    /// What `--template` calls it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Docking => "docking",
            Self::Cobot => "cobot",
            Self::Mobile => "mobile",
            Self::Gripper => "gripper",
            Self::Command => "command",
            Self::Formal => "formal",
            Self::Recordings => "recordings",
            Self::Policy => "policy",
        }
    }

    /// What it is a study of.
    pub const fn meaning(self) -> &'static str {
        match self {
            Self::Docking => {
                "a formal model and a table of trials; the shortest, without simulation"
            }
            Self::Cobot => "a small arm works beside a person who reaches into its cell; simulated",
            Self::Mobile => {
                "a mobile robot drives to its goal past shelves and a person; simulated"
            }
            Self::Gripper => "a gripper lifts a part and places it in a tray; simulated",
            Self::Command => {
                "an outside simulator of a few lines, against a formal model and trials"
            }
            Self::Formal => "a formal model, requirements in sentences, a table of trials",
            Self::Recordings => "recordings in CSV judged by monitors, and a table of trials",
            Self::Policy => "a learned policy evaluated from many seeds, with a success rate",
        }
    }

    /// Its files.
    pub fn files(self) -> Vec<NewFile> {
        let own = self.own().iter();
        let mut files: Vec<NewFile> = own
            .map(|(path, text)| NewFile::text(*path, *text))
            .collect();
        if self.has_program() {
            let client = CLIENT.iter();
            files.extend(
                client.map(|(path, text)| NewFile::text(format!("controller/{path}"), *text)),
            );
        }
        files.push(NewFile::text(".gitignore", "results/\n__pycache__/\n"));
        files
    }

    /// Whether a program drives its robot.
    const fn has_program(self) -> bool {
        matches!(self, Self::Cobot | Self::Mobile | Self::Gripper)
    }

    const fn own(self) -> &'static [(&'static str, &'static str)] {
        match self {
            Self::Docking => {
                folder!("docking": "README.md" "study.toml" "requirements.toml" "vocabulary.toml"
                "parameters.toml" "ledger.toml" "model.prism" "attempts.csv" "requirements.csv" "failure_modes.csv")
            }
            Self::Cobot => {
                folder!("cobot": "README.md" "study.toml" "requirements.toml" "vocabulary.toml"
                "parameters.toml" "ledger.toml" "simulation/scene.toml" "simulation/arm.urdf" "controller/worker.py")
            }
            Self::Mobile => {
                folder!("mobile": "README.md" "study.toml" "requirements.toml" "vocabulary.toml"
                "parameters.toml" "ledger.toml" "simulation/scene.toml" "simulation/carrier.urdf" "controller/driver.py")
            }
            Self::Gripper => {
                folder!("gripper": "README.md" "study.toml" "requirements.toml" "vocabulary.toml"
                "parameters.toml" "ledger.toml" "simulation/scene.toml" "simulation/gripper.urdf" "controller/placer.py")
            }
            Self::Command => {
                folder!("command": "README.md" "study.toml" "requirements.toml" "vocabulary.toml"
                "parameters.toml" "ledger.toml" "topics.toml" "stimulus.toml" "simulate.py" "model.prism" "trials.csv")
            }
            Self::Formal => {
                folder!("formal": "README.md" "study.toml" "requirements.toml" "vocabulary.toml"
                "parameters.toml" "ledger.toml" "model.prism" "properties.props" "trials.csv")
            }
            Self::Recordings => {
                folder!("recordings": "README.md" "study.toml" "requirements.toml" "vocabulary.toml"
                "parameters.toml" "ledger.toml" "topics.toml" "acceptance.csv"
                "recordings/2024-05-13_shift2.csv" "recordings/2024-05-14_shift1.csv" "recordings/2024-05-15_shift2.csv"
                "recordings/2024-05-16_shift1.csv" "recordings/2024-05-17_shift2.csv" "recordings/2024-05-18_shift1.csv"
                "recordings/2024-05-19_shift2.csv" "recordings/2024-05-20_shift1.csv" "recordings/2024-05-21_shift2.csv"
                "recordings/2024-05-22_shift1.csv")
            }
            Self::Policy => {
                folder!("policy": "README.md" "study.toml" "requirements.toml" "vocabulary.toml"
                "parameters.toml" "ledger.toml" "topics.toml" "trained.toml" "blurred.toml" "policy.py" "evaluate.py"
                "weights.json")
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;
    use std::path::{Path, PathBuf};

    fn files_in(folder: &Path, within: &Path, found: &mut BTreeSet<PathBuf>) {
        for entry in std::fs::read_dir(folder).expect("a folder").flatten() {
            let (path, inside) = (entry.path(), within.join(entry.file_name()));
            match path.is_dir() {
                true if path.ends_with("__pycache__") => {}
                true => files_in(&path, &inside, found),
                false => drop(found.insert(inside)),
            }
        }
    }

    #[test]
    fn a_template_has_every_file_of_its_folder() {
        let templates = Path::new(env!("CARGO_MANIFEST_DIR")).join("templates");
        for template in Template::ALL {
            let mut there = BTreeSet::new();
            files_in(&templates.join(template.name()), Path::new(""), &mut there);
            let own = template.own().iter().map(|(path, _)| PathBuf::from(path));
            assert_eq!(own.collect::<BTreeSet<_>>(), there, "{template:?}");
        }
    }

    #[test]
    fn a_misspelt_name_gets_the_nearest_one() {
        assert_eq!(Template::named("cobot").expect("known"), Template::Cobot);
        let problem = Template::named("kobot").expect_err("unknown");
        assert_eq!(problem.code, "unknown-study-template");
        assert!(
            format!("{problem:?}").contains("did you mean `cobot`?"),
            "{problem:?}"
        );
        assert!(format!("{:?}", Template::named("").expect_err("unknown")).contains("policy"));
    }
}
