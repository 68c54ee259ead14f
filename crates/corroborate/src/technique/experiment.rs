//! Experiments, and published simulations: counts read from tables.
//!
//! * The *cohort* has a row for each subject or session: the first column
//!   names it, `attempts` counts trials, and the columns that the vocabulary
//!   binds count what happened. A binding `failure_modes: R` counts the code
//!   `R` in a column of codes.
//! * *requirements* has the columns requirement, covered, passed, failed; and, where that matters, `undecided`, the trials beside
//!   those covered that reached no verdict, and `stopped`, `yes` if the number of trials was chosen by looking at them.
//! * *failure modes* has the columns mode, occurrences, opportunities.
//! * JUnit XML of runs, whose test cases are trials (`junit.rs`).
//! * Episodes of a learned policy, of which a cohort is made (`episodes.rs`).
//!
//! Where two tables speak of the same count, they must agree. What is counted only in all, beside a cohort,
//! was done by the same people: it is worth as many independent trials as they tell.

mod alike;
mod by_subject;
mod columns;
mod episodes;
pub mod groups;
mod junit;
mod placed;
pub mod renamed;
pub mod repeated;
mod tests_of_cohort;
mod triggering;

pub use by_subject::SubjectCount;

use super::campaign::anytime;
use super::files::Files;
use super::{Produced, confidence, counts};
use alike::Alike;
use diagnostic::Problem;
use evidence::{
    AssetRole, Cost, Denominator, Finding, Measure, Subject, Technique, Tool, WitnessOf,
};
use host::store::Inputs;
use placed::{RowPlace, in_row, table_problem};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use study::{Binding, Study, SubjectForm, TableFiles};
use trace::Table;
use triggering::Triggering;

/// More trials than any experiment has, and few enough for exact sums.
const MOST_TRIALS: u64 = 1_000_000_000_000;

/// A row that counts more trials than there were attempts.
pub struct Excess {
    /// Of what.
    pub subject: Subject,
    /// The trials that it counts.
    pub trials: u64,
    /// The attempts.
    pub attempts: u64,
    /// Where it stands.
    pub place: RowPlace,
}

impl Excess {
    /// The same for people.
    pub fn in_words(&self) -> String {
        format!(
            "{} trials count for {} in {} attempts, and its property asks in how many runs it comes: a run counts once",
            self.trials,
            self.subject.in_words(),
            self.attempts
        )
    }
}

/// The tables of one piece of evidence, checked.
#[derive(Debug)]
pub struct Tables {
    cohort: Option<Cohort>,
    requirements: Vec<VerdictRow>,
    failure_modes: Vec<ModeRow>,
    /// Counts of JUnit XML, with those that a row of a table does not have: trials whose harness broke, and those to which no case applied.
    of_runs: Vec<junit::Counted>,
    /// Why the one subject of the cohort stands for all, where the study declares it.
    one_for_all: Option<String>,
    /// Of what the episodes of a learned policy speak.
    speaks_of: Option<String>,
}

#[derive(Debug)]
struct Cohort {
    attempts: Vec<u64>,
    table: Table,
    /// The bindings that other cohorts of the study count (`columns.rs`).
    left_to_others: BTreeSet<String>,
}

#[derive(Debug)]
struct VerdictRow {
    requirement: String,
    covered: u64,
    passed: u64,
    /// Trials that reached no verdict.
    undecided: u64,
    /// Whether the number of trials was chosen by looking at them.
    is_stopped: bool,
    /// None of what no table counts.
    place: Option<RowPlace>,
}

#[derive(Debug)]
struct ModeRow {
    mode: String,
    occurrences: u64,
    opportunities: u64,
    place: RowPlace,
}

impl Tables {
    /// Reads and checks the tables that are given.
    pub fn read(study: &Study, files: TableFiles<'_>) -> Result<Self, Problem> {
        Self::read_through(study, files, &Files::of_study(study))
    }

