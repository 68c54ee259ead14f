//! Subset simulation: how rare an event is among inputs, where no run can be saved.
//!
//! Definition. The inputs are standard normal numbers `z` (of which `Phi(z)`, uniform in (0, 1), is
//! what the caller gets) and a seed for everything else; they have a score, and the event is a
//! score of at least `limit`. `N` inputs are drawn. Then, again and again: `b` is the score that a
//! share `p0` of the `N` reaches; from those as seeds, Markov chains of length `1/p0` draw `N`
//! inputs given that the score is at least `b`. This ends when `b >= limit`. The estimate is the
//! product of the shares that reached each `b` and, last, the limit.
//!
//! Source: S.-K. Au and J. L. Beck, "Estimation of small failure probabilities in high dimensions
//! by subset simulation", Probabilistic Engineering Mechanics 16 (2001); the proposal that keeps
//! the normal law, `z' = r z + sqrt(1 - r^2) w`, from I. Papaioannou, W. Betz, K. Zwirglmaier and
//! D. Straub, "MCMC algorithms for subset simulation", same journal 41 (2015), section 4.
//!
//! Deviation: beside the numbers, the seed is an input, drawn anew in half of the proposals, so
//! that inputs whose outcome is random are treated correctly; the correlation `r` is adapted to an
//! acceptance of 0.44, from level to level, never within one. Cost: `N (1 + (1 - p0) (levels - 1))`
//! runs. Guarantee: consistent for many particles; biased by an amount of the order of `1/N`, with
//! a spread that replications show. The same seed gives the same estimate on any number of threads.

use stats::special::normal_cdf;

use super::Descent;
use crate::error::CampaignError;
use crate::random::Random;

/// The share of accepted proposals that moves best in few dimensions (Papaioannou et al., 2015).
const WANTED_ACCEPTANCE: f64 = 0.44;

/// How many levels are tried before the event counts as out of reach.
const MOST_LEVELS: usize = 40;

/// How [`subset`] goes about it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SubsetOptions {
    /// Inputs at a time, `N`; a multiple of `chains`.
    pub particles: usize,
    /// How many are kept at each level, as seeds of chains: `p0 N`.
    pub chains: usize,
    /// How many numbers an input has.
    pub dimensions: usize,
    /// The event: a score of at least this.
    pub limit: f64,
    /// The seed of everything.
    pub seed: u64,
}

/// An input to be scored.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// Numbers in (0, 1), uniform and independent before any level.
    pub unit: Vec<f64>,
    /// The seed of everything else that is random.
    pub seed: u64,
}

/// What is learnt on the way down.
pub type Ladder = Vec<(f64, f64)>;

#[derive(Debug, Clone)]
struct Particle {
    normal: Vec<f64>,
    seed: u64,
    score: f64,
}

impl Particle {
    fn candidate(&self) -> Candidate {
        let tiny = f64::EPSILON / 4.0;
        let unit = self.normal.iter().map(|z| normal_cdf(*z));
        Candidate {
            unit: unit.map(|u| u.clamp(tiny, 1.0 - f64::EPSILON)).collect(),
            seed: self.seed,
        }
    }
}

/// Estimates the probability of a score of at least the limit, and gives the levels on the way with
/// the share that reached each. `score` is given inputs that may be run in parallel and returns
/// their scores in the same order.
///
/// ```
/// use campaign::splitting::{SubsetOptions, combine, subset};
/// // The sum of two uniform numbers exceeds 1.998 with probability 0.002^2 / 2 = 2e-6.
/// let mut descents = Vec::new();
/// for seed in 0..20 {
///     let options = SubsetOptions { particles: 500, chains: 50, dimensions: 2, limit: 1.998, seed };
///     let (descent, _) = subset(&options, |inputs| {
///         Ok::<_, campaign::CampaignError>(inputs.iter().map(|i| i.unit[0] + i.unit[1]).collect())
///     })?;
///     descents.push(descent);
/// }
/// let estimate = combine(&descents, stats::Confidence::P99)?;
/// assert!(estimate.interval.contains(2e-6), "{estimate:?}");
/// assert!(estimate.episode_equivalents < 1e5);
/// # Ok::<(), campaign::CampaignError>(())
/// ```
///
/// # Errors
/// [`CampaignError::Setting`] for options that cannot be and for scores that are no numbers, and
/// whatever `score` returns.
pub fn subset<E: From<CampaignError>>(
    options: &SubsetOptions,
    mut score: impl FnMut(Vec<Candidate>) -> Result<Vec<f64>, E>,
) -> Result<(Descent, Ladder), E> {
    check(options)?;
    let mut random = Random::new(options.seed, "subset simulation");
    let mut particles: Vec<Particle> = (0..options.particles)
        .map(|_| Particle {
            normal: (0..options.dimensions)
                .map(|_| random.standard_normal())
                .collect(),
            seed: random.bits(),
            score: f64::NAN,
        })
        .collect();
    rate(&mut particles, &mut score)?;
    let hits = |particles: &[Particle]| {
        let above = particles.iter().filter(|p| p.score >= options.limit);
        above.count()
    };
    let n = options.particles;
    let mut descent = Descent {
        probability: 1.0,
        survived: Vec::new(),
        first_hits: hits(&particles) as u64,
        first_runs: n as u64,
        cost: n as f64,
    };
    let mut ladder = Ladder::new();
    let mut correlation: f64 = 0.8;
    while hits(&particles) < options.chains {
        particles.sort_by(|a, b| b.score.total_cmp(&a.score));
        let level = particles[options.chains - 1].score;
        // Inputs as good as the last seed are seeds, too, so a plateau of scores is no error.
        let kept = particles.iter().filter(|p| p.score >= level).count();
        let stuck = ladder.last().is_some_and(|(last, _)| level <= *last);
        let share = kept as f64 / n as f64;
        if (stuck && kept == n) || ladder.len() >= MOST_LEVELS {
            descent.probability = 0.0;
            return Ok((descent, ladder));
        }
        ladder.push((level, share));
        descent.survived.push((ladder.len(), share));
        descent.probability *= share;
        particles.truncate(kept);
        let (next, accepted) = chains(particles, n, level, correlation, &mut random, &mut score)?;
        particles = next;
        descent.cost += (n - kept) as f64;
        correlation = adapted(correlation, accepted);
    }
    let share = hits(&particles) as f64 / n as f64;
    ladder.push((options.limit, share));
    descent.probability *= share;
    Ok((descent, ladder))
}

