//! Properties: state and path formulas told apart, labels found, bounds computed.

use std::collections::BTreeMap;

use super::checks::is_probability;
use super::scope::{Renaming, Scope, Symbol};
use super::unreadable;
use crate::ast::{self, BinaryOp, Comparison, ExprKind, StepBound, TemporalOp, Type, UnaryOp};
use crate::diagnostic::{Diagnostic, Span};
use crate::number::{Constants, Number, Value};
use crate::property::{NamedProperty, Path, Property, StateFormula, TimeBound};
use crate::resolved::Model;
use crate::suggest::suggest;

/// Gives properties their meaning over a model.
///
/// `given` sets undefined constants of the property file; a name that neither the file nor the model
/// declares is reported. Labels and formulas of the file are written out; labels of the model keep their name.
/// A quoted name may also refer to an earlier property of the file that is a state formula.
///
/// # Errors
/// All mistakes that were found, in the order of their places.
///
/// ```
/// use prism_lang::{Constants, Property, parse_model, parse_properties, resolve, resolve_properties};
/// let model = parse_model("dtmc module m x : [0..1]; [] true -> (x'=1-x); endmodule");
/// let model = resolve(&model.tree, &Constants::new()).unwrap();
/// let file = parse_properties("P=? [ F<=3 x=1 ]");
/// let properties = resolve_properties(&file.tree, &model, &Constants::new()).unwrap();
/// assert!(matches!(properties[0].property, Property::Probability { bound: None, .. }));
/// ```
pub fn resolve_properties(
    properties: &ast::PropertyFile,
    model: &Model,
    given: &Constants,
) -> Result<Vec<NamedProperty>, Vec<Diagnostic>> {
    let mut resolver = PropertyResolver {
        scope: model_scope(model),
        model,
        labels: BTreeMap::new(),
        named: BTreeMap::new(),
    };
    resolver.unknown_constants(properties, given);
    resolver.declarations(properties, given);
    let resolved: Vec<Option<NamedProperty>> = properties
        .properties
        .iter()
        .map(|p| resolver.named_property(p))
        .collect();
    let mut diagnostics = resolver.scope.diagnostics;
    if !diagnostics.is_empty() {
        diagnostics.sort_by_key(|d| (d.span.start, d.span.end));
        return Err(diagnostics);
    }
    let resolved: Option<Vec<_>> = resolved.into_iter().collect();
    resolved.ok_or_else(|| vec![unreadable()])
}

/// The names that a model gives to its properties.
fn model_scope<'a>(model: &Model) -> Scope<'a> {
    let mut scope = Scope::new();
    for constant in &model.constants {
        let symbol = Symbol::Constant(constant.value.clone());
        scope.declare(&constant.name, None, symbol);
    }
    for (name, body) in &model.formulas {
        scope.declare(name, None, Symbol::Formula(body.clone()));
    }
    for (index, variable) in model.variables.iter().enumerate() {
        let ty = match variable.kind {
            crate::resolved::VariableKind::Bool => Type::Bool,
            crate::resolved::VariableKind::Int { .. } => Type::Int,
        };
        scope.declare(&variable.name, None, Symbol::Variable(index, ty));
    }
    scope
}

struct PropertyResolver<'a> {
    scope: Scope<'a>,
    model: &'a Model,
    /// Labels of the property file; `None` if one is wrong.
    labels: BTreeMap<&'a str, Option<crate::Expr>>,
    /// Earlier properties by name; `None` if one is no state formula.
    named: BTreeMap<&'a str, Option<StateFormula>>,
}

/// A formula of either kind.
enum Formula {
    State(StateFormula),
    Path(Path),
}

impl Formula {
    fn into_path(self) -> Path {
        match self {
            Self::State(state) => Path::State(Box::new(state)),
            Self::Path(path) => path,
        }
    }
}