    /// The same, read through `reader`.
    pub(crate) fn read_through(
        study: &Study,
        files: TableFiles<'_>,
        reader: &Files<'_>,
    ) -> Result<Self, Problem> {
        let open = |path: &Path| {
            reader.bytes(AssetRole::Data, path)?;
            Table::read(&study.folder.join(path)).map_err(table_problem)
        };
        let mut tables = Self {
            of_runs: Vec::new(),
            cohort: match files.cohort {
                Some(path) => Some(Cohort::new(study, open(path)?)?),
                None => None,
            },
            requirements: match files.requirements {
                Some(path) => verdict_rows(study, &open(path)?)?,
                None => Vec::new(),
            },
            failure_modes: match files.failure_modes {
                Some(path) => mode_rows(study, &open(path)?)?,
                None => Vec::new(),
            },
            one_for_all: files.one_for_all.map(str::to_owned),
            speaks_of: None,
        };
        if let Some((path, cluster)) = files.episodes {
            let read = episodes::read(study, path, cluster, reader)?;
            tables.cohort = Some(Cohort::new(study, read.cohort)?);
            tables.speaks_of = Some(read.speaks_of);
        }
        if let Some(path) = files.junit {
            tables.add_junit(junit::read(study, path, files.tests, reader)?)?;
        }
        tables.check_agreement(study)?;
        tables.check_triggers(study)?;
        tables.check_is_one()?;
        Ok(tables)
    }

    /// What the tables say, one finding for each subject that they name.
    pub fn produce(
        &self,
        study: &Study,
        id: &str,
        technique: Technique,
    ) -> Result<Produced, Problem> {
        let mut alike = self
            .cohort
            .as_ref()
            .map(|cohort| Alike::of(study, cohort))
            .transpose()?;
        let mut findings = Vec::new();
        for form in &study.forms.subjects {
            let triggering = self.triggering(study, form)?;
            let finding = Finding {
                subject: form.subject.clone(),
                measure: self.measure((study, form), triggering.as_ref(), alike.as_mut())?,
                denominator: self.denominator(form, triggering.as_ref()),
                trigger: self.trigger(study, &form.subject, triggering.as_ref())?,
                undecided: self.row(&form.subject).map_or(0, |row| row.undecided),
                left_out: 0,
                completions: None,
                witnesses: Vec::new(),
                readings: Vec::new(),
            };
            let level = confidence(study.about.confidence)?;
            let is_stopped = self.is_stopped(&form.subject);
            let counted = |sample| match is_stopped {
                true => Ok(anytime(sample, level)),
                false => Measure::of_counts(sample, None, level),
            };
            let finding = finding.counting_undecided(level, &counted);
            findings.push(finding.map_err(|error| Problem::new("bad-counts", error.to_string()))?);
        }
        let clusters = match (&self.cohort, alike) {
            (Some(cohort), Some(alike)) => cohort.tests(study, alike)?,
            _ => None,
        };
        let clusters = clusters.map(|it| it.with_one_for_all(self.one_for_all.clone()));
        Ok(Produced {
            tool: Tool {
                name: match technique.witness_of() {
                    WitnessOf::System => "the real robot".into(),
                    WitnessOf::Model | WitnessOf::Simulator => "published counts".into(),
                },
                version: String::new(),
                settings: match &self.speaks_of {
                    Some(speaks_of) => speaks_of.clone(),
                    None => "counts read from tables".into(),
                },
            },
            findings,
            form_differences: Vec::new(),
            description_gaps: Vec::new(),
            failures: Vec::new(),
            clusters,
            alike_trials: None,
            repeated_recordings: Vec::new(),
            findings_once: Vec::new(),
            influences: Vec::new(),
            cost: Cost {
                evidence: id.to_owned(),
                ..Cost::default()
            },
        })
    }

