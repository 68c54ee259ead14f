//! A simulator that is a command: one number of its files, fitted to counts.
//!
//! # Definition
//! The files that the command names, and its stimulus, hold numbers with names ([`refinement::named_numbers`]). Which of them is wrong nothing
//! of the evidence says, so that the simulator is asked: each number is searched for a value with which the subject comes as
//! often as it was counted ([`refinement::fitted`]), all with the same seeds. A number that changes no count of the subject in
//! the first `SCREENED` episodes, neither `FAR` times as large nor as small, is left out. Of the numbers for which there is one, that is
//! taken with which the simulator disagrees least with all other evidence, and of those that leave as much, to within
//! `AS_GOOD` decades, the one that changes by the smallest factor. Files of parameters are asked first, the program itself
//! only where they have no such number; the other way round where only the time differs in which something is done, since a
//! clock is the program's.
//!
//! # Guarantee
//! The value was run. It is kept in a new file beside the old one, for a new entry of the ledger, which has seeds of its own
//! and says to whose counts it was set: agreement on them is a fit. That the number means what its new value says is not
//! shown, so that the proposal needs a decision.
//!
//! # Cost
//! For each named number at most [`refinement::MOST_RUNS_OF_A_FIT`] times the entry's episodes, and nothing before the
//! proposal is accepted, or the search is asked for (`search`). A simulator that hangs with a value is given `PATIENCE` times as long as its slowest episode.

use super::apply::{Applied, append_to_ledger};
use super::ledger_text::{Names, NewEntry, SetTo};
use super::proposal::{Change, Offered, Proposal};
use crate::technique::campaign::judge_left;
use crate::technique::matrix::is_timed;
use crate::technique::simulation::{Seeds, findings};
use diagnostic::Problem;
use evidence::{Evidence, Finding, Measure, Rate, STRONG, StudyResult, Subject, Suspect, strength};
use host::Host;
use host::files::{write_text, write_whole};
use judging::Judges;
use rayon::prelude::*;
use refinement::{
    Counts, NamedNumber, Touch, Trial, Tried, anchors, fitted, is_all_named, named_numbers,
};
use rig::OutsideCommand;
use std::path::{Path, PathBuf};
use std::time::Instant;
use study::{CommandText, Entry, Study};

/// Decades of disagreement that do not tell two numbers apart.
const AS_GOOD: f64 = 0.5;

/// Episodes in which it is seen whether a number matters.
const SCREENED: u64 = 24;

/// By which factor it is changed for that.
const FAR: f64 = 16.0;

/// How many times the slowest episode a changed one may take.
const PATIENCE: f64 = 20.0;

/// The least that an episode may take, in seconds.
const LEAST_SECS: f64 = 5.0;

/// A number that is to be found and fitted.
#[derive(Clone, Debug, PartialEq)]
pub struct CommandFit {
    /// The entry of the ledger.
    pub entry: String,
    /// The files that are asked, the first first.
    pub files: Vec<String>,
    /// What is to come as often as it was counted.
    pub subject: Subject,
    /// The counts.
    pub counts: Counts,
    /// What a search found already.
    pub found: Option<FoundNumber>,
}

/// A number that brings the subject to its counts.
#[derive(Clone, Debug, PartialEq)]
pub struct FoundNumber {
    /// The file.
    pub file: String,
    /// The number in it.
    number: NamedNumber,
    /// The value, and how often the subject comes with it.
    tried: Tried,
}

impl FoundNumber {
    fn in_words(&self) -> String {
        format!(
            "{} of {} set from {} to {}",
            self.number.name,
            self.file,
            self.number.value,
            NamedNumber::written(self.tried.value)
        )
    }
}

