//! Rounds of episodes, and the posterior from all of them.

use serde::{Deserialize, Serialize};
use stats::design;

use super::likelihood::Likelihood;
use super::posterior::Posterior;
use super::predictive::Predictive;
use super::surface::{Surface, SurfaceFit, features, rate_with};
use crate::error::CampaignError;
use crate::random::Random;

/// Draws of the surfaces' weights over which a likelihood is averaged.
const WEIGHT_DRAWS: usize = 48;

/// More opportunities than this are refused: predictions are sums over all counts.
const MOST_OPPORTUNITIES: u64 = 100_000;

/// With clusters the sums are nested.
const MOST_IN_CLUSTERS: u64 = 2_000;

/// Occurrences in opportunities.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Counted {
    /// How often it occurred.
    pub occurrences: u64,
    /// How often it could have.
    pub opportunities: u64,
}

/// What was counted in reality of one way to fail.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Observed {
    /// Its name.
    pub mode: String,
    /// How often it occurred.
    pub occurrences: u64,
    /// How often it could have.
    pub opportunities: u64,
    /// Whether it is kept out of the fit, to be predicted.
    pub held_out: bool,
    /// The same counts by person or session, whose trials may be alike; none if all are independent.
    pub clusters: Vec<Counted>,
    /// Further runs that are kept out of the fit, to be predicted; by person or session.
    pub held_out_runs: Vec<Counted>,
}

impl Observed {
    /// Independent trials, to be fitted.
    #[must_use]
    pub fn new(mode: &str, occurrences: u64, opportunities: u64) -> Self {
        Self {
            mode: mode.to_owned(),
            occurrences,
            opportunities,
            held_out: false,
            clusters: Vec::new(),
            held_out_runs: Vec::new(),
        }
    }

    /// The same, but only to be predicted.
    #[must_use]
    pub fn held_out(mut self) -> Self {
        self.held_out = true;
        self
    }

    fn check(&self) -> Result<(), CampaignError> {
        let sum = |count: fn(&Counted) -> u64| {
            let mut all = self.clusters.iter().map(count);
            all.try_fold(0_u64, u64::checked_add)
        };
        let whole = (Some(self.occurrences), Some(self.opportunities));
        let parts = (sum(|it| it.occurrences), sum(|it| it.opportunities));
        let all = self.clusters.iter().chain(&self.held_out_runs);
        let impossible = self.occurrences > self.opportunities
            || all.clone().any(|it| it.occurrences > it.opportunities);
        let most = match self.clusters.is_empty() {
            true => MOST_OPPORTUNITIES,
            false => MOST_IN_CLUSTERS,
        };
        let largest = all.map(|it| it.opportunities).chain([self.opportunities]);
        let problem = if impossible {
            let (k, n) = (self.occurrences, self.opportunities);
            format!("{k} of {n} in all, or those of a cluster, cannot be; check the counts")
        } else if !self.clusters.is_empty() && whole != parts {
            "the clusters' counts do not add up to the whole's; check them".to_owned()
        } else if largest.max().is_some_and(|n| n > most) {
            format!("more than {most} opportunities cannot be summed over; take a part of them")
        } else {
            return Ok(());
        };
        Err(CampaignError::setting(&self.mode, problem))
    }
}

/// How the posterior is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CalibrationOptions {
    /// Number of parameters.
    pub dimensions: usize,
    /// Points of the prior that are weighed; they become the posterior's sample.
    pub points: usize,
    /// The seed of everything.
    pub seed: u64,
}

/// One simulated episode.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Episode {
    /// Its parameters in the unit cube of the prior.
    pub unit: Vec<f64>,
    /// For each way to fail: did it occur? `None` without an opportunity.
    pub outcomes: Vec<Option<bool>>,
}

