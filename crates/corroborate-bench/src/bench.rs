//! Many studies, scored: the figures of the benchmark.

use crate::coverage::{Kind, coverage};
use crate::family::Family;
use crate::fault::{Fault, Site};
use crate::matrix::site;
use crate::random::Random;
use crate::repair::{Repair, repair};
use crate::score::{Powers, Score, score};
use crate::study::{LEVEL, Synthetic};
use crate::trials::Told;
use evidence::Outcome;
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// How much is run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plan {
    /// Studies with each fault, of the toys and of the serial tasks together.
    pub studies: u64,
    /// Studies without one.
    pub sound: u64,
    /// Studies with people whose attempts are alike, where there is no fault to be found, only false alarms.
    pub clustered: u64,
    /// Studies of the handover with each fault; its model has 15,623 states.
    pub handover: u64,
    /// Studies of the corridor with each fault.
    pub corridor: u64,
    /// From which everything is drawn.
    pub seed: u64,
    /// Only studies of this family, if any; each is the one that it is among all.
    pub only: Option<Family>,
}

impl Plan {
    /// What the published table was made with.
    pub const FULL: Plan = Plan {
        studies: 60,
        sound: 400,
        clustered: 400,
        handover: 12,
        corridor: 12,
        seed: 5,
        only: None,
    };

    /// What a change is judged by.
    pub const SMALL: Plan = Plan {
        studies: 8,
        sound: 40,
        clustered: 8,
        handover: 0,
        corridor: 0,
        seed: 5,
        only: None,
    };
}

/// One study's result.
#[derive(Clone, Debug)]
pub struct Line {
    /// Its number, from which it can be made again.
    pub number: u64,
    /// Its family.
    pub family: Family,
    /// Whether the formal model's constants were counted.
    pub counted_constants: bool,
    /// What the tables say of who did what.
    pub told: Told,
    /// Its score.
    pub score: Score,
    /// Where its suspects are, the first three of them, with their scores.
    pub accused: Vec<(Site, f64)>,
    /// What came of the first proposal, where something was planted.
    pub repair: Repair,
    /// Its intervals, where nothing was planted.
    pub intervals: Vec<(Kind, bool)>,
    /// One of its comparisons at random: whether "no difference" is rejected at the level of a single comparison, and
    /// whether the program calls it a conflict.
    pub comparison: Option<(bool, bool)>,
}

/// Runs the plan; the same lines at any number of threads. `said` is told after each study how many are done, of how
/// many.
///
/// # Errors
/// What could not be produced, with the study's number.
pub fn run(plan: &Plan, said: &(dyn Fn(usize, usize) + Sync)) -> Result<Vec<Line>, String> {
    let is_wanted = |family: Family| plan.only.is_none_or(|only| only == family);
    let jobs: Vec<(usize, (Family, Fault))> = jobs(plan)
        .into_iter()
        .enumerate()
        .filter(|(_, (family, _))| is_wanted(*family))
        .collect();
    let (all, done) = (jobs.len(), AtomicUsize::new(0));
    jobs.into_par_iter()
        .map(|(number, (family, fault))| {
            let line = one(family, fault, plan.seed, number as u64).map_err(|error| {
                format!(
                    "study {number} ({}, {}): {error}",
                    family.name(),
                    fault.name()
                )
            });
            said(done.fetch_add(1, Ordering::Relaxed) + 1, all);
            line
        })
        .collect()
}

fn jobs(plan: &Plan) -> Vec<(Family, Fault)> {
    let mut jobs = Vec::new();
    for fault in Fault::ALL {
        let studies = if fault == Fault::None {
            plan.sound
        } else if fault == Fault::ClusteredSubjects {
            plan.clustered
        } else {
            plan.studies
        };
        let mut add = |family: Family, count: u64| {
            if fault.fits(family) {
                jobs.extend((0..count).map(|_| (family, fault)));
            }
        };
        let toys = if fault.fits(Family::Toy) {
            studies / 4
        } else {
            0
        };
        add(Family::Toy, toys);
        add(Family::Serial, studies - toys);
        let times = if fault.is_conflict() { 1 } else { 3 };
        add(Family::Handover, times * plan.handover);
        add(Family::Corridor, times * plan.corridor);
    }
    jobs
}

fn one(family: Family, fault: Fault, seed: u64, number: u64) -> Result<Line, String> {
    let study = Synthetic::new(family, fault, seed, number)?;
    let mut random = Random::new(seed ^ 0x5eed, number);
    let first = study.suspects.iter().take(3);
    Ok(Line {
        number,
        family,
        accused: first.map(|it| (site(it), it.score)).collect(),
        counted_constants: study.setup.rig.is_some(),
        told: study.setup.cohort.told,
        score: score(&study),
        repair: repair(&study)?,
        comparison: one_comparison(&study, &mut Random::new(seed ^ 0xa1a, number)),
        intervals: match fault {
            Fault::None => coverage(&study, &mut random)?,
            _ => Vec::new(),
        },
    })
}

impl Line {
    /// What of a planted fault was missed, for somebody who looks at misses one by one; `None` if nothing was.
    #[must_use]
    pub fn missed(&self) -> Option<String> {
        let score = &self.score;
        let is_repaired = matches!(self.repair, Repair::Repaired | Repair::NotRepairable);
        let is_first = score.rank == Some(1);
        if !score.fault.is_conflict() || score.found && is_first && is_repaired {
            return None;
        }
        let Powers {
            known,
            learned,
            of_all,
        } = score.theory;
        Some(format!(
            "study {} ({}, {}): found {} (power {known:.3}, {learned:.3}, {of_all:.3}), suspect {:?} of {:?}, {:?}",
            self.number,
            self.family.name(),
            score.fault.name(),
            score.found,
            score.rank,
            self.accused,
            self.repair
        ))
    }
}

fn one_comparison(study: &Synthetic, random: &mut Random) -> Option<(bool, bool)> {
    let tested = study.comparisons.iter();
    let tested: Vec<(f64, bool)> = tested
        .filter_map(|c| Some((c.p_difference?, c.outcome == Outcome::Conflicts)))
        .collect();
    let (p, conflicts) = *tested.get(random.below(tested.len()))?;
    Some((p <= 1.0 - LEVEL, conflicts))
}