/// What is offered for a command that is suspected for these failure modes, or for what its suspect is named for.
pub(super) fn of_command(
    study: &Study,
    result: &StudyResult,
    (entry, command): (&Entry, &CommandText),
    (suspect, modes): (Option<&Suspect>, &[String]),
    offered: &mut Offered,
) -> Result<(), Problem> {
    let Some(piece) = result.evidence.iter().find(|piece| piece.id == entry.id) else {
        return Ok(());
    };
    let named = suspect.map_or_else(Vec::new, |it| it.subjects.clone());
    let is_mode = |subject: &&Subject| matches!(subject, Subject::FailureMode(_));
    let first = named.iter().find(is_mode).or(named.first()).cloned();
    let subject = first.or_else(|| modes.first().cloned().map(Subject::FailureMode));
    let Some(subject) = subject else {
        return Ok(());
    };
    let counts = anchors(&result.evidence, piece, &subject)
        .into_iter()
        .next();
    let (Some(counts), Some(rate)) = (counts, rate_of(&piece.findings, &subject)) else {
        return Ok(());
    };
    let tried = predicted(
        study,
        result,
        (piece, entry.work.episodes()),
        &subject,
        &counts,
    );
    let is_clock = named.iter().all(|it| {
        let form = study.forms.of(it);
        form.is_some_and(|form| matches!(it, Subject::Requirement(_)) && is_timed(study, form))
    });
    let files = files(study, command, is_clock && !named.is_empty())?;
    let Some((first, also)) = files.split_first() else {
        offered.refused.push(format!(
            "{} of {}: no file that its command names holds a number with a name.",
            name_of(&subject),
            entry.id
        ));
        return Ok(());
    };
    offered.add(Proposal {
        number: 0,
        suspect: suspect.map(|it| it.rank),
        title: format!(
            "{}: one number of {} fitted to {} of {}",
            entry.id,
            files.join(" or "),
            name_of(&subject),
            counts.words()
        ),
        reason: format!(
            "{} has a share of {rate:.4} for {}, and it was counted in {}.",
            entry.id,
            name_of(&subject),
            counts.words()
        ),
        file: first.clone(),
        also: also.to_vec(),
        chosen: Vec::new(),
        rivals: Vec::new(),
        diff: String::new(),
        effects: Vec::new(),
        tried,
        notes: vec![
            format!(
                "Which number, and its value, is found by running the command: at most {} times {} episodes for each number \
                 with a name. Nothing is run before this is accepted, or `--fit` asks for it; the old file stays.",
                refinement::MOST_RUNS_OF_A_FIT,
                entry.work.episodes()
            ),
            format!(
                "From then on, agreement with {} on {} is a fit, not corroboration.",
                counts.evidence,
                name_of(&subject)
            ),
        ],
        needs_decision: true,
        change: Change::FitCommand(CommandFit {
            entry: entry.id.clone(),
            files: files.clone(),
            subject,
            counts,
            found: None,
        }),
    });
    Ok(())
}

/// What the counted share in place of the simulator's does to its agreement on the subject; what else the number moves is
/// known once it is found.
fn predicted(
    study: &Study,
    result: &StudyResult,
    (piece, episodes): (&Evidence, u64),
    subject: &Subject,
    counts: &Counts,
) -> Trial {
    let mut trial = Trial::default();
    let Some(was) = Rate::on(piece, subject) else {
        return trial;
    };
    let trials = match was {
        Rate::Counted { trials, .. } => trials,
        Rate::Computed(_) | Rate::Never => episodes as f64,
    };
    let is = Rate::Counted {
        count: counts.rate() * trials,
        open: 0.0,
        trials,
    };
    let margin = super::proposal::ground(study, result).margin(subject);
    for other in others(result, piece) {
        let theirs = Rate::on(other, subject);
        let Some(theirs) = theirs else {
            continue;
        };
        trial.weigh(Touch {
            evidence: other.id.clone(),
            subject: subject.clone(),
            before: strength(was, theirs, margin),
            after: strength(is, theirs, margin),
        });
    }
    trial
}

/// The other evidence that speaks for itself under the same conditions.
fn others<'r>(result: &'r StudyResult, piece: &Evidence) -> impl Iterator<Item = &'r Evidence> {
    let (id, conditions) = (piece.id.clone(), piece.conditions.clone());
    result.evidence.iter().filter(move |other| {
        other.id != id
            && other.conditions == conditions
            && !other.intermediate
            && !(other.published && other.reproduced_by.is_some())
    })
}

fn name_of(subject: &Subject) -> String {
    subject.in_words()
}

/// How often a subject is triggered, of all runs.
fn rate_of_trigger(finding: &Finding) -> Option<Rate> {
    match finding.trigger.as_deref()? {
        Measure::Counts { trials: 0, .. } => None,
        Measure::Counts { count, trials, .. } => Some(Rate::counted(*count, *trials)),
        Measure::Probability { answer, .. } => Some(Rate::Computed(answer.value)),
        Measure::NotExpressible { .. } | Measure::NotCovered { .. } => None,
    }
}

fn rate_of(findings: &[Finding], subject: &Subject) -> Option<f64> {
    let mut all = findings.iter();
    all.find(|it| &it.subject == subject)?.measure.estimate()
}

