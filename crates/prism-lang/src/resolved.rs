//! A model whose names are bound, types checked, constants evaluated, formulas inlined and renamings expanded.
//!
//! # For what explores it
//!
//! Everything is an index: variables, actions and parameters are numbers, a state is a `[i64]`, and no
//! expression has a name left to look up. Guards and updates are typed trees ([`Expr`]) that can be evaluated
//! in any [`Arithmetic`](crate::Arithmetic) or compiled once; [`Parameter`](crate::ExprKind::Parameter)s, if
//! the model was resolved with constants left open, are leaves of their own, so that the same tree gives a
//! number, an exact rational or a rational function.
//!
//! The choices of a state are the same in all model types: for each action of the composition every
//! combination of one enabled command for each module that takes part, and every enabled command without an
//! action. They are alternatives of a scheduler in an `mdp` or `lts`, are drawn uniformly in a `dtmc`, and race
//! in a `ctmc` (where the rates of synchronised commands are multiplied).

mod composition;

pub use composition::Composition;

use crate::ast::Type;
use crate::diagnostic::{Diagnostic, Span};
use crate::expr::{Expr, VarIndex};
use crate::number::Value;

/// The index of an action in [`Model::actions`].
pub type ActionId = usize;

/// The kind of a model that has a meaning here.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ModelType {
    /// Labelled transition system: choices, no probabilities.
    Lts,
    /// Discrete-time Markov chain.
    Dtmc,
    /// Markov decision process.
    Mdp,
    /// Continuous-time Markov chain.
    Ctmc,
}

impl ModelType {
    /// Its name, as in the language (which has no keyword for `lts`).
    pub fn keyword(self) -> &'static str {
        match self {
            Self::Lts => "lts",
            Self::Dtmc => "dtmc",
            Self::Mdp => "mdp",
            Self::Ctmc => "ctmc",
        }
    }

    /// Whether a scheduler chooses what happens.
    pub fn has_choices(self) -> bool {
        matches!(self, Self::Lts | Self::Mdp)
    }

    /// Whether time is a real number, and bounds of temporal operators are times.
    pub fn has_continuous_time(self) -> bool {
        self == Self::Ctmc
    }
}

/// A resolved model.
///
/// A state is a `[i64]` with one value per variable in the order of [`Model::variables`];
/// truth values are 0 and 1.
#[derive(Clone, Debug)]
pub struct Model {
    /// The kind of model.
    pub model_type: ModelType,
    /// All constants with their values, in the order of the text; without those that were left open.
    pub constants: Vec<Constant>,
    /// Constants that were left open, in the order of the text (see [`crate::resolve_open`]).
    pub parameters: Vec<Parameter>,
    /// Global variables, then the local ones module by module, in the order of the text.
    pub variables: Vec<Variable>,
    /// The modules, in the order of the text.
    pub modules: Vec<Module>,
    /// Names of the actions, in the order of first use; those that only `system` introduces come last.
    pub actions: Vec<String>,
    /// How the modules are composed; `None`: all of them, synchronised on every action that they share.
    pub composition: Option<Composition>,
    /// Labels and their definitions.
    pub labels: Vec<(String, Expr)>,
    /// Formulas and their definitions, for use in properties.
    pub formulas: Vec<(String, Expr)>,
    /// Reward structures.
    pub rewards: Vec<RewardStructure>,
    /// Where the model starts.
    pub init: Init,
    /// What was suspicious, but no error.
    pub warnings: Vec<Diagnostic>,
    /// Commands whose probabilities were divided by their sum (see [`crate::resolve_rounded`]).
    pub rounded: Vec<RoundedSum>,
}

/// A command whose probabilities, as they are written, do not sum to 1.
#[derive(Clone, Debug, PartialEq)]
pub struct RoundedSum {
    /// The command.
    pub span: Span,
    /// How far from 1 they sum up, in magnitude; no less than that.
    pub excess: f64,
}

/// A constant and its value.
#[derive(Clone, Debug, PartialEq)]
pub struct Constant {
    /// Its name.
    pub name: String,
    /// Its value.
    pub value: Value,
    /// Its declaration.
    pub span: Span,
}

