//! A node of ROS 2 that is started for an episode and ended with it.

use crate::consent::Consent;
use crate::group::{Group, Request};
use crate::process::{Said, indented, keep_lines};
use crate::processor::Counted;
use crate::start::program;
use std::ffi::OsStr;
use std::path::Path;
use std::process::{ExitStatus, Stdio};
use std::time::Duration;
use testbench::controller::Setup;

/// How long a node has to end once it is asked to.
const GRACE: Duration = Duration::from_secs(2);

/// A running node.
pub struct Node {
    name: String,
    group: Counted,
    said: Said,
}

impl Node {
    /// Starts `command` in `folder` in a domain, with simulated time, the seed and the settings as
    /// parameters, and with `PYTHONPATH` if one is given.
    pub fn start(
        command: &[String],
        (folder, python_path): (&Path, Option<&OsStr>),
        domain: u16,
        setup: &Setup,
        consent: &Consent,
    ) -> Result<Self, String> {
        let name = command.join(" ");
        let mut prepared = program(command, folder, consent)?;
        prepared
            .args(parameters(setup))
            .env("ROS_DOMAIN_ID", domain.to_string())
            .env("PYTHONHASHSEED", "0")
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        if let Some(path) = python_path {
            prepared.env("PYTHONPATH", path);
        }
        let mut group = Group::start(prepared)
            .map_err(|error| format!("`{name}` cannot be started: {error}"))?;
        let said = Said::default();
        let (output, errors) = (group.output(), group.errors());
        let kept = [said.clone(), said.clone()];
        let [first, second] = kept;
        if let Some(output) = output {
            std::thread::spawn(move || keep_lines(output, &first));
        }
        if let Some(errors) = errors {
            std::thread::spawn(move || keep_lines(errors, &second));
        }
        Ok(Self {
            name,
            group: Counted(group),
            said,
        })
    }

    /// How it ended, if it did.
    pub fn ended(&mut self) -> Option<ExitStatus> {
        // Of what cannot be looked at nothing is known.
        self.group.ended().unwrap_or_default()
    }

    /// What it does and what it said last.
    pub fn last_words(&mut self) -> String {
        let does = match self.ended() {
            Some(status) => format!("ended with {status}"),
            None => "still runs".to_owned(),
        };
        let lines = indented(&self.said);
        let output = if lines.is_empty() {
            String::new()
        } else {
            format!(" and said last\n{lines}")
        };
        format!("`{}` {does}{output}", self.name)
    }
}

impl Drop for Node {
    fn drop(&mut self) {
        if self.ended().is_none() {
            // On Ctrl-C nodes say goodbye.
            self.group.end(Request::Interrupt, GRACE);
        }
    }
}

/// The arguments that a program of ROS 2 takes its parameters from.
fn parameters(setup: &Setup) -> Vec<String> {
    let mut arguments = vec!["--ros-args".to_owned()];
    let mut give = |name: &str, value: String| {
        arguments.extend(["-p".to_owned(), format!("{name}:={value}")]);
    };
    give("use_sim_time", "true".to_owned());
    give("seed", setup.seed.to_string());
    give("period_secs", format!("{:?}", setup.period_secs));
    for (name, value) in &setup.settings {
        // JSON is YAML, which parameters are given in.
        give(name, value.to_string());
    }
    arguments
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::processor;

    #[test]
    fn parameters_are_given_as_ros_2_takes_them() {
        let mut setup = Setup {
            seed: 7,
            period_secs: 0.05,
            ..Setup::default()
        };
        setup.settings.insert("goal_m".into(), 10.0.into());
        setup.settings.insert("name".into(), "a b".into());
        let given = parameters(&setup).join(" ");
        let expected = "--ros-args -p use_sim_time:=true -p seed:=7 -p period_secs:=0.05 -p goal_m:=10.0 -p name:=\"a b\"";
        assert_eq!(given, expected);
    }

    #[test]
    fn a_node_is_ended_what_it_said_is_known_and_its_processor_time_counts() {
        let work = "i=0; while [ $i -lt 200000 ]; do i=$((i+1)); done";
        let command = format!("{work}; echo $ROS_DOMAIN_ID; exec sleep 600");
        let command = ["sh", "-c", &command].map(str::to_owned);
        let setup = Setup::default();
        let place = (Path::new("."), None);
        let mut node =
            Node::start(&command, place, 42, &setup, &Consent::typed()).expect("started");
        while !node.last_words().contains("    42") {
            std::thread::sleep(crate::group::LOOK);
        }
        let (id, before) = (node.group.id(), processor::used_secs());
        drop(node);
        let secs = processor::used_secs()
            .zip(before)
            .map(|(now, before)| now - before);
        let secs = secs.expect("Unix tells");
        // A shell needs a tenth of a second or so for that; ending it hardly takes this thread any time.
        assert!(secs > 0.02, "{secs} s");
        assert!(!Path::new(&format!("/proc/{id}")).exists());
    }
}
