//! Arguments of `shrink` and `replay`.

use super::{Format, study_folder};
use clap::Args;
use corroborate::technique::simulation::SearchPhysics;
use std::path::PathBuf;

/// Arguments of `shrink`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  corroborate shrink case-studies/handover results/exploration/findings/violated-8.toml
  corroborate shrink my-study found.toml --budget 500 --name dropped
  corroborate shrink my-study found.toml --seeds 3/5
  corroborate shrink my-study found.toml --margin 0.3
  corroborate shrink my-study E4:5 --only 1a

Makes the episode of a finding, or one of an evidence by its number, smaller
while it still shows the same: fewer actions, fewer settings, rounder numbers,
shorter delays, an earlier end. What the seed draws once in the episode (a
friction, a pull) becomes a setting first and goes back to its nominal value, or
as near to that as still shows it, so that what is left names the cause. The
finding's own seed is kept; with --seeds K/N it must show in at least K of N
seeds, the finding's own among them, so that what is left does not hang on one
draw. What is kept violates its requirement clearly and not by a hair, by at
least a margin: --margin. The result goes to STUDY/regressions/NAME.toml; `corroborate replay STUDY
--check` runs all of them again. Interrupted, it keeps the smallest so far.
Exits 3 if the finding is not shown when it is run again.")]
pub struct Shrink {
    /// The study's folder, or its study.toml.
    #[arg(value_parser = study_folder())]
    pub study: PathBuf,
    /// The finding's file, as it is or relative to the study; or
    /// EVIDENCE:EPISODE.
    #[arg(value_name = "FINDING|EVIDENCE:EPISODE")]
    pub finding: PathBuf,
    /// What is to be shown still, where the episode shows several things: a
    /// requirement, a failure mode, or a failure such as controller-failed.
    #[arg(long, value_name = "ID")]
    pub only: Option<String>,
    /// How many episodes may be run; with --seeds each scenario takes up to N
    /// of them.
    #[arg(long, value_name = "N", default_value = "300", value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub budget: u64,
    /// In how many of how many seeds it must show.
    #[arg(long, value_name = "K/N", default_value = "1/1", value_parser = seeds)]
    pub seeds: (u32, u32),
    /// By how much what is kept has to violate its requirement, as a share of
    /// what is allowed: of a limit, or of a time. Without it a tenth, or half of
    /// what the finding does if that is less; 0 for a violation by a hair.
    #[arg(long, value_name = "SHARE", value_parser = share)]
    pub margin: Option<f64>,
    /// In which physics scenarios are tried first: the fast one where the bench has one, without this. The full physics
    /// goes on from what the fast one proposes, and shows what is kept.
    #[arg(long, value_parser = super::choice::<SearchPhysics>(), value_name = "PHYSICS")]
    pub physics: Option<SearchPhysics>,
    /// The exploration whose parameters say what is possible, and what needs
    /// no explanation. Without it that of the finding, or exploration.toml if
    /// it is of the same evidence.
    #[arg(long, value_name = "FILE")]
    pub exploration: Option<PathBuf>,
    /// Name of the regression; the finding's without it.
    #[arg(long, value_name = "NAME")]
    pub name: Option<String>,
    /// How the result is printed.
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
}

/// Arguments of `replay`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  corroborate replay case-studies/handover regressions/dropped.toml
  corroborate replay case-studies/handover E4:17 --only 1a --out /tmp/seventeen
  corroborate replay case-studies/handover --check
  corroborate replay my-study --check --junit regressions.xml
  corroborate replay my-study --check --update

Runs one episode again, bit for bit: that of a finding or regression, or an
episode of an evidence by its number. The folder gets replay.html (a 3D view
with signals and verdicts; opens offline), recording.mcap (everything recorded),
verdicts.mcap and scene.mcap (for Foxglove's 3D panel). With --check all
regressions are run again. The file of each says what is expected of it:
`expected = \"fails\"` until its fault is fixed, `expected = \"passes\"` from then
on. To pass, its requirement has to come up and to be decided. --check exits 1 if
one that is expected to pass fails again, if one that is expected to fail passes
(with --update that is written into its file and is not a failure), or if one
neither fails nor passes or cannot be run; --junit writes the same for a build
server.
Without --check exits 1 if a finding or regression no longer shows what it did, 3
if it does but the recording is not the same bytes as before (another machine or
another version of the program; --check only says so).")]
pub struct Replay {
    /// The study's folder, or its study.toml.
    #[arg(value_parser = study_folder())]
    pub study: PathBuf,
    /// A finding's file, as it is or relative to the study; or
    /// EVIDENCE:EPISODE. With --check, regressions; all if none is named.
    #[arg(
        value_name = "FINDING|EVIDENCE:EPISODE",
        required_unless_present = "check"
    )]
    pub what: Vec<String>,
    /// Run regressions again and say which do not do what is expected of them.
    #[arg(long, conflicts_with_all = ["only", "out"])]
    pub check: bool,
    /// With --check: write into the files of those that pass that they are
    /// expected to pass from now on.
    #[arg(long, requires = "check")]
    pub update: bool,
    /// With --check: also write the result as JUnit XML.
    #[arg(long, value_name = "FILE", requires = "check")]
    pub junit: Option<PathBuf>,
    /// Show this requirement or failure mode (may be repeated). Without it, what
    /// the finding is of, or all that is violated.
    #[arg(long, value_name = "ID")]
    pub only: Vec<String>,
    /// Where the files go instead of STUDY/results/replays/NAME.
    #[arg(long, value_name = "FOLDER")]
    pub out: Option<PathBuf>,
    /// How many threads to use (results do not depend on it).
    #[arg(long, short = 'j', value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// How the result is printed.
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
}

/// A number from 0 on.
fn share(text: &str) -> Result<f64, String> {
    let number = text.trim().parse::<f64>().ok();
    number
        .filter(|it| it.is_finite() && *it >= 0.0)
        .ok_or_else(|| {
            "write a number from 0 on, for example 0.2: a fifth of what is allowed".to_owned()
        })
}

/// `K/N` with 1 <= K <= N <= 1000.
fn seeds(text: &str) -> Result<(u32, u32), String> {
    let wrong = || "write for example 3/5: in at least 3 of 5 seeds, at most 1000".to_owned();
    let (least, all) = text.split_once('/').ok_or_else(wrong)?;
    let number = |text: &str| text.trim().parse::<u32>().map_err(|_| wrong());
    let (least, all) = (number(least)?, number(all)?);
    if (1..=all).contains(&least) && all <= 1000 {
        Ok((least, all))
    } else {
        Err(wrong())
    }
}

#[cfg(test)]
mod tests {
    use super::seeds;

    #[test]
    fn seeds_are_some_of_many() {
        assert_eq!(seeds("3/5"), Ok((3, 5)));
        assert_eq!(seeds("1/1"), Ok((1, 1)));
        for wrong in ["0/5", "6/5", "3", "3/1001", "a/b", "3/", "-1/4"] {
            assert!(seeds(wrong).is_err(), "{wrong}");
        }
    }
}