fn check(options: &SubsetOptions) -> Result<(), CampaignError> {
    let (n, chains) = (options.particles, options.chains);
    if chains < 2 || chains >= n || !n.is_multiple_of(chains) {
        let problem = format!(
            "{chains} chains do not share {n} particles; take 2 or more, and a divisor of them"
        );
        return Err(CampaignError::setting("chains", problem));
    }
    if !options.limit.is_finite() {
        return Err(CampaignError::setting("limit", "take a finite number"));
    }
    Ok(())
}

fn rate<E: From<CampaignError>>(
    particles: &mut [Particle],
    score: &mut impl FnMut(Vec<Candidate>) -> Result<Vec<f64>, E>,
) -> Result<(), E> {
    let scores = score(particles.iter().map(Particle::candidate).collect())?;
    if scores.len() != particles.len() || scores.iter().any(|score| score.is_nan()) {
        let problem = "each input needs a score that is a number";
        return Err(CampaignError::setting("score", problem).into());
    }
    for (particle, score) in particles.iter_mut().zip(scores) {
        particle.score = score;
    }
    Ok(())
}

/// Chains from all seeds, side by side, until there are `wanted` inputs; and the share of proposals
/// that were accepted.
fn chains<E: From<CampaignError>>(
    seeds: Vec<Particle>,
    wanted: usize,
    level: f64,
    correlation: f64,
    random: &mut Random,
    score: &mut impl FnMut(Vec<Candidate>) -> Result<Vec<f64>, E>,
) -> Result<(Vec<Particle>, f64), E> {
    let mut current = seeds.clone();
    let mut all = seeds;
    let (mut accepted, mut proposed) = (0_usize, 0_usize);
    while all.len() < wanted {
        let missing = wanted - all.len();
        let moving = missing.min(current.len());
        let mut next: Vec<Particle> = (current[..moving].iter())
            .map(|particle| proposal(particle, correlation, random))
            .collect();
        rate(&mut next, score)?;
        proposed += moving;
        for (place, candidate) in next.into_iter().enumerate() {
            if candidate.score >= level {
                accepted += 1;
                current[place] = candidate;
            }
            all.push(current[place].clone());
        }
    }
    Ok((all, accepted as f64 / proposed.max(1) as f64))
}

fn proposal(from: &Particle, correlation: f64, random: &mut Random) -> Particle {
    let rest = (1.0 - correlation * correlation).sqrt();
    let normal = from.normal.iter();
    let normal = normal.map(|z| correlation * z + rest * random.standard_normal());
    let normal = normal.collect();
    // The draw is made in any case, so that streams do not depend on the coin.
    let (anew, seed) = (random.chance(0.5), random.bits());
    Particle {
        normal,
        seed: if anew { seed } else { from.seed },
        score: f64::NAN,
    }
}

/// The correlation for the next level: nearer to 1 when too few proposals were accepted.
fn adapted(correlation: f64, accepted: f64) -> f64 {
    let spread = (1.0 - correlation * correlation).sqrt();
    let spread = (spread * (accepted - WANTED_ACCEPTANCE).exp()).clamp(0.02, 0.95);
    (1.0 - spread * spread).sqrt()
}
