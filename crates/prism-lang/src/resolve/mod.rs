//! From syntax trees to meaning: names bound, types checked, constants evaluated, formulas inlined, module
//! renamings expanded, ranges known (PRISM manual, section "The PRISM language").
//!
//! All mistakes are collected. Deviations from PRISM: constants are evaluated exactly (`1-0.95` is one
//! twentieth); the constant probabilities of a command must sum to 1 to within 1e-12 (PRISM: 1e-5, and it
//! rescales them silently).

mod checks;
mod composition;
mod constants;
mod expression;
mod filters;
mod formula;
mod model_type;
mod modules;
mod properties;
mod queries;
mod rewards;
mod scope;
mod temporal;
mod variables;

use std::collections::{BTreeMap, BTreeSet, HashSet};

use crate::ast::{self, Type};
use crate::diagnostic::{Diagnostic, Diagnostics, Span};
use crate::expr::Expr;
use crate::number::Constants;
use crate::resolved::{Constant, Init, Model, Parameter, RoundedSum, Variable};
pub use properties::resolve_properties;
use scope::{Renaming, Scope, Symbol};

/// Gives a model its meaning.
///
/// `given` sets constants that the model leaves undefined; names that the model does not declare are ignored
/// (they may belong to the properties, see [`resolve_properties`]).
///
/// # Errors
/// All mistakes that were found, in the order of their places; warnings among them.
///
/// ```
/// use prism_lang::{Constants, parse_model, resolve};
/// let text = "dtmc const double p; module m x : [0..1]; [] x=0 -> p:(x'=1) + 1-p:true; endmodule";
/// let model = resolve(&parse_model(text).tree, &Constants::parse("p=0.25")?).unwrap();
/// assert_eq!(model.variables[0].name, "x");
/// # Ok::<(), prism_lang::ConstantsError>(())
/// ```
pub fn resolve(model: &ast::Model, given: &Constants) -> Result<Model, Diagnostics> {
    resolve_with(model, given, &Constants::new())
}

/// Like [`resolve`], but `overrides` replace the values of constants that the model defines.
///
/// # Errors
/// As for [`resolve`]; also if a constant in `overrides` is not declared.
pub fn resolve_with(
    model: &ast::Model,
    given: &Constants,
    overrides: &Constants,
) -> Result<Model, Diagnostics> {
    resolve_open(model, given, overrides, &[])
}

/// Like [`resolve_with`], but the constants named in `open` get no value: they are the model's
/// [`parameters`](Model::parameters), and expressions keep them as [`ExprKind::Parameter`](crate::ExprKind).
/// States must not depend on them.
///
/// # Errors
/// As for [`resolve_with`]; also if a name in `open` is no constant of the model, is one of type `bool`, or if a
/// range, an initial value, a guard or an assigned value depends on it.
///
/// ```
/// use prism_lang::{Constants, parse_model, resolve_open};
/// let text = "dtmc const double p; module m x : [0..1]; [] x=0 -> p:(x'=1) + 1-p:true; endmodule";
/// let none = Constants::new();
/// let model = resolve_open(&parse_model(text).tree, &none, &none, &["p"]).unwrap();
/// assert_eq!(model.parameters[0].name, "p");
/// assert!(model.modules[0].commands[0].updates[0].probability.has_parameters());
/// ```
pub fn resolve_open(
    model: &ast::Model,
    given: &Constants,
    overrides: &Constants,
    open: &[&str],
) -> Result<Model, Diagnostics> {
    resolve_all(model, given, overrides, open, None)
}

