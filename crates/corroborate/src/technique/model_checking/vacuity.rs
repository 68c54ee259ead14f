//! Properties that say nothing of a model, because no run of any model with its variables could make them false, or true.
//!
//! # Definition
//! The greatest state formulas of a path formula are its atoms. Their joint values are those that they have for some values
//! of their variables, each within its declared range and one step beyond either end: what the range alone excludes (`x <=
//! 9` of `x : [0..9]`) says something of the model, since an update out of range is an error. A *free* model begins with
//! the values that the atoms have in the model's initial state, and may go from any joint values to any. The path formula
//! is constant if all paths of the free model satisfy it, or none does: its least probability over all schedulers is 1, or
//! its greatest 0. Of a conditional probability the same is asked of "if the condition holds, so does the formula".
//!
//! An atom without variables is what the model's author says, for example that a failure cannot happen; a formula with such an
//! atom is none of these.
//!
//! # Deviation
//! Nothing is said where the variables have more than [`MAX_VALUATIONS`] valuations, where there are more than
//! [`MAX_ATOMS`] atoms or [`MAX_VALUES`] joint values, and of bounds in continuous time.
//!
//! # Assumes
//! Nothing of the data.
//!
//! # Guarantee
//! What is said to be constant is: all joint values are tried, and probabilities of 0 and 1 are found on the graph.

use super::answer::answer;
use checker::state_space::StateSpace;
use diagnostic::Source;
use prism_lang::property::{Path, Quantity, StateFormula};
use prism_lang::resolved::{Init, Model, VariableKind};
use prism_lang::{Constants, Expr, Property, TimeBound, VarIndex};
use query::explore;
use std::collections::BTreeSet;
use study::Method;

/// Valuations of the variables that are tried at most.
const MAX_VALUATIONS: u64 = 100_000;
/// Atoms and joint values of them, at most.
const MAX_ATOMS: usize = 6;
const MAX_VALUES: usize = 32;

/// The one truth value that the path formula of a property has on all runs that satisfy the condition, of all models with
/// these variables; `None` if it has both, or may have.
pub(super) fn constant_truth(
    property: &Property,
    condition: Option<&Property>,
    model: &Model,
) -> Option<bool> {
    let (path, own) = parts(property)?;
    let condition = match condition {
        Some(condition) => Some(parts(condition)?.0),
        None => own,
    };
    let mut free = Free::default();
    let asked = free.text(path)?;
    let given = match condition {
        Some(condition) => Some(free.text(condition)?),
        None => None,
    };
    let free = free.built(model)?;
    let holds = |path: &str| free.is_certain(path);
    let (always, never) = match &given {
        None => (asked.clone(), format!("!({asked})")),
        Some(given) => (
            format!("(!({given})) | ({asked})"),
            format!("(!({given})) | !({asked})"),
        ),
    };
    match (holds(&always)?, holds(&never)?) {
        (true, false) => Some(true),
        (false, true) => Some(false),
        // The condition cannot hold: that it has probability 0 is said elsewhere.
        (true, true) | (false, false) => None,
    }
}

/// The path formula of a property that asks for a probability, and its own condition.
fn parts(property: &Property) -> Option<(&Path, Option<&Path>)> {
    match property {
        Property::Probability { path, .. } => Some((path, None)),
        Property::Number(Quantity::Probability { path, .. }) => Some((path, None)),
        Property::Number(Quantity::Conditional {
            path, condition, ..
        }) => Some((path, Some(condition))),
        Property::Number(_) | Property::State(_) | Property::Range(_) | Property::Objectives(_) => {
            None
        }
    }
}

/// The atoms that were met.
#[derive(Default)]
struct Free<'p> {
    atoms: Vec<&'p StateFormula>,
}

/// The free model of some atoms.
struct Built {
    model: Model,
    space: StateSpace<f64>,
    labels: String,
}

