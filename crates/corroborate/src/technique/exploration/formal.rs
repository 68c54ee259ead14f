//! A formal model with its states, and what the vocabulary's words mean to it.

use checker::state_space::{Csr, StateSpace};
use diagnostic::{Problem, Source};
use host::Cancel;
use prism_lang::{
    Constants, Property, StateFormula, parse_properties, resolve_properties, resolved,
};
use query::explore;
use study::Study;

use std::collections::BTreeSet;

/// The most states that a model of an exploration may have.
const MAX_STATES: usize = 5_000_000;

/// A formal model with its states.
pub struct Formal {
    /// The model.
    pub model: resolved::Model,
    /// Its states.
    pub space: StateSpace<f64>,
    /// Of a model that leaves choices open: from each state the states that some choice leads to.
    by_any_choice: Option<Csr<f64>>,
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
    pub fn of_entry(study: &Study, id: &str, interrupt: &Cancel) -> Result<Self, Problem> {
        let Some(model) = study.entry(id)?.work.model() else {
            return Err(Problem::new(
                "bad-exploration",
                format!("`{id}` is not a formal model of this study"),
            )
            .remedy("name an entry of the ledger with a `model`"));
        };
        // That letters had to be guessed is said where the model is checked.
        let (source, _) = host::files::read_prism(&study.folder.join(model))?;
        let parsed = prism_lang::parse_model(&source.text);
        if let Some(problem) = study::placed::from_diagnostics(&source, &parsed.diagnostics) {
            return Err(problem);
        }
        let model = prism_lang::resolve(&parsed.tree, &Constants::new())
            .map_err(|found| first_problem(&source, &found))?;
        let cancel = || interrupt.is_cancelled();
        let space = explore::<f64>(&source, &model, MAX_STATES, &cancel)?;
        let by_any_choice = by_any_choice(&space);
        Ok(Self {
            model,
            space,
            by_any_choice,
        })
    }

    /// The states that some step leads to from each state, by whichever choice.
    pub fn steps(&self) -> &Csr<f64> {
        self.by_any_choice.as_ref().unwrap_or(&self.space.matrix)
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
                format!("`{text}` is not an expression over the model's variables"),
            )
            .remedy("write a condition, such as `x=1 & y>2`")),
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
                "an expression over the model's variables cannot contain a probability",
            )
            .remedy("write a condition on states, without `P`, `R` or `S`")),
        }
    }
}

fn by_any_choice(space: &StateSpace<f64>) -> Option<Csr<f64>> {
    if space.choice_start.is_empty() {
        return None;
    }
    let rows = (0..space.num_states()).map(|state| {
        let choices = space.choices(state);
        let targets = choices.flat_map(|choice| space.matrix.row(choice));
        let targets = targets.map(|(target, _)| target as u32);
        let targets: BTreeSet<u32> = targets.collect();
        targets.into_iter().map(|target| (target, 1.0)).collect()
    });
    Some(Csr::from_rows(rows.collect()))
}

fn first_problem(source: &Source, found: &[prism_lang::Diagnostic]) -> Problem {
    study::placed::from_diagnostics(source, found).unwrap_or_else(|| {
        let words: Vec<_> = found.iter().map(|d| d.message.clone()).collect();
        Problem::new("cannot-resolve", words.join("; "))
    })
}
