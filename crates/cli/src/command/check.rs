//! `corroborate check`: properties of one model, like the peers' command lines.

mod print;

use super::{Done, Host, json};
use crate::args::{Check, CheckFormat, Termination, refused};
use crate::memory::Memory;
use crate::written;
use corroborate::Ended;
use diagnostic::Problem;
use prism_lang::Experiment;
use prism_lang::ast::ModelType;
use query::{CheckRequest, Checked, Exports, ModelInput, PropertyInput};
use std::io::Write;
use std::path::Path;
use std::sync::Arc;

/// Checks properties of a model, for each valuation of its constants.
pub fn check(arguments: &Check, setting: &Host) -> Result<Done, Problem> {
    refuse(arguments)?;
    let request = request(arguments)?;
    say_what_has_no_effect(arguments, setting);
    let host = Host {
        memory: Arc::new(memory(arguments, setting)),
        ..setting.clone()
    };
    let print = |bytes: &[u8]| std::io::stdout().write_all(bytes);
    let found = corroborate::check(&request, &host, &print);
    keep_mistakes(arguments, &found)?;
    let found = found?;
    let is_for_lines = arguments.format == CheckFormat::Jsonl;
    let report = match found.problem {
        Some(problem) if !found.report.is_built() && !is_for_lines => return Err(problem),
        Some(problem) => {
            host.events.mistake(&problem);
            found.report
        }
        None => found.report,
    };
    if let Some(file) = &arguments.export_results {
        match report.is_finished() {
            true => query::write_results(file, &report, &print)?,
            false => (setting.events).say(&format!(
                "note: {file} not written: some properties have no result"
            )),
        }
    }
    let output = match arguments.format {
        CheckFormat::Json => json(&report)?,
        CheckFormat::Jsonl => print::lines(&report)?,
        CheckFormat::Text => print::text(&report),
    };
    Ok(Done {
        output,
        outcome: report.outcome(),
    })
}

/// Writes mistakes in the model and the properties in SARIF, if that was asked for.
fn keep_mistakes(arguments: &Check, found: &Result<Checked, Problem>) -> Result<(), Problem> {
    let mistakes = match found {
        Ok(found) => found.problem.as_ref(),
        Err(problem) => Some(problem),
    };
    let alerts = mistakes.map(written::of_problem).unwrap_or_default();
    written::keep_sarif(arguments.sarif.as_deref(), &alerts)
}

/// What the arguments ask.
fn request(arguments: &Check) -> Result<CheckRequest, Problem> {
    let given = arguments.property_texts.iter().cloned();
    let properties = arguments.properties.iter().map(|text| file_or_text(text));
    let own = [ModelType::Dtmc, ModelType::Ctmc, ModelType::Mdp];
    let model_type = arguments.model_type.as_deref();
    Ok(CheckRequest {
        model_type: own
            .into_iter()
            .find(|own| Some(own.keyword()) == model_type),
        imports: arguments.import.clone(),
        properties: properties.chain(given.map(PropertyInput::Text)).collect(),
        selected: arguments.selected.clone(),
        constants: constants(&arguments.constants)?,
        open: (!arguments.open.is_empty()).then(|| arguments.open.join(",")),
        method: arguments.method,
        precision: arguments.precision,
        epsilon: arguments.epsilon,
        termination: match arguments.termination {
            Termination::Relative => checker::Termination::Relative,
            Termination::Absolute => checker::Termination::Absolute,
        },
        max_iterations: arguments.max_iterations,
        max_states: arguments.max_states,
        fair: arguments.fair,
        sum_roundoff: arguments.sum_roundoff,
        certify: arguments.certify,
        witness: arguments.witness,
        timeout: arguments.timeout,
        steady_state: arguments.steady_state,
        transient: arguments.transient.clone(),
        initial_distribution: arguments.import_initial.clone(),
        exports: Exports {
            model: arguments.export_model.clone(),
            labels: arguments.export_labels.clone(),
            strategy: arguments.export_strategy.clone(),
            steady_state: arguments.export_steady_state.clone(),
            transient: arguments.export_transient.clone(),
        },
        ..CheckRequest::new(ModelInput::File(arguments.model.clone()))
    })
}

/// A file of properties, or one property.
fn file_or_text(argument: &str) -> PropertyInput {
    let endings = [".props", ".pctl", ".csl", ".prop", ".ltl"];
    let path = Path::new(argument);
    match path.exists() || endings.iter().any(|ending| argument.ends_with(ending)) {
        true => PropertyInput::File(path.to_owned()),
        false => PropertyInput::Text(argument.to_owned()),
    }
}

/// Flags of PRISM's that are not taken.
fn refuse(arguments: &Check) -> Result<(), Problem> {
    match arguments.refused.first() {
        None => Ok(()),
        Some(flag) => {
            let problem = Problem::new("refused-flag", format!("{flag} is not taken"));
            Err(problem.remedy(refused::reason(flag)))
        }
    }
}

/// The limit of memory; where the system does not tell what is held, whoever asks for one is told so.
fn memory(arguments: &Check, setting: &Host) -> Memory {
    let memory = Memory::new(arguments.memory_limit);
    if arguments.memory_limit.is_some() && !memory.is_watched() {
        setting.events.say(
            "note: --memory-limit has no effect: only Linux tells what a program takes; elsewhere a model that is too large ends the program",
        );
    }
    memory
}

fn say_what_has_no_effect(arguments: &Check, setting: &Host) {
    for flag in &arguments.without_effect {
        let why = match flag.as_str() {
            file if file.starts_with("-export") => "what it writes cannot be written yet",
            "-valiter" | "-power" | "-pow" | "-pwr" | "-gaussseidel" | "-gs" | "-jacobi"
            | "-jac" | "-politer" | "-modpoliter" => {
                "another flag asks for answers with a guarantee"
            }
            "-sim" => "the answers are computed, not estimated from samples",
            "-noprobchecks" => "probabilities are always checked",
            "-javamaxmem" | "-javastack" | "-cuddmaxmem" => "--memory-limit is the limit here",
            "-symm" => "states that stand for each other are found without it",
            "-verbose" | "-v" | "-extraddinfo" | "-extrareachinfo" => "there is no more to be said",
            _ => "our bounds hold by any method, in any data structure",
        };
        setting
            .events
            .say(&format!("note: {flag} has no effect: {why}"));
    }
}

fn constants(texts: &[String]) -> Result<Experiment, Problem> {
    Experiment::parse(&texts.join(",")).map_err(|error| {
        Problem::new("bad-constants", format!("--const: {error}"))
            .remedy("write for example --const N=5,p=0.1 or, for a range, --const N=1:2:9")
    })
}

#[cfg(test)]
mod tests {
    use crate::command::tests::assert_schema_is_committed;

    #[test]
    fn the_committed_schemas_are_the_forms_that_are_printed_and_written() {
        let schema: serde_json::Value = schemars::schema_for!(query::CheckReport).into();
        assert_schema_is_committed("check.schema.json", &schema);
        let schema: serde_json::Value = schemars::schema_for!(query::StrategyReport).into();
        assert_schema_is_committed("strategy.schema.json", &schema);
    }
}
