//! Counting a campaign again from its journal, without running or judging anything.

use super::driver::hash_of_recording;
use super::record::{EpisodeRecord, is_judged_by, records, verdicts};
use super::tally::{Intervals, Tally, monitors};
use diagnostic::Problem;
use evidence::{EpisodeFailures, Finding, Measure, Subject};
use judging::Judges;
use judging::verdicts::RunVerdicts;
use std::path::Path;
use study::Study;

/// What a journal says.
#[derive(Debug)]
pub struct Recount {
    /// The findings of its episodes.
    pub findings: Vec<Finding>,
    /// Episodes of it that were ended by a failure.
    pub failures: Vec<EpisodeFailures>,
    /// Recordings that are as the journal says.
    pub recordings: u64,
    /// What is not as the journal says: file and fault.
    pub faults: Vec<(String, String)>,
}

/// Counts the episodes that are kept in `folder`; `None` if it holds no journal.
///
/// At most `episodes` are counted. Where a stopping rule may have ended the campaign earlier, the
/// first of them that give the `claimed` findings are, so that episodes behind do not matter. `own_name` is that of a recording that is not
/// there.
pub fn recount(
    (study, own_name): (&Study, &dyn Fn(u64) -> String),
    folder: &Path,
    episodes: u64,
    intervals: Intervals,
    claimed: &[Finding],
) -> Result<Option<Recount>, Problem> {
    let path = folder.join("journal");
    if !path.exists() {
        return Ok(None);
    }
    let (records, damaged) = records(&path)?;
    let mut recount = Recount {
        findings: Vec::new(),
        failures: Vec::new(),
        recordings: 0,
        faults: Vec::new(),
    };
    if damaged > 0 {
        let fault = format!("{damaged} lines are damaged");
        recount.faults.push((path.display().to_string(), fault));
    }
    let names = recording_names(folder)?;
    let target = first_counts(claimed);
    let mut tally = Tally::new(&monitors(&Judges::new(study, |_| true)?));
    for record in records
        .iter()
        .take(usize::try_from(episodes).unwrap_or(usize::MAX))
    {
        let name = name_of(&names, record.number, own_name);
        recount.check_recording(folder, &name, record);
        let verdicts: Vec<_> = record.judged.iter().map(|judged| judged.verdict).collect();
        tally.add(&name, &verdicts);
        tally.left_out(record.judged.iter().map(|it| it.left_out));
        tally.ended_by(record.number, record.failure());
        let here = target.is_some_and(|(subject, sample)| tally.sample(subject) == sample);
        if intervals == Intervals::Anytime && here {
            let findings = tally.findings(study, intervals)?;
            if findings == claimed {
                recount.findings = findings;
                recount.failures = tally.failures(study, intervals)?;
                return Ok(Some(recount));
            }
        }
    }
    recount.findings = tally.findings(study, intervals)?;
    recount.failures = tally.failures(study, intervals)?;
    Ok(Some(recount))
}

/// What the monitors and the forms say of each of the first `episodes` that are kept in `folder`; `None` if it holds no
/// journal.
pub fn form_verdicts(folder: &Path, episodes: u64) -> Result<Option<RunVerdicts>, Problem> {
    let path = folder.join("journal");
    match path.exists() {
        true => verdicts(&path, episodes).map(Some),
        false => Ok(None),
    }
}

/// The records of the journal in `folder` if these monitors judged it; none if others did.
pub fn records_judged_by(folder: &Path, judged_by: &str) -> Result<Vec<EpisodeRecord>, Problem> {
    let path = folder.join("journal");
    match is_judged_by(&path, judged_by) {
        true => Ok(records(&path)?.0),
        false => Ok(Vec::new()),
    }
}

/// The first `episodes` records of the journal in `folder`, whoever judged them, up to one that is damaged.
pub fn journal_of(folder: &Path, episodes: u64) -> Result<Vec<EpisodeRecord>, Problem> {
    let (mut found, _) = records(&folder.join("journal"))?;
    found.truncate(usize::try_from(episodes).unwrap_or(usize::MAX));
    Ok(found)
}

impl Recount {
    fn check_recording(&mut self, folder: &Path, name: &str, record: &EpisodeRecord) {
        let Some(hash) = &record.recording else {
            return;
        };
        let path = folder.join(name);
        match hash_of_recording(&path) {
            Ok(found) if &found == hash => self.recordings += 1,
            Ok(_) => {
                let fault = "the recording is not the one that was judged".to_owned();
                self.faults.push((path.display().to_string(), fault));
            }
            Err(_) => {
                let fault = "the recording is missing or cannot be read".to_owned();
                self.faults.push((path.display().to_string(), fault));
            }
        }
    }
}

/// A finding with counts, to look out for.
fn first_counts(findings: &[Finding]) -> Option<(&Subject, stats::Sample)> {
    findings.iter().find_map(|finding| match finding.measure {
        Measure::Counts { count, trials, .. } => {
            Some((&finding.subject, stats::Sample::new(count, trials).ok()?))
        }
        _ => None,
    })
}

/// The names of what is recorded in a folder, sorted.
fn recording_names(folder: &Path) -> Result<Vec<String>, Problem> {
    let fail = |error: std::io::Error| Problem::cannot_read(folder, &error);
    let entries = std::fs::read_dir(folder).and_then(Iterator::collect::<Result<Vec<_>, _>>);
    let names = entries.map_err(fail)?.into_iter();
    let mut names: Vec<String> = names
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .filter(|name| name.starts_with("episode-"))
        .collect();
    names.sort();
    Ok(names)
}

/// The name of an episode's recording: as it is there, or as it would be.
fn name_of(names: &[String], number: u64, own_name: &dyn Fn(u64) -> String) -> String {
    let stem = format!("episode-{number:05}");
    let is_of_it = |name: &&String| {
        let rest = name.strip_prefix(&stem);
        rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
    };
    let found = names[names.partition_point(|name| name < &stem)..].first();
    let found = found.filter(is_of_it).cloned();
    found.unwrap_or_else(|| own_name(number))
}
