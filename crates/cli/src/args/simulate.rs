//! The arguments of `simulate`, and what its recordings hold.

use super::{Format, choice, study_folder};
use clap::{Args, ValueEnum};
use std::path::PathBuf;
use study::{Keep, OnFailure, PhysicsEngine};

/// Arguments of `simulate`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  corroborate simulate case-studies/handover E4 --episodes 20 --out recordings
  corroborate simulate case-studies/handover E2 --seed 7 --episodes 1 --out one
  corroborate simulate case-studies/handover E2 --as ros2 --episodes 3 --out bags
  corroborate simulate case-studies/handover E4 --episodes 10000 --keep violations \\
      --until 'requirement 1a is decided at 99 %' --out many

Each episode becomes one MCAP file, which Foxglove opens and `corroborate
monitor` judges. The same study and seed give the same bytes. Each requirement
with a threshold is judged as `corroborate run` judges one piece of evidence:
exits 0 if all hold, 1 if one is violated, 3 if one is undecided.")]
pub struct Simulate {
    /// The study's folder, or its study.toml.
    #[arg(value_parser = study_folder())]
    pub study: PathBuf,
    /// The ledger's entry whose scenario and parameters are simulated.
    pub evidence: String,
    /// How many episodes; as many as the ledger says if left out.
    #[arg(long, short = 'n', value_name = "N", value_parser = clap::value_parser!(u64).range(1..=10_000_000))]
    pub episodes: Option<u64>,
    /// End before that once a requirement is decided, for example
    /// "requirement 1a is decided at 99 %" or, without a threshold of its own,
    /// "requirement 3 is decided against 0.9 at 99 %".
    #[arg(long, value_name = "RULE")]
    pub until: Option<String>,
    /// Which recordings are kept; results are kept in any case.
    #[arg(long, value_parser = choice::<Keep>(), value_name = "WHICH")]
    pub keep: Option<Keep>,
    /// What is done when the robot's program or the simulator fails in an
    /// episode; as the ledger says, or counted, if left out.
    #[arg(long, value_parser = choice::<OnFailure>(), value_name = "WHAT")]
    pub on_failure: Option<OnFailure>,
    /// Number of the first episode.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..=1_000_000_000))]
    pub first: u64,
    /// Seed instead of the study's.
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
    /// Where the recordings go.
    #[arg(long, value_name = "FOLDER")]
    pub out: PathBuf,
    /// The physics engine of a scene or of the handover, in place of the ledger's.
    #[arg(long, value_parser = choice::<PhysicsEngine>(), value_name = "ENGINE")]
    pub engine: Option<PhysicsEngine>,
    /// What the recordings hold.
    #[arg(long = "as", value_enum, default_value_t, value_name = "FORM")]
    pub form: RecordingForm,
    /// How many threads to use (results do not depend on it).
    #[arg(long, short = 'j', value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// How the summary is printed.
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
}

/// What the recordings of a simulation hold.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum RecordingForm {
    /// The simulation's own signals.
    #[default]
    Corroborate,
    /// ROS 2 messages, by the table `ros2.toml` beside the scenario.
    Ros2,
}
