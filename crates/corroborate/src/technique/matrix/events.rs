//! Unmodelled behaviour: steps of simulated or recorded runs that a formal model does not have.
//!
//! Runs and models are told by the same propositions, those of the `[abstraction]` of exploration.toml;
//! see [`crate::technique::exploration::Abstraction`] for what counts as a step of the model. An event
//! belongs to the failure mode that occurs in at least [`MOST`] of the runs that show it.

use super::{Diagnosing, Gathered};
use crate::corroboration::ANY_STUDY;
use crate::technique::campaign::form_verdicts;
use crate::technique::exploration::{Abstraction, Class, Formal, Plan};
use diagnostic::Problem;
use evidence::{
    Clue, Evidence, Figure, Inaccuracy, Interval, Measure, Rate, Subject, Symptom, Witness,
    strength, system_model,
};
use judging::Judges;
use judging::verdicts::RunVerdicts;
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use study::{Entry, Work};
use temporal::monitor::Verdict;

/// The share of an event's runs in which a failure mode must occur for the event to be its.
const MOST: f64 = 0.8;

/// The most that an event counts if the model knows its failure mode, only not there.
const KNOWN: f64 = 1.0;

/// A step of runs, or their end.
type Event = (Class, Option<Class>);

/// The runs of one entry, as sequences of abstract states.
struct Runs<'a> {
    entry: &'a Entry,
    /// The number of each run with its steps.
    steps: Vec<(u64, crate::technique::exploration::AbstractTrace)>,
    /// The failure modes that occur in each run.
    modes: BTreeMap<u64, BTreeSet<String>>,
}

