//! Verdicts over looks: trials are added to an experiment and the requirement is judged again, until the verdict comes
//! out that is wrong, or to the end of the rule.
//!
//! Rules of going on: *double* (as many trials again, 5 looks), *often* (a tenth more, 25 looks), *by what is seen* (few
//! more when it is near to come out, many when not, 8 looks), *as proposed* (the trials that `synthesise` plans for a
//! study whose sizes are fixed, 5 looks). No rule goes beyond 30 times the first trials.
//!
//! The p-values over all looks are worked out here with `stats::continuation`, as the definition of `looks/over_looks.rs`
//! says: `conclude` also works out two intervals at each look, which takes a hundred times as long.
//! `tests/integration/error_rates.rs` holds both against each other.

use super::laws::Law;
use super::several::concluded;
use super::support::{Uniform, at_least, counts, piece, requirement};
use super::table::{Job, Row, all};
use evidence::*;
use stats::{
    BetaBinomial, ClusteredLook, Confidence, EffectiveSample, Sample, ScoredLook,
    clustered_test_above, clustered_test_below, continued_above, continued_below,
    continued_clusters_above, continued_clusters_below,
};

/// When to go on with how many trials.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Going {
    Double,
    Often,
    BySeen,
    AsProposed,
}

impl Going {
    pub const ALL: [Going; 4] = [
        Going::Double,
        Going::Often,
        Going::BySeen,
        Going::AsProposed,
    ];

    pub fn name(self) -> &'static str {
        match self {
            Going::Double => "double",
            Going::Often => "often",
            Going::BySeen => "by what is seen",
            Going::AsProposed => "as proposed",
        }
    }

    pub fn looks(self) -> usize {
        match self {
            Going::Double | Going::AsProposed => 5,
            Going::Often => 25,
            Going::BySeen => 8,
        }
    }

    /// Further trials, given those of now, the p-value of what is sought, and what is proposed.
    pub fn further(
        self,
        trials: u64,
        p: f64,
        proposed: impl FnOnce() -> Option<u64>,
    ) -> Option<u64> {
        match self {
            Going::Double => Some(trials),
            Going::Often => Some(trials.div_ceil(10)),
            Going::BySeen => Some(if p < 0.15 {
                trials.div_ceil(5)
            } else {
                2 * trials
            }),
            Going::AsProposed => proposed(),
        }
    }
}

/// Who makes the trials.
#[derive(Clone, Copy, Debug)]
pub enum Trials {
    /// Independent ones.
    Independent,
    /// People with ten attempts each, at this intraclass correlation.
    People(f64),
    /// People who differ by a law that is held out.
    HeldOut(Law),
}

impl Trials {
    /// More of them; whole people.
    pub fn add(self, uniform: &mut Uniform, seen: &mut Vec<Sample>, trials: u64, rate: f64) {
        match self {
            Trials::Independent => seen.push(uniform.sample(trials, rate)),
            Trials::People(correlation) => {
                let people = trials.div_ceil(10) as usize;
                seen.extend(uniform.people(people, 10, rate, correlation));
            }
            Trials::HeldOut(law) => {
                let people = trials.div_ceil(10);
                seen.extend((0..people).map(|_| law.person(uniform, rate)));
            }
        }
    }

    pub fn measure(self, seen: &[Sample]) -> Measure {
        let total = stats::pool(seen).expect("counts");
        match self {
            Trials::Independent => counts(total.successes, total.trials),
            Trials::People(_) | Trials::HeldOut(_) => {
                Measure::of_clusters(seen, Confidence::P95).expect("counts")
            }
        }
    }

    pub fn name(self) -> String {
        match self {
            Trials::Independent => "independent trials".into(),
            Trials::People(correlation) => format!("people x 10, correlation {correlation}"),
            Trials::HeldOut(law) => format!("held out: {}", law.name()),
        }
    }
}

/// What is looked at.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    pub going: Going,
    pub trials: Trials,
    pub requirements: usize,
    pub rate: f64,
    pub threshold: f64,
    pub first: u64,
}