/// The files of the study that the command names and that hold named numbers: parameters first, or the program.
fn files(
    study: &Study,
    command: &CommandText,
    is_program_first: bool,
) -> Result<Vec<String>, Problem> {
    let mut found: Vec<(bool, String)> = Vec::new();
    let stimulus = command.stimulus.as_deref().map(shown);
    for word in command.command.iter().chain(&stimulus) {
        let path = study.folder.join(word);
        // What lies elsewhere is not the study's to change.
        let is_own =
            Path::new(word).is_relative() && path.is_file() && study.reach.refuses(&path).is_none();
        if !is_own || found.iter().any(|(_, known)| known == word) {
            continue;
        }
        // What is no text has no numbers to read.
        let Ok(text) = std::fs::read_to_string(&path) else {
            continue;
        };
        if named_numbers(&text).iter().any(|it| it.value > 0.0) {
            let is_settings = Some(word) == stimulus.as_ref() || is_all_named(&text);
            found.push((is_settings == is_program_first, word.clone()));
        }
    }
    found.sort_by_key(|(is_later, _)| *is_later);
    Ok(found.into_iter().map(|(_, file)| file).collect())
}

/// A file as the study's texts name it.
fn shown(path: &Path) -> String {
    path.to_string_lossy().replace('\\', "/")
}

/// A number with the value that was found for it.
struct Candidate {
    found: FoundNumber,
    /// What the simulator shows with it.
    findings: Vec<Finding>,
    /// Disagreement with all other evidence that is left.
    left: f64,
}

impl Candidate {
    /// How much it changes.
    fn size(&self) -> f64 {
        (self.found.tried.value / self.found.number.value)
            .ln()
            .abs()
    }
}

/// Searches for the number of a proposal, which then shows its value, its diff and what it does to the agreement with all
/// other evidence. Without one the proposal is none; what is said of that is returned.
pub(super) fn search(
    study: &Study,
    result: &StudyResult,
    proposal: &mut Proposal,
    setting: &Host,
) -> Result<Option<String>, Problem> {
    let Change::FitCommand(wanted) = &mut proposal.change else {
        return Ok(None);
    };
    let asked = wanted.clone();
    let mut fitting = Fitting::new(study, result, &asked, setting)?;
    let mut best = fitting.best_of_files()?.into_iter();
    let Some(first) = best.next() else {
        return Ok(Some(none_found(&asked)));
    };
    let others: Vec<String> = best.map(|it| it.found.in_words()).collect();
    let found = &first.found;
    let text = host::files::read_source(&study.folder.join(&found.file))?.text;
    let changed = found.number.set(&text, found.tried.value);
    let target = Names::free_model(&study.folder, Path::new(&found.file), &[]);
    proposal.title = format!("{}: {}", asked.entry, found.in_words());
    proposal.diff = refinement::unified(&found.file, &target, &text, &changed);
    proposal.also.clear();
    proposal.file.clone_from(&found.file);
    proposal.tried = fitting.tried(&first.findings);
    proposal.notes[0] = fitting.came(&first.findings);
    if !others.is_empty() {
        let others = others.join(", or ");
        proposal
            .notes
            .insert(1, format!("The evidence does not tell it from {others}."));
    }
    wanted.found = Some(first.found);
    Ok(None)
}

/// Finds the number, if that is not done, and writes the changed file and the entry that simulates with it.
pub fn fit(
    study: &Study,
    result: &StudyResult,
    wanted: &CommandFit,
    setting: &Host,
) -> Result<Applied, Problem> {
    let entry = study.entry(&wanted.entry)?;
    let mut fitting = Fitting::new(study, result, wanted, setting)?;
    let found = match &wanted.found {
        Some(found) => Some(found.clone()),
        None => {
            let best = fitting.best_of_files()?.into_iter().next();
            best.map(|it| it.found)
        }
    };
    let Some(found) = found else {
        return Err(Problem::new("cannot-refine", none_found(wanted)).remedy(
            "more than one number may be wrong, or what the program does; look at the witnesses of `diagnose`",
        ));
    };
    let text = host::files::read_source(&study.folder.join(&found.file))?.text;
    let target = Names::free_model(&study.folder, Path::new(&found.file), &[]);
    let changed = found.number.set(&text, found.tried.value);
    write_text(
        &study.folder.join(&target),
        &changed,
        &study.folder.join(&found.file),
    )?;
    fitting.keep(entry, &target, &found)
}