    /// Each requirement that JUnit XML counts is a row like one of a table.
    fn add_junit(&mut self, counted: Vec<junit::Counted>) -> Result<(), Problem> {
        for one in &counted {
            let id = &one.requirement;
            if self.requirements.iter().any(|row| &row.requirement == id) {
                let message =
                    format!("requirement {id} is counted by a table and by JUnit XML, too");
                return Err(Problem::new("tables-disagree", message)
                    .remedy("leave one of them out, or make them two entries of the ledger"));
            }
            self.requirements.push(VerdictRow {
                requirement: id.clone(),
                covered: one.passed + one.failed,
                passed: one.passed,
                undecided: one.unknown,
                is_stopped: false,
                place: None,
            });
        }
        self.of_runs = counted;
        Ok(())
    }

    /// The row of a requirement.
    fn row(&self, subject: &Subject) -> Option<&VerdictRow> {
        let Subject::Requirement(id) = subject else {
            return None;
        };
        self.requirements.iter().find(|row| &row.requirement == id)
    }

    fn is_stopped(&self, subject: &Subject) -> bool {
        self.row(subject).is_some_and(|row| row.is_stopped)
    }

    fn of_junit(&self, subject: &Subject) -> Option<&junit::Counted> {
        let Subject::Requirement(id) = subject else {
            return None;
        };
        self.of_runs.iter().find(|it| &it.requirement == id)
    }

    fn measure(
        &self,
        (study, form): (&Study, &SubjectForm),
        triggering: Option<&Triggering>,
        mut alike: Option<&mut Alike>,
    ) -> Result<Measure, Problem> {
        let level = confidence(study.about.confidence)?;
        if let (Some(triggering), Some(alike)) = (triggering, alike.as_deref_mut()) {
            match triggering {
                // All attempts are counted.
                Triggering::Unknown { .. } => {}
                _ if triggering.trials() == 0 => return Ok(not_covered("No trial triggered it.")),
                Triggering::BySubject(found) => return alike.by_subject(form, found, level),
                Triggering::Total(trials) => {
                    let found = self.cohort_counts(study, form)?.unwrap_or_default();
                    let count = found.iter().map(|it| it.successes).sum();
                    return alike.occurrences(form, &found, (count, *trials), level);
                }
            }
        }
        let by_subject = self.cohort_counts(study, form)?;
        let (total, uncovered) = match &form.subject {
            Subject::Requirement(id) => (
                (self.requirements.iter().find(|row| &row.requirement == id))
                    .map(|row| (row.passed, row.covered)),
                "No trial met its precondition.",
            ),
            Subject::FailureMode(id) => (
                (self.failure_modes.iter().find(|row| &row.mode == id))
                    .map(|row| (row.occurrences, row.opportunities)),
                "No trial gave it an opportunity.",
            ),
        };
        let is_requirement = matches!(form.subject, Subject::Requirement(_));
        // Of a requirement that the tables do not say to be covered in fewer, every attempt is a trial.
        let in_every_attempt = is_requirement
            && total.is_none_or(|(_, trials)| Some(trials) == self.attempts() || trials == 0);
        match (alike, by_subject, total) {
            // Which attempts were opportunities is known only in all.
            (Some(alike), Some(by_subject), Some((count, trials)))
                if !in_every_attempt && trials > 0 =>
            {
                alike.occurrences(form, &by_subject, (count, trials), level)
            }
            (Some(alike), Some(by_subject), total) if is_requirement || total.is_none() => {
                alike.by_subject(form, &by_subject, level)
            }
            (_, _, Some((_, 0))) => Ok(not_covered(uncovered)),
            (Some(alike), _, Some((count, trials))) => alike.total(form, (count, trials), level),
            (None, _, Some((count, trials))) if self.is_stopped(&form.subject) => {
                let sample = stats::Sample::new(count, trials);
                let sample =
                    sample.map_err(|error| Problem::new("bad-counts", error.to_string()))?;
                Ok(anytime(sample, level))
            }
            (None, _, Some((count, trials))) => counts(count, trials, None, level),
            (_, _, None) => Ok(not_covered("The tables do not count it.")),
        }
    }

    /// All attempts of the cohort.
    fn attempts(&self) -> Option<u64> {
        self.cohort
            .as_ref()
            .map(|cohort| cohort.attempts.iter().sum())
    }

