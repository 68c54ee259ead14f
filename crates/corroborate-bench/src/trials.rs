//! Trials with people: counts by subject, whose rates are each person's own.

use crate::judges::finding;
use crate::random::Random;
use crate::requirements::id;
use crate::task::{Run, SPEED_LIMIT, Task};
use evidence::{Finding, Measure, Subject};
use stats::{Confidence, Sample};

/// How many people, how many attempts each, and how alike the attempts of one are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cohort {
    /// People.
    pub subjects: usize,
    /// Attempts of each.
    pub attempts: usize,
    /// Intraclass correlation of each rate.
    pub correlation: f64,
    /// Whether the tables say who did which attempt.
    pub by_subject: bool,
}

impl Cohort {
    /// Independent trials that say as much about a rate as `share` of the attempts.
    #[must_use]
    pub fn effective(&self, share: f64) -> f64 {
        let each = self.attempts as f64 * share;
        let effect = 1.0 + (each - 1.0).max(0.0) * self.correlation;
        self.subjects as f64 * each / effect
    }

    /// The runs of each person.
    pub fn runs(&self, task: &Task, random: &mut Random) -> Vec<Vec<Run>> {
        (0..self.subjects)
            .map(|_| {
                let own = task.of_person(self.correlation, random);
                (0..self.attempts).map(|_| own.run(random)).collect()
            })
            .collect()
    }
}

/// What the people's runs count for each subject of the study. `modes` are the failure modes, each with
/// the place of the stage whose failures stand in its column.
///
/// # Errors
/// What cannot be counted, in words.
pub fn findings(
    runs: &[Vec<Run>],
    limit_steps: u32,
    modes: &[(String, Option<usize>)],
    by_subject: bool,
    level: Confidence,
) -> Result<Vec<Finding>, String> {
    let mut findings = Vec::new();
    let mut add = |subject: Subject, what: &dyn Fn(&Run) -> Option<bool>| {
        let counted: Vec<Sample> = runs.iter().map(|person| count(person, what)).collect();
        findings.push(clustered(subject, &counted, by_subject, level)?);
        Ok::<(), String>(())
    };
    let requirement = |id: &str| Subject::Requirement(id.to_owned());
    add(requirement(id::DONE), &|run| Some(run.is_done()))?;
    add(requirement(id::IN_TIME), &|run| {
        Some(run.is_done_by(limit_steps))
    })?;
    add(requirement(id::READY), &|run| Some(run.is_done()))?;
    add(requirement(id::SLOW), &|run| {
        run.is_done().then_some(run.speed < SPEED_LIMIT)
    })?;
    for (mode, place) in modes {
        add(Subject::FailureMode(mode.clone()), &|run| match place {
            Some(place) => run.reached(*place).then(|| run.failed_at(*place)),
            // A mode that nobody has ever seen: every attempt was an opportunity.
            None => Some(false),
        })?;
    }
    Ok(findings)
}

fn count(runs: &[Run], what: &dyn Fn(&Run) -> Option<bool>) -> Sample {
    let mut sample = Sample {
        successes: 0,
        trials: 0,
    };
    for seen in runs.iter().filter_map(what) {
        sample.trials += 1;
        sample.successes += u64::from(seen);
    }
    sample
}

fn clustered(
    subject: Subject,
    counted: &[Sample],
    by_subject: bool,
    level: Confidence,
) -> Result<Finding, String> {
    let mut total = Sample {
        successes: 0,
        trials: 0,
    };
    for of_person in counted {
        total.successes += of_person.successes;
        total.trials += of_person.trials;
    }
    let mut found = finding(subject, total, 0, level)?;
    if by_subject && total.trials > 0 {
        found.measure = Measure::of_clusters(counted, level).map_err(|error| error.to_string())?;
    }
    Ok(found)
}
