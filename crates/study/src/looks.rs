//! `looks.toml`: the counts by which the study was judged so far.
//!
//! `run` adds a look whenever a count is new; the file belongs to the study like its ledger, and is kept with it under
//! version control. Two histories are merged by keeping the looks of both.
//!
//! ```toml
//! [[looks]]
//! counts = [
//!     { evidence = "E3", subject = { kind = "requirement", id = "1a" }, count = 88, trials = 100 },
//! ]
//! ```
//!
//! A study whose sample sizes were fixed before the first trial says `sample_sizes = "fixed"` in `study.toml`: then
//! nothing is recorded, and each test has its whole level at the only look.

use super::{About, SampleSizes, Texts};
use crate::placed::toml_place;
use diagnostic::Problem;
use evidence::{Look, LookedAt, Looks, adds_up};
use host::files::{with_line_ends_of, write_whole};
use std::fmt::Write;
use std::path::Path;

/// The file's name.
pub const LOOKS: &str = "looks.toml";

/// The looks recorded in a study's folder; `None` if its sample sizes are fixed.
pub fn load(folder: &Path, texts: &dyn Texts, about: &About) -> Result<Option<Looks>, Problem> {
    let path = folder.join(LOOKS);
    let is_fixed = about.sample_sizes == SampleSizes::Fixed;
    if !texts.exists(&path) {
        return Ok((!is_fixed).then(Looks::default));
    }
    let source = texts.text(&path)?;
    if is_fixed {
        return Err(Problem::new(
            "looks-of-fixed-sizes",
            format!("study.toml says that all sample sizes are fixed, but {LOOKS} records looks"),
        )
        .at(&source, 0..0)
        .remedy(format!(
            "if trials are added after a look, delete `sample_sizes` from study.toml; else delete {LOOKS}"
        )));
    }
    let looks: Looks = crate::toml_text::read("bad-study-file", &source)?;
    let numbered = looks.looks.iter().enumerate();
    let mut counts = numbered.flat_map(|(look, all)| {
        let counts = all.counts.iter().enumerate();
        counts.map(move |(place, one)| (look, place, one))
    });
    let found = counts.find_map(|(look, place, one)| Some((look, place, mistake(one)?)));
    let Some((look, place, mistake)) = found else {
        return Ok(Some(looks));
    };
    let (look, place) = (look.to_string(), place.to_string());
    let place = toml_place(&source, &["looks", &look, "counts", &place]);
    Err(Problem::new("bad-look", mistake)
        .at(&source, place)
        .remedy(format!("restore {LOOKS} from version control")))
}

/// Why a look can be of no trials.
fn mistake(one: &LookedAt) -> Option<String> {
    let (id, count, trials) = (&one.evidence, one.count, one.trials);
    if count > trials || trials == 0 {
        return Some(format!(
            "a look at {id} has {count} of {trials} trials; `count` must be at most `trials`, and `trials` at least 1"
        ));
    }
    let by_subject = one.by_subject.as_ref()?;
    let sum = |place: usize| -> u128 { by_subject.iter().map(|it| u128::from(it[place])).sum() };
    (!adds_up(by_subject, [count, trials])).then(|| {
        format!(
            "a look at {id} has {count} of {trials} trials, and its `by_subject` have {} of {}; they must add up, none with \
             more successes than trials",
            sum(0),
            sum(1)
        )
    })
}

/// Records the looks, whole or not at all, unless the file has them.
pub fn keep(folder: &Path, looks: &Looks) -> Result<(), Problem> {
    let path = folder.join(LOOKS);
    let text = text(looks);
    let old = std::fs::read_to_string(&path).unwrap_or_default();
    let text = with_line_ends_of(&text, &old);
    match *text == old {
        true => Ok(()),
        false => write_whole(&path, text.as_bytes()),
    }
}

/// The file's text.
fn text(looks: &Looks) -> String {
    let mut text = String::from(
        "# The counts by which this study was judged so far, written by `corroborate run`. Keep this file with the study:\n\
         # adding trials and judging again is allowed for only as far as it is recorded (`corroborate explain looks`).\n",
    );
    for look in &looks.looks {
        text.push_str("\n[[looks]]\ncounts = [\n");
        text.push_str(&counts(look));
        text.push_str("]\n");
    }
    text
}

fn counts(look: &Look) -> String {
    let mut text = String::new();
    for one in &look.counts {
        let kind = match &one.subject {
            evidence::Subject::Requirement(_) => "requirement",
            evidence::Subject::FailureMode(_) => "failure-mode",
        };
        let quoted = |name: &str| toml::Value::from(name).to_string();
        let _ = write!(
            text,
            "    {{ evidence = {}, subject = {{ kind = \"{kind}\", id = {} }}, count = {}, trials = {}",
            quoted(&one.evidence),
            quoted(one.subject.id()),
            one.count,
            one.trials
        );
        if let Some(effective) = one.effective_trials {
            let _ = write!(text, ", effective_trials = {effective:?}");
        }
        if one.undecided > 0 {
            let _ = write!(text, ", undecided = {}", one.undecided);
        }
        if let Some(by_subject) = &one.by_subject {
            let _ = write!(text, ", by_subject = {by_subject:?}");
        }
        text.push_str(" },\n");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use evidence::Subject;

    #[test]
    fn what_is_written_is_read_again() {
        let one = |id: &str, subject, effective_trials| LookedAt {
            evidence: id.into(),
            subject,
            count: 88,
            trials: 100,
            effective_trials,
            undecided: 7,
            by_subject: None,
        };
        let first = Look {
            counts: vec![one(
                "E \"3\"",
                Subject::Requirement("1a".into()),
                Some(37.25),
            )],
        };
        let second = Look {
            counts: vec![
                one("E4", Subject::FailureMode("slip".into()), Some(40.0)),
                LookedAt {
                    by_subject: Some(vec![[40, 50], [48, 50]]),
                    ..one("E5", Subject::FailureMode("slip".into()), None)
                },
            ],
        };
        let looks = Looks::default().with(first).with(second);
        let read: Looks = toml::from_str(&text(&looks)).expect("valid TOML");
        assert_eq!(read, looks);
        let older = text(&looks).replace("by_subject", "clusters");
        let read: Looks = toml::from_str(&older).expect("valid TOML");
        assert_eq!(read, looks);
    }
}