    /// Rows that count more trials than there were attempts, of what is asked of each run once: by a property of a model.
    pub fn more_than_attempts(&self, study: &Study) -> Vec<Excess> {
        let Some(attempts) = self.attempts() else {
            return Vec::new();
        };
        let requirements = self.requirements.iter().filter_map(|row| {
            let subject = Subject::Requirement(row.requirement.clone());
            Some((subject, row.covered, row.place.as_ref()?))
        });
        let modes = self.failure_modes.iter().map(|row| {
            let subject = Subject::FailureMode(row.mode.clone());
            (subject, row.opportunities, &row.place)
        });
        let is_asked_of_runs = |subject: &Subject| {
            let form = study.forms.of(subject);
            form.is_some_and(|form| form.property.is_some())
        };
        let rows = requirements.chain(modes);
        let rows =
            rows.filter(|(subject, trials, _)| *trials > attempts && is_asked_of_runs(subject));
        rows.map(|(subject, trials, place)| Excess {
            subject,
            trials,
            attempts,
            place: place.clone(),
        })
        .collect()
    }

    /// In how many trials the subject was covered, if the tables say so.
    fn covered(&self, subject: &Subject) -> Option<u64> {
        match subject {
            Subject::Requirement(id) => {
                let mut rows = self.requirements.iter();
                rows.find(|row| &row.requirement == id)
                    .map(|row| row.covered)
            }
            Subject::FailureMode(id) => {
                let mut rows = self.failure_modes.iter();
                rows.find(|row| &row.mode == id)
                    .map(|row| row.opportunities)
            }
        }
    }

    /// Attempts are taken to be trials of what is counted, unless the tables say that fewer of them were. Where attempts are
    /// not told, other rows of the table tell of more than a row was covered in. A failure mode with an opportunity of its own
    /// may have none in an attempt.
    fn denominator(&self, form: &SubjectForm, triggering: Option<&Triggering>) -> Denominator {
        let subject = &form.subject;
        if let Some(Triggering::Unknown { reason, .. }) = triggering {
            return Denominator::AllRuns {
                reason: reason.clone(),
            };
        }
        if let Some(triggering) = triggering {
            return match Some(triggering.trials()) == self.attempts() {
                true => Denominator::EveryRun,
                false => Denominator::Triggered,
            };
        }
        // Runs of different tests are not the same runs.
        if let Some(counted) = self.of_junit(subject) {
            return match counted.skipped {
                0 => Denominator::Covered,
                _ => Denominator::Triggered,
            };
        }
        let covered = self.requirements.iter().map(|row| row.covered).max();
        let opportunities = self.failure_modes.iter().map(|row| row.opportunities).max();
        let most = covered.or(opportunities);
        match (self.covered(subject), self.attempts()) {
            (None, _) if form.opportunity.is_some() => Denominator::AllRuns {
                reason: "the tables do not say which attempts gave it an opportunity".to_owned(),
            },
            (None, _) => Denominator::EveryRun,
            (Some(covered), Some(attempts)) if covered == attempts => Denominator::EveryRun,
            (Some(covered), None) if Some(covered) == most => Denominator::Covered,
            (Some(_), _) => Denominator::Triggered,
        }
    }

    /// The share of attempts that trigger the subject, if the tables say it.
    fn trigger(
        &self,
        study: &Study,
        subject: &Subject,
        triggering: Option<&Triggering>,
    ) -> Result<Option<Box<Measure>>, Problem> {
        let level = confidence(study.about.confidence)?;
        let covered = triggering.map(Triggering::trials);
        match (covered.or(self.covered(subject)), self.attempts()) {
            // A trial may have several opportunities, which are then no share of the attempts.
            (Some(covered), Some(attempts)) if covered <= attempts => {
                Ok(Some(Box::new(counts(covered, attempts, None, level)?)))
            }
            _ => Ok(None),
        }
    }