impl<'p> Free<'p> {
    /// A path formula with its atoms as labels, in the property language.
    fn text(&mut self, path: &'p Path) -> Option<String> {
        Some(match path {
            Path::State(formula) => format!("\"{}\"", self.atom(formula)),
            Path::Not(inner) => format!("!({})", self.text(inner)?),
            Path::And(left, right) => self.both(left, "&", right)?,
            Path::Or(left, right) => self.both(left, "|", right)?,
            Path::Implies(left, right) => self.both(left, "=>", right)?,
            Path::Iff(left, right) => self.both(left, "<=>", right)?,
            Path::Next(inner) => format!("(X ({}))", self.text(inner)?),
            Path::Finally { operand, bound } => {
                format!("(F{} ({}))", in_words(bound), self.text(operand)?)
            }
            Path::Globally { operand, bound } => {
                format!("(G{} ({}))", in_words(bound), self.text(operand)?)
            }
            Path::Until { left, right, bound } => {
                self.both(left, &format!("U{}", in_words(bound)), right)?
            }
            Path::WeakUntil { left, right, bound } => {
                self.both(left, &format!("W{}", in_words(bound)), right)?
            }
            Path::Release { left, right, bound } => {
                self.both(left, &format!("R{}", in_words(bound)), right)?
            }
            Path::Timed { .. } => return None,
        })
    }

    fn both(&mut self, left: &'p Path, operator: &str, right: &'p Path) -> Option<String> {
        let (left, right) = (self.text(left)?, self.text(right)?);
        Some(format!("(({left}) {operator} ({right}))"))
    }

    /// The label of an atom.
    fn atom(&mut self, formula: &'p StateFormula) -> String {
        let known = self.atoms.iter().position(|other| *other == formula);
        let place = known.unwrap_or_else(|| {
            self.atoms.push(formula);
            self.atoms.len() - 1
        });
        format!("atom{place}")
    }

    /// The model in which the atoms take all joint values that they can have, in any order.
    fn built(&self, model: &Model) -> Option<Built> {
        let (mut values, first) = self.joint_values(model)?;
        let start = match first {
            Some(first) => {
                values.insert(first);
                let place = values.iter().position(|it| *it == first)?;
                format!("init v={place} endinit")
            }
            None => "init true endinit".to_owned(),
        };
        if values.len() > MAX_VALUES {
            return None;
        }
        let last = values.len() - 1;
        let moves: String = (0..=last)
            .map(|to| format!("  [] true -> (v'={to});\n"))
            .collect();
        let text = format!("mdp\nmodule free\n  v : [0..{last}];\n{moves}endmodule\n{start}\n");
        let labels = (0..self.atoms.len()).map(|atom| {
            let holding = values
                .iter()
                .enumerate()
                .filter(|(_, it)| **it >> atom & 1 == 1);
            let states: String = holding.map(|(place, _)| format!(" | v={place}")).collect();
            format!("label \"atom{atom}\" = false{states};\n")
        });
        let parsed = prism_lang::parse_model(&text);
        let model = prism_lang::resolve(&parsed.tree, &Constants::new()).ok()?;
        let source = Source::new("free model", text);
        Some(Built {
            labels: labels.collect(),
            space: explore::<f64>(&source, &model, MAX_VALUES, &|| false).ok()?,
            model,
        })
    }

    /// The joint values of the atoms, a bit for each, and those in the initial state where there is one.
    fn joint_values(&self, model: &Model) -> Option<(BTreeSet<u64>, Option<u64>)> {
        if self.atoms.len() > MAX_ATOMS {
            return None;
        }
        let mut variables = BTreeSet::new();
        for atom in &self.atoms {
            let mut own = BTreeSet::new();
            collect(atom, model, &mut own)?;
            if own.is_empty() {
                return None;
            }
            variables.extend(own);
        }
        let domains = domains(&variables, model)?;
        let of = |state: &[i64]| {
            let mut bits = 0_u64;
            for (place, atom) in self.atoms.iter().enumerate() {
                bits |= u64::from(value(atom, model, state)?) << place;
            }
            Some(bits)
        };
        let first = match &model.init {
            Init::Single(begins) => Some(of(begins)?),
            Init::Predicate(_) => None,
        };
        let mut state: Vec<i64> = model.variables.iter().map(|it| it.init).collect();
        for (variable, low, _) in &domains {
            *state.get_mut(*variable)? = *low;
        }
        let mut found = BTreeSet::from([of(&state)?]);
        while next(&mut state, &domains)? {
            found.insert(of(&state)?);
        }
        Some((found, first))
    }
}

