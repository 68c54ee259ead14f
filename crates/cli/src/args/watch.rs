//! Arguments of `watch`.

use super::{Format, TimeChoice, duration, study_folder};
use clap::{ArgGroup, Args};
use std::net::IpAddr;
use std::path::PathBuf;
use std::time::Duration;

/// Arguments of `watch`.
#[derive(Debug, Args)]
#[command(
    group = ArgGroup::new("connection").required(true).args(["dds", "foxglove"]),
    after_help = "\
Examples:
  corroborate watch my-study --dds                          ROS 2, domain 0
  corroborate watch my-study --dds 42 --out runs            and record the run
  corroborate watch my-study --foxglove ws://robot:8765 --for 60s --format json
  corroborate watch my-study --dds --topics '/robot/*' --out runs
  corroborate watch my-study --dds --simulate E2 --outside /sensors/pressure_ok --out runs

Judges as messages come: a verdict is said as soon as it is determined. By the
time of arrival (`--time log`, unless the topic map says otherwise) nothing is
waited for; by other times a verdict waits for what may still come late (as
long as `reorder` in the topic map says). By the time of arrival, a deadline that
has passed is judged 100 ms later even if all is silent; by other times, with the
next message.

Ctrl-C (or SIGTERM) ends and sums up; a second one ends at once. Where another
end was planned (--for, --simulate), the run then counts as incomplete. Exits 1
if a requirement is violated, 3 if messages were lost or a verdict is open, 130
if it was interrupted before what was planned was over."
)]
pub struct Watch {
    /// The folder of the study whose requirements and failure modes are judged, or its study.toml; the folder around, if left out.
    #[arg(default_value = ".", hide_default_value = true, value_parser = study_folder())]
    pub study: PathBuf,
    /// Listen to ROS 2 (or plain DDS) in this domain; 0 if none is said.
    #[arg(long, value_name = "DOMAIN", num_args = 0..=1, default_missing_value = "0", value_parser = clap::value_parser!(u16).range(0..=232))]
    pub dds: Option<u16>,
    /// Listen to a Foxglove WebSocket, `ws://HOST:PORT`.
    #[arg(long, value_name = "URL")]
    pub foxglove: Option<String>,
    /// Topics to listen to and record beside those that the requirements need;
    /// `*` stands for anything (may be repeated).
    #[arg(long, value_name = "PATTERN")]
    pub topics: Vec<String>,
    /// This machine's address on the network of the robot (DDS; may be
    /// repeated; all networks if left out).
    #[arg(long, value_name = "ADDRESS", conflicts_with = "foxglove")]
    pub network: Vec<IpAddr>,
    /// A folder of `.msg` files, for types that the connection does not define
    /// (may be repeated).
    #[arg(long, value_name = "FOLDER")]
    pub message_path: Vec<PathBuf>,
    /// Where the signals are, instead of the study's topics.toml.
    #[arg(long, value_name = "FILE")]
    pub map: Option<PathBuf>,
    /// Which time of a message counts, instead of what the topic map says.
    #[arg(long, value_enum)]
    pub time: Option<TimeChoice>,
    /// Only this requirement or failure mode (may be repeated).
    #[arg(long, value_name = "ID")]
    pub only: Vec<String>,
    /// End after this time, for example `60s` or `5 min`; by default with Ctrl-C.
    #[arg(long = "for", value_name = "TIME", value_parser = duration)]
    pub limit: Option<Duration>,
    /// How long to wait for the topics that the requirements need.
    #[arg(long, value_name = "TIME", default_value = "30s", value_parser = duration)]
    pub wait: Duration,
    /// Record the messages as they come, and the verdicts, in this folder; a
    /// ledger's `recordings` may name it.
    #[arg(long, value_name = "FOLDER")]
    pub out: Option<PathBuf>,
    /// Simulate the rest of the robot: run an episode of this entry of the
    /// ledger at the pace of the clock, publish what it shows by the table
    /// ros2.toml beside its scenario, and judge both together.
    #[arg(long, value_name = "ENTRY")]
    pub simulate: Option<String>,
    /// A topic that comes from outside, not from the simulation (may be
    /// repeated); where the simulated robot reads it, it acts by it.
    #[arg(long, value_name = "TOPIC", requires = "simulate")]
    pub outside: Vec<String>,
    /// Number of the episode that is simulated.
    #[arg(long, value_name = "N", requires = "simulate", default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..=1_000_000_000))]
    pub episode: u64,
    /// Seed of the simulation instead of the study's.
    #[arg(long, value_name = "N", requires = "simulate")]
    pub seed: Option<u64>,
    /// Format of the events; `json`: one object a line.
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
}