    /// Counts by subject of the proposition that the experiments count for a
    /// requirement or failure mode, if the cohort has them.
    fn cohort_counts(
        &self,
        study: &Study,
        form: &SubjectForm,
    ) -> Result<Option<Vec<stats::Sample>>, Problem> {
        let (Some(cohort), Some(proposition)) = (&self.cohort, &form.experiment) else {
            return Ok(None);
        };
        let binding = study
            .vocabulary
            .propositions
            .get(proposition)
            .and_then(|p| p.column.as_ref());
        let Some(binding) = binding else {
            return Ok(None);
        };
        if cohort.left_to_others.contains(&binding.text) {
            return Ok(None);
        }
        cohort.has_column(study, binding)?;
        cohort.counts(&binding.text).map(Some)
    }

    /// The cohort and the other tables must not contradict each other.
    fn check_agreement(&self, study: &Study) -> Result<(), Problem> {
        for form in &study.forms.subjects {
            let Some(by_subject) = self.cohort_counts(study, form)? else {
                continue;
            };
            let total: u64 = by_subject.iter().map(|s| s.successes).sum();
            let id = form.subject.id();
            let other = match form.subject {
                Subject::Requirement(_) => {
                    let row = self.requirements.iter().find(|r| r.requirement == id);
                    row.map(|r| (r.passed, r.place.as_ref()))
                }
                Subject::FailureMode(_) => {
                    let row = self.failure_modes.iter().find(|r| r.mode == id);
                    row.map(|r| (r.occurrences, Some(&r.place)))
                }
            };
            if let Some((other, place)) = other
                && other != total
            {
                let cohort = self
                    .cohort
                    .as_ref()
                    .map_or("the cohort", |c| c.table.name());
                let problem = Problem::new(
                    "tables-disagree",
                    format!(
                        "{other} are counted for `{id}` here, and {total} by {cohort}, a table of the same evidence"
                    ),
                );
                let problem = match place {
                    Some(place) => place.of(problem),
                    None => problem,
                };
                return Err(problem.remedy("correct the table that is wrong"));
            }
        }
        Ok(())
    }

    /// That one stands for all can be declared of one alone.
    fn check_is_one(&self) -> Result<(), Problem> {
        let (Some(_), Some(cohort)) = (&self.one_for_all, &self.cohort) else {
            return Ok(());
        };
        match cohort.subjects() {
            1 => Ok(()),
            many => Err(Problem::new(
                "one-for-all",
                format!(
                    "`one_for_all` is declared of {}, which has trials of {many}",
                    cohort.table.name()
                ),
            )
            .remedy("leave `one_for_all` out: how they differ is taken from the table")),
        }
    }

    /// What the findings depend on.
    pub fn inputs(&self, study: &Study, inputs: &mut Inputs) {
        if let Some(cohort) = &self.cohort {
            for column in cohort.table.columns() {
                inputs.add(column.header(), column.as_texts().join("\n").as_bytes());
            }
        }
        for row in &self.requirements {
            inputs.add_json(&row.requirement, &(row.covered, row.passed));
            // A table without these columns has the inputs that it had before there were any.
            if row.undecided > 0 || row.is_stopped {
                inputs.add_json(&row.requirement, &("beside", row.undecided, row.is_stopped));
            }
        }
        for row in &self.failure_modes {
            inputs.add_json(&row.mode, &(row.occurrences, row.opportunities));
        }
        for one in &self.of_runs {
            inputs.add_json(&one.requirement, &("junit", one.unknown, one.skipped));
        }
        if let Some(speaks_of) = &self.speaks_of {
            inputs.add("speaks_of", speaks_of.as_bytes());
        }
        // An entry without it has the inputs that it had before there was the key.
        if let Some(because) = &self.one_for_all {
            inputs.add("one_for_all", because.as_bytes());
        }
        for form in &study.forms.subjects {
            inputs.add("subject", form.subject.id().as_bytes());
            if let Some(proposition) = &form.experiment {
                let binding = study.vocabulary.propositions.get(proposition);
                let column = binding.and_then(|p| p.column.as_ref());
                inputs.add(proposition, column.map_or("", |c| &c.text).as_bytes());
            }
        }
    }
}