impl Built {
    /// Whether all paths satisfy a path formula; `None` if that cannot be found out.
    fn is_certain(&self, path: &str) -> Option<bool> {
        let text = format!("{}Pmin=? [ {path} ]", self.labels);
        let tree = prism_lang::parse_properties(&text).into_result().ok()?;
        let mut properties =
            prism_lang::resolve_properties(&tree, &self.model, &Constants::new()).ok()?;
        let property = properties.pop()?.property;
        let answer = answer(&property, Method::Sound, &self.space, None, &|| false).ok()?;
        Some(answer.value >= 1.0)
    }
}

/// A bound in steps behind its operator.
fn in_words(bound: &TimeBound) -> String {
    let last = bound.last_step();
    match (bound.first_step(), last) {
        (0, None) => String::new(),
        (0, Some(last)) => format!("<={last}"),
        (first, None) => format!(">={first}"),
        (first, Some(last)) => format!("[{first},{last}]"),
    }
}

/// The variables with their ranges and a step beyond either end.
fn domains(variables: &BTreeSet<VarIndex>, model: &Model) -> Option<Vec<(VarIndex, i64, i64)>> {
    let mut domains = Vec::new();
    let mut valuations = 1_u64;
    for variable in variables {
        let (low, high) = match model.variables.get(*variable)?.kind {
            VariableKind::Bool => (0, 1),
            VariableKind::Int { low, high } => (low.checked_sub(1)?, high.checked_add(1)?),
            VariableKind::Unbounded => return None,
        };
        let values = u64::try_from(high.checked_sub(low)?.checked_add(1)?).ok()?;
        valuations = valuations.checked_mul(values)?;
        domains.push((*variable, low, high));
    }
    (valuations <= MAX_VALUATIONS).then_some(domains)
}

/// The next valuation in the order of counting; false after the last.
fn next(state: &mut [i64], domains: &[(VarIndex, i64, i64)]) -> Option<bool> {
    for (variable, low, high) in domains {
        let value = state.get_mut(*variable)?;
        if *value < *high {
            *value += 1;
            return Some(true);
        }
        *value = *low;
    }
    Some(false)
}

/// The variables of a formula; `None` if it depends on more than their values in one state.
fn collect(formula: &StateFormula, model: &Model, into: &mut BTreeSet<VarIndex>) -> Option<()> {
    match formula {
        StateFormula::Expr(expr) => into.extend(expr.variables()),
        StateFormula::Label(name) => into.extend(label(name, model)?.variables()),
        StateFormula::Not(inner) => collect(inner, model, into)?,
        StateFormula::And(left, right)
        | StateFormula::Or(left, right)
        | StateFormula::Implies(left, right)
        | StateFormula::Iff(left, right) => {
            collect(left, model, into)?;
            collect(right, model, into)?;
        }
        StateFormula::Choice(condition, then, otherwise) => {
            for part in [condition, then, otherwise] {
                collect(part, model, into)?;
            }
        }
        _ => return None,
    }
    Some(())
}

fn value(formula: &StateFormula, model: &Model, state: &[i64]) -> Option<bool> {
    let of = |inner: &StateFormula| value(inner, model, state);
    Some(match formula {
        StateFormula::Expr(expr) => expr.eval_bool(state).ok()?,
        StateFormula::Label(name) => label(name, model)?.eval_bool(state).ok()?,
        StateFormula::Not(inner) => !of(inner)?,
        StateFormula::And(left, right) => of(left)? && of(right)?,
        StateFormula::Or(left, right) => of(left)? || of(right)?,
        StateFormula::Implies(left, right) => !of(left)? || of(right)?,
        StateFormula::Iff(left, right) => of(left)? == of(right)?,
        StateFormula::Choice(condition, then, otherwise) => match of(condition)? {
            true => of(then)?,
            false => of(otherwise)?,
        },
        _ => return None,
    })
}