/// Like [`resolve`], but constant probabilities of a command that sum to 1 only to within `tolerance` are divided by their
/// sum, which [`Model::rounded`] tells: numbers of a few digits, such as 0.333333 three times (PRISM's switch `-sumroundoff`).
/// What is meant may be any distribution near them, so that answers about the model are not exact answers about what is
/// meant.
///
/// # Errors
/// As for [`resolve`].
///
/// ```
/// use prism_lang::{Constants, parse_model, resolve, resolve_rounded};
/// let text = "dtmc module m x : [0..2];
///     [] x=0 -> 0.333333:(x'=0) + 0.333333:(x'=1) + 0.333333:(x'=2); endmodule";
/// let tree = parse_model(text).tree;
/// assert!(resolve(&tree, &Constants::new()).is_err());
/// let model = resolve_rounded(&tree, &Constants::new(), 1e-5).unwrap();
/// assert_eq!(model.modules[0].commands[0].updates[0].probability.eval_number::<f64>(&[0])?, 1.0 / 3.0);
/// assert!(model.rounded[0].excess >= 1e-6);
/// # Ok::<(), prism_lang::EvalError>(())
/// ```
pub fn resolve_rounded(
    model: &ast::Model,
    given: &Constants,
    tolerance: f64,
) -> Result<Model, Diagnostics> {
    resolve_all(model, given, &Constants::new(), &[], Some(tolerance))
}

fn resolve_all(
    model: &ast::Model,
    given: &Constants,
    overrides: &Constants,
    open: &[&str],
    sum_tolerance: Option<f64>,
) -> Result<Model, Diagnostics> {
    let mut resolver = Resolver {
        scope: Scope::new(),
        variables: Vec::new(),
        owners: Vec::new(),
        actions: Vec::new(),
        action_ids: BTreeMap::new(),
        parameters: Vec::new(),
        has_init: model.init.is_some(),
        has_rates: matches!(model.model_type, Some((ast::ModelType::Ctmc, _))),
        has_intervals: false,
        sum_tolerance,
        rounded: Vec::new(),
    };
    resolver.open_parameters(model, open);
    resolver.unknown_overrides(model, overrides);
    let resolved = resolver.model(model, given, overrides);
    let mut diagnostics = resolver.scope.diagnostics;
    diagnostics.sort_by_key(|d| (d.span.start, d.span.end));
    // What is wrong in a module is wrong in its copies.
    let mut told: HashSet<Diagnostic> = HashSet::new();
    diagnostics.retain(|diagnostic| told.insert(diagnostic.clone()));
    // Nothing is gained by giving values to what is not supported.
    if diagnostics.iter().any(|d| d.code == "unsupported") {
        diagnostics.retain(|d| d.code != "undefined-constant");
    }
    if diagnostics.iter().any(Diagnostic::is_error) {
        return Err(diagnostics.into());
    }
    match resolved {
        Some(mut model) => {
            model.warnings = diagnostics;
            Ok(model)
        }
        // What the parser could not read leaves no diagnostic here.
        None => Err(vec![unreadable()].into()),
    }
}

fn unreadable() -> Diagnostic {
    let message = "part of the text could not be read.";
    Diagnostic::error("unreadable", Span::default(), message)
        .remedy("Correct what the parser reported first.")
}

/// What is known of a model so far.
struct Resolver<'a> {
    scope: Scope<'a>,
    variables: Vec<Variable>,
    /// For each variable: the index of its module; none if it is global.
    owners: Vec<Option<usize>>,
    actions: Vec<String>,
    action_ids: BTreeMap<String, usize>,
    parameters: Vec<Parameter>,
    has_init: bool,
    /// Whether updates have rates (else probabilities).
    has_rates: bool,
    /// Whether some probability is an interval.
    has_intervals: bool,
    /// Up to which distance from 1 the probabilities of a command are divided by their sum.
    sum_tolerance: Option<f64>,
    rounded: Vec<RoundedSum>,
}

impl<'a> Resolver<'a> {
    fn model(
        &mut self,
        model: &'a ast::Model,
        given: &Constants,
        overrides: &Constants,
    ) -> Option<Model> {
        self.scope
            .declare_constants(&model.constants, given, overrides, &self.parameters);
        for formula in &model.formulas {
            let symbol = Symbol::FormulaDefinition(formula);
            self.scope
                .declare(&formula.name.text, Some(formula.name.span), symbol);
        }
        let instances = self.instances(&model.modules, &model.formulas);
        self.declare_variables(&model.globals, &instances);
        let constants = self.constants(&model.constants);
        let values = self.ranges(&model.globals, &instances);
        let formulas = self.formulas(&model.formulas);
        let modules = self.modules(&instances);
        let model_type = self.model_type(model);
        let labels = self.labels(&model.labels);
        let composition = self.composition(&model.systems, &instances);
        let rewards = self.rewards(&model.rewards);
        let init = self.init(model.init.as_ref(), values);
        self.check_names(model);
        self.check_observables(model);
        let (modules, init, composition) = (modules?, init?, composition?);
        if composition.is_none() {
            self.check_synchronisation(&modules);
        }
        Some(Model {
            model_type: model_type?,
            constants: constants?,
            parameters: std::mem::take(&mut self.parameters),
            composition,
            variables: std::mem::take(&mut self.variables),
            modules,
            actions: std::mem::take(&mut self.actions),
            labels: labels?,
            formulas: formulas?,
            rewards: rewards?,
            init,
            warnings: Vec::new(),
            rounded: std::mem::take(&mut self.rounded),
        })
    }