impl Diagnosing<'_> {
    /// Looks for unmodelled behaviour.
    pub(super) fn events(&self, gathered: &mut Gathered) -> Result<(), Problem> {
        let file = Path::new("exploration.toml");
        if !self.study.folder.join(file).exists() {
            let said = "no exploration.toml defines the propositions that states are compared by";
            gathered
                .not_done
                .push(format!("unmodelled behaviour: {said}"));
            return Ok(());
        }
        let plan = Plan::load(&self.study.folder, file)?;
        let mut models = Vec::new();
        for entry in self.entries(|work| work.model().is_some()) {
            let formal = Formal::of_entry(self.study, &entry.id, &self.setting.cancel)?;
            let Some(abstraction) = Abstraction::new(self.study, &plan, &formal)? else {
                let said = "exploration.toml has no [abstraction]";
                gathered
                    .not_done
                    .push(format!("unmodelled behaviour: {said}"));
                return Ok(());
            };
            models.push((entry, abstraction));
        }
        let Some((_, first)) = models.first() else {
            return Ok(());
        };
        for entry in self.entries(Work::is_simulated_here) {
            let runs = self.abstracted(entry, first, gathered)?;
            if runs.steps.is_empty() {
                let said = format!("unmodelled behaviour in {}: no recording is kept", entry.id);
                gathered.not_done.push(said);
            }
            let comparable = models
                .iter()
                .filter(|(m, _)| m.conditions == entry.conditions);
            for (model, abstraction) in comparable {
                let clues = self.unknown(model, abstraction, &runs);
                if clues.is_empty() && !runs.steps.is_empty() {
                    let (n, of) = (runs.steps.len(), &entry.id);
                    let said = format!("{} knows every step of {n} runs of {of}", model.id);
                    gathered.in_order.push(said);
                }
                gathered.clues.extend(clues);
            }
        }
        Ok(())
    }

    /// The kept recordings of an entry, abstracted.
    fn abstracted<'e>(
        &self,
        entry: &'e Entry,
        abstraction: &Abstraction,
        gathered: &mut Gathered,
    ) -> Result<Runs<'e>, Problem> {
        let folder = self.folder.join("episodes").join(&entry.id);
        let all = recordings(&folder);
        let kept = all.len();
        let modes = match kept {
            0 => BTreeMap::new(),
            _ => self.failures(&folder)?,
        };
        // Evenly from all, so that shares of the chosen estimate shares of all.
        let most = self
            .effort
            .runs
            .map_or(kept, |most| usize::try_from(most).unwrap_or(kept));
        let files = evenly(all, most);
        if files.len() < kept {
            gathered.not_done.push(format!(
                "steps of {} of {kept} recordings of {} (--runs)",
                kept - files.len(),
                entry.id
            ));
        }
        let title = format!("{}: steps of runs", entry.id);
        let stage = self.setting.events.begin(&title, files.len() as u64);
        let steps = files.par_iter().map(|(number, path)| {
            self.setting.go_on()?;
            let read = recording::read_mcap(path)
                .map_err(|error| Problem::new("bad-recording", error.to_string()))?;
            stage.advance();
            Ok((*number, abstraction.of_trace(&read.trace)?))
        });
        let steps = steps.collect::<Result<Vec<_>, Problem>>()?;
        Ok(Runs {
            entry,
            steps,
            modes,
        })
    }

    /// The failure modes that occur in each episode of a folder.
    fn failures(&self, folder: &Path) -> Result<BTreeMap<u64, BTreeSet<String>>, Problem> {
        let mut modes: BTreeMap<u64, BTreeSet<String>> = BTreeMap::new();
        if let Some(RunVerdicts { main, .. }) = form_verdicts(folder, u64::MAX)? {
            let judges = Judges::new(self.study, |_| true)?;
            let places: Vec<_> = judges.monitors().collect();
            for (number, verdicts) in (1..).zip(main) {
                for ((subject, reading), verdict) in places.iter().zip(verdicts) {
                    if let (Subject::FailureMode(id), None, Verdict::Violated) =
                        (subject, reading, verdict)
                    {
                        modes.entry(number).or_default().insert(id.clone());
                    }
                }
            }
        }
        Ok(modes)
    }

    /// Events of runs that a model does not have.
    fn unknown(&self, model: &Entry, abstraction: &Abstraction, runs: &Runs<'_>) -> Vec<Clue> {
        let mut events: BTreeMap<Event, Vec<u64>> = BTreeMap::new();
        for (number, steps) in &runs.steps {
            let of_run: BTreeSet<Event> = abstraction.unknown(steps).into_iter().collect();
            for event in of_run {
                events.entry(event).or_default().push(*number);
            }
        }
        let piece = self.result.evidence.iter().find(|e| e.id == model.id);
        let found = events.iter();
        found
            .filter_map(|(event, numbers)| {
                Some(self.unknown_event(piece?, abstraction, runs, *event, numbers))
            })
            .collect()
    }

    fn unknown_event(
        &self,
        model: &Evidence,
        abstraction: &Abstraction,
        runs: &Runs<'_>,
        (from, to): Event,
        numbers: &[u64],
    ) -> Clue {
        let (count, of, id) = (
            numbers.len() as u64,
            runs.steps.len() as u64,
            &runs.entry.id,
        );
        let mode = runs.mode_of(numbers);
        let subject = self.subject_of(mode.as_ref());
        let whole = strength(
            Rate::Computed(0.0),
            Rate::counted(count, of),
            self.margin(&subject),
        );
        let knows = model
            .finding(&subject)
            .is_none_or(|f| !matches!(f.measure, Measure::NotExpressible { .. }));
        let held = |class: Class| abstraction.describe(class);
        let words = match to {
            Some(to) => {
                let (from, to) = (held(from), held(to));
                format!("`{from}` is followed by `{to}`")
            }
            None => format!("a run ends in `{}`", held(from)),
        };
        let occurring = mode.as_ref().map_or(String::new(), |mode| {
            format!(" In most of them {} occurs.", mode.replace('_', " "))
        });
        let names = |class: Class| held(class).split_whitespace().map(str::to_owned).collect();
        Clue {
            inaccuracy: Inaccuracy::SystemModel,
            asset: system_model(model),
            score: if knows { whole.min(KNOWN) } else { whole },
            title: format!(
                "{} does not know a step that {count} of {of} runs of {id} take",
                model.id
            ),
            explanation: format!(
                "In {count} of {of} runs of {id} {words}, which the model does not have.{occurring}"
            ),
            symptom: Symptom::UnmodelledEvent {
                from: names(from),
                to: to.map(names),
                evidence: id.clone(),
                runs: count,
                of,
            },
            figures: vec![Figure {
                name: "rate of the event".into(),
                value: count as f64 / of.max(1) as f64,
                interval: self.interval(count, of),
            }],
            witnesses: numbers
                .iter()
                .take(3)
                .map(|number| Witness {
                    name: format!("{id} episode {number}"),
                    shows: words.clone(),
                    replay: format!("corroborate replay {ANY_STUDY} {id}:{number}"),
                })
                .collect(),
            subject,
            ruled_out: Vec::new(),
            resolved_by: None,
        }
    }

    fn subject_of(&self, mode: Option<&String>) -> Subject {
        let first = self.study.requirements.first().map(|r| r.id.clone());
        match mode {
            Some(mode) => Subject::FailureMode(mode.clone()),
            None => Subject::Requirement(first.unwrap_or_default()),
        }
    }

    /// The declared margin of a subject.
    pub(super) fn margin(&self, subject: &Subject) -> f64 {
        self.study.margin(subject)
    }

    fn interval(&self, count: u64, of: u64) -> Option<Interval> {
        let sample = stats::Sample::new(count, of)
            .ok()
            .filter(|s| s.trials > 0)?;
        let level = stats::Confidence::new(self.study.about.confidence).ok()?;
        let wilson = stats::wilson(sample, level);
        Some(Interval {
            low: wilson.low,
            high: wilson.high,
        })
    }
}

