//! `corroborate verify`: whether every figure of a result follows from its evidence, and every hash
//! holds; of an evidence pack, whether every byte is as it was written.

use super::{Done, Host, json};
use crate::args::{Format, Verify};
use crate::drawing::drawing;
use corroborate::pack::{PackSignature, PackVerification};
use corroborate::{Ended, VerifyReport, VerifyRequest};
use diagnostic::{Problem, counted};
use std::hash::{BuildHasher, Hasher};

/// Verifies the results of a study.
pub fn verify(arguments: &Verify, setting: &Host) -> Result<Done, Problem> {
    if arguments.results.is_file() {
        return pack(arguments);
    }
    if arguments.key.is_some() {
        let message = format!(
            "{} is not an evidence pack: --key verifies a pack's signature",
            arguments.results.display()
        );
        return Err(Problem::new("not-a-pack", message)
            .remedy("name the file that `corroborate pack` wrote, or leave --key out"));
    }
    let request = VerifyRequest {
        techniques: corroborate::Techniques::default(),
        results: arguments.results.clone(),
        study: arguments.study.clone(),
        deep: arguments.deep,
        episodes: arguments.episodes,
        draw: arguments.draw.unwrap_or_else(any_number),
    };
    let report = corroborate::verify(&request, setting, Some(&drawing()))?;
    Ok(Done {
        outcome: report.outcome(),
        output: match arguments.format {
            Format::Json => json(&report)?,
            Format::Text => text(&report),
        },
    })
}

/// A number that nobody knew before: hash maps are seeded with randomness of the system. Short enough to be given again.
fn any_number() -> u64 {
    let seeded = std::hash::RandomState::new().build_hasher().finish();
    seeded % 1_000_000_000
}

/// Verifies an evidence pack.
fn pack(arguments: &Verify) -> Result<Done, Problem> {
    if arguments.study.is_some() || arguments.deep {
        let message = format!(
            "{} is a file: an evidence pack is verified by itself",
            arguments.results.display()
        );
        return Err(Problem::new("not-a-pack", message)
            .remedy("leave the study and --deep out, or unpack it and name study/results in it"));
    }
    let report = corroborate::verify_pack(&arguments.results, arguments.key.as_deref())?;
    Ok(Done {
        outcome: report.outcome(),
        output: match arguments.format {
            Format::Json => json(&report)?,
            Format::Text => text_of_pack(&report),
        },
    })
}

fn text_of_pack(report: &PackVerification) -> String {
    let mut text = String::new();
    for fault in &report.faults {
        text.push_str(&format!("✗ {}: {}\n", fault.file, fault.fault));
    }
    for checked in &report.checked {
        text.push_str(&format!("{:>8} {}\n", checked.count, checked.what));
    }
    for what in &report.not_checked {
        text.push_str(&format!("  not checked: {what}\n"));
    }
    text.push_str(&match (report.faults.len(), &report.signature) {
        (0, PackSignature::Valid { key }) => format!("The pack is as the key {key} signed it.\n"),
        (0, PackSignature::Absent) => {
            "The pack is undamaged, but NOT SIGNED: nothing shows who made it.\n".into()
        }
        (0, _) => "The pack is undamaged; its signature is NOT VERIFIED.\n".into(),
        (faults, _) => format!(
            "{}: the pack is not as it was written.\n",
            counted(faults, "fault")
        ),
    });
    text
}

/// For people.
fn text(report: &VerifyReport) -> String {
    let mut text = String::new();
    for fault in &report.faults {
        let place = match fault.place.as_str() {
            "" => String::new(),
            place => format!(" at {place}"),
        };
        text.push_str(&format!("✗ {}{place}: {}\n", fault.file, fault.fault));
    }
    for checked in &report.checked {
        text.push_str(&format!("{:>8} {}\n", checked.count, checked.what));
    }
    for what in &report.not_checked {
        text.push_str(&format!("  not derived again: {what}\n"));
    }
    text.push_str(&match report.faults.len() {
        0 => "Everything that was checked holds.\n".to_owned(),
        1 => "1 fault.\n".to_owned(),
        faults => format!("{faults} faults.\n"),
    });
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_committed_schema_is_the_form_that_is_printed() {
        let schema: serde_json::Value = schemars::schema_for!(VerifyReport).into();
        crate::command::tests::assert_schema_is_committed("verify.schema.json", &schema);
        let schema: serde_json::Value = schemars::schema_for!(PackVerification).into();
        crate::command::tests::assert_schema_is_committed("verify-pack.schema.json", &schema);
    }
}