impl Cohort {
    fn new(study: &Study, table: Table) -> Result<Self, Problem> {
        let attempts = table
            .column("attempts")
            .and_then(|c| c.as_counts())
            .map_err(table_problem)?;
        let total = attempts
            .iter()
            .try_fold(0_u64, |sum, n| sum.checked_add(*n));
        let wrong = match total {
            _ if attempts.is_empty() => Some("the table has headers and no rows"),
            Some(0) => Some("the column \"attempts\" has nothing but zeros"),
            Some(total) if total <= MOST_TRIALS => None,
            Some(_) | None => Some("the column \"attempts\" sums to more than 10^12"),
        };
        if let Some(wrong) = wrong {
            return Err(RowPlace::head(&table)
                .of(Problem::new("bad-counts", wrong))
                .remedy("there must be at least one attempt and at most 10^12"));
        }
        if let Some(first) = table.columns().next() {
            check_unique(&table, &first.as_texts())?;
        }
        let cohort = Self {
            attempts,
            left_to_others: columns::left_to_others(study, &table),
            table,
        };
        cohort.check_codes(study)?;
        Ok(cohort)
    }

    /// Subjects with trials.
    fn subjects(&self) -> u64 {
        self.attempts.iter().filter(|trials| **trials > 0).count() as u64
    }

    /// Every code in a column of codes must be one that the vocabulary counts;
    /// a misspelt one would go uncounted.
    fn check_codes(&self, study: &Study) -> Result<(), Problem> {
        let mut known: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
        for proposition in study.vocabulary.propositions.values() {
            let binding = proposition.column.as_ref();
            if let Some((header, code)) = binding.and_then(|b| b.text.split_once(':')) {
                known.entry(header.trim()).or_default().push(code.trim());
            }
        }
        for (header, codes) in known {
            let Ok(column) = self.table.column(header) else {
                continue;
            };
            for (row, cell) in column.cells().enumerate() {
                if let Some(unknown) = cell.split_whitespace().find(|c| !codes.contains(c)) {
                    return Err(in_row(
                        &self.table,
                        row,
                        "unknown-code",
                        format!("column \"{header}\": no proposition counts the code `{unknown}`"),
                    )
                    .remedy(format!(
                        "the vocabulary counts {}; correct the code, or bind it with `column = \"{header}: {unknown}\"`",
                        codes.join(", ")
                    )));
                }
            }
        }
        Ok(())
    }

    /// A binding to a column that the table lacks is a mistake of either; it is shown where the column is named.
    fn has_column(&self, study: &Study, binding: &Binding) -> Result<(), Problem> {
        let Err(error) = self.table.column(columns::header(&binding.text)) else {
            return Ok(());
        };
        let all = "a word is bound once for all tables, so their columns have to be named alike";
        let remedy = match error.remedy() {
            Some(remedy) => format!("{remedy} ({all})"),
            None => all.to_owned(),
        };
        Err(Problem::new("bad-table", error.what())
            .about(self.table.name())
            .at(&study.vocabulary.source, binding.span.clone())
            .remedy(remedy))
    }

    /// Counts by row of a binding: a column of counts, or `column: code`.
    fn counts(&self, binding: &str) -> Result<Vec<stats::Sample>, Problem> {
        let counted: Vec<u64> = match binding.split_once(':') {
            None => {
                let column = self.table.column(binding.trim()).map_err(table_problem)?;
                column.as_counts().map_err(table_problem)?
            }
            Some((header, code)) => {
                let column = self.table.column(header.trim()).map_err(table_problem)?;
                let code = code.trim();
                let occurrences =
                    |cell: &str| cell.split_whitespace().filter(|c| *c == code).count();
                column
                    .cells()
                    .map(|cell| occurrences(cell) as u64)
                    .collect()
            }
        };
        counted
            .iter()
            .zip(&self.attempts)
            .enumerate()
            .map(|(row, (count, attempts))| {
                stats::Sample::new(*count, *attempts).map_err(|error| {
                    in_row(&self.table, row, "bad-counts", error.to_string())
                        .remedy("correct the row")
                })
            })
            .collect()
    }
}