/// A label of the model; none for `init` and `deadlock`, which are no matter of one state's values.
fn label<'m>(name: &str, model: &'m Model) -> Option<&'m Expr> {
    model.label(name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use prism_lang::Constants;

    fn truth(property: &str) -> Option<bool> {
        truth_given(property, None)
    }

    fn truth_given(property: &str, condition: Option<&str>) -> Option<bool> {
        let model = "dtmc\nmodule m\n  s : [0..9] init 0;\n  b : bool init false;\n  [] s<9 -> (s'=s+1);\n  [] s=9 -> true;\n\
                     endmodule\nlabel \"never\" = s=0 & s=2;\nlabel \"end\" = s=9;\n";
        let parsed = prism_lang::parse_model(model);
        let model = prism_lang::resolve(&parsed.tree, &Constants::new()).expect("a model");
        let resolved = |text: &str| {
            let tree = prism_lang::parse_properties(text).into_result();
            let tree = tree.unwrap_or_else(|found| panic!("{text}: {found:?}"));
            let mut properties = prism_lang::resolve_properties(&tree, &model, &Constants::new())
                .unwrap_or_else(|found| panic!("{text}: {found:?}"));
            properties.pop().expect("a property").property
        };
        let condition = condition.map(resolved);
        constant_truth(&resolved(property), condition.as_ref(), &model)
    }

    #[test]
    fn what_no_model_can_violate_or_satisfy_is_found() {
        for (property, expected) in [
            ("P=? [ G !(s=0 & s=2) ]", Some(true)),
            ("P=? [ F \"never\" ]", Some(false)),
            ("P=? [ F<=7 (b | !b) ]", Some(true)),
            ("P=? [ G (\"never\" => (F s=5)) ]", Some(true)),
            ("P=? [ b U \"never\" ]", Some(false)),
            ("P=? [ b U (b | !b) ]", Some(true)),
            ("P=? [ G !\"never\" || F s=3 ]", Some(true)),
            ("P=? [ G (s=1 => s<2) ]", Some(true)),
            // By the operators together.
            ("P=? [ (F s=3) | (G s!=3) ]", Some(true)),
            ("P=? [ G (s=1 => (F s=1)) ]", Some(true)),
            ("P=? [ G (s=1 => (X (b | !b))) ]", Some(true)),
            ("P=? [ s=4 W s!=4 ]", Some(true)),
            ("P=? [ (G s=1) & (F s=2) ]", Some(false)),
            // By where the model begins.
            ("P=? [ F s=0 ]", Some(true)),
            ("P=? [ F<=0 s=4 ]", Some(false)),
        ] {
            assert_eq!(truth(property), expected, "{property}");
        }
    }

    #[test]
    fn what_follows_from_the_condition_is_found() {
        let given = |property, condition| truth_given(property, Some(condition));
        assert_eq!(given("P=? [ F s=3 ]", "P=? [ F s=3 ]"), Some(true));
        assert_eq!(given("P=? [ G s!=3 ]", "P=? [ F s=3 ]"), Some(false));
        assert_eq!(given("P=? [ F s=4 ]", "P=? [ F s=3 ]"), None);
        assert_eq!(truth("P=? [ F s=3 || F (s=3 & b) ]"), Some(true));
        // A condition that cannot hold is another matter.
        assert_eq!(given("P=? [ F s=4 ]", "P=? [ F (s=3 & s=4) ]"), None);
    }

    #[test]
    fn what_some_model_violates_is_not_accused() {
        for property in [
            // The range is kept by no more than the updates.
            "P=? [ G s<=9 ]",
            "P=? [ G s>=0 ]",
            "P=? [ F \"end\" ]",
            "P=? [ G !(s=0 & b) ]",
            "P=? [ F \"deadlock\" ]",
            "P=? [ !b U>=2 (b | !b) ]",
            "P=? [ G (s=1 => (F s=2)) ]",
        ] {
            assert_eq!(truth(property), None, "{property}");
        }
    }
}
