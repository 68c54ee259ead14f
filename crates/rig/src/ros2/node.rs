//! A node of ROS 2 that is started for an episode and ended with it.

use crate::process::{Said, indented, keep_lines};
use crate::processor::Counted;
use std::ffi::OsStr;
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::{Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};
use testbench::controller::Setup;

/// How long a node has to end once it is asked to.
const GRACE: Duration = Duration::from_secs(2);
const LOOK: Duration = Duration::from_millis(10);

/// A running node.
pub struct Node {
    name: String,
    child: Counted,
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
    ) -> Result<Self, String> {
        let name = command.join(" ");
        let Some((program, arguments)) = command.split_first() else {
            return Err("no program is named".into());
        };
        let mut prepared = Command::new(program);
        prepared
            .args(arguments)
            .args(parameters(setup))
            .current_dir(folder)
            .env("ROS_DOMAIN_ID", domain.to_string())
            .env("PYTHONHASHSEED", "0")
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            // Ctrl-C is for us; what we end ends its nodes.
            .process_group(0);
        if let Some(path) = python_path {
            prepared.env("PYTHONPATH", path);
        }
        let mut child = prepared
            .spawn()
            .map_err(|error| format!("`{name}` cannot be started: {error}"))?;
        let said = Said::default();
        let (output, errors) = (child.stdout.take(), child.stderr.take());
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
            child: Counted::new(child),
            said,
        })
    }

    /// How it ended, if it did.
    pub fn ended(&mut self) -> Option<ExitStatus> {
        self.child.ended()
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

    fn signal(&self, signal: rustix::process::Signal) {
        let id = i32::try_from(self.child.id()).ok();
        if let Some(group) = id.and_then(rustix::process::Pid::from_raw) {
            // If it cannot be had it has ended in the meantime.
            let _ = rustix::process::kill_process_group(group, signal);
        }
    }
}

impl Drop for Node {
    fn drop(&mut self) {
        if self.ended().is_some() {
            return;
        }
        // As Ctrl-C does, on which nodes say goodbye.
        self.signal(rustix::process::Signal::INT);
        let asked = Instant::now();
        while asked.elapsed() < GRACE && self.ended().is_none() {
            std::thread::sleep(LOOK);
        }
        if self.ended().is_none() {
            self.signal(rustix::process::Signal::KILL);
            self.child.kill();
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
        let mut node = Node::start(&command, (Path::new("."), None), 42, &setup).expect("started");
        while !node.last_words().contains("    42") {
            std::thread::sleep(LOOK);
        }
        let (id, before) = (node.child.id(), processor::used_secs());
        drop(node);
        let secs = processor::used_secs() - before;
        // A shell needs a tenth of a second or so for that; ending it hardly takes this thread any time.
        assert!(secs > 0.02, "{secs} s");
        assert!(!Path::new(&format!("/proc/{id}")).exists());
    }
}
