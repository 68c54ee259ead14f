//! Adaptive multilevel splitting over runs that can be saved.
//!
//! Definition. A run has a level, the highest rung of a ladder `1, ..., top` that it reached; the
//! event is to reach `top`. `N` runs are begun. Then, again and again: `z` is the k-th lowest level;
//! all `K >= k` runs with a level up to `z` are killed, and each is replaced by a run that goes on,
//! with new random draws, from where a random survivor first stood above `z`. This ends when the
//! k-th lowest level is `top`, or when no run survives. The estimate is the product of all
//! `1 - K/N`, times the share of runs that are at the top in the end.
//!
//! Source: F. Cérou and A. Guyader, "Adaptive multilevel splitting for rare event analysis",
//! Stochastic Analysis and Applications 25 (2007); for ties and for runs in discrete time C.-E.
//! Bréhier, M. Gazeau, L. Goudenège, T. Lelièvre and M. Rousset, "Unbiasedness of some generalized
//! adaptive multilevel splitting algorithms", Annals of Applied Probability 26 (2016).
//!
//! Deviation: levels are rungs of a ladder given beforehand, not real numbers, so that a run is
//! saved a bounded number of times. Cost: about `N (1 + sum of K/N)` runs, those of later rungs
//! shorter because they begin where their parents stood. Guarantee: the estimate is unbiased if a
//! saved state determines the law of what follows; its spread is found by replications, not assumed.
//! The same seed gives the same estimate however the runs are spread over threads.

use serde::{Deserialize, Serialize};

use crate::error::CampaignError;
use crate::random::Random;

/// How [`split`] goes about it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SplittingOptions {
    /// Runs at a time, `N`.
    pub particles: usize,
    /// At least so many are killed at a time, `k`; ties are killed together.
    pub killed: usize,
    /// The highest rung; reaching it is the event.
    pub top: usize,
    /// The seed of everything.
    pub seed: u64,
}

/// Where a run first stood on a rung or above it.
#[derive(Debug, Clone)]
pub struct Crossing<S> {
    /// The highest rung reached at that moment.
    pub rung: usize,
    /// The run as it was then.
    pub state: S,
}

/// A run that is wanted.
#[derive(Debug, Clone)]
pub struct Job<S> {
    /// Where it begins: at the very beginning, or at a saved crossing.
    pub from: Option<Crossing<S>>,
    /// The seed of all its random draws from there on.
    pub seed: u64,
}

/// What a run showed.
#[derive(Debug, Clone)]
pub struct Branch<S> {
    /// Each new highest rung, from 1 (or above that of its beginning) on, in order, with the state
    /// then. The state at the top is never continued.
    pub crossings: Vec<Crossing<S>>,
    /// How much it cost, in runs from beginning to end.
    pub cost: f64,
}

/// One replication's estimate.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Descent {
    /// The estimate of the event's probability.
    pub probability: f64,
    /// For each iteration, the level killed and the share that survived it.
    pub survived: Vec<(usize, f64)>,
    /// How many of the first runs, which are independent, reached the top at once.
    pub first_hits: u64,
    /// How many first runs there were.
    pub first_runs: u64,
    /// The cost of all runs, in runs from beginning to end.
    pub cost: f64,
}

