//! Arguments of `engines`.

use super::{Format, study_folder};
use clap::Args;
use std::path::PathBuf;

/// Arguments of `engines`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  corroborate engines case-studies/corridor S1
  corroborate engines case-studies/corridor S1 -n 50 --format json
  corroborate engines case-studies/handover E4 -n 20
  corroborate engines case-studies/corridor S1 -n 2 --determinism
  corroborate engines case-studies/four-physics S1 --against P1
  corroborate engines my-study S1 --tolerance /truth/arm.x=0.005

Runs the same episodes (test, seeds, controllers) of a scene or of the handover in the engine that
its entry says and in the other one, MuJoCo and Rapier, and prints what matters first: verdicts that differ, then truth values
and names that differ (equal or not, by name), then numbers, those that lie
furthest apart first: the largest difference as a multiple of the signal's
--tolerance, or else the root mean square as a share of the signal's range.
Numbers whose unit is one of angles (rad, deg) are compared the shorter way
round where both lie within one turn. What is the same is counted. Exits 1 if a
verdict on an episode differs. With --against another
entry takes the place of the other engine, whatever its simulator is, with the seeds of
the first; signals of the same name are compared. With --determinism each
episode is run again, and saved in its middle and continued, and the hashes of
all its recordings are compared; exits 1 if two differ. A command is run in
its own engine alone, with --determinism or --against.")]
pub struct Engines {
    /// The study's folder, or its study.toml.
    #[arg(value_parser = study_folder())]
    pub study: PathBuf,
    /// The ledger's entry whose scene or scenario is simulated.
    pub evidence: String,
    /// How many episodes.
    #[arg(long, short = 'n', value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u64).range(1..=100_000))]
    pub episodes: u64,
    /// Seed instead of the study's.
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
    /// Compare hashes of repeated and of continued episodes instead.
    #[arg(long)]
    pub determinism: bool,
    /// Run another entry of the ledger in place of the second engine.
    #[arg(long, value_name = "EVIDENCE", conflicts_with = "determinism")]
    pub against: Option<String>,
    /// By how much a number may differ, in its unit: SIGNAL=NUMBER (may be repeated).
    #[arg(long, value_name = "SIGNAL=NUMBER", value_parser = tolerance, conflicts_with = "determinism")]
    pub tolerance: Vec<(String, f64)>,
    /// How many threads to use (results do not depend on it).
    #[arg(long, short = 'j', value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// How the result is printed.
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
}

/// `SIGNAL=NUMBER` with a number above 0.
fn tolerance(text: &str) -> Result<(String, f64), String> {
    let wrong = || "write for example /truth/arm.x=0.005: a signal and a number above 0".to_owned();
    let (signal, number) = text.rsplit_once('=').ok_or_else(wrong)?;
    let number: f64 = number.trim().parse().map_err(|_| wrong())?;
    match number > 0.0 && number.is_finite() && !signal.is_empty() {
        true => Ok((signal.trim().to_owned(), number)),
        false => Err(wrong()),
    }
}

#[cfg(test)]
mod tests {
    use super::tolerance;

    #[test]
    fn a_tolerance_is_a_signal_and_a_number_above_nothing() {
        assert_eq!(tolerance("/a.x = 0.5"), Ok(("/a.x".to_owned(), 0.5)));
        for wrong in [
            "/a.x", "/a.x=", "=1", "/a.x=0", "/a.x=-1", "/a.x=inf", "/a.x=nan",
        ] {
            assert!(tolerance(wrong).is_err(), "{wrong}");
        }
    }
}
