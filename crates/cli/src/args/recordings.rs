//! The arguments of commands that read recordings, and how recordings are opened.

use super::Format;
use clap::{Args, Subcommand, ValueEnum};
use recording::{OpenOptions, TimeSource};
use std::path::PathBuf;

/// How recordings are opened.
#[derive(Clone, Debug, Default, Args)]
pub struct Opening {
    /// The column or key that has the time, in tables and JSON lines.
    #[arg(long, value_name = "NAME")]
    pub time_field: Option<String>,
    /// The unit of the times in tables and JSON lines: s, ms, us or ns.
    #[arg(long, value_name = "UNIT")]
    pub time_unit: Option<recording::TimeUnit>,
    /// A folder of `.msg` files, for types that a recording does not define
    /// itself (may be repeated).
    #[arg(long, value_name = "FOLDER")]
    pub message_path: Vec<PathBuf>,
}

impl Opening {
    /// How files are opened, as the call says.
    pub fn options(&self) -> OpenOptions {
        OpenOptions {
            time_field: self.time_field.clone(),
            time_unit: self.time_unit,
            message_path: self.message_path.clone(),
            ..OpenOptions::default()
        }
    }
}

/// Which time of a message counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum TimeChoice {
    /// When the recorder received it.
    Log,
    /// When it was sent.
    Publish,
    /// When it was measured, by its header.
    Header,
    /// When it was received, by the simulation's /clock.
    Clock,
}

impl TimeChoice {
    /// As the reader of recordings has it.
    pub fn source(self) -> TimeSource {
        match self {
            TimeChoice::Log => TimeSource::Log,
            TimeChoice::Publish => TimeSource::Publish,
            TimeChoice::Header => TimeSource::Header,
            TimeChoice::Clock => TimeSource::Clock,
        }
    }
}

/// What is said of times behind the end of a recording.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum EndingChoice {
    /// The recording is all there is, but what is pending at its end in a bounded window violates nothing: it is left out, or
    /// the verdict is open if no window was seen whole.
    #[default]
    LongEnough,
    /// The recording is all there is.
    Finite,
    /// The benefit of the doubt.
    Weak,
    /// No benefit.
    Strong,
    /// Nothing: a verdict only if no continuation can change it.
    Inconclusive,
}

