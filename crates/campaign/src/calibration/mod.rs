//! Simulator parameters from counts of what happened in reality.
//!
//! Definition. Parameters `theta` have a prior. In episode `i` of a campaign each way to fail `j`
//! occurs, does not occur, or had no opportunity; its rate `p_j(theta)` is unknown, but episodes can
//! be run at any `theta`. In reality way `j` occurred `k_j` times in `n_j` opportunities. Wanted is
//! the posterior, `prior(theta) * product over fitted j of Binomial(k_j; n_j, p_j(theta))`. Where
//! trials come by person or session, which may differ, the counts are beta binomial instead, with an
//! unknown correlation. Ways to fail, and persons, can be held out and predicted.
//!
//! Each episode is run at another `theta`. All of them together give each way a response surface, a
//! Bayesian logistic regression on `theta` ([`Surface`]), and the likelihood is averaged over what
//! the regression does not know. Rounds after the first draw `theta` where the posterior so far is,
//! so that the surfaces are good where it matters.
//!
//! Why this and not approximate Bayesian computation: comparing counts needs a whole campaign at
//! each `theta` (a hundred episodes to see a rate of 2 %), a surface learns from every single
//! episode. What it costs is the assumption that the rates are smooth; [`SurfaceFit`] and the
//! episodes run afterwards at the posterior ([`Calibration::predictive`]) test it.
//!
//! Source: S. N. Wood, "Statistical inference for noisy nonlinear ecological dynamic systems",
//! Nature 466 (2010) (likelihoods from simulations); C. C. Drovandi, T. Pettitt and A. Lee,
//! "Bayesian indirect inference using a parametric auxiliary model", Statistical Science 30 (2015)
//! (likelihoods of a fitted model); D. J. C. MacKay, "The evidence framework applied to
//! classification networks", Neural Computation 4 (1992) (Laplace's approximation); O. Cappé, A.
//! Guillin, J. M. Marin and C. P. Robert, "Population Monte Carlo", JCGS 13 (2004); S. Talts et al.,
//! "Validating Bayesian inference algorithms with simulation-based calibration" (2018), by which the
//! tests hold it.
//!
//! Deviation: ways to fail count as independent given `theta` (each has its own opportunities, and
//! few episodes show two). Cost: the episodes, and seconds. Guarantee: none beyond the model's;
//! coverage of the posterior's intervals is tested on simulators with known parameters, and a fit
//! that the data contradict is said.

mod inference;
mod likelihood;
mod posterior;
mod predictive;
mod surface;
#[cfg(test)]
mod tests;

pub use inference::{Calibration, CalibrationOptions, Counted, Episode, Observed};
pub use posterior::{Direction, Identifiability, Marginal, Posterior};
pub use predictive::{Prediction, Predictive};
pub use surface::{Surface, SurfaceFit};