/// A calibration under way.
///
/// ```
/// use campaign::calibration::{Calibration, CalibrationOptions, Episode, Observed};
/// // A simulator fails at a rate of theta / 2; in reality 12 of 100 failed: theta is near 0.24.
/// let mut random = campaign::Random::new(1, "simulator");
/// let observed = vec![Observed::new("slip", 12, 100)];
/// let options = CalibrationOptions { dimensions: 1, points: 2000, seed: 7 };
/// let mut calibration = Calibration::new(observed, options)?;
/// for _round in 0..3 {
///     for unit in calibration.ask(300) {
///         let slipped = random.chance(unit[0] / 2.0);
///         calibration.tell(Episode { unit, outcomes: vec![Some(slipped)] })?;
///     }
/// }
/// let posterior = calibration.posterior();
/// let theta = &posterior.marginals(stats::Confidence::P95)[0];
/// assert!(theta.interval.contains(0.24) && theta.interval.width() < 0.35, "{theta:?}");
/// # Ok::<(), campaign::CampaignError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Calibration {
    observed: Vec<Observed>,
    options: CalibrationOptions,
    episodes: Vec<Episode>,
    asked: u64,
}

impl Calibration {
    /// Before the first episode.
    ///
    /// # Errors
    /// [`CampaignError::Setting`] for counts that contradict each other or are too many, for nothing
    /// to fit, and for a calibration without parameters or points.
    pub fn new(
        observed: Vec<Observed>,
        options: CalibrationOptions,
    ) -> Result<Self, CampaignError> {
        observed.iter().try_for_each(Observed::check)?;
        if !observed.iter().any(|m| !m.held_out && m.opportunities > 0) {
            let problem = "none of the modes is fitted and has opportunities";
            return Err(CampaignError::setting("observed", problem));
        }
        if options.dimensions == 0 || options.points < 100 {
            let problem = "take at least one parameter, and 100 points";
            return Err(CampaignError::setting("options", problem));
        }
        Ok(Self {
            observed,
            options,
            episodes: Vec::new(),
            asked: 0,
        })
    }

    /// What was counted in reality.
    #[must_use]
    pub fn observed(&self) -> &[Observed] {
        &self.observed
    }

    /// The episodes told so far.
    #[must_use]
    pub fn episodes(&self) -> &[Episode] {
        &self.episodes
    }

    /// Parameters for the next round, in the unit cube: evenly over the prior at first, afterwards
    /// four of five from the posterior so far and the rest from the prior. A function of what was
    /// told before and of the number of rounds alone.
    pub fn ask(&mut self, count: usize) -> Vec<Vec<f64>> {
        let round = self.asked;
        self.asked += 1;
        let seed = self.options.seed.wrapping_add(round);
        let prior = design(count, self.options.dimensions, seed);
        if self.episodes.is_empty() {
            return prior;
        }
        let posterior = self.posterior();
        let mut random = Random::new(seed, "calibration round");
        let of = |place: usize, prior: Vec<f64>, random: &mut Random| match place % 5 {
            0 => prior,
            _ => posterior.draw(random),
        };
        let points = prior.into_iter().enumerate();
        points.map(|(i, p)| of(i, p, &mut random)).collect()
    }

    /// Takes an episode into account.
    ///
    /// # Errors
    /// [`CampaignError::Setting`] if it has another number of parameters or outcomes.
    pub fn tell(&mut self, episode: Episode) -> Result<(), CampaignError> {
        let fits = episode.unit.len() == self.options.dimensions
            && episode.outcomes.len() == self.observed.len()
            && episode.unit.iter().all(|u| (0.0..=1.0).contains(u));
        if !fits {
            let problem = "an episode needs each parameter in [0, 1] and an outcome for each mode";
            return Err(CampaignError::setting("episode", problem));
        }
        self.episodes.push(episode);
        Ok(())
    }

    fn outcomes(&self, mode: usize) -> Vec<(&[f64], bool)> {
        let with = |e: &'_ Episode| e.outcomes[mode].is_some();
        (self.episodes.iter())
            .filter(|e| with(e))
            .map(|e| (e.unit.as_slice(), e.outcomes[mode] == Some(true)))
            .collect()
    }

    /// The surface of each way to fail.
    #[must_use]
    pub fn surfaces(&self) -> Vec<Surface> {
        (0..self.observed.len())
            .map(|mode| Surface::fit(self.options.dimensions, &self.outcomes(mode)))
            .collect()
    }

