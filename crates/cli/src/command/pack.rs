//! `corroborate pack`: what assessors ask for, in one signed archive; and the key that signs.

mod pdf;

use super::{Done, Host, json};
use crate::args::{Format, Pack};
use crate::drawing::drawing;
use crate::written;
use corroborate::pack::{NewKey, PackDrawing, PackReport};
use corroborate::{Outcome, PackRequest, StudyResult};
use diagnostic::{Problem, counted};
use report::sarif::sarif;
use std::path::Path;

/// Makes a pack, or a key.
pub fn pack(arguments: &Pack, setting: &Host) -> Result<Done, Problem> {
    if let Some(file) = &arguments.new_key {
        return new_key(file, arguments.format);
    }
    let study = arguments.study.clone().unwrap_or_default();
    let request = PackRequest {
        study: study.clone(),
        out: arguments.out.clone(),
        to: arguments.to.clone(),
        key: arguments.key.clone(),
        sboms: arguments.sbom.clone(),
        pdf: arguments.pdf.clone(),
        with_recordings: arguments.with_recordings,
        techniques: corroborate::Techniques::default(),
    };
    let report = packed(&request, setting)?;
    Ok(Done {
        output: match arguments.format {
            Format::Json => json(&report)?,
            Format::Text => text(&report),
        },
        outcome: Outcome::Holds,
    })
}

/// Makes a pack with all that is drawn for it.
pub fn packed(request: &PackRequest, setting: &Host) -> Result<PackReport, Problem> {
    let drawn = PackDrawing {
        result: &drawing(),
        junit: &|result| report::junit::xml(&report::junit::of_study(result)),
        sarif: &findings,
        markdown: &report::markdown,
        traceability: &report::traceability,
        pdf: &|page| pdf::printed(page, setting),
    };
    corroborate::pack(request, setting, &drawn)
}

/// Findings with their places in the study's files as the pack has them.
fn findings(folder: &Path, result: &StudyResult) -> String {
    let mut alerts = written::of_study(folder, result);
    for spot in alerts.iter_mut().filter_map(|it| it.spot.as_mut()) {
        let below = Path::new(&spot.file).strip_prefix(folder);
        let below = below.map(|it| it.display().to_string());
        spot.file = ::pack::encoded(&format!("study/{}", below.unwrap_or_default()));
    }
    sarif(env!("CARGO_PKG_VERSION"), &alerts)
}

fn text(report: &PackReport) -> String {
    let pack = report.pack.display();
    let mut text = format!(
        "{} in {pack} ({} bytes)\nSHA-256: {}\n",
        counted(report.parts as usize, "part"),
        report.bytes,
        report.sha256
    );
    text.push_str(&match &report.signed_by {
        Some(key) => format!("Signed by the key {key}\n"),
        None => "NOT SIGNED: nothing will show who made this pack. `corroborate pack --new-key FILE` makes a key, `--key FILE` signs.\n".into(),
    });
    text.push_str("What the pack does not show (README.md in it):\n");
    for one in &report.not_shown {
        text.push_str(&format!("  {}: {}\n", plain(&one.of), plain(&one.words)));
    }
    text
}

/// What quotes the study's files, without what would mean something to a terminal.
fn plain(text: &str) -> String {
    diagnostic::printable_line(text).into_owned()
}

fn new_key(file: &Path, format: Format) -> Result<Done, Problem> {
    let mut seed = [0; 32];
    getrandom::fill(&mut seed).map_err(|error| {
        Problem::new(
            "no-random-numbers",
            format!("the system gives no random numbers: {error}"),
        )
        .remedy("make the key elsewhere: openssl genpkey -algorithm ed25519 -out signer.pem")
    })?;
    let key: NewKey = corroborate::pack::new_key(file, seed)?;
    Ok(Done {
        output: match format {
            Format::Json => json(&key)?,
            Format::Text => format!(
                "Secret key: {} (keep it where others cannot read it)\nPublic key: {} (give it to whoever verifies)\nIts SHA-256: {}\n",
                key.secret.display(),
                key.public.display(),
                key.id
            ),
        },
        outcome: Outcome::Holds,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::command::tests::assert_schema_is_committed;

    #[test]
    fn the_committed_schemas_are_the_forms_that_are_written() {
        let schema = schemars::schema_for!(PackReport).into();
        assert_schema_is_committed("pack.schema.json", &schema);
        let schema = schemars::schema_for!(NewKey).into();
        assert_schema_is_committed("pack-key.schema.json", &schema);
        let schema = schemars::schema_for!(corroborate::pack::Log).into();
        assert_schema_is_committed("pack-log.schema.json", &schema);
        let schema = schemars::schema_for!(::pack::Manifest).into();
        assert_schema_is_committed("statement-pack.schema.json", &schema);
    }
}
