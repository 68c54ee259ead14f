//! `check --export-strategy`: the scheduler of an answer, as decisions or as the chain that it induces.

use crate::export::{FORMS, Output, chain, files};
use checker::formats::{Explicit, Written};
use checker::scheduler::{Meaning, Scheduler, scheduler, scheduler_exact};
use checker::state_space::StateSpace;
use checker::{CheckError, Options};
use diagnostic::Problem;
use host::Events;
use prism_lang::{Arithmetic, Property, Rational, resolved};
use schemars::JsonSchema;
use serde::Serialize;
use std::any::Any;
use std::path::Path;

/// What `check --export-strategy FILE.json` writes.
#[derive(Debug, Serialize, JsonSchema)]
pub struct StrategyReport {
    /// Version of this form.
    pub format: String,
    /// The names of the model's variables.
    pub variables: Vec<String>,
    /// What the memory says: `steps` (how many were taken, up to a last number after which none matters), `automaton`
    /// (where the automaton of the formula is, and what must recur next), `mixture` (which of several schedulers was
    /// drawn in the beginning, and its memory); null where the state is enough.
    pub memory: Option<String>,
    /// What is done, where it matters.
    pub decisions: Vec<DecisionReport>,
}

/// What is done in a state.
#[derive(Debug, Serialize, JsonSchema)]
pub struct DecisionReport {
    /// The values of the variables; a truth value is 0 or 1.
    pub state: Vec<i64>,
    /// The memory; 0 in the beginning of `steps`.
    pub memory: Option<u32>,
    /// The place of the choice among the state's, from 0.
    pub choice: usize,
    /// Its action, if it has one.
    pub action: Option<String>,
    /// How likely it is taken, as a fraction, where one of several choices is drawn; null where it is the only one.
    pub share: Option<String>,
}

/// Writes the scheduler of a property, or says why there is none.
pub(crate) fn write_strategy<N: Arithmetic + Written + 'static>(
    asked: &str,
    model: &resolved::Model,
    space: &StateSpace<N>,
    property: &Property,
    options: &Options<'_>,
    talk: &Events,
    output: Output<'_>,
) -> Result<(), Problem> {
    let scheduler = match found(space, property, options) {
        Ok(scheduler) => scheduler,
        Err(CheckError::Cancelled) => return Err(Problem::interrupted()),
        Err(error) => {
            talk.say(&format!("note: no scheduler is written: {error}"));
            return Ok(());
        }
    };
    // A colon may stand in a file's name, too.
    let (file, settings) = match asked.rsplit_once(':') {
        Some((file, settings)) if settings.contains('=') => (file, settings),
        _ => (asked.trim_end_matches(':'), ""),
    };
    let is_set = |setting: &str| settings.split(',').any(|given| given == setting);
    let form = |ending: &str| {
        let last = file.rsplit_once('.').map_or("", |(_, endings)| endings);
        last.split(',').any(|own| own == ending)
    };
    if is_set("type=dot")
        || is_set("type=induced")
        || FORMS.iter().any(|of| form(of))
        || form("all")
    {
        let chain_of = scheduler.induced(space);
        if is_set("type=dot") || is_set("type=induced") {
            let form = if is_set("type=dot") { "dot" } else { "tra" };
            return chain(model, &chain_of, form, Path::new(file), output);
        }
        for (form, path) in files(file)? {
            chain(model, &chain_of, &form, &path, output)?;
        }
        return Ok(());
    }
    let path = Path::new(file);
    let explicit = Explicit::new(space);
    if form("json") || is_set("type=json") {
        let report = report(space, &explicit, &scheduler);
        return output.write(path, json(&report)?.as_bytes());
    }
    let mut bytes = Vec::new();
    let (values, actions) = (
        !is_set("states=false") && !is_set("type=indices"),
        !is_set("type=indices"),
    );
    explicit
        .write_scheduler(&scheduler, values, actions, &mut bytes)
        .map_err(|error| Problem::cannot_write(path, &error))?;
    output.write(path, &bytes)
}