impl<'a> PropertyResolver<'a> {
    fn unknown_constants(&mut self, file: &ast::PropertyFile, given: &Constants) {
        let of_model = self.model.constants.iter().map(|c| c.name.as_str());
        let of_file = file.constants.iter().map(|c| c.name.text.as_str());
        let known: Vec<&str> = of_model.chain(of_file).collect();
        for name in given.0.keys().filter(|n| !known.contains(&n.as_str())) {
            let remedy = match suggest(name, known.iter().copied()) {
                Some(near) => format!("Did you mean `{near}`?"),
                None => "Declare it, or do not give it a value.".to_owned(),
            };
            let message = format!("neither the model nor the properties have a constant `{name}`.");
            let error = Diagnostic::error("unknown-constant", Span::default(), message);
            self.scope.report(error.remedy(remedy));
        }
    }

    fn declarations(&mut self, file: &'a ast::PropertyFile, given: &Constants) {
        self.scope
            .declare_constants(&file.constants, given, &Constants::new());
        for formula in &file.formulas {
            let symbol = Symbol::FormulaDefinition(formula);
            self.scope
                .declare(&formula.name.text, Some(formula.name.span), symbol);
        }
        for constant in &file.constants {
            self.scope.constant(constant);
        }
        for formula in &file.formulas {
            self.scope.formula(formula);
        }
        for label in &file.labels {
            let name = label.name.text.as_str();
            let known = self.labels.contains_key(name)
                || self.model.label(name).is_some()
                || matches!(name, "init" | "deadlock");
            if known {
                let message = format!("there is already a label \"{name}\".");
                let error = Diagnostic::error("duplicate-name", label.name.span, message);
                self.scope.report(error.remedy("Choose another name."));
                continue;
            }
            let what = format!("label \"{name}\"");
            let body = self
                .scope
                .typed(&label.body, &Renaming::default(), Type::Bool, &what);
            self.labels.insert(name, body);
        }
    }

    fn named_property(&mut self, property: &'a ast::Property) -> Option<NamedProperty> {
        let meaning = self.property(&property.formula);
        if let Some(name) = &property.name {
            let state = match &meaning {
                Some(Property::State(state)) => Some(state.clone()),
                Some(Property::Probability {
                    bound: Some(bound),
                    path,
                }) => Some(StateFormula::Probability {
                    bound: bound.clone(),
                    path: Box::new(path.clone()),
                }),
                _ => None,
            };
            if self.named.insert(&name.text, state).is_some() {
                let message = format!("there are two properties with the name \"{}\".", name.text);
                let error = Diagnostic::error("duplicate-name", name.span, message);
                self.scope.report(error.remedy("Choose another name."));
            }
        }
        Some(NamedProperty {
            name: property.name.as_ref().map(|n| n.text.clone()),
            text: property.text.clone(),
            span: property.span,
            property: meaning?,
        })
    }

    fn property(&mut self, formula: &'a ast::Expr) -> Option<Property> {
        if let ExprKind::Probability { bound, path } = &formula.kind {
            let bound = match bound {
                None => None,
                Some((comparison, bound)) => Some((*comparison, self.probability_bound(bound)?)),
            };
            let path = self.formula(path)?.into_path();
            return Some(Property::Probability { bound, path });
        }
        match self.formula(formula)? {
            Formula::State(state) => Some(Property::State(state)),
            // The parser has reported the temporal operator outside of `P`.
            Formula::Path(_) => None,
        }
    }

    /// The exact bound of a probability.
    fn probability_bound(&mut self, bound: &'a ast::Expr) -> Option<Number> {
        let none = Renaming::default();
        let what = "the bound of a probability";
        let Some(Value::Double(number)) =
            self.scope.constant_value(bound, &none, Type::Double, what)
        else {
            return None;
        };
        if !is_probability(&number) {
            let message = format!("the bound {number} is not between 0 and 1.");
            let error = Diagnostic::error("not-a-probability", bound.span, message);
            self.scope
                .report(error.remedy("Compare with a number between 0 and 1."));
            return None;
        }
        Some(number)
    }