impl Case {
    /// How many people there are at the first look, where they are few.
    fn beginning(&self) -> String {
        match self.first < 60 {
            true => format!(" from {} people", self.first / 10),
            false => String::new(),
        }
    }
}

/// The p-value over all looks of what denies a verdict: that the rate is below the threshold, or at least as high.
pub fn doubt(looks: &[Measure], verdict: Verdict, threshold: f64) -> f64 {
    let is_above = verdict == Verdict::Satisfied;
    let samples: Vec<Sample> = looks.iter().map(|it| sample_of(it).0).collect();
    if looks.iter().all(|it| sample_of(it).1.is_none()) {
        return match is_above {
            true => continued_above(&samples, threshold),
            false => continued_below(&samples, threshold),
        };
    }
    let test = match is_above {
        true => clustered_test_above,
        false => clustered_test_below,
    };
    let clusters: Vec<Option<Vec<Sample>>> = looks.iter().map(clusters_of).collect();
    let scored = looks.iter().zip(&clusters).map(|(it, clusters)| {
        let (sample, effective) = sample_of(it);
        let size = effective.unwrap_or(sample.trials as f64);
        let by_size = test(
            EffectiveSample::at_size(sample, size).expect("a size"),
            threshold,
        );
        let fit = clusters
            .as_ref()
            .filter(|_| sample.successes > 0 && sample.failures() > 0)
            .and_then(|clusters| BetaBinomial::fit(clusters).ok());
        let by_people = fit.map_or(0.0, |people| {
            let (above, below) = people.threshold_tests(threshold);
            if is_above { above } else { below }
        });
        ClusteredLook {
            clusters: clusters.as_deref(),
            scored: ScoredLook {
                p: by_size.max(by_people),
                information: sample.trials as f64,
            },
        }
    });
    let looks: Vec<ClusteredLook<'_>> = scored.collect();
    match is_above {
        true => continued_clusters_above(&looks, threshold),
        false => continued_clusters_below(&looks, threshold),
    }
}

fn clusters_of(measure: &Measure) -> Option<Vec<Sample>> {
    let Measure::Counts {
        by_subject: Some(clusters),
        ..
    } = measure
    else {
        return None;
    };
    let one = |&[successes, trials]: &[u64; 2]| Sample { successes, trials };
    Some(clusters.iter().map(one).collect())
}

fn sample_of(measure: &Measure) -> (Sample, Option<f64>) {
    let Measure::Counts {
        count,
        trials,
        effective_trials,
        ..
    } = measure
    else {
        unreachable!("all are counted")
    };
    (
        Sample::new(*count, *trials).expect("counts"),
        *effective_trials,
    )
}

/// Whether a study comes to a verdict on any requirement, at any look. Several requirements divide the level, by Holm's
/// first step.
fn comes_out(case: &Case, wanted: Verdict, uniform: &mut Uniform) -> bool {
    let mut seen: Vec<Vec<Sample>> = vec![Vec::new(); case.requirements];
    let mut looks: Vec<Vec<Measure>> = vec![Vec::new(); case.requirements];
    let (mut further, mut made) = (case.first, 0);
    for _ in 0..case.going.looks() {
        made += further;
        let mut least = 1.0_f64;
        for (samples, looks) in seen.iter_mut().zip(&mut looks) {
            case.trials.add(uniform, samples, further, case.rate);
            looks.push(case.trials.measure(samples));
            least = least.min(doubt(looks, wanted, case.threshold));
        }
        if least <= 0.05 / case.requirements as f64 {
            return true;
        }
        let last = || looks.iter().filter_map(|it| it.last().cloned()).collect();
        let proposed = || proposed(last(), case.threshold);
        match case.going.further(made, least, proposed) {
            Some(more) if made < 30 * case.first => further = more.min(30 * case.first),
            _ => return false,
        }
    }
    false
}

