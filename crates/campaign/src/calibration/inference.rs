//! Rounds of episodes, and the posterior from all of them.

use serde::{Deserialize, Serialize};
use stats::design;

use super::posterior::Posterior;
use super::predictive::Predictive;
use super::surface::{Surface, SurfaceFit, features, rate_with};
use crate::error::CampaignError;
use crate::random::Random;

/// Draws of the surfaces' weights over which a likelihood is averaged.
const WEIGHT_DRAWS: usize = 48;

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
/// let observed = vec![Observed {
///     mode: "slip".into(), occurrences: 12, opportunities: 100, held_out: false,
/// }];
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
    /// [`CampaignError::Setting`] for counts that contradict each other, for nothing to fit, and
    /// for a calibration without parameters or points.
    pub fn new(
        observed: Vec<Observed>,
        options: CalibrationOptions,
    ) -> Result<Self, CampaignError> {
        for mode in &observed {
            if mode.occurrences > mode.opportunities {
                let problem = format!(
                    "{} of {} cannot be; check the two counts",
                    mode.occurrences, mode.opportunities
                );
                return Err(CampaignError::setting(&mode.mode, problem));
            }
        }
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
        let fitted: Vec<usize> = (0..self.observed.len())
            .filter(|mode| !self.observed[*mode].held_out)
            .collect();
        let mut rates = Vec::with_capacity(points);
        let mut ln_weights = Vec::with_capacity(points);
        for unit in &units {
            let row = features(unit);
            let of_draws: Vec<Vec<f64>> = (draws.iter())
                .map(|draw| draw.iter().map(|w| rate_with(w, &row)).collect())
                .collect();
            let ln: Vec<f64> = (of_draws.iter())
                .map(|rates| self.ln_likelihood(&fitted, rates))
                .collect();
            ln_weights.push(ln_mean(&ln));
            rates.push(likeliest_mean(&of_draws, &ln));
        }
        Posterior::new(units, &ln_weights, rates)
    }

    fn ln_likelihood(&self, fitted: &[usize], rates: &[f64]) -> f64 {
        if self.episodes.is_empty() {
            return 0.0;
        }
        (fitted.iter())
            .map(|mode| {
                let Observed {
                    occurrences,
                    opportunities,
                    ..
                } = self.observed[*mode];
                let (k, n) = (occurrences as f64, opportunities as f64);
                let rate = rates[*mode].clamp(1e-12, 1.0 - 1e-12);
                k * rate.ln() + (n - k) * (-rate).ln_1p()
            })
            .sum()
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

/// The logarithm of the mean of exponentials.
fn ln_mean(ln: &[f64]) -> f64 {
    let most = ln.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let sum: f64 = ln.iter().map(|x| (x - most).exp()).sum();
    most + (sum / ln.len() as f64).ln()
}

/// The mean of the rates over the draws, each weighed by its likelihood.
fn likeliest_mean(of_draws: &[Vec<f64>], ln: &[f64]) -> Vec<f64> {
    let most = ln.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let weights: Vec<f64> = ln.iter().map(|x| (x - most).exp()).collect();
    let total: f64 = weights.iter().sum();
    let modes = of_draws.first().map_or(0, Vec::len);
    (0..modes)
        .map(|mode| {
            let parts = of_draws.iter().zip(&weights);
            parts.map(|(rates, w)| rates[mode] * w).sum::<f64>() / total
        })
        .collect()
}
