//! What the language can ask and the checker cannot answer yet, each with one sentence.

use prism_lang::property::{Objective, Path, Property, StateFormula};

/// Why a property cannot be checked, before anything is computed; `None` if it can.
///
/// (Whether a method can answer it may still depend on the model: exact arithmetic has no exponentials, several
/// objectives are computed in rational arithmetic only.)
///
/// ```
/// use prism_lang::{Constants, parse_model, parse_properties, resolve, resolve_properties};
/// let text = "mdp module m x : [0..1]; [] true -> (x'=1-x); endmodule rewards [] true : 1; endrewards";
/// let model = resolve(&parse_model(text).tree, &Constants::new()).unwrap();
/// let asked = parse_properties("multi(Pmax=? [ F x=1 ], Pmax=? [ F x=0 ], Pmax=? [ G x=1 ])").tree;
/// let asked = resolve_properties(&asked, &model, &Constants::new()).unwrap();
/// let refused = checker::unsupported(&asked[0].property).unwrap();
/// assert!(refused.starts_with("the curve of more than two objectives (`multi`) cannot be computed yet"));
/// ```
pub fn unsupported(property: &Property) -> Option<String> {
    let Property::Objectives(objectives) = property else {
        return None;
    };
    let free = |objective: &&Objective| matches!(objective, Objective::Optimise(..));
    let free = objectives.iter().filter(free).count();
    (free > 2 || free == 2 && objectives.len() > 2).then(|| sentence(CURVES))
}

/// Why a property cannot be bounded over all chains of an interval model; `None` if it can.
pub(crate) fn unsupported_over_intervals(property: &Property) -> Option<String> {
    let what = match property {
        Property::Probability { path, .. } => in_path(path),
        Property::State(formula) => in_state(formula),
        Property::Number(number) => in_number(number),
        Property::Range(_) => Some(FILTERS),
        Property::Objectives(_) => Some(OBJECTIVES),
    };
    what.map(sentence)
}

fn sentence((what, remedy): Missing) -> String {
    format!("{what} cannot be computed yet: {remedy}")
}

const OBJECTIVES: Missing = ("several objectives (`multi`) over intervals", ASK_EACH);
const CURVES: Missing = (
    "the curve of more than two objectives (`multi`)",
    "give bounds to all but one",
);

/// What is missing, and what to do instead.
type Missing = (&'static str, &'static str);

const ASK_EACH: &str = "ask for each probability on its own";
const ASK_P: &str = "ask for a probability with `P`";
const FILTERS: Missing = (
    "filters (`filter(...)`, `{...}`)",
    "ask for the value in the initial state",
);
const REWARDS: Missing = ("expected rewards (`R`) over intervals", ASK_P);
const LONG_RUN: Missing = ("long-run probabilities (`S`) over intervals", ASK_P);
const CONDITIONAL: Missing = ("conditional probabilities (`||`) over intervals", ASK_EACH);
const SCHEDULERS: Missing = (
    "minimal and maximal probabilities over schedulers",
    "use a model without choices",
);
const ARITHMETIC: Missing = ("arithmetic over properties", ASK_EACH);
const QUANTIFIERS: Missing = (
    "the path quantifiers `A` and `E`",
    "write `P>=1 [ ... ]` for almost all paths, `P>0 [ ... ]` for some",
);

fn in_number(number: &prism_lang::property::Quantity) -> Option<Missing> {
    use prism_lang::property::Quantity;
    Some(match number {
        Quantity::Probability { .. } => SCHEDULERS,
        Quantity::Conditional { .. } => CONDITIONAL,
        Quantity::Reward { .. } => REWARDS,
        Quantity::LongRun(_) => LONG_RUN,
        Quantity::Filter(_) => FILTERS,
        Quantity::Expr(_)
        | Quantity::Minus(_)
        | Quantity::Binary(..)
        | Quantity::Choice(..)
        | Quantity::Call(..) => ARITHMETIC,
    })
}

fn in_state(formula: &StateFormula) -> Option<Missing> {
    match formula {
        StateFormula::Expr(_) | StateFormula::Label(_) => None,
        StateFormula::Not(a) => in_state(a),
        StateFormula::And(a, b)
        | StateFormula::Or(a, b)
        | StateFormula::Implies(a, b)
        | StateFormula::Iff(a, b) => in_state(a).or_else(|| in_state(b)),
        StateFormula::Probability { path, .. } => in_path(path),
        StateFormula::Reward { .. } => Some(REWARDS),
        StateFormula::LongRun { .. } => Some(LONG_RUN),
        StateFormula::ForAll(_) | StateFormula::Exists(_) => Some(QUANTIFIERS),
        StateFormula::SomeScheduler(_) => Some(SCHEDULERS),
        StateFormula::Choice(..) | StateFormula::Compare(..) => Some(ARITHMETIC),
        StateFormula::Filter(_) => Some(FILTERS),
    }
}

fn in_path(path: &Path) -> Option<Missing> {
    match path {
        Path::State(formula) => in_state(formula),
        Path::Not(a) | Path::Next(a) => in_path(a),
        Path::And(a, b) | Path::Or(a, b) | Path::Implies(a, b) | Path::Iff(a, b) => {
            in_path(a).or_else(|| in_path(b))
        }
        Path::Until { left, right, .. }
        | Path::WeakUntil { left, right, .. }
        | Path::Release { left, right, .. } => in_path(left).or_else(|| in_path(right)),
        Path::Finally { operand, .. } | Path::Globally { operand, .. } => in_path(operand),
        Path::Timed { .. } => Some((
            "bounds in continuous time",
            "use a `dtmc` and bounds in steps",
        )),
    }
}