fn none_found(wanted: &CommandFit) -> String {
    format!(
        "{}: no named number of {} brings {} to {} without new disagreement",
        wanted.entry,
        wanted.files.join(" or "),
        name_of(&wanted.subject),
        wanted.counts.words()
    )
}

/// What a fit needs.
struct Fitting<'a> {
    study: &'a Study,
    result: &'a StudyResult,
    wanted: &'a CommandFit,
    setting: &'a Host,
    command: &'a CommandText,
    piece: &'a Evidence,
    episodes: u64,
    folder: PathBuf,
    /// The longest that an episode may take.
    limit_secs: f64,
    /// What the first episodes show as they are.
    screened: Option<Vec<Finding>>,
}

impl<'a> Fitting<'a> {
    fn new(
        study: &'a Study,
        result: &'a StudyResult,
        wanted: &'a CommandFit,
        setting: &'a Host,
    ) -> Result<Self, Problem> {
        let entry = study.entry(&wanted.entry)?;
        let piece = result.evidence.iter().find(|it| it.id == wanted.entry);
        let (Some(command), Some(piece)) = (entry.work.command(), piece) else {
            return Err(Problem::new(
                "cannot-refine",
                format!("{} is not simulated by a command", wanted.entry),
            )
            .remedy("run the study again, and look at what is offered then"));
        };
        let folder = study.folder.join("results").join("fit");
        std::fs::create_dir_all(&folder).map_err(|error| Problem::cannot_write(&folder, &error))?;
        Ok(Self {
            study,
            result,
            wanted,
            setting,
            command,
            piece,
            episodes: entry.work.episodes(),
            folder,
            limit_secs: command.limit_secs,
            screened: None,
        })
    }

    /// What is best of the first file that has a number which gives the rate.
    fn best_of_files(&mut self) -> Result<Vec<Candidate>, Problem> {
        let began = Instant::now();
        self.screened = self.run(self.command, SCREENED.min(self.episodes))?;
        let patient = (PATIENCE * began.elapsed().as_secs_f64()).max(LEAST_SECS);
        self.limit_secs = self.limit_secs.min(patient);
        for file in &self.wanted.files {
            let text = host::files::read_source(&self.study.folder.join(file))?.text;
            let best = self.best(file, &text)?;
            if !best.is_empty() {
                return Ok(best);
            }
        }
        Ok(Vec::new())
    }

    /// The numbers of a file that give the rate and with which the simulator disagrees least with all other evidence, the one
    /// that changes least first.
    fn best(&self, file: &str, text: &str) -> Result<Vec<Candidate>, Problem> {
        let now = rate_of(&self.piece.findings, &self.wanted.subject);
        let before = self.disagreement(&self.piece.findings);
        let mut found: Vec<Candidate> = Vec::new();
        let numbers = named_numbers(text).into_iter().filter(|it| it.value > 0.0);
        let numbers: Vec<NamedNumber> = numbers.collect();
        let stage = self.setting.events.begin(
            &format!("{}: numbers of {file}", self.wanted.entry),
            numbers.len() as u64,
        );
        for number in numbers {
            stage.advance();
            if !self.matters(file, text, &number)? {
                continue;
            }
            let mut rate = |value: f64| {
                let findings = self.with(file, &number.set(text, value), self.episodes)?;
                Ok::<_, Problem>(findings.and_then(|all| rate_of(&all, &self.wanted.subject)))
            };
            let start = now.map(|rate| Tried {
                value: number.value,
                rate,
            });
            let tried = match start {
                Some(start) => fitted(start, self.wanted.counts.rate(), &mut rate)?,
                None => None,
            };
            if let Some(tried) = tried
                && let Some(findings) =
                    self.with(file, &number.set(text, tried.value), self.episodes)?
            {
                let left = self.disagreement(&findings);
                let file = file.to_owned();
                found.push(Candidate {
                    found: FoundNumber {
                        file,
                        number,
                        tried,
                    },
                    findings,
                    left,
                });
            }
        }
        found.retain(|it| it.left < before && it.left_on_subject_is_small(self));
        let least = found.iter().map(|it| it.left).fold(f64::INFINITY, f64::min);
        found.retain(|it| it.left <= least + AS_GOOD);
        found.sort_by(|a, b| a.size().total_cmp(&b.size()));
        Ok(found)
    }

