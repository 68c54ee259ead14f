//! What is around the program: whether other programs answer, and whether the network takes messages to many.

use crate::command::once;
use crate::group::Group;
use host::Cancel;
use std::ffi::OsStr;
use std::net::{Ipv4Addr, UdpSocket};
use std::process::{Command, Stdio};
use std::time::Duration;

/// How long a program may take to answer.
const ANSWER: Duration = Duration::from_secs(10);
/// The group by which participants of DDS find each other (OMG, DDS Interoperability Wire Protocol 2.2, section 9.6.1.4).
const DDS_GROUP: Ipv4Addr = Ipv4Addr::new(239, 255, 0, 1);

/// The first line that a program prints, if it ends well within ten seconds; its search path for Python's modules is given, if there is
/// one. Its words are those of this program: nothing that a study says can be given.
///
/// # Errors
/// In words: it cannot be started, failed, or did not end.
pub fn first_line(words: &[&'static str], python_path: Option<&OsStr>) -> Result<String, String> {
    let (program, arguments) = words.split_first().ok_or("no program is named")?;
    let mut command = Command::new(program);
    command
        .args(arguments)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::null());
    if let Some(path) = python_path {
        command.env("PYTHONPATH", path);
    }
    // Whatever it starts is ended with it.
    let group =
        Group::start(command).map_err(|error| format!("`{program}` cannot be started: {error}"))?;
    once::output_of(group, ANSWER, &Cancel::default())
}

/// Whether this machine joins the group by which participants of DDS find each other.
///
/// # Errors
/// In words, what the system says.
pub fn joins_dds() -> Result<(), String> {
    let socket = UdpSocket::bind((Ipv4Addr::UNSPECIFIED, 0)).map_err(|error| error.to_string())?;
    let joined = socket.join_multicast_v4(&DDS_GROUP, &Ipv4Addr::UNSPECIFIED);
    joined.map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn programs_answer_fail_or_are_not_there() {
        assert_eq!(
            first_line(&["sh", "-c", "echo one; echo two"], None),
            Ok("one".into())
        );
        assert!(first_line(&["sh", "-c", "echo no >&2; exit 3"], None).is_err());
        let missing = first_line(&["/no/such/program"], None).expect_err("not there");
        assert!(missing.contains("cannot be started"), "{missing}");
        let path = first_line(&["sh", "-c", "echo $PYTHONPATH"], Some("a:b".as_ref()));
        assert_eq!(path, Ok("a:b".into()));
    }
}
