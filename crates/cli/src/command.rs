//! The commands: from arguments to a printed result and an outcome.

mod assure;
mod calibrate;
mod check;
mod compare;
mod completions;
mod decide;
mod diagnose;
mod diff;
mod doctor;
mod engines;
mod explore;
mod format;
mod init;
mod inspect;
mod language_server;
mod man;
mod merge;
mod monitor;
pub(crate) mod pack;
mod plan;
mod rare;
mod refine;
mod replay;
mod report;
mod requirements;
mod run;
mod schema;
mod shrink;
mod simulate;
mod trust;
mod verify;
mod watch;
mod what_if;

use crate::args::Command;
use corroborate::Outcome;
pub use corroborate::results::json;
use diagnostic::Problem;
pub use host::Host;

/// A finished command.
#[derive(Debug)]
pub struct Done {
    /// What goes to standard output.
    pub output: String,
    /// How it ended.
    pub outcome: Outcome,
}

/// Carries out a command.
pub fn carry_out(command: &Command, setting: &Host) -> Result<Done, Problem> {
    match command {
        Command::Run(arguments) => run::run(arguments, setting),
        Command::Merge(arguments) => merge::merge(arguments, setting),
        Command::Plan(arguments) => plan::plan(arguments, setting),
        Command::Check(arguments) => check::check(arguments, setting),
        Command::Format(arguments) => format::format(arguments),
        Command::LanguageServer(arguments) => language_server::language_server(arguments),
        Command::Simulate(arguments) => simulate::simulate(arguments, setting),
        Command::Explore(arguments) => explore::explore(arguments, setting),
        Command::Shrink(arguments) => shrink::shrink(arguments, setting),
        Command::Replay(arguments) => replay::replay(arguments, setting),
        Command::Engines(arguments) => engines::engines(arguments, setting),
        Command::Rare(arguments) => rare::rare(arguments, setting),
        Command::Calibrate(arguments) => calibrate::calibrate(arguments, setting),
        Command::Refine(arguments) => refine::refine(arguments, setting),
        Command::WhatIf(arguments) => what_if::what_if(arguments, setting),
        Command::Monitor(arguments) => monitor::monitor(arguments, setting),
        Command::Inspect(arguments) => inspect::inspect(arguments, setting),
        Command::Watch(arguments) => watch::watch(arguments, setting),
        Command::Requirements(arguments) => requirements::requirements(arguments, setting),
        Command::Decide(arguments) => decide::decide(arguments, setting),
        Command::Compare(arguments) => compare::compare(arguments),
        Command::Diff(arguments) => diff::diff(arguments),
        Command::Diagnose(arguments) => diagnose::diagnose(arguments, setting),
        Command::Report(arguments) => report::report(arguments),
        Command::Assure(arguments) => assure::assure(arguments),
        Command::Pack(arguments) => pack::pack(arguments, setting),
        Command::Verify(arguments) => verify::verify(arguments, setting),
        Command::Init(arguments) => init::init(arguments, setting),
        Command::Trust(arguments) => trust::trust(arguments, setting),
        Command::Schema(arguments) => schema::schema(arguments),
        Command::Explain(arguments) => crate::explain::explain(arguments),
        Command::Doctor(arguments) => doctor::doctor(arguments, setting),
        Command::Completions(arguments) => completions::completions(arguments),
        Command::Man(arguments) => man::man(arguments),
    }
}

/// Limits the number of threads that work in parallel.
pub fn use_threads(threads: Option<u16>) -> Result<(), Problem> {
    let Some(threads) = threads else {
        return Ok(());
    };
    rayon::ThreadPoolBuilder::new()
        .num_threads(usize::from(threads))
        .build_global()
        .map_err(|error| Problem::new("cannot-start-threads", error.to_string()))
}

#[cfg(test)]
pub(crate) mod tests {
    /// Fails if a schema in `schemas/` is not the one of the code; with
    /// `UPDATE_SCHEMAS=1` it is written instead.
    pub fn assert_schema_is_committed(name: &str, schema: &serde_json::Value) {
        let text = serde_json::to_string_pretty(schema).expect("a schema") + "\n";
        assert_is_committed(&format!("schemas/{name}"), &text);
    }

    /// The same of any text that is made of the code, at its path in the project.
    pub fn assert_is_committed(name: &str, text: &str) {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("../..")
            .join(name);
        if std::env::var_os("UPDATE_SCHEMAS").is_some() {
            std::fs::write(&path, text).expect("written");
        }
        let committed = std::fs::read_to_string(&path).unwrap_or_default();
        assert!(
            committed == text,
            "{name} is not the form of the code; run the tests with UPDATE_SCHEMAS=1"
        );
    }

    #[test]
    fn the_committed_schema_of_a_study_is_its_form() {
        let schema = evidence::StudyResult::json_schema();
        assert_schema_is_committed("study.schema.json", &schema);
    }
}
