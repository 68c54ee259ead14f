//! A model whose names are bound, types checked, constants evaluated, formulas inlined and renamings expanded.

pub use crate::ast::ModelType;
use crate::diagnostic::{Diagnostic, Span};
use crate::expr::{Expr, VarIndex};
use crate::number::Value;

/// The index of an action in [`Model::actions`].
pub type ActionId = usize;

/// A resolved model.
///
/// A state is a `[i64]` with one value per variable in the order of [`Model::variables`];
/// truth values are 0 and 1.
#[derive(Clone, Debug)]
pub struct Model {
    /// The kind of model.
    pub model_type: ModelType,
    /// All constants with their values, in the order of the text.
    pub constants: Vec<Constant>,
    /// Global variables, then the local ones module by module, in the order of the text.
    pub variables: Vec<Variable>,
    /// The modules, in the order of the text.
    pub modules: Vec<Module>,
    /// Names of the actions, in the order of first use.
    pub actions: Vec<String>,
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

/// A variable.
#[derive(Clone, Debug, PartialEq)]
pub struct Variable {
    /// Its name.
    pub name: String,
    /// The module that owns it; none for a global variable.
    pub module: Option<String>,
    /// Its range.
    pub kind: VariableKind,
    /// Its initial value (for `Init::Predicate` models: its least value).
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
}

impl VariableKind {
    /// Smallest and largest value.
    pub fn bounds(self) -> (i64, i64) {
        match self {
            Self::Bool => (0, 1),
            Self::Int { low, high } => (low, high),
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
    /// Its probability (a rate in a `ctmc`).
    pub probability: Expr,
    /// Simultaneous assignments; variables that are not named keep their values.
    pub assignments: Vec<(VarIndex, Expr)>,
    /// Its place.
    pub span: Span,
}

/// A reward structure; the checker does not evaluate it yet.
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

    /// The definition of a label.
    pub fn label(&self, name: &str) -> Option<&Expr> {
        self.labels.iter().find(|(n, _)| n == name).map(|(_, e)| e)
    }
}
