//! What is to be shrunk: a finding, or an episode of an evidence by its number.

use super::ShrinkRequest;
use crate::replay::{Episode, finding_file, no_finding};
use crate::technique::campaign::kind_of;
use crate::technique::exploration::{OpenBench, failed};
use diagnostic::Problem;
use evidence::{FailureKind, Subject as Judged};
use host::Host;
use judging::Judges;
use std::path::Path;
use study::{Expected, Finding, Shows, Study};
use temporal::monitor::Verdict;
use testbench::Recorded;

/// An episode that shows something, with the bench that runs it.
pub struct Subject {
    /// The episode as a finding.
    pub finding: Finding,
    /// What runs it.
    pub bench: OpenBench,
    /// The name that its regression has if it is given no other.
    pub name: String,
    /// What it was called, in words.
    pub from: String,
}

impl Subject {
    /// What is asked for.
    pub fn of(study: &Study, request: &ShrinkRequest, host: &Host) -> Result<Self, Problem> {
        let named = Path::new(&request.episode);
        let only = request.only.as_deref();
        let asked = only.map(|id| shows_of(study, id)).transpose()?;
        if let Some(file) = finding_file(study, named) {
            return Self::of_file(study, &file, asked, host);
        }
        if !request.episode.contains(':') {
            return Err(no_finding(study, named));
        }
        Self::of_evidence(study, &request.episode, asked, host)
    }

    /// The episode of a finding's file.
    fn of_file(
        study: &Study,
        file: &Path,
        asked: Option<Shows>,
        host: &Host,
    ) -> Result<Self, Problem> {
        let mut finding = Finding::read(file)?;
        finding.shows = asked.unwrap_or(finding.shows);
        let bench = OpenBench::of_files(study, &finding.bench, host)?;
        let stem = file.file_stem().unwrap_or_default().to_string_lossy();
        let from = file.file_name().unwrap_or_default().to_string_lossy();
        Ok(Self {
            name: stem.into_owned(),
            from: from.into_owned(),
            finding,
            bench,
        })
    }

    /// An episode of an evidence by its number, as it is written.
    fn of_evidence(
        study: &Study,
        text: &str,
        asked: Option<Shows>,
        host: &Host,
    ) -> Result<Self, Problem> {
        let (episode, bench) = Episode::named(study, text, host)?;
        let shows = match asked {
            Some(shows) => shows,
            None => only_thing_shown(study, &episode, &bench, host)?,
        };
        Ok(Self {
            name: name_of(&episode, &shows),
            from: text.to_owned(),
            finding: Finding {
                found_by: episode.origin,
                program: env!("CARGO_PKG_VERSION").into(),
                seed: episode.seed,
                bench: episode.bench,
                shows,
                expected: Expected::Fails,
                recording: None,
                stimulus: episode.stimulus,
            },
            bench,
        })
    }
}

/// The name of an episode that shows something, as a file may have it.
fn name_of(episode: &Episode, shows: &Shows) -> String {
    let name = match shows {
        Shows::Violated(id) | Shows::FailureMode(id) => format!("{}-{id}", episode.name),
        Shows::Failed(kind) => format!("{}-{}", episode.name, kind.name()),
        Shows::Unknown(_) => episode.name.clone(),
    };
    let safe = |c: char| {
        if c.is_ascii_alphanumeric() || "-_.".contains(c) {
            c
        } else {
            '-'
        }
    };
    name.chars().map(safe).collect()
}

/// What an identifier asks an episode to show.
fn shows_of(study: &Study, id: &str) -> Result<Shows, Problem> {
    if let Some(kind) = FailureKind::named(id) {
        return Ok(Shows::Failed(kind));
    }
    match study.forms.by_id(id).map(|form| &form.subject) {
        Some(Judged::Requirement(id)) => Ok(Shows::Violated(id.clone())),
        Some(Judged::FailureMode(id)) => Ok(Shows::FailureMode(id.clone())),
        None => {
            let message = format!("requirements.toml does not declare `{id}`");
            Err(Problem::new("unknown-subject", message).remedy("check the identifier"))
        }
    }
}

/// The one thing that an episode shows. Which of several is meant, only the call can say.
fn only_thing_shown(
    study: &Study,
    episode: &Episode,
    bench: &OpenBench,
    host: &Host,
) -> Result<Shows, Problem> {
    let recorded = episode
        .run(bench, None, &host.cancel)
        .map_err(|error| failed(&error))?;
    let mut all = all_shown(study, &recorded)?;
    if all.len() == 1 {
        return Ok(all.remove(0));
    }
    let name = &episode.origin;
    if all.is_empty() {
        let message = format!("{name} violates no requirement and shows no failure mode");
        return Err(Problem::new("not-shown", message)
            .remedy("name an episode that does; the report and the table of episodes name some"));
    }
    let listed: Vec<String> = all.iter().map(ToString::to_string).collect();
    let first = match &all[0] {
        Shows::Violated(id) | Shows::FailureMode(id) => id.as_str(),
        Shows::Failed(kind) => kind.name(),
        Shows::Unknown(_) => "ID",
    };
    let message = format!("{name} shows several things: {}", listed.join(", "));
    Err(Problem::new("several-shown", message).remedy(format!(
        "choose one, for example {first} (--only {first} on the command line)"
    )))
}

/// Everything that an episode shows, by the main monitors.
fn all_shown(study: &Study, recorded: &Recorded) -> Result<Vec<Shows>, Problem> {
    let judges = Judges::new(study, |_| true)?;
    let judged = judges.judge(&recorded.trace)?;
    let violated = judged
        .iter()
        .filter(|it| it.reading.is_none() && it.findings.verdict == Verdict::Violated);
    let shown = violated.map(|it| match it.subject {
        Judged::Requirement(id) => Shows::Violated(id.clone()),
        Judged::FailureMode(id) => Shows::FailureMode(id.clone()),
    });
    let failed = recorded
        .failure
        .as_ref()
        .map(|it| Shows::Failed(kind_of(it)));
    Ok(shown.chain(failed).collect())
}