/// Arguments of `monitor`.
#[derive(Debug, Args)]
#[command(
    override_usage = "corroborate monitor [OPTIONS] STUDY RECORDINGS...\n       \
                      corroborate monitor [OPTIONS] --formula FORMULA RECORDINGS...",
    after_help = "\
Examples:
  corroborate monitor case-studies/handover recordings/*.mcap
  corroborate monitor case-studies/handover recordings --only 3 --format json
  corroborate monitor my-study run.bag --map topics.toml --time header
  corroborate monitor my-study run.mcap --verdicts shown
  corroborate monitor --formula 'always (/robot.speed < 250 mm/s)' run.mcap

Reads MCAP, ROS 1 bags, rosbag2 (sqlite and MCAP), CSV and JSON lines; a folder
of recordings is a set of trials. The topic map (STUDY/topics.toml, or --map)
says where the signals are; others are looked up as they are written.
Exits 1 if a requirement is violated, 3 if a verdict is open. A recording that
was cut short or lost messages is an error, unless --partial says to judge what
there is; then it exits 3, since what is lost may have changed a verdict."
)]
pub struct Monitor {
    /// The study whose requirements and failure modes are monitored (none with
    /// --formula), then recordings, or folders of them.
    #[arg(required = true, value_name = "STUDY RECORDINGS")]
    pub paths: Vec<PathBuf>,
    /// Judge this formula of temporal logic instead of a study (may be
    /// repeated).
    #[arg(long, value_name = "FORMULA", conflicts_with = "only")]
    pub formula: Vec<String>,
    /// What the formula assumes behind the end of a recording.
    #[arg(long, value_enum, default_value_t, requires = "formula")]
    pub ending: EndingChoice,
    /// The formula's operators speak of all times, not of the samples.
    #[arg(long, requires = "formula")]
    pub dense: bool,
    /// By how many seconds the signals of a formula may begin later than the
    /// first of them for judging to begin when all are there.
    #[arg(long, value_name = "SECS", requires = "formula",
          default_value_t = study::START_WITHIN_SECS, value_parser = from_zero)]
    pub start_within: f64,
    /// Only this requirement or failure mode (may be repeated).
    #[arg(long, value_name = "ID")]
    pub only: Vec<String>,
    /// Where recordings have the signals, instead of the study's topics.toml.
    #[arg(long, value_name = "FILE")]
    pub map: Option<PathBuf>,
    /// Which time of a message counts, instead of what the topic map says.
    #[arg(long, value_enum)]
    pub time: Option<TimeChoice>,
    /// How recordings are opened.
    #[command(flatten)]
    pub opening: Opening,
    /// Judge recordings that are not complete as far as they go.
    #[arg(long)]
    pub partial: bool,
    /// Write verdicts and robustness over time to this folder, as MCAP files
    /// that viewers open beside the recordings.
    #[arg(long, value_name = "FOLDER")]
    pub verdicts: Option<PathBuf>,
    /// How the verdicts are printed.
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
}

/// Arguments of `inspect`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  corroborate inspect run.mcap
  corroborate inspect bag_folder --draft-map topics.toml
  corroborate inspect run.bag --draft-map -
  corroborate inspect robot.urdf --packages ros_ws/src
  corroborate inspect my-study

Lists topics with their types, rates, jitter and gaps, and what does not fit.
The draft has an entry for every value; delete what is not needed. Exits 3 if
something of the recording is lost. Of a robot's or scene's description (URDF,
SDF, MJCF: .urdf, .sdf, .world, .xml) shows the tree of links and joints, and
what of it a simulation would not have. Of a study lists the signals of its
simulations with units and frames, and all truth that propositions may name.")]
pub struct Inspect {
    /// The recording: a file, or a folder that rosbag2 recorded. Or a
    /// description of a robot or a scene. Or a study's folder.
    pub recording: PathBuf,
    /// A folder with the packages or models that a description names; may be
    /// repeated. The folders around the description are searched too.
    #[arg(long, value_name = "FOLDER")]
    pub packages: Vec<PathBuf>,
    /// A value of an argument (`xacro:arg`) of a description in xacro; may be repeated. In a scene they stand in the robot's
    /// `arguments`.
    #[arg(long = "argument", value_name = "NAME=VALUE", value_parser = named_value)]
    pub arguments: Vec<(String, String)>,
    /// Write a draft of the topic map to this new file (`-`: print it instead
    /// of the table).
    #[arg(long, value_name = "FILE")]
    pub draft_map: Option<PathBuf>,
    /// A period this many times as long as the middle one is a gap.
    #[arg(long, value_name = "X", default_value = "5", value_parser = gap_factor)]
    pub gap_factor: f64,
    /// How the recording is opened.
    #[command(flatten)]
    pub opening: Opening,
    /// How the result is printed.
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
}

/// Arguments of `requirements`.
#[derive(Debug, Args)]
#[command(
    args_conflicts_with_subcommands = true,
    subcommand_negates_reqs = true,
    after_help = "\
Examples:
  corroborate requirements case-studies/handover
  corroborate requirements case-studies/handover recordings
  corroborate requirements --library
  corroborate requirements import my-study fret-requirements.json
  corroborate requirements export my-study requirements.reqif

Shows each requirement with its sentence, its property, its monitor, its test
goals and its coverage bins. Forms that were written by hand are held against
the declared parameters and, on recordings, against each other. Exits 1 if
they do not agree."
)]
pub struct Requirements {
    /// The study whose requirements are shown.
    #[arg(required_unless_present = "library")]
    pub study: Option<PathBuf>,
    /// Recordings, or folders of them, on which the forms are compared.
    pub recordings: Vec<PathBuf>,
    /// List ready requirements for collaborative robots instead.
    #[arg(long, conflicts_with = "study")]
    pub library: bool,
    /// Where recordings have the signals, instead of the study's topics.toml.
    #[arg(long, value_name = "FILE")]
    pub map: Option<PathBuf>,
    /// Also write forms that drifted apart, and mistakes in the study's files, in SARIF.
    #[arg(long, value_name = "FILE")]
    pub sarif: Option<PathBuf>,
    /// How the requirements are printed.
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
    /// To or from a file of another tool.
    #[command(subcommand)]
    pub exchange: Option<Exchange>,
}

/// To or from a file of another tool.
#[derive(Debug, Subcommand)]
pub enum Exchange {
    /// Carry requirements over from another tool's file to the study, by id.
    #[command(after_help = "\
Examples:
  corroborate requirements import my-study fret-requirements.json
  corroborate requirements import my-study requirements.reqif --field text=Description
  corroborate requirements import my-study doorstop-folder --dry-run

Reads FRET (.json), ReqIF (.reqif, .reqifz), StrictDoc (.sdoc), CSV (.csv, .tsv)
and folders of Doorstop. What was edited on one side since the last import or
export is carried over; what was edited on both is a conflict, shown with both
texts and left alone. Nothing is deleted. Exits 3 if there are conflicts, 1 if a
sentence of the study means something else than FRET's formulas.")]
    Import(Exchanged),
    /// Carry requirements over from the study to another tool's file, by id.
    #[command(after_help = "\
Examples:
  corroborate requirements export my-study requirements.reqif
  corroborate requirements export my-study requirements.csv --only R1 --only R2
  corroborate requirements export my-study requirements.sdoc --take study

A file that is there is changed in place: what is not carried over stays byte
for byte. One that is not is made. Exits as import does.")]
    Export(Exchanged),
}

/// Arguments of `requirements import` and `requirements export`.
#[derive(Debug, Args)]
pub struct Exchanged {
    /// The study's folder.
    pub study: PathBuf,
    /// The other tool's file, or a folder of Doorstop.
    pub file: PathBuf,
    /// What a field is called in the file: `id`, `text`, `rationale`, `status` or `parents`, and the name of its column,
    /// attribute or type of relations (may be repeated; remembered in the study).
    #[arg(long, value_name = "FIELD=NAME", value_parser = field)]
    pub field: Vec<(Option<corroborate::requirements::exchange::Field>, String)>,
    /// Whose value counts where both sides were edited.
    #[arg(long, value_enum)]
    pub take: Option<TakeChoice>,
    /// Only this requirement (may be repeated).
    #[arg(long, value_name = "ID")]
    pub only: Vec<String>,
    /// Let translated sentences of FRET become the sentences of requirements that are added, where the vocabulary has their
    /// names; else they stand in a comment.
    #[arg(long)]
    pub sentences: bool,
    /// Write nothing; say what would be written.
    #[arg(long)]
    pub dry_run: bool,
    /// How the report is printed.
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
}

/// Whose value counts where both sides were edited.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum TakeChoice {
    /// The study's.
    Study,
    /// The file's.
    File,
}

/// Reads `FIELD=NAME`; no field is the id.
fn field(
    text: &str,
) -> Result<(Option<corroborate::requirements::exchange::Field>, String), String> {
    use corroborate::requirements::exchange::Field;
    let (field, name) = text
        .split_once('=')
        .filter(|(_, name)| !name.trim().is_empty())
        .ok_or("must be FIELD=NAME, for example text=Description")?;
    if field == "id" {
        return Ok((None, name.to_owned()));
    }
    let known = Field::ALL.into_iter().find(|known| known.name() == field);
    let known =
        known.ok_or_else(|| format!("`{field}` must be id, text, rationale, status or parents"))?;
    Ok((Some(known), name.to_owned()))
}

fn from_zero(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value >= 0.0 => Ok(value),
        _ => Err("must be a number of seconds from 0, for example 0.5".into()),
    }
}

fn named_value(text: &str) -> Result<(String, String), String> {
    let (name, value) = (text.split_once(":=").or_else(|| text.split_once('=')))
        .ok_or("write NAME=VALUE, for example ur_type=ur5e")?;
    Ok((name.to_owned(), value.to_owned()))
}

fn gap_factor(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 1.0 && value.is_finite() => Ok(value),
        _ => Err("must be a number above 1, for example 5".into()),
    }
}