    /// How often what was fitted comes, of the runs that count for it, with those that reached no verdict.
    fn came(&self, findings: &[Finding]) -> String {
        let name = name_of(&self.wanted.subject);
        let mut all = findings.iter();
        let finding = all.find(|it| it.subject == self.wanted.subject);
        let Some((finding, Measure::Counts { count, trials, .. })) =
            finding.map(|it| (it, &it.measure))
        else {
            return format!(
                "It was run: {name} is counted in none of {} episodes then.",
                self.episodes
            );
        };
        let of_all = match *trials == self.episodes {
            true => "episodes".to_owned(),
            false => format!("runs that count for it, of {} episodes", self.episodes),
        };
        let undecided = match finding.undecided {
            0 => String::new(),
            _ => format!("; {}", finding.undecided_in_words()),
        };
        format!(
            "It was run with the draws of the entry: {name} comes in {count} of {trials} {of_all} then{undecided}; other draws give other \
             counts, and the value is as uncertain as these."
        )
    }

    /// What findings in place of the simulator's do to its agreement with the other evidence.
    fn tried(&self, findings: &[Finding]) -> Trial {
        let mut trial = Trial::default();
        let ground = super::proposal::ground(self.study, self.result);
        for other in others(self.result, self.piece) {
            for finding in findings {
                let subject = &finding.subject;
                let was = Rate::on(self.piece, subject);
                let rates = was.zip(Rate::of(finding)).zip(Rate::on(other, subject));
                let Some(((was, is), theirs)) = rates else {
                    continue;
                };
                let margin = ground.margin(subject);
                trial.weigh(Touch {
                    evidence: other.id.clone(),
                    subject: subject.clone(),
                    before: strength(was, theirs, margin),
                    after: strength(is, theirs, margin),
                });
            }
        }
        trial
    }

    /// The findings with a file in place of another; none where the simulator does not run.
    fn with(&self, file: &str, text: &str, episodes: u64) -> Result<Option<Vec<Finding>>, Problem> {
        let name = Path::new(file).file_name().unwrap_or_default();
        let path = self.folder.join(name);
        write_whole(&path, text.as_bytes())?;
        let path =
            std::fs::canonicalize(&path).map_err(|error| Problem::cannot_read(&path, &error))?;
        let word = path.to_string_lossy();
        let words = self.command.command.iter();
        let words = words.map(|old| match old == file {
            true => word.clone().into_owned(),
            false => old.clone(),
        });
        let stimulus = self.command.stimulus.clone();
        let command = CommandText {
            stimulus: stimulus.map(|old| match shown(&old) == file {
                true => path.clone(),
                false => old,
            }),
            command: words.collect(),
            limit_secs: self.limit_secs,
            ..self.command.clone()
        };
        self.run(&command, episodes)
    }

