//! A job object, to which a program belongs before its first instruction.

use super::Request;
use process_wrap::std::{ChildWrapper, CommandWrap, CreationFlags, JobObject};
use std::process::{ChildStderr, ChildStdin, ChildStdout, Command, ExitStatus};
use windows::Win32::System::Threading::CREATE_NEW_PROCESS_GROUP;

/// Exit codes from here on are those of exceptions that nobody has handled: `NTSTATUS` with the severity "error".
const EXCEPTIONS: u32 = 0xC000_0000;

/// A program in a job of its own.
pub(super) struct Processes(Box<dyn ChildWrapper>);

impl Processes {
    pub(super) fn start(command: Command) -> std::io::Result<Self> {
        let mut wrapped = CommandWrap::from(command);
        wrapped
            .wrap(CreationFlags(CREATE_NEW_PROCESS_GROUP))
            .wrap(JobObject);
        wrapped.spawn().map(Self)
    }

    pub(super) fn id(&self) -> u32 {
        self.0.id()
    }

    pub(super) fn input(&mut self) -> &mut Option<ChildStdin> {
        self.0.stdin()
    }

    pub(super) fn output(&mut self) -> &mut Option<ChildStdout> {
        self.0.stdout()
    }

    pub(super) fn errors(&mut self) -> &mut Option<ChildStderr> {
        self.0.stderr()
    }

    pub(super) fn try_wait(&mut self) -> std::io::Result<Option<ExitStatus>> {
        self.0.try_wait()
    }

    /// There is no way to ask: a message to its windows or its console reaches few programs.
    pub(super) fn ask(&self, _: Request) -> bool {
        false
    }

    pub(super) fn kill(&mut self) {
        // If it cannot be ended, all of it has ended in the meantime.
        let _ = self.0.start_kill();
    }
}

/// What ended a program, if it did not end by itself.
pub(crate) fn crash(status: ExitStatus) -> Option<String> {
    let code = status.code()?.cast_unsigned();
    (code >= EXCEPTIONS).then(|| format!("exception {code:#X}"))
}