    /// How well each surface describes the episodes.
    #[must_use]
    pub fn fits(&self) -> Vec<SurfaceFit> {
        let surfaces = self.surfaces();
        let modes = surfaces.iter().enumerate();
        modes
            .map(|(mode, surface)| surface.fit_test(&self.outcomes(mode)))
            .collect()
    }

    /// The posterior given all episodes so far; without any, the prior.
    #[must_use]
    pub fn posterior(&self) -> Posterior {
        let CalibrationOptions {
            dimensions,
            points,
            seed,
        } = self.options;
        let units = design(points, dimensions, seed ^ 0x706f_696e_7473);
        let surfaces = self.surfaces();
        let mut random = Random::new(seed, "calibration weights");
        let draws: Vec<Vec<Vec<f64>>> = (0..WEIGHT_DRAWS)
            .map(|_| surfaces.iter().map(|s| s.draw(&mut random)).collect())
            .collect();
        let fitted = self.likelihoods();
        let mut rates = Vec::with_capacity(points);
        let mut ln_weights = Vec::with_capacity(points);
        for unit in &units {
            let row = features(unit);
            let of_draws: Vec<Vec<f64>> = (draws.iter())
                .map(|draw| draw.iter().map(|w| rate_with(w, &row)).collect())
                .collect();
            let ln: Vec<f64> = (of_draws.iter())
                .map(|rates| ln_likelihood(&fitted, rates))
                .collect();
            ln_weights.push(ln_mean(&ln));
            rates.push(one_of(of_draws, &ln, &mut random));
        }
        Posterior::new(units, &ln_weights, rates)
    }

    /// Of each fitted way to fail, with its place; of none before the first episode.
    fn likelihoods(&self) -> Vec<(usize, Likelihood)> {
        let modes = self.observed.iter().enumerate();
        modes
            .filter(|(_, mode)| !mode.held_out && !self.episodes.is_empty())
            .map(|(place, mode)| (place, Likelihood::of(mode)))
            .collect()
    }

    /// The same episodes with other counts of the same ways to fail: what would have been inferred
    /// from them. The episodes' parameters are those that were drawn for the first counts, which
    /// decides where the surfaces are well known, not what they say.
    ///
    /// # Errors
    /// As [`Calibration::new`], and for another number of ways to fail.
    pub fn with_observed(&self, observed: Vec<Observed>) -> Result<Self, CampaignError> {
        if observed.len() != self.observed.len() {
            let problem = "counts of the same ways to fail are needed, in the same order";
            return Err(CampaignError::setting("observed", problem));
        }
        let mut other = Self::new(observed, self.options)?;
        other.episodes.clone_from(&self.episodes);
        other.asked = self.asked;
        Ok(other)
    }

    /// What the posterior predicts for each way to fail, beside what was counted.
    #[must_use]
    pub fn predictive(&self, posterior: &Posterior) -> Vec<Predictive> {
        let modes = self.observed.iter().enumerate();
        modes
            .map(|(mode, observed)| Predictive::of(observed, posterior, mode))
            .collect()
    }
}

fn ln_likelihood(fitted: &[(usize, Likelihood)], rates: &[f64]) -> f64 {
    let of = |(mode, likelihood): &(usize, Likelihood)| likelihood.ln(rates[*mode]);
    fitted.iter().map(of).sum()
}

/// The logarithm of the mean of exponentials.
pub(super) fn ln_mean(ln: &[f64]) -> f64 {
    let most = ln.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let sum: f64 = ln.iter().map(|x| (x - most).exp()).sum();
    most + (sum / ln.len() as f64).ln()
}

/// The rates of one draw of the surfaces, taken in proportion to its likelihood: a sample, so that
/// predictions have all the spread that the surfaces leave.
fn one_of(mut of_draws: Vec<Vec<f64>>, ln: &[f64], random: &mut Random) -> Vec<f64> {
    let most = ln.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let weights: Vec<f64> = ln.iter().map(|x| (x - most).exp()).collect();
    of_draws.swap_remove(random.weighted(&weights).unwrap_or(0))
}
