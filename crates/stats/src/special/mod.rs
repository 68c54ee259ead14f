//! Special functions, accurate to about 1e-13 relative from counts of 0 to counts of 10^8.
//!
//! Everything rests on two small functions ([`stirling_error`], [`deviance`]) that keep
//! densities accurate for huge counts, and on the incomplete beta and gamma functions that are
//! built on them. Both tails are offered throughout, because `1 - cdf` loses every digit of a
//! small p-value.

mod beta;
mod beta_integral;
mod density;
mod gamma;
mod normal;
mod student;

pub use beta::{beta_cdf, beta_density, beta_quantile, beta_quantile_upper, beta_sf};
pub(crate) use beta::{beta_tails, power_over_beta};
pub(crate) use density::deviance_of_sum;
pub use density::{binomial_pmf, deviance, hypergeometric_pmf, stirling_error};
pub use gamma::{chi_squared_sf, gamma_p, gamma_q, ln_gamma};
pub use normal::{normal_cdf, normal_density, normal_quantile, normal_sf};
pub use student::{f_sf, student_t_quantile, student_t_sf};