    fn unknown_overrides(&mut self, model: &ast::Model, overrides: &Constants) {
        for name in overrides.0.keys() {
            if model.constants.iter().any(|c| c.name.text == *name) {
                continue;
            }
            let known = model.constants.iter().map(|c| c.name.text.as_str());
            let remedy = match crate::suggest::suggest(name, known) {
                Some(near) => format!("Did you mean `{near}`?"),
                None => "Declare it in the model, or do not set it.".to_owned(),
            };
            let message = format!("the model has no constant `{name}` to set.");
            let error = Diagnostic::error("unknown-constant", Span::default(), message);
            self.scope.report(error.remedy(remedy));
        }
    }

    fn constants(&mut self, constants: &'a [ast::Constant]) -> Option<Vec<Constant>> {
        let mut resolved = Some(Vec::new());
        for constant in constants {
            match (self.scope.constant(constant), &mut resolved) {
                (Some(Some(value)), Some(known)) => known.push(Constant {
                    name: constant.name.text.clone(),
                    value,
                    span: constant.span,
                }),
                (None, _) => resolved = None,
                _ => {}
            }
        }
        resolved
    }

    fn formulas(&mut self, formulas: &'a [ast::Formula]) -> Option<Vec<(String, Expr)>> {
        let resolved: Vec<Option<(String, Expr)>> = formulas
            .iter()
            .map(|f| Some((f.name.text.clone(), self.scope.formula(f)?)))
            .collect();
        resolved.into_iter().collect()
    }

    fn labels(&mut self, labels: &'a [ast::Label]) -> Option<Vec<(String, Expr)>> {
        let resolved: Vec<Option<(String, Expr)>> = labels
            .iter()
            .map(|label| {
                let what = format!("label \"{}\"", label.name.text);
                let none = Renaming::default();
                let body = self.scope.closed(&label.body, &none, Type::Bool, &what)?;
                Some((label.name.text.clone(), body))
            })
            .collect();
        resolved.into_iter().collect()
    }

    fn init(&mut self, predicate: Option<&'a ast::Expr>, values: Option<Vec<i64>>) -> Option<Init> {
        match predicate {
            None => values.map(Init::Single),
            Some(predicate) => {
                let none = Renaming::default();
                let what = "the predicate of `init`";
                let predicate = self.scope.closed(predicate, &none, Type::Bool, what)?;
                values.map(|_| Init::Predicate(predicate))
            }
        }
    }

    /// Reports labels and modules that are declared twice, and labels that PRISM defines itself.
    fn check_names(&mut self, model: &ast::Model) {
        let labels = model.labels.iter().map(|l| (&l.name, "label"));
        let modules = model.modules.iter().map(|m| (&m.name, "module"));
        let mut seen: BTreeSet<(&str, &str)> = BTreeSet::new();
        for (name, what) in labels.chain(modules) {
            let built_in = what == "label" && matches!(name.text.as_str(), "init" | "deadlock");
            if built_in {
                let message = format!("the label \"{}\" is built in.", name.text);
                let error = Diagnostic::error("duplicate-name", name.span, message);
                self.scope.report(error.remedy("Choose another name."));
            } else if !seen.insert((what, &name.text)) {
                let message = format!("there are two {what}s with the name `{}`.", name.text);
                let error = Diagnostic::error("duplicate-name", name.span, message);
                self.scope.report(error.remedy("Choose another name."));
            }
        }
    }
}
