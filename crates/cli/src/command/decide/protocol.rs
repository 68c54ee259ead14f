//! `corroborate decide --protocol`: lines on standard input, an answer to each on standard output.

use super::{Done, keep};
use crate::args::Decide;
use corroborate::Ended;
use corroborate::decide::{Answer, Protocol, ProtocolRequest};
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
        if let (Some(out), Answer::Report(report)) = (&arguments.out, &answer) {
            keep(report, out)?;
        }
        let mut output = std::io::stdout().lock();
        let answer = in_one_line(&answer)?;
        let said = writeln!(output, "{answer}").and_then(|()| output.flush());
        said.map_err(lost)?;
    }
    Ok(Done {
        output: String::new(),
        outcome: protocol.report().outcome(),
    })
}

fn in_one_line(answer: &Answer) -> Result<String, Problem> {
    let text = serde_json::to_string(answer);
    text.map_err(|error| Problem::new("cannot-write", error.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_committed_schema_is_the_form_that_is_printed() {
        let schema: serde_json::Value = schemars::schema_for!(Answer).into();
        crate::command::tests::assert_schema_is_committed("decide-answer.schema.json", &schema);
    }
}
