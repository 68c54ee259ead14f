//! A formal model with its states, and what the vocabulary's words mean to it.

use crate::problem::{Problem, Source};
use crate::study::{Study, Work};
use crate::talk::Interrupt;
use crate::technique::model_checking::explore;
use checker::state_space::StateSpace;
use prism_lang::{
    Constants, Property, StateFormula, parse_properties, resolve_properties, resolved,
};

/// The most states that a model of an exploration may have.
const MAX_STATES: usize = 5_000_000;

/// A formal model with its states.
pub struct Formal {
    /// The model.
    pub model: resolved::Model,
    /// Its states.
    pub space: StateSpace<f64>,
}

/// What an expression means to a model.
pub enum Meaning {
    /// Where it holds: one flag per state.
    Holds(Vec<bool>),
    /// The model has no such variable or constant.
    Unknown(String),
}

impl Formal {
    /// The model of a ledger's entry, explored.
    pub fn of_entry(study: &Study, id: &str, interrupt: &Interrupt) -> Result<Self, Problem> {
        let Work::Check { model, .. } = &study.entry(id)?.work else {
            return Err(Problem::new(
                "bad-exploration",
                format!("`{id}` is no formal model of this study"),
            )
            .remedy("name an entry of the ledger with a `model`"));
        };
        let source = Source::read(&study.folder.join(model))?;
        let parsed = prism_lang::parse_model(&source.text);
        if let Some(problem) = Problem::from_diagnostics(&source, &parsed.diagnostics) {
            return Err(problem);
        }
        let model = prism_lang::resolve(&parsed.tree, &Constants::new())
            .map_err(|found| first_problem(&source, &found))?;
        let cancel = || interrupt.is_set();
        let space = explore::<f64>(&source, &model, MAX_STATES, &cancel)?;
        Ok(Self { model, space })
    }

    /// Where an expression over the model's variables holds.
    pub fn meaning(&self, text: &str) -> Result<Meaning, Problem> {
        let source = Source {
            name: "<expression>".into(),
            text: text.to_owned(),
        };
        let tree = parse_properties(text)
            .into_result()
            .map_err(|found| first_problem(&source, &found))?;
        let properties = match resolve_properties(&tree, &self.model, &Constants::new()) {
            Ok(properties) => properties,
            Err(found) if found.iter().all(|d| d.code == "unknown-name") => {
                let words: Vec<_> = found.iter().map(|d| d.message.clone()).collect();
                return Ok(Meaning::Unknown(words.join("; ")));
            }
            Err(found) => return Err(first_problem(&source, &found)),
        };
        match properties.first().map(|p| &p.property) {
            Some(Property::State(state)) => self.holds(state).map(Meaning::Holds),
            _ => Err(Problem::new(
                "bad-exploration",
                format!("`{text}` is no expression over the model's variables"),
            )),
        }
    }

    fn holds(&self, formula: &StateFormula) -> Result<Vec<bool>, Problem> {
        let wrong = |error: checker::state_space::StateError| {
            Problem::new("bad-exploration", error.to_string())
        };
        let both = |a: &StateFormula, b: &StateFormula, f: fn(bool, bool) -> bool| {
            let (a, b) = (self.holds(a)?, self.holds(b)?);
            Ok(a.into_iter().zip(b).map(|(a, b)| f(a, b)).collect())
        };
        match formula {
            StateFormula::Expr(expr) => self.space.evaluate(expr).map_err(wrong),
            StateFormula::Label(name) => self.space.label(name).map_err(wrong),
            StateFormula::Not(a) => Ok(self.holds(a)?.into_iter().map(|a| !a).collect()),
            StateFormula::And(a, b) => both(a, b, |a, b| a && b),
            StateFormula::Or(a, b) => both(a, b, |a, b| a || b),
            StateFormula::Implies(a, b) => both(a, b, |a, b| !a || b),
            StateFormula::Iff(a, b) => both(a, b, |a, b| a == b),
            _ => Err(Problem::new(
                "bad-exploration",
                "a probability is no expression over the model's variables",
            )),
        }
    }
}

fn first_problem(source: &Source, found: &[prism_lang::Diagnostic]) -> Problem {
    Problem::from_diagnostics(source, found).unwrap_or_else(|| {
        let words: Vec<_> = found.iter().map(|d| d.message.clone()).collect();
        Problem::new("cannot-resolve", words.join("; "))
    })
}
