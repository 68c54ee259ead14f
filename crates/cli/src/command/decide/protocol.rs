//! `corroborate decide --protocol`: lines on standard input, an answer to each on standard output.

use super::{Done, keep};
use crate::args::Decide;
use corroborate::Ended;
use corroborate::decide::{Protocol, ProtocolRequest};
use diagnostic::Problem;
use std::io::{BufRead, Write};

/// Answers until the input ends. The outcome is that of the trials told by then.
pub fn converse(arguments: &Decide) -> Result<Done, Problem> {
    let request = ProtocolRequest {
        requirement: arguments.requirement.clone(),
        command: arguments.command.clone(),
        rule: arguments.rule(),
        seed: arguments.seed,
        out: arguments.out.clone(),
    };
    let mut protocol = Protocol::new(request)?;
    let lost = |error: std::io::Error| Problem::data_lost("cannot-read", error.to_string());
    for line in std::io::stdin().lock().lines() {
        let line = line.map_err(lost)?;
        if line.trim().is_empty() {
            continue;
        }
        let answer = protocol.answer(&line)?;
        if let (Some(out), "report") = (&arguments.out, line.trim()) {
            keep(&protocol.report(), out)?;
        }
        let mut output = std::io::stdout().lock();
        let said = writeln!(output, "{answer}").and_then(|()| output.flush());
        said.map_err(lost)?;
    }
    Ok(Done {
        output: String::new(),
        outcome: protocol.report().outcome(),
    })
}