    fn formula(&mut self, expr: &'a ast::Expr) -> Option<Formula> {
        if is_plain(expr) {
            let none = Renaming::default();
            let predicate = self.scope.typed(expr, &none, Type::Bool, "a formula")?;
            return Some(Formula::State(StateFormula::Expr(predicate)));
        }
        match &expr.kind {
            ExprKind::Label(name) => self.label(name, expr.span).map(Formula::State),
            ExprKind::Unary(UnaryOp::Not, operand) => Some(match self.formula(operand)? {
                Formula::State(state) => Formula::State(StateFormula::Not(Box::new(state))),
                Formula::Path(path) => Formula::Path(Path::Not(Box::new(path))),
            }),
            ExprKind::Binary(operator, a, b) => self.connective(*operator, a, b, expr.span),
            ExprKind::Probability { bound, path } => {
                self.nested_probability(bound.as_ref(), path, expr.span)
            }
            ExprKind::Temporal {
                operator,
                bound,
                left,
                right,
            } => self.temporal(
                *operator,
                bound.as_deref(),
                left.as_deref(),
                right,
                expr.span,
            ),
            ExprKind::Error => None,
            _ => {
                self.not_a_connective(expr.span);
                None
            }
        }
    }

    fn connective(
        &mut self,
        operator: BinaryOp,
        a: &'a ast::Expr,
        b: &'a ast::Expr,
        span: Span,
    ) -> Option<Formula> {
        type Join<T> = fn(Box<T>, Box<T>) -> T;
        let (of_states, of_paths): (Join<StateFormula>, Join<Path>) = match operator {
            BinaryOp::And => (StateFormula::And, Path::And),
            BinaryOp::Or => (StateFormula::Or, Path::Or),
            BinaryOp::Implies => (StateFormula::Implies, Path::Implies),
            BinaryOp::Iff => (StateFormula::Iff, Path::Iff),
            _ => {
                self.not_a_connective(span);
                return None;
            }
        };
        let (a, b) = (self.formula(a), self.formula(b));
        Some(match (a?, b?) {
            (Formula::State(a), Formula::State(b)) => {
                Formula::State(of_states(Box::new(a), Box::new(b)))
            }
            (a, b) => Formula::Path(of_paths(Box::new(a.into_path()), Box::new(b.into_path()))),
        })
    }

    fn not_a_connective(&mut self, span: Span) {
        let message = "labels, `P` and temporal operators can only be joined by `!`, `&`, `|`, `=>` and `<=>`.";
        let error = Diagnostic::error("property-in-expression", span, message);
        self.scope.report(error.remedy(
            "Write the condition itself in place of a label, and a bound such as `P>=0.9` in place of `P=?`.",
        ));
    }

    fn nested_probability(
        &mut self,
        bound: Option<&'a (Comparison, Box<ast::Expr>)>,
        path: &'a ast::Expr,
        span: Span,
    ) -> Option<Formula> {
        let Some((comparison, bound)) = bound else {
            let message = "`P=?` has a number as its value and cannot be part of another formula.";
            let error = Diagnostic::error("nested-query", span, message);
            self.scope
                .report(error.remedy("Give it a bound, such as `P>=0.9`."));
            return None;
        };
        let bound = (*comparison, self.probability_bound(bound)?);
        let path = Box::new(self.formula(path)?.into_path());
        Some(Formula::State(StateFormula::Probability { bound, path }))
    }

    fn label(&mut self, name: &'a str, span: Span) -> Option<StateFormula> {
        if let Some(body) = self.labels.get(name) {
            return body.clone().map(StateFormula::Expr);
        }
        if self.model.label(name).is_some() || matches!(name, "init" | "deadlock") {
            return Some(StateFormula::Label(name.to_owned()));
        }
        match self.named.get(name) {
            Some(Some(state)) => return Some(state.clone()),
            Some(None) => {
                let message = format!("the property \"{name}\" has a number as its value.");
                let error = Diagnostic::error("nested-query", span, message);
                self.scope.report(
                    error.remedy("Refer to a property with a bound, such as `P>=0.9 [ ... ]`."),
                );
                return None;
            }
            None => {}
        }
        let of_model = self.model.labels.iter().map(|(n, _)| n.as_str());
        let known = of_model
            .chain(self.labels.keys().copied())
            .chain(["init", "deadlock"]);
        let remedy = match suggest(name, known) {
            Some(near) => format!("Did you mean \"{near}\"?"),
            None => format!("Define it with `label \"{name}\" = ...;`."),
        };
        let message = format!("there is no label \"{name}\".");
        self.scope
            .report(Diagnostic::error("unknown-label", span, message).remedy(remedy));
        None
    }

