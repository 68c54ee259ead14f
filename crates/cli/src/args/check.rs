//! Arguments of `check`.

use super::duration;
use clap::{Args, ValueEnum};
use std::path::PathBuf;
use std::time::Duration;
use study::Method;

/// Arguments of `check`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  corroborate check model.prism 'P=? [ F \"done\" ]'
  corroborate check model.prism properties.props --prop safety --const N=5,p=0.1
  corroborate check model.prism properties.props --method exact
  corroborate check model.prism 'P>=0.95 [ F \"done\" ]'   exits 1 if it does not hold
  corroborate check model.prism                          counts states and transitions
  corroborate check model.prism 'P=? [ F \"done\" ]' --param p=0:1   a function of p
  corroborate check model.all 'P=? [ F \"done\" ]'       of model.tra, model.sta, model.lab, ...

PRISM's flags are understood, such as -const N=3, -pf, -prop, -exact, -exportresults, -exportmodel and
-exportstrat; so are those that choose a numerical method (-valiter, -power, -gs, -jac, -politer, -modpoliter, with -epsilon,
-maxiters, -absolute, -relative), of which the last one counts. Those that choose an engine have no effect.")]
pub struct Check {
    /// The model, in the PRISM language; or its states and transitions: FILE.tra, FILE.tra,sta,lab, FILE.all
    /// (all that there are: .tra, .sta, .lab, .srew, .trew) or FILE.drn.
    pub model: PathBuf,
    /// A file of properties, or one property.
    #[arg(allow_hyphen_values = false)]
    pub properties: Option<String>,
    /// A property, beside those of the file (may be repeated).
    #[arg(long = "pf", value_name = "PROPERTY")]
    pub property_texts: Vec<String>,
    /// Only the property with this name or number (may be repeated).
    #[arg(long = "prop", value_name = "NAME")]
    pub selected: Vec<String>,
    /// Values of undefined constants: `a=1,b=0.5` (may be repeated).
    #[arg(long = "const", short = 'c', value_name = "VALUES")]
    pub constants: Vec<String>,
    /// Constants that stay open, with their ranges: `p=0:1,q=0.2:0.4`; answers are rational functions of them
    /// (may be repeated).
    #[arg(long = "param", value_name = "RANGES")]
    pub open: Vec<String>,
    /// Check each answer again with code that shares nothing with the solver.
    #[arg(long)]
    pub certify: bool,
    /// How the answer is computed; of several the last one counts.
    #[arg(long, value_parser = super::choice::<Method>(), default_value = "sound", overrides_with = "method")]
    pub method: Method,
    /// Relative width of the bounds, of methods that have bounds.
    #[arg(long, value_name = "X", default_value = "1e-6", value_parser = precision)]
    pub precision: f64,
    /// When a method that has no bounds stops: change of the values.
    #[arg(long, value_name = "X", default_value = "1e-6", value_parser = precision)]
    pub epsilon: f64,
    /// Which change that is.
    #[arg(long, value_enum, default_value_t, overrides_with = "termination")]
    pub termination: Termination,
    /// Take probabilities of a command that miss the sum 1 by up to X as rounded: they are divided by their sum, and the answer's
    /// bounds hold wherever the rest belongs (PRISM's -sumroundoff; PRISM's default is 1e-5).
    #[arg(long = "sum-roundoff", value_name = "X", value_parser = precision, overrides_with = "sum_roundoff", conflicts_with = "open")]
    pub sum_roundoff: Option<f64>,
    /// How many states the model may have; by default as many as fit into the memory.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=4_000_000_000))]
    pub max_states: Option<u64>,
    /// How many iterations a method that has no bounds may take.
    #[arg(long = "maxiters", value_name = "N")]
    pub max_iterations: Option<u64>,
    /// Also write mistakes in the model and the properties in SARIF.
    #[arg(long, value_name = "FILE")]
    pub sarif: Option<PathBuf>,
    /// How the answers are printed.
    #[arg(long, value_enum, default_value_t)]
    pub format: CheckFormat,
    /// Take the model for one of this type.
    #[arg(long = "type", value_name = "TYPE", value_parser = ["dtmc", "ctmc", "mdp"])]
    pub model_type: Option<String>,
    /// Write the answers to FILE, in PRISM's form: FILE[:csv|matrix|matrix,csv|dataframe|comment].
    #[arg(long = "export-results", value_name = "FILE")]
    pub export_results: Option<String>,
    /// Write the model: FILE.tra (transitions), .sta (states), .lab (labels), .srew and .trew (rewards), .dot,
    /// .drn; several as FILE.tra,sta; as many as there are as FILE.all (may be repeated).
    #[arg(long = "export-model", value_name = "FILE")]
    pub export_model: Vec<String>,
    /// Read a part of the model from another file: tra=FILE, sta=, lab=, srew=, trew= (may be repeated).
    #[arg(long = "import", value_name = "FORM=FILE")]
    pub import: Vec<String>,
    /// Write the labels.
    #[arg(long = "export-labels", value_name = "FILE")]
    pub export_labels: Option<PathBuf>,
    /// Write the scheduler that attains the answer: its action in each state, with the memory it needs (FILE, or
    /// FILE.json); or the chain that it induces, which can be checked (FILE.tra, .sta, .lab, .srew, .trew, .dot, .drn, with the
    /// memory as a variable).
    #[arg(long = "export-strategy", value_name = "FILE")]
    pub export_strategy: Option<String>,
    /// Show the most probable path that satisfies (or violates) each path formula with one temporal operator.
    #[arg(long)]
    pub witness: bool,
    /// Show the share of time in each state in the long run (`dtmc`, `ctmc`).
    #[arg(long)]
    pub steady_state: bool,
    /// Show the probability of each state after T steps (`dtmc`) or at time T (`ctmc`); T may be a range: 0:0.5:5.
    #[arg(long, value_name = "T")]
    pub transient: Option<String>,
    /// Write the shares of `--steady-state` to FILE: the probability of each state on a line of its own.
    #[arg(long, value_name = "FILE")]
    pub export_steady_state: Option<PathBuf>,
    /// Write the probabilities of `--transient` to FILE.
    #[arg(long, value_name = "FILE")]
    pub export_transient: Option<PathBuf>,
    /// Start `--steady-state` and `--transient` from the distribution in FILE; without it, all initial states are equally probable.
    #[arg(long, value_name = "FILE")]
    pub import_initial: Option<PathBuf>,
    /// End with a message when more than this many GB of memory are taken; by default 90 % of what is free.
    #[arg(long, value_name = "GB", value_parser = gigabytes)]
    pub memory_limit: Option<f64>,
    /// End after so long with what was found: seconds, or with a unit, for example `30s` or `5 min`.
    #[arg(long, value_name = "TIME", value_parser = duration)]
    pub timeout: Option<Duration>,
    /// Only fair schedulers: each choice of each state that is visited infinitely often is taken infinitely often.
    #[arg(long)]
    pub fair: bool,
    /// PRISM's flags that have none.
    #[arg(long = "without-effect", value_name = "FLAG", hide = true)]
    pub without_effect: Vec<String>,
    /// Flags that are not taken.
    #[arg(long = "refused", value_name = "FLAG", hide = true)]
    pub refused: Vec<String>,
}

/// How answers are printed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum CheckFormat {
    /// For people.
    #[default]
    Text,
    /// For programs; the schema is `schemas/check.schema.json`.
    Json,
    /// One line of JSON for each answer, also where the model has a mistake.
    Jsonl,
}

/// Which change of the values stops an iteration.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Termination {
    /// Relative to the value.
    #[default]
    Relative,
    /// As it is.
    Absolute,
}

fn precision(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value < 1.0 => Ok(value),
        _ => Err("must be a number between 0 and 1, for example 1e-6".into()),
    }
}

fn gigabytes(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value.is_finite() => Ok(value),
        _ => Err("must be a number above 0, for example 4 or 0.5".into()),
    }
}