/// A constant without a value: the results of the model are functions of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Its name.
    pub name: String,
    /// Its type: `int` or `double`.
    pub ty: Type,
    /// Its declaration.
    pub span: Span,
}

/// A variable.
#[derive(Clone, Debug, PartialEq)]
pub struct Variable {
    /// Its name.
    pub name: String,
    /// The module that owns it; none for a global variable.
    pub module: Option<String>,
    /// Its range.
    pub kind: VariableKind,
    /// Its initial value (for `Init::Predicate` models: its least value, 0 if it has none).
    pub init: i64,
    /// Its declaration.
    pub span: Span,
}

/// The range of a variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VariableKind {
    /// 0 or 1.
    Bool,
    /// `low..=high`.
    Int {
        /// Smallest value.
        low: i64,
        /// Largest value.
        high: i64,
    },
    /// Any integer of 64 bits; beyond them is an error, never a wrapped value.
    Unbounded,
}

impl VariableKind {
    /// Smallest and largest value.
    pub fn bounds(self) -> (i64, i64) {
        match self {
            Self::Bool => (0, 1),
            Self::Int { low, high } => (low, high),
            Self::Unbounded => (i64::MIN, i64::MAX),
        }
    }
}

/// A module.
#[derive(Clone, Debug, PartialEq)]
pub struct Module {
    /// Its name.
    pub name: String,
    /// Its commands, in the order of the text.
    pub commands: Vec<Command>,
}

/// A guarded command.
#[derive(Clone, Debug, PartialEq)]
pub struct Command {
    /// The action on which it synchronises, if any.
    pub action: Option<ActionId>,
    /// When it is enabled.
    pub guard: Expr,
    /// What it does, one of these at random.
    pub updates: Vec<Update>,
    /// Its place.
    pub span: Span,
}

/// One outcome of a command.
#[derive(Clone, Debug, PartialEq)]
pub struct Update {
    /// Its probability (a rate in a `ctmc`; 1 in an `lts`).
    pub probability: Expr,
    /// Simultaneous assignments; variables that are not named keep their values.
    pub assignments: Vec<(VarIndex, Expr)>,
    /// Its place.
    pub span: Span,
}

/// A reward structure: what a state earns (for each step, or for each unit of time in a `ctmc`), and what a
/// transition earns. Items add up.
#[derive(Clone, Debug, PartialEq)]
pub struct RewardStructure {
    /// Its name, if it has one.
    pub name: Option<String>,
    /// Its items.
    pub items: Vec<RewardItem>,
}

/// One line of a reward structure.
#[derive(Clone, Debug, PartialEq)]
pub struct RewardItem {
    /// `None` for a state reward, `Some(None)` for transitions without action, `Some(Some(a))` for those of action `a`.
    pub transition: Option<Option<ActionId>>,
    /// Where it is earned.
    pub guard: Expr,
    /// How much.
    pub value: Expr,
    /// Its place.
    pub span: Span,
}

/// Where a model starts.
#[derive(Clone, Debug, PartialEq)]
pub enum Init {
    /// In this state.
    Single(Vec<i64>),
    /// In any state in which this holds.
    Predicate(Expr),
}

impl Model {
    /// The index of a variable.
    pub fn variable(&self, name: &str) -> Option<VarIndex> {
        self.variables.iter().position(|v| v.name == name)
    }

    /// The value of a constant.
    pub fn constant(&self, name: &str) -> Option<&Value> {
        self.constants
            .iter()
            .find(|c| c.name == name)
            .map(|c| &c.value)
    }

    /// The index of the reward structure of this name.
    pub fn reward(&self, name: &str) -> Option<usize> {
        self.rewards
            .iter()
            .position(|r| r.name.as_deref() == Some(name))
    }

    /// The definition of a label.
    pub fn label(&self, name: &str) -> Option<&Expr> {
        self.labels.iter().find(|(n, _)| n == name).map(|(_, e)| e)
    }
}