    fn temporal(
        &mut self,
        operator: TemporalOp,
        bound: Option<&'a StepBound>,
        left: Option<&'a ast::Expr>,
        right: &'a ast::Expr,
        span: Span,
    ) -> Option<Formula> {
        let time = match bound {
            None => Some(TimeBound::default()),
            Some(_) if operator == TemporalOp::Next => {
                let message = "`X` cannot have a bound.";
                let error = Diagnostic::error("bounded-next", span, message);
                self.scope
                    .report(error.remedy("Write `F=k` for a formula at exactly step k."));
                None
            }
            Some(bound) => self.time_bound(bound, span),
        };
        let left = left.map(|l| self.formula(l).map(|l| Box::new(l.into_path())));
        let right = self.formula(right).map(|r| Box::new(r.into_path()));
        let (bound, right) = (time?, right?);
        let operand = right.clone();
        let path = match (operator, left) {
            (TemporalOp::Next, _) => Path::Next(right),
            (TemporalOp::Finally, _) => Path::Finally { operand, bound },
            (TemporalOp::Globally, _) => Path::Globally { operand, bound },
            (TemporalOp::Until, Some(left)) => Path::Until {
                left: left?,
                right,
                bound,
            },
            (TemporalOp::WeakUntil, Some(left)) => Path::WeakUntil {
                left: left?,
                right,
                bound,
            },
            (TemporalOp::Release, Some(left)) => Path::Release {
                left: left?,
                right,
                bound,
            },
            (_, None) => return None,
        };
        Some(Formula::Path(path))
    }

    fn time_bound(&mut self, bound: &'a StepBound, span: Span) -> Option<TimeBound> {
        let mut time = TimeBound::default();
        match bound {
            StepBound::Compare(comparison, steps) => {
                let steps = self.steps(steps)?;
                match comparison {
                    Comparison::Less => time.upper = Some((steps, true)),
                    Comparison::LessEqual => time.upper = Some((steps, false)),
                    Comparison::Greater => time.lower = Some((steps, true)),
                    Comparison::GreaterEqual => time.lower = Some((steps, false)),
                }
            }
            StepBound::Exactly(steps) => {
                let steps = self.steps(steps)?;
                time.lower = Some((steps, false));
                time.upper = Some((steps, false));
            }
            StepBound::Between(low, high) => {
                let (low, high) = (self.steps(low), self.steps(high));
                time.lower = Some((low?, false));
                time.upper = Some((high?, false));
            }
        }
        let empty = match time.upper {
            Some((0, true)) => true,
            Some(_) => time
                .last_step()
                .is_some_and(|last| last < time.first_step()),
            None => false,
        };
        if empty {
            let message = "no step satisfies this bound.";
            let error = Diagnostic::error("empty-bound", span, message);
            self.scope
                .report(error.remedy("Write the smaller number of steps first."));
            return None;
        }
        Some(time)
    }

    fn steps(&mut self, steps: &'a ast::Expr) -> Option<i64> {
        let none = Renaming::default();
        let Some(Value::Int(value)) =
            self.scope
                .constant_value(steps, &none, Type::Int, "a number of steps")
        else {
            return None;
        };
        if value < 0 {
            let message = format!("a number of steps cannot be negative, but this is {value}.");
            let error = Diagnostic::error("negative-steps", steps.span, message);
            self.scope.report(error.remedy("Use 0 or more."));
            return None;
        }
        Some(value)
    }
}

/// Whether an expression is about variables only.
fn is_plain(expr: &ast::Expr) -> bool {
    match &expr.kind {
        ExprKind::Label(_) | ExprKind::Probability { .. } | ExprKind::Temporal { .. } => false,
        ExprKind::Unary(_, a) => is_plain(a),
        ExprKind::Binary(_, a, b) => is_plain(a) && is_plain(b),
        ExprKind::IfThenElse(a, b, c) => is_plain(a) && is_plain(b) && is_plain(c),
        ExprKind::Call(_, arguments) => arguments.iter().all(is_plain),
        _ => true,
    }
}
