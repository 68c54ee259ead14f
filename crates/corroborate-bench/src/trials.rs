//! Trials with people, whose rates are each person's own: counts by subject, or totals of all beside what the table
//! says of each.

use crate::judges::finding;
use crate::random::Random;
use crate::requirements::id;
use crate::task::{Run, SPEED_LIMIT, Task};
use evidence::{Finding, Measure, Subject};
use stats::{CommonCorrelation, Confidence, Sample};

/// What an experiment's tables say of who did what.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Told {
    /// Everything that was counted, by person.
    Everything,
    /// Success by person, all else as totals.
    Success,
    /// How many attempts each person made; all counts as totals.
    Attempts,
    /// Totals; not that people made them.
    Nothing,
}

impl Told {
    /// All of them.
    pub const ALL: [Told; 4] = [
        Told::Everything,
        Told::Success,
        Told::Attempts,
        Told::Nothing,
    ];

    /// Its name in tables.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Told::Everything => "everything by person",
            Told::Success => "success by person, all else as totals",
            Told::Attempts => "attempts of each person, all counts as totals",
            Told::Nothing => {
                "totals, and not that people made them: each attempt is taken for a trial of its own, as declared"
            }
        }
    }
}

/// How many people, how many attempts each, and how alike the attempts of one are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cohort {
    /// People.
    pub subjects: usize,
    /// Attempts of each.
    pub attempts: usize,
    /// Intraclass correlation of each rate.
    pub correlation: f64,
    /// What the tables say of who did what.
    pub told: Told,
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
    told: Told,
    level: Confidence,
) -> Result<Vec<Finding>, String> {
    let mut counted: Vec<(Subject, Vec<Sample>)> = Vec::new();
    let mut add = |subject: Subject, what: &dyn Fn(&Run) -> Option<bool>| {
        let column = runs.iter().map(|person| count(person, what)).collect();
        counted.push((subject, column));
    };
    let requirement = |id: &str| Subject::Requirement(id.to_owned());
    add(requirement(id::DONE), &|run| Some(run.is_done()));
    add(requirement(id::IN_TIME), &|run| {
        Some(run.is_done_by(limit_steps))
    });
    add(requirement(id::READY), &|run| Some(run.is_done()));
    add(requirement(id::SLOW), &|run| {
        run.is_done().then_some(run.speed < SPEED_LIMIT)
    });
    for (mode, place) in modes {
        add(Subject::FailureMode(mode.clone()), &|run| match place {
            Some(place) => run.reached(*place).then(|| run.failed_at(*place)),
            // A mode that nobody has ever seen: every attempt was an opportunity.
            None => Some(false),
        });
    }
    let attempts: Vec<u64> = runs.iter().map(|person| person.len() as u64).collect();
    let by_person = match told {
        Told::Everything => counted.len(),
        Told::Success => 1,
        Told::Attempts | Told::Nothing => 0,
    };
    let has_trials = |column: &&Vec<Sample>| column.iter().any(|person| person.trials > 0);
    let columns = counted[..by_person].iter().map(|(_, column)| column);
    let columns: Vec<&Vec<Sample>> = columns.filter(has_trials).collect();
    let common = CommonCorrelation::of(&columns).map_err(|error| error.to_string())?;
    let found = counted
        .iter()
        .enumerate()
        .map(|(place, (subject, column))| {
            let total = in_all(column);
            let mut found = finding(subject.clone(), total, 0, level)?;
            if total.trials > 0 && told != Told::Nothing {
                let measure = match place < by_person {
                    true => Measure::of_clusters_among(&common, column, level),
                    false => Measure::of_total_among(&common, total, &attempts, level),
                };
                found.measure = measure.map_err(|error| error.to_string())?;
            }
            Ok(found)
        });
    found.collect()
}

fn in_all(column: &[Sample]) -> Sample {
    let none = Sample {
        successes: 0,
        trials: 0,
    };
    column.iter().fold(none, |sum, person| Sample {
        successes: sum.successes + person.successes,
        trials: sum.trials + person.trials,
    })
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::family::{Family, Setup};

    /// The less a table says of who did what, the less its counts are worth; but if it does not say that people
    /// made them, each attempt is taken for a trial of its own.
    #[test]
    fn what_is_not_told_is_not_known() {
        let mut random = Random::new(2, 1);
        let setup = Setup::draw(Family::Serial, &mut random);
        let cohort = Cohort {
            subjects: 20,
            correlation: 0.3,
            ..setup.cohort
        };
        let runs = cohort.runs(&setup.truth, &mut random);
        let widths = Told::ALL.map(|told| {
            let found = findings(&runs, setup.limit_steps, &[], told, Confidence::P95).unwrap();
            // The second is not success.
            found[1]
                .measure
                .interval()
                .map(|it| it.high - it.low)
                .unwrap()
        });
        let [everything, success, attempts, nothing] = widths;
        assert!(success < attempts && everything < attempts, "{widths:?}");
        assert!(nothing < everything && nothing < success, "{widths:?}");
    }
}