/// Estimates the probability of reaching the top rung. `run` is given jobs that may be done in
/// parallel and returns their outcomes in the same order.
///
/// ```
/// use campaign::splitting::{Branch, Crossing, SplittingOptions, combine, split};
/// // A walk goes up with probability 1/4, else down, and begins at 1; does it reach 10 before 0?
/// let walk = |job: &campaign::splitting::Job<usize>| {
///     let mut random = campaign::Random::new(job.seed, "walk");
///     let mut place = job.from.as_ref().map_or(1, |from| from.state);
///     let mut highest = job.from.as_ref().map_or(0, |from| from.rung);
///     let mut branch = Branch { crossings: vec![], cost: 1.0 };
///     while place > 0 && highest < 10 {
///         if place > highest {
///             highest = place;
///             branch.crossings.push(Crossing { rung: highest, state: place });
///         }
///         place = if random.chance(0.25) { place + 1 } else { place - 1 };
///     }
///     branch
/// };
/// let descents: Vec<_> = (0..20).map(|seed| {
///     let options = SplittingOptions { particles: 300, killed: 30, top: 10, seed };
///     split(&options, |jobs| Ok::<_, campaign::CampaignError>(jobs.iter().map(&walk).collect()))
/// }).collect::<Result<_, _>>()?;
/// let estimate = combine(&descents, stats::Confidence::P99)?;
/// // The gambler's ruin: (3 - 1) / (3^10 - 1), once in 29524.
/// assert!(estimate.interval.contains(2.0 / (3_f64.powi(10) - 1.0)), "{estimate:?}");
/// # Ok::<(), campaign::CampaignError>(())
/// ```
///
/// # Errors
/// [`CampaignError::Setting`] for options that cannot be, and whatever `run` returns.
pub fn split<S: Clone, E: From<CampaignError>>(
    options: &SplittingOptions,
    mut run: impl FnMut(Vec<Job<S>>) -> Result<Vec<Branch<S>>, E>,
) -> Result<Descent, E> {
    check(options)?;
    let mut random = Random::new(options.seed, "splitting");
    let n = options.particles;
    let first = (0..n).map(|_| Job {
        from: None,
        seed: random.bits(),
    });
    let branches = expected(run(first.collect())?, n)?;
    let mut descent = Descent {
        probability: 1.0,
        survived: Vec::new(),
        first_hits: 0,
        first_runs: n as u64,
        cost: branches.iter().map(|branch| branch.cost).sum(),
    };
    let mut runs: Vec<Vec<Crossing<S>>> = branches.into_iter().map(|b| b.crossings).collect();
    descent.first_hits = runs.iter().filter(|r| level(r) >= options.top).count() as u64;
    loop {
        let killed_level = kth_lowest(&runs, options.killed);
        if killed_level >= options.top {
            break;
        }
        let (killed, living): (Vec<usize>, Vec<usize>) =
            (0..n).partition(|i| level(&runs[*i]) <= killed_level);
        let share = living.len() as f64 / n as f64;
        descent.survived.push((killed_level, share));
        descent.probability *= share;
        if living.is_empty() {
            return Ok(descent);
        }
        let parents: Vec<usize> = (killed.iter())
            .map(|_| living[random.index(living.len())])
            .collect();
        let kept: Vec<Vec<Crossing<S>>> = (parents.iter())
            .map(|parent| up_to_first_above(&runs[*parent], killed_level))
            .collect();
        let jobs = kept.iter().map(|kept| Job {
            from: kept.last().cloned(),
            seed: random.bits(),
        });
        let branches = expected(run(jobs.collect())?, killed.len())?;
        for ((place, mut kept), branch) in killed.into_iter().zip(kept).zip(branches) {
            descent.cost += branch.cost;
            kept.extend(branch.crossings);
            runs[place] = kept;
        }
        // Nothing is ever continued from a rung that was killed: let go of its states.
        for run in &mut runs {
            run.retain(|crossing| crossing.rung > killed_level);
        }
    }
    let at_top = runs.iter().filter(|r| level(r) >= options.top).count();
    descent.probability *= at_top as f64 / n as f64;
    Ok(descent)
}

fn check(options: &SplittingOptions) -> Result<(), CampaignError> {
    if options.particles < 2 {
        return Err(CampaignError::setting("particles", "take at least 2 runs"));
    }
    if options.killed == 0 || options.killed >= options.particles {
        let problem = "kill at least 1 run at a time, and fewer than there are particles";
        return Err(CampaignError::setting("killed", problem));
    }
    if options.top == 0 {
        return Err(CampaignError::setting("top", "the ladder needs a rung"));
    }
    Ok(())
}

fn expected<T>(given: Vec<T>, wanted: usize) -> Result<Vec<T>, CampaignError> {
    if given.len() == wanted {
        return Ok(given);
    }
    let problem = format!("{} outcomes were given for {wanted} runs", given.len());
    Err(CampaignError::setting("run", problem))
}

/// The highest rung of a run; 0 below the ladder.
fn level<S>(crossings: &[Crossing<S>]) -> usize {
    crossings.last().map_or(0, |crossing| crossing.rung)
}

fn kth_lowest<S>(runs: &[Vec<Crossing<S>>], k: usize) -> usize {
    let mut levels: Vec<usize> = runs.iter().map(|run| level(run)).collect();
    levels.sort_unstable();
    levels[k - 1]
}

/// The run until it first stood above `rung`, that moment included. States at the top are not
/// needed for it, but a run that jumped there is continued from there: it is at the top already.
fn up_to_first_above<S: Clone>(crossings: &[Crossing<S>], rung: usize) -> Vec<Crossing<S>> {
    let end = crossings.iter().position(|crossing| crossing.rung > rung);
    crossings[..end.map_or(crossings.len(), |end| end + 1)].to_vec()
}