fn json(report: &StrategyReport) -> Result<String, Problem> {
    serde_json::to_string_pretty(report)
        .map(|text| text + "\n")
        .map_err(|error| Problem::new("cannot-write", format!("the result as JSON: {error}")))
}

fn found<N: 'static>(
    space: &StateSpace<N>,
    property: &Property,
    options: &Options<'_>,
) -> Result<Scheduler, CheckError> {
    let any = space as &dyn Any;
    if let Some(space) = any.downcast_ref::<StateSpace<Rational>>() {
        return scheduler_exact(space, property, options);
    }
    match any.downcast_ref::<StateSpace<f64>>() {
        Some(space) => scheduler(space, property, options),
        None => Err(CheckError::Unsupported(
            "there is no scheduler of a model with open constants".to_owned(),
        )),
    }
}

fn report<N: Arithmetic + Written>(
    space: &StateSpace<N>,
    explicit: &Explicit<'_, N>,
    scheduler: &Scheduler,
) -> StrategyReport {
    let memory = match scheduler {
        Scheduler::ByState(_) => None,
        Scheduler::WithMemory(memory) => Some(match memory.meaning {
            Meaning::Steps => "steps",
            Meaning::Automaton => "automaton",
            Meaning::Mixture => "mixture",
        }),
    };
    let decision = |decision: checker::formats::Decision| DecisionReport {
        state: space.state(decision.state),
        memory: decision.memory,
        choice: decision.row - space.choices(decision.state).start,
        action: (space.action(decision.row)).map(|action| space.actions()[action].clone()),
        share: decision.share.map(|share| share.to_string()),
    };
    StrategyReport {
        format: "1.0".into(),
        variables: space.variables().iter().map(|v| v.name.clone()).collect(),
        memory: memory.map(str::to_owned),
        decisions: explicit
            .decisions(scheduler)
            .into_iter()
            .map(decision)
            .collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use prism_lang::{Constants, parse_model, parse_properties, resolve, resolve_properties};

    #[test]
    fn a_scheduler_is_written_in_each_form() {
        let text = "mdp module m x : [0..2]; [risk] x=0 -> 0.4:(x'=1) + 0.6:(x'=2);
            [try] x=0 -> 0.25:(x'=1) + 0.75:(x'=0); endmodule label \"done\" = x=1;";
        let model = resolve(&parse_model(text).tree, &Constants::new()).unwrap();
        let asked = parse_properties("Pmax=? [ F<=2 x=1 ]").tree;
        let asked = resolve_properties(&asked, &model, &Constants::new()).unwrap();
        let space = checker::explore::explore::<f64>(&model).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let written = |name: &str, settings: &str| {
            let path = folder.path().join(name);
            let asked_for = format!("{}{settings}", path.display());
            let (property, options) = (&asked[0].property, Options::default());
            let talk = host::Events::none();
            let output = Output(&|_| Ok(()));
            write_strategy(
                &asked_for, &model, &space, property, &options, &talk, output,
            )
            .unwrap();
            std::fs::read_to_string(path).unwrap()
        };
        assert_eq!(written("plain", ""), "(0),0=try\n(0),1=risk\n");
        assert_eq!(written("indices", ":type=indices"), "0,0=1\n0,1=0\n");
        assert_eq!(written("numbers", ":states=false"), "0,0=try\n0,1=risk\n");
        assert!(written("chain.tra", "").starts_with("# Transitions (DTMC)\n"));
        assert_eq!(written("chain", ":type=induced"), written("chain.tra", ""));
        assert!(written("chain.sta", "").contains("(x,_mem)\n0:(0,0)\n1:(0,1)\n"));
        assert!(written("chain.dot", "").contains("label=\"1\\n(0,1)\""));
        assert!(written("chain.drn", "").contains("@type: DTMC"));
        let json: serde_json::Value = serde_json::from_str(&written("s.json", "")).unwrap();
        assert_eq!(json["decisions"][1]["memory"], 1);
        assert_eq!(json["decisions"][1]["action"], "risk");
    }
}
