//! A program with all that it starts, as one: it is looked at, asked to end, and ended.
//!
//! | | Unix (`group/unix.rs`) | Windows (`group/windows.rs`) |
//! |---|---|---|
//! | they are held together by | a group of processes | a job object |
//! | Ctrl-C at our terminal | does not reach them | does not reach them |
//! | they are asked to end by | a signal to the group | nothing: there is no request that every program there takes |
//! | they are ended by | `SIGKILL` to the group | the end of the job |
//!
//! What a program leaves behind when it ends by itself is its own.

#[cfg(unix)]
mod unix;
#[cfg(windows)]
mod windows;

#[cfg(unix)]
use unix::Processes;
#[cfg(unix)]
pub(crate) use unix::crash;
#[cfg(windows)]
use windows::Processes;
#[cfg(windows)]
pub(crate) use windows::crash;

#[cfg(not(any(unix, windows)))]
compile_error!(
    "programs are started in groups that can be ended as one, which this crate can do on Unix and Windows: add a module beside `group/unix.rs`"
);

use crate::processor;
use std::process::{ChildStderr, ChildStdin, ChildStdout, Command, ExitStatus};
use std::time::{Duration, Instant};

/// How often a program that runs is looked at.
pub(crate) const LOOK: Duration = Duration::from_millis(5);

/// What programs are asked to end by, where there is such a thing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Request {
    /// As Ctrl-C does.
    Interrupt,
    /// As a system that shuts down does.
    Terminate,
}

/// A program that was started, with all that it starts.
pub(crate) struct Group {
    processes: Processes,
    /// The processor time of the program, as it was last seen.
    secs: Option<f64>,
    /// How the program ended, once it has.
    status: Option<ExitStatus>,
}

impl Group {
    /// Starts a program.
    pub(crate) fn start(command: Command) -> std::io::Result<Self> {
        Ok(Self {
            processes: Processes::start(command)?,
            secs: None,
            status: None,
        })
    }

    /// Its input, if that is a pipe and was not taken before.
    pub(crate) fn input(&mut self) -> Option<ChildStdin> {
        self.processes.input().take()
    }

    /// Its output, likewise.
    pub(crate) fn output(&mut self) -> Option<ChildStdout> {
        self.processes.output().take()
    }

    /// Its error output, likewise.
    pub(crate) fn errors(&mut self) -> Option<ChildStderr> {
        self.processes.errors().take()
    }

    /// How the program ended, if it did.
    pub(crate) fn ended(&mut self) -> std::io::Result<Option<ExitStatus>> {
        if self.status.is_none() {
            // Once its end is known its time is not, and its number may be another's.
            self.secs = processor::of_process(self.processes.id()).or(self.secs);
            self.status = self.processes.try_wait()?;
        }
        Ok(self.status)
    }

    /// How the program ended, if it does within a while.
    pub(crate) fn wait(&mut self, longest: Duration) -> Option<ExitStatus> {
        let began = Instant::now();
        loop {
            // Of what cannot be looked at nothing is known.
            let status = self.ended().unwrap_or_default();
            if status.is_some() || began.elapsed() >= longest {
                return status;
            }
            std::thread::sleep(LOOK);
        }
    }

    /// Asks all to end, and ends what is left once the program has or a while is over.
    pub(crate) fn end(&mut self, request: Request, longest: Duration) {
        if self.processes.ask(request) {
            self.wait(longest);
        }
        self.kill();
    }

    /// Ends all at once.
    pub(crate) fn kill(&mut self) {
        self.processes.kill();
        while self.ended().is_ok_and(|status| status.is_none()) {
            std::thread::sleep(LOOK);
        }
    }

    /// The processor time of the program and of those of its children whose end it has seen, as it was last looked at; 0 where
    /// the system does not tell.
    pub(crate) fn processor_secs(&self) -> f64 {
        self.secs.unwrap_or(0.0)
    }

    /// The program's number, which may be another's once it has ended.
    #[cfg(test)]
    pub(crate) fn id(&self) -> u32 {
        self.processes.id()
    }
}

#[cfg(test)]
#[cfg(unix)]
mod tests {
    use super::*;
    use std::io::{BufRead, BufReader};
    use std::process::Stdio;

    /// A shell and a child of it, which has said its number.
    fn with_child(script: &str) -> (Group, String) {
        let mut command = Command::new("sh");
        command.args(["-c", script]).stdout(Stdio::piped());
        let mut group = Group::start(command).expect("started");
        let mut line = String::new();
        let output = group.output().expect("a pipe");
        BufReader::new(output).read_line(&mut line).expect("a line");
        (group, line.trim().to_owned())
    }

    /// Whether a process is there and is not merely unburied.
    fn runs(id: &str) -> bool {
        let asked = Command::new("ps")
            .args(["-o", "stat=", "-p", id])
            .output()
            .expect("ps");
        let stat = String::from_utf8_lossy(&asked.stdout);
        !stat.trim().is_empty() && !stat.trim().starts_with('Z')
    }

    fn soon_gone(id: &str) -> bool {
        let began = Instant::now();
        while runs(id) && began.elapsed() < Duration::from_secs(60) {
            std::thread::sleep(LOOK);
        }
        !runs(id)
    }

    #[test]
    fn what_a_program_has_started_ends_with_it() {
        let (mut group, child) = with_child("sleep 600 & echo $!; wait");
        assert!(runs(&child));
        group.kill();
        assert!(soon_gone(&child));
        // Nor does what does not listen to a request outlive it.
        let deaf =
            "(trap '' TERM; echo $(exec sh -c 'echo $PPID'); while :; do sleep 1; done) & wait";
        let (mut group, child) = with_child(deaf);
        assert!(runs(&child));
        group.end(Request::Terminate, Duration::from_millis(50));
        assert!(soon_gone(&child));
    }

    #[test]
    fn who_asks_gives_time_to_end() {
        let (mut group, _) =
            with_child("trap 'exit 7' INT; echo ready; while :; do sleep 0.01; done");
        group.end(Request::Interrupt, Duration::from_secs(60));
        let status = group.ended().expect("looked at").expect("ended");
        assert_eq!(status.code(), Some(7));
    }
}