/// The most trials that are proposed for a requirement.
fn proposed(now: Vec<Measure>, threshold: f64) -> Option<u64> {
    let asked: Vec<Requirement> = (0..now.len())
        .map(|it| requirement(it, at_least(threshold)))
        .collect();
    let ledger = [piece(
        "E",
        Technique::Experiment,
        now.into_iter().enumerate().collect(),
    )];
    let (comparisons, conclusions) = concluded(&ledger, &asked, None);
    let influences = Influences::learn(&ledger);
    let study = Study {
        requirements: &asked,
        failure_modes: &[],
        evidence: &ledger,
        influences: &influences,
        looks: None,
        levels: Levels::new(0.95, 0.95).expect("levels"),
    };
    let found = synthesise(
        &study,
        (&comparisons, Vec::new()),
        &conclusions,
        TrialCosts::equal(),
        &Weights::default(),
    );
    found.deciding.iter().filter_map(|it| it.trials).max()
}

/// How often a verdict comes out.
pub fn share(case: &Case, wanted: Verdict, studies: u64) -> (u64, u64) {
    let mut uniform = Uniform(11 + case.going as u64 + 10 * case.requirements as u64);
    let found = (0..studies).filter(|_| comes_out(case, wanted, &mut uniform));
    (found.count() as u64, studies)
}

fn row(case: &Case, wanted: Verdict, studies: u64) -> Row {
    let name = match case.requirements {
        1 => String::new(),
        many => format!("{many} requirements, "),
    };
    let (rate, threshold) = (case.rate, case.threshold);
    let name = format!(
        "{name}{}, {}{}: rate {rate}, threshold {threshold}",
        case.trials.name(),
        case.going.name(),
        case.beginning()
    );
    let is_power = (rate - threshold).abs() > 1e-9;
    let statement = match (wanted, is_power) {
        (Verdict::Satisfied, false) => "satisfied, at any look",
        (Verdict::Satisfied, true) => "satisfied (it is), at any look",
        _ => "violated, at any look",
    };
    let most = (!is_power).then_some(0.05);
    Row::counted(&name, statement, share(case, wanted, studies), most)
}

pub fn rows(studies: u64) -> Vec<Row> {
    let mut jobs: Vec<Job<'_>> = Vec::new();
    let mut add = |case: Case, wanted: Verdict, studies: u64| {
        jobs.push(Box::new(move || vec![row(&case, wanted, studies)]));
    };
    for going in Going::ALL {
        let case = Case {
            going,
            trials: Trials::Independent,
            requirements: 1,
            rate: 0.9,
            threshold: 0.9,
            first: 60,
        };
        let few = studies / if going == Going::AsProposed { 4 } else { 1 };
        add(case, Verdict::Satisfied, few);
        add(case, Verdict::Violated, few);
        add(Case { rate: 0.95, ..case }, Verdict::Satisfied, few / 2);
        if going == Going::Double {
            let three = Case {
                requirements: 3,
                ..case
            };
            add(three, Verdict::Violated, few);
        }
    }
    all(&jobs)
}

/// The same of people, at the one correlation that a cohort has, and by the laws that are held out.
pub fn rows_of_people(studies: u64) -> Vec<Row> {
    let held_out = Law::ALL.map(Trials::HeldOut);
    let of = [Trials::People(0.3)].into_iter().chain(held_out);
    let cases = of.flat_map(|trials| {
        [Going::Double, Going::Often].map(|going| Case {
            going,
            trials,
            requirements: 1,
            rate: 0.9,
            threshold: 0.9,
            first: 100,
        })
    });
    let few = [2, 4].map(|people| Case {
        going: Going::Double,
        trials: Trials::People(0.3),
        requirements: 1,
        rate: 0.9,
        threshold: 0.9,
        first: 10 * people,
    });
    let jobs = cases.chain(few).flat_map(|case| {
        let verdicts = [Verdict::Satisfied, Verdict::Violated];
        verdicts.map(|wanted| -> Job<'_> { Box::new(move || vec![row(&case, wanted, studies)]) })
    });
    all(&jobs.collect::<Vec<_>>())
}
