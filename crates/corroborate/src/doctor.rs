//! What of its surroundings the program finds, what is missing, and what each missing thing disables.

use crate::outcome::{Ended, Outcome};
use crate::technique::simulation::load_engine;
use host::Host;
use rig::surroundings::{first_line, joins_dds};
use schemars::JsonSchema;
use serde::Serialize;
use testbench::SUPPORTED_VERSION;

/// Whether something is there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Presence {
    /// It is there and can be used.
    Present,
    /// It is not there, or cannot be used.
    Missing,
}

/// One thing that the program looks for.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Examined {
    /// What it is.
    pub name: String,
    /// Whether it is there.
    pub presence: Presence,
    /// What was found, or why it cannot be used.
    pub found: String,
    /// What needs it.
    pub needed_for: String,
    /// What to do if it is missing.
    pub remedy: String,
}

/// What was found around the program.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, JsonSchema)]
pub struct DoctorReport {
    /// The form of this report; what begins with the same number can be read alike.
    pub format: String,
    /// The program's version.
    pub version: String,
    /// Which build computes: results of another one are stale.
    pub build: String,
    /// How many threads work at a time.
    pub threads: usize,
    /// What was looked for.
    pub examined: Vec<Examined>,
}

/// Looks for all that some of the work needs and that does not come with the program.
#[must_use]
pub fn doctor(host: &Host) -> DoctorReport {
    DoctorReport {
        format: "1.0".into(),
        version: env!("CARGO_PKG_VERSION").into(),
        build: host.build.as_str().to_owned(),
        threads: rayon::current_num_threads(),
        examined: vec![
            physics(host),
            python(host),
            controllers(host),
            scratch(host),
            network(),
        ],
    }
}

fn examined(name: &str, found: Result<String, String>, needed_for: &str, remedy: &str) -> Examined {
    Examined {
        name: name.to_owned(),
        presence: match found {
            Ok(_) => Presence::Present,
            Err(_) => Presence::Missing,
        },
        found: found.unwrap_or_else(|why| why),
        needed_for: needed_for.to_owned(),
        remedy: remedy.to_owned(),
    }
}

fn physics(host: &Host) -> Examined {
    let place = host.physics_library.as_ref();
    let place = place.map_or_else(String::new, |it| it.display().to_string());
    let loaded = load_engine(host).map(|_| place);
    examined(
        "MuJoCo",
        loaded.map_err(|problem| problem.message().to_owned()),
        "scenes and the handover in full physics: `simulate`, `explore`, `replay`, `engines`, `rare`, `calibrate`, and studies that simulate",
        &format!(
            "`pip install 'mujoco=={SUPPORTED_VERSION}.*'` beside the Python package, or set CORROBORATE_MUJOCO to the path of \
             libmujoco.so; in a copy of the repository start the program as `./corroborate`, which fetches it"
        ),
    )
}

fn python(host: &Host) -> Examined {
    examined(
        "python3",
        first_line(&["python3", "--version"], host.python_path.as_deref()),
        "controllers, simulators and adapters that are written in Python",
        "install Python 3.8 or later",
    )
}

fn controllers(host: &Host) -> Examined {
    // The folder in which somebody stands may be a stranger's, and Python would look there first.
    let script = "import sys; sys.path = [p for p in sys.path if p]; import corroborate_controller as c; print(c.__file__)";
    let found = first_line(&["python3", "-c", script], host.python_path.as_deref());
    examined(
        "corroborate_controller",
        found.map_err(|_| "python3 does not find the module".to_owned()),
        "controllers of scenes that are written in Python with our client",
        "studies of `corroborate init` that need it bring it along; to have it elsewhere, copy controller/corroborate_controller of \
         `corroborate init DIR --template gripper`, or start the program of a copy of the repository as `./corroborate`",
    )
}

fn scratch(host: &Host) -> Examined {
    let folder = &host.scratch;
    let path = folder.join(format!("corroborate-doctor-{}", std::process::id()));
    let written = std::fs::write(&path, b"x");
    let _ = std::fs::remove_file(&path);
    let shown = folder.display().to_string();
    examined(
        "scratch folder",
        written
            .map(|()| shown.clone())
            .map_err(|error| format!("{shown} cannot be written: {error}")),
        "simulators that are commands, outside of campaigns",
        "set TMPDIR to a folder that can be written",
    )
}

fn network() -> Examined {
    examined(
        "multicast",
        joins_dds().map(|()| "this machine joins the group of DDS".to_owned()),
        "ROS 2 and DDS: `watch --dds`, and nodes as controllers",
        "give the machine a network interface that takes multicast; in a container, share the network of its host",
    )
}

impl Ended for DoctorReport {
    /// Whether anything is missing: then something cannot be done here.
    fn outcome(&self) -> Outcome {
        let mut examined = self.examined.iter();
        match examined.any(|it| it.presence == Presence::Missing) {
            true => Outcome::Inconclusive,
            false => Outcome::Holds,
        }
    }
}
