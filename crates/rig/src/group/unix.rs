//! A group of processes, and signals to it.

use super::Request;
use rustix::process::{Pid, Signal, kill_process_group};
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::process::{Child, ChildStderr, ChildStdin, ChildStdout, Command, ExitStatus};

/// A program that leads a group of its own.
pub(super) struct Processes(Child);

impl Processes {
    pub(super) fn start(mut command: Command) -> std::io::Result<Self> {
        command.process_group(0).spawn().map(Self)
    }

    pub(super) fn id(&self) -> u32 {
        self.0.id()
    }

    pub(super) fn input(&mut self) -> &mut Option<ChildStdin> {
        &mut self.0.stdin
    }

    pub(super) fn output(&mut self) -> &mut Option<ChildStdout> {
        &mut self.0.stdout
    }

    pub(super) fn errors(&mut self) -> &mut Option<ChildStderr> {
        &mut self.0.stderr
    }

    pub(super) fn try_wait(&mut self) -> std::io::Result<Option<ExitStatus>> {
        self.0.try_wait()
    }

    /// Asks all to end; says whether there is a way to ask.
    pub(super) fn ask(&self, request: Request) -> bool {
        self.signal(match request {
            Request::Interrupt => Signal::INT,
            Request::Terminate => Signal::TERM,
        });
        true
    }

    pub(super) fn kill(&self) {
        self.signal(Signal::KILL);
    }

    fn signal(&self, signal: Signal) {
        let id = i32::try_from(self.0.id()).ok();
        if let Some(group) = id.and_then(Pid::from_raw) {
            // If it cannot be had, all of it has ended in the meantime.
            let _ = kill_process_group(group, signal);
        }
    }
}

/// What ended a program, if it did not end by itself.
pub(crate) fn crash(status: ExitStatus) -> Option<String> {
    status.signal().map(|signal| format!("signal {signal}"))
}