fn verdict_rows(study: &Study, table: &Table) -> Result<Vec<VerdictRow>, Problem> {
    let column = |name: &str| {
        table
            .column(name)
            .and_then(|c| c.as_counts())
            .map_err(table_problem)
    };
    let ids = table
        .column("requirement")
        .map_err(table_problem)?
        .as_texts();
    let (covered, passed, failed) = (column("covered")?, column("passed")?, column("failed")?);
    let has = |name: &str| table.columns().any(|it| it.header() == name);
    let undecided = match has("undecided") {
        true => column("undecided")?,
        false => vec![0; ids.len()],
    };
    let stopped = match has("stopped") {
        true => table.column("stopped").map_err(table_problem)?.as_texts(),
        false => vec!["no"; ids.len()],
    };
    check_unique(table, &ids)?;
    let mut rows = Vec::new();
    for (row, id) in ids.iter().enumerate() {
        known_subject(study, table, row, &Subject::Requirement((*id).to_owned()))?;
        if passed[row].checked_add(failed[row]) != Some(covered[row]) {
            let message = format!(
                "{} passed and {} failed are not {} covered",
                passed[row], failed[row], covered[row]
            );
            return Err(in_row(table, row, "bad-counts", message).remedy("correct the row"));
        }
        rows.push(VerdictRow {
            requirement: (*id).to_owned(),
            covered: covered[row],
            passed: passed[row],
            undecided: undecided[row],
            place: Some(RowPlace::new(table, row)),
            is_stopped: match stopped[row].trim() {
                "yes" => true,
                "no" => false,
                other => {
                    let message = format!("column \"stopped\": `{other}` is neither `yes` nor `no`");
                    return Err(in_row(table, row, "bad-counts", message).remedy(
                        "write `yes` if trials went on until what they showed was enough, `no` if their number was fixed",
                    ));
                }
            },
        });
    }
    Ok(rows)
}

fn mode_rows(study: &Study, table: &Table) -> Result<Vec<ModeRow>, Problem> {
    let column = |name: &str| {
        table
            .column(name)
            .and_then(|c| c.as_counts())
            .map_err(table_problem)
    };
    let ids = table.column("mode").map_err(table_problem)?.as_texts();
    let (occurrences, opportunities) = (column("occurrences")?, column("opportunities")?);
    check_unique(table, &ids)?;
    let mut rows = Vec::new();
    for (row, id) in ids.iter().enumerate() {
        known_subject(study, table, row, &Subject::FailureMode((*id).to_owned()))?;
        stats::Sample::new(occurrences[row], opportunities[row]).map_err(|error| {
            in_row(table, row, "bad-counts", error.to_string()).remedy("correct the row")
        })?;
        rows.push(ModeRow {
            mode: (*id).to_owned(),
            occurrences: occurrences[row],
            opportunities: opportunities[row],
            place: RowPlace::new(table, row),
        });
    }
    Ok(rows)
}

/// Two rows about one thing would leave open which of them counts.
fn check_unique(table: &Table, ids: &[&str]) -> Result<(), Problem> {
    for (row, id) in ids.iter().enumerate() {
        if let Some(first) = ids[..row].iter().position(|other| other == id) {
            let line = table.line(first).unwrap_or_default();
            let message = format!("`{id}` stands in line {line} already");
            return Err(in_row(table, row, "duplicate-row", message)
                .remedy("keep one row for each, with all its counts"));
        }
    }
    Ok(())
}

fn known_subject(
    study: &Study,
    table: &Table,
    row: usize,
    subject: &Subject,
) -> Result<(), Problem> {
    if study.forms.of(subject).is_some() {
        return Ok(());
    }
    let message = format!("requirements.toml does not declare `{}`", subject.id());
    Err(in_row(table, row, "unknown-subject", message)
        .remedy("correct the identifier, or declare it"))
}

fn not_covered(reason: &str) -> Measure {
    Measure::NotCovered {
        reason: reason.into(),
        constant: None,
    }
}