    /// Whether a number far away changes what the first episodes show of the subject, or whether they run.
    fn matters(&self, file: &str, text: &str, number: &NamedNumber) -> Result<bool, Problem> {
        let counted = |all: &Option<Vec<Finding>>| -> Option<Measure> {
            let mut all = all.as_ref()?.iter();
            let own = all.find(|it| it.subject == self.wanted.subject)?;
            Some(own.measure.clone())
        };
        let now = counted(&self.screened);
        for value in [number.value * FAR, number.value / FAR] {
            let few = SCREENED.min(self.episodes);
            let then = self.with(file, &number.set(text, value), few)?;
            if counted(&then) != now {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// The findings of the first episodes of a command; none where one of them fails.
    fn run(&self, command: &CommandText, episodes: u64) -> Result<Option<Vec<Finding>>, Problem> {
        let outside = OutsideCommand::new(self.study, command, None, self.setting)?;
        outside.prepare(&self.folder)?;
        let judges = Judges::new(self.study, |_| true)?;
        let entry = self.study.entry(&self.wanted.entry)?;
        let seeds = Seeds::new(self.study.about.seed, entry.seeded_as());
        let go_on = || self.setting.go_on();
        let numbers: Vec<u64> = (1..=episodes).collect();
        let judged = numbers.par_iter().map(|number| {
            self.setting.go_on()?;
            let place = outside.room_for(&self.folder, &outside.recording_name(*number))?;
            let failed = outside.run(None, seeds.of(*number), &place, &self.setting.cancel)?;
            let judged = match failed {
                None => judge_left(&outside, &judges, &place, &go_on).ok(),
                Some(_) => None,
            };
            self.setting.go_on()?;
            OutsideCommand::remove(&place);
            Ok::<_, Problem>(judged.map(|it| it.judgements))
        });
        let judged: Vec<Option<Vec<_>>> = judged.collect::<Result<_, Problem>>()?;
        let judged: Option<Vec<Vec<_>>> = judged.into_iter().collect();
        outside.tidy(&self.folder);
        let names: Vec<String> = numbers.iter().map(u64::to_string).collect();
        judged
            .map(|judged| findings(self.study, &judges, &judged, &names))
            .transpose()
    }

    /// How strongly findings in place of the simulator's disagree with all other evidence: the sum over subjects of the
    /// strongest.
    fn disagreement(&self, findings: &[Finding]) -> f64 {
        let all = findings.iter();
        all.map(|finding| self.on_subject(finding)).sum()
    }

    /// On a subject, or on how often it is triggered: what leaves few runs that count is no better for it.
    fn on_subject(&self, finding: &Finding) -> f64 {
        let margin = super::proposal::ground(self.study, self.result).margin(&finding.subject);
        let apart = others(self.result, self.piece).flat_map(|other| {
            let theirs = other.finding(&finding.subject);
            let rates = [
                Rate::of(finding).zip(Rate::on(other, &finding.subject)),
                rate_of_trigger(finding).zip(theirs.and_then(rate_of_trigger)),
            ];
            let rates = rates.into_iter().flatten();
            rates.map(|(own, theirs)| strength(own, theirs, margin))
        });
        apart.fold(0.0, f64::max)
    }

    /// Writes the entry that simulates with the changed file.
    fn keep(&self, entry: &Entry, target: &str, found: &FoundNumber) -> Result<Applied, Problem> {
        let file = found.file.as_str();
        let words = self.command.command.iter().map(|word| match word == file {
            true => target.into(),
            false => word.clone().into(),
        });
        let words: Vec<toml::Value> = words.collect();
        let path = |path: &Path| {
            toml::Value::from(match shown(path) {
                own if own == file => target.to_owned(),
                other => other,
            })
        };
        let episodes = i64::try_from(self.episodes).unwrap_or(100);
        let mut assets: Vec<(&'static str, toml::Value)> = vec![
            ("command", words.into()),
            ("leaves", self.command.leaves.clone().into()),
            ("limit_secs", self.command.limit_secs.into()),
            ("episodes", episodes.into()),
        ];
        if self.command.persistent {
            assets.push(("persistent", true.into()));
        }
        if !self.command.assets.is_empty() {
            let all: Vec<toml::Value> = self.command.assets.iter().map(|it| path(it)).collect();
            assets.push(("assets", all.into()));
        }
        if let Some(stimulus) = &self.command.stimulus {
            assets.push(("stimulus", path(stimulus)));
        }
        let mut set_to = SetTo::of(entry);
        set_to.push(SetTo {
            key: "parameter",
            name: found.number.name.clone(),
            from: self.wanted.counts.evidence.clone(),
            subject: self.wanted.subject.clone(),
            held: false,
            is_complement: false,
        });
        let id = Names::next_id(self.study, &entry.id, &[]);
        let what = format!(
            "{}, with which {} comes in {:.4} of the episodes that count for it ({} counted)",
            found.in_words(),
            name_of(&self.wanted.subject),
            found.tried.rate,
            self.wanted.counts.words()
        );
        let new = NewEntry {
            id: id.clone(),
            title: format!("{}, fitted", entry.title.trim_end_matches(", fitted")),
            technique: "simulation",
            conditions: entry.conditions.clone(),
            assets,
            intermediate: false,
            changed: format!("{what}."),
            set_to,
            chosen: entry.chosen.clone(),
        };
        append_to_ledger(self.study, &new.text())?;
        Ok(Applied {
            entry: Some(id),
            file: target.to_owned(),
            what,
        })
    }
}

impl Candidate {
    /// Whether the wanted rate was reached: what is left of the difference is not strong evidence of one.
    fn left_on_subject_is_small(&self, of: &Fitting<'_>) -> bool {
        let mut all = self.findings.iter();
        let own = all.find(|it| it.subject == of.wanted.subject);
        // With the runs that reached no verdict, whatever they would have shown.
        let Some(own) = own.and_then(Rate::of) else {
            return false;
        };
        let counted = Rate::counted(of.wanted.counts.count, of.wanted.counts.trials);
        strength(own, counted, 0.0) < STRONG
    }
}

impl Drop for Fitting<'_> {
    fn drop(&mut self) {
        // What cannot be removed is in nobody's way.
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}