impl Runs<'_> {
    /// The failure mode that occurs in most of these runs.
    fn mode_of(&self, numbers: &[u64]) -> Option<String> {
        let mut counts: BTreeMap<&String, usize> = BTreeMap::new();
        let all = numbers
            .iter()
            .filter_map(|number| self.modes.get(number))
            .flatten();
        all.for_each(|mode| *counts.entry(mode).or_default() += 1);
        let most = counts.into_iter().max_by_key(|(_, count)| *count)?;
        let is_most = most.1 as f64 >= MOST * numbers.len() as f64;
        is_most.then(|| most.0.clone())
    }
}

/// At most so many of all, evenly spread.
pub(super) fn evenly<T>(all: Vec<T>, most: usize) -> Vec<T> {
    let (len, most) = (all.len(), most.min(all.len()));
    let is_chosen = |i: usize| (i + 1) * most / len > i * most / len;
    let numbered = all.into_iter().enumerate();
    numbered
        .filter(|(i, _)| is_chosen(*i))
        .map(|(_, it)| it)
        .collect()
}

/// The recordings of a campaign by the numbers of their episodes.
fn recordings(folder: &Path) -> Vec<(u64, PathBuf)> {
    let Ok(entries) = std::fs::read_dir(folder) else {
        return Vec::new();
    };
    let numbered = entries.flatten().filter_map(|entry| {
        let name = entry.file_name().into_string().ok()?;
        let number = name.strip_prefix("episode-")?.strip_suffix(".mcap")?;
        Some((number.parse().ok()?, entry.path()))
    });
    let mut all: Vec<(u64, PathBuf)> = numbered.collect();
    all.sort();
    all
}

#[cfg(test)]
mod tests {
    use super::evenly;

    #[test]
    fn what_is_chosen_is_spread_over_all() {
        let of = |n: u64, most| evenly((1..=n).collect(), most);
        assert_eq!(of(5, 9), [1, 2, 3, 4, 5]);
        assert_eq!(of(10, 5), [2, 4, 6, 8, 10]);
        assert_eq!(of(7, 3), [3, 5, 7]);
        assert!(of(0, 3).is_empty() && of(3, 0).is_empty());
    }
}
