//! From syntax trees to meaning: names bound, types checked, constants evaluated, formulas inlined, module
//! renamings expanded, ranges known (PRISM manual, section "The PRISM language").
//!
//! All mistakes are collected. Deviations from PRISM: constants are evaluated exactly (`1-0.95` is one
//! twentieth); the constant probabilities of a command must sum to 1 to within 1e-12 (PRISM: 1e-5, and it
//! rescales them silently).

mod checks;
mod expression;
mod modules;
mod properties;
mod scope;

use std::collections::BTreeSet;

use crate::ast::{self, Type};
use crate::diagnostic::{Diagnostic, Span};
use crate::expr::Expr;
use crate::number::{Constants, Value};
use crate::resolved::{Constant, Init, Model, RewardItem, RewardStructure, Variable, VariableKind};
use modules::Instance;
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
pub fn resolve(model: &ast::Model, given: &Constants) -> Result<Model, Vec<Diagnostic>> {
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
) -> Result<Model, Vec<Diagnostic>> {
    let mut resolver = Resolver {
        scope: Scope::new(),
        variables: Vec::new(),
        owners: Vec::new(),
        actions: Vec::new(),
        has_init: model.init.is_some(),
        is_probabilistic: !matches!(
            model.model_type.map(|(t, _)| t),
            Some(ast::ModelType::Ctmc | ast::ModelType::Pta | ast::ModelType::Popta)
        ),
    };
    resolver.unknown_overrides(model, overrides);
    let resolved = resolver.model(model, given, overrides);
    let mut diagnostics = resolver.scope.diagnostics;
    diagnostics.sort_by_key(|d| (d.span.start, d.span.end));
    if diagnostics.iter().any(Diagnostic::is_error) {
        return Err(diagnostics);
    }
    match resolved {
        Some(mut model) => {
            model.warnings = diagnostics;
            Ok(model)
        }
        // What the parser could not read leaves no diagnostic here.
        None => Err(vec![unreadable()]),
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
    has_init: bool,
    /// Whether updates have probabilities (else rates).
    is_probabilistic: bool,
}

impl<'a> Resolver<'a> {
    fn model(
        &mut self,
        model: &'a ast::Model,
        given: &Constants,
        overrides: &Constants,
    ) -> Option<Model> {
        let model_type = self.model_type(model);
        self.scope
            .declare_constants(&model.constants, given, overrides);
        for formula in &model.formulas {
            let symbol = Symbol::FormulaDefinition(formula);
            self.scope
                .declare(&formula.name.text, Some(formula.name.span), symbol);
        }
        let instances = self.instances(&model.modules);
        self.declare_variables(&model.globals, &instances);
        let constants = self.constants(&model.constants);
        let values = self.ranges(&model.globals, &instances);
        let formulas = self.formulas(&model.formulas);
        let modules = self.modules(&instances);
        let labels = self.labels(&model.labels);
        let rewards = self.rewards(&model.rewards);
        let init = self.init(model.init.as_ref(), values);
        self.check_names(model);
        let (modules, init) = (modules?, init?);
        self.check_synchronisation(&modules);
        Some(Model {
            model_type,
            constants: constants?,
            variables: std::mem::take(&mut self.variables),
            modules,
            actions: std::mem::take(&mut self.actions),
            labels: labels?,
            formulas: formulas?,
            rewards: rewards?,
            init,
            warnings: Vec::new(),
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

    fn model_type(&mut self, model: &ast::Model) -> ast::ModelType {
        if let Some((model_type, _)) = model.model_type {
            return model_type;
        }
        let message = "the model does not say what type it has; PRISM takes it as an mdp.";
        let warning = Diagnostic::warning("no-model-type", Span::default(), message);
        self.scope
            .report(warning.remedy("Write `dtmc` in its first line."));
        ast::ModelType::Mdp
    }

    fn constants(&mut self, constants: &'a [ast::Constant]) -> Option<Vec<Constant>> {
        let resolved: Vec<Option<Constant>> = constants
            .iter()
            .map(|constant| {
                let value = self.scope.constant(constant)?;
                Some(Constant {
                    name: constant.name.text.clone(),
                    value,
                    span: constant.span,
                })
            })
            .collect();
        resolved.into_iter().collect()
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
                let body = self.scope.typed(&label.body, &none, Type::Bool, &what)?;
                Some((label.name.text.clone(), body))
            })
            .collect();
        resolved.into_iter().collect()
    }

    fn rewards(&mut self, rewards: &'a [ast::RewardStructure]) -> Option<Vec<RewardStructure>> {
        let mut structures = Vec::new();
        for structure in rewards {
            let items: Vec<Option<RewardItem>> = structure
                .items
                .iter()
                .map(|i| self.reward_item(i))
                .collect();
            structures.push(items.into_iter().collect::<Option<_>>().map(|items| {
                RewardStructure {
                    name: structure.name.as_ref().map(|n| n.text.clone()),
                    items,
                }
            }));
        }
        structures.into_iter().collect()
    }

    fn reward_item(&mut self, item: &'a ast::RewardItem) -> Option<RewardItem> {
        let none = Renaming::default();
        let guard = self
            .scope
            .typed(&item.guard, &none, Type::Bool, "the guard of a reward");
        let value = self
            .scope
            .typed(&item.value, &none, Type::Double, "a reward");
        let transition = match &item.kind {
            ast::RewardKind::State => None,
            ast::RewardKind::Transition(None) => Some(None),
            ast::RewardKind::Transition(Some(name)) => Some(Some(self.known_action(name)?)),
        };
        Some(RewardItem {
            transition,
            guard: guard?,
            value: value?,
        })
    }

    fn known_action(&mut self, name: &ast::Name) -> Option<usize> {
        let known = self.actions.iter().position(|a| *a == name.text);
        if known.is_none() {
            let near = crate::suggest::suggest(&name.text, self.actions.iter().map(String::as_str));
            let remedy = match near {
                Some(near) => format!("Did you mean `{near}`?"),
                None => "Use an action of some command.".to_owned(),
            };
            let message = format!("no command has the action `{}`.", name.text);
            self.scope
                .report(Diagnostic::error("unknown-action", name.span, message).remedy(remedy));
        }
        known
    }

    fn init(&mut self, predicate: Option<&'a ast::Expr>, values: Option<Vec<i64>>) -> Option<Init> {
        match predicate {
            None => values.map(Init::Single),
            Some(predicate) => {
                let none = Renaming::default();
                let what = "the predicate of `init`";
                let predicate = self.scope.typed(predicate, &none, Type::Bool, what)?;
                values.map(|_| Init::Predicate(predicate))
            }
        }
    }

    /// Declares all variables before any expression is read, globals first.
    fn declare_variables(&mut self, globals: &'a [ast::Variable], instances: &[Instance<'a>]) {
        for variable in globals {
            self.declare_variable(&variable.name.text, variable, None);
        }
        for (owner, instance) in instances.iter().enumerate() {
            for variable in instance.variables {
                let name = instance.renaming.apply(&variable.name.text);
                self.declare_variable(name, variable, Some((owner, instance.name)));
            }
        }
    }

    fn declare_variable(
        &mut self,
        name: &str,
        variable: &ast::Variable,
        owner: Option<(usize, &str)>,
    ) {
        let ty = match variable.range {
            ast::VariableRange::Bool => Type::Bool,
            _ => Type::Int,
        };
        let symbol = Symbol::Variable(self.variables.len(), ty);
        self.scope.declare(name, Some(variable.name.span), symbol);
        self.owners.push(owner.map(|(index, _)| index));
        // Range and initial value follow once all names are known.
        self.variables.push(Variable {
            name: name.to_owned(),
            module: owner.map(|(_, module)| module.to_owned()),
            kind: VariableKind::Bool,
            init: 0,
            span: variable.span,
        });
    }

    /// Computes ranges and initial values, in the order of declaration.
    fn ranges(
        &mut self,
        globals: &'a [ast::Variable],
        instances: &[Instance<'a>],
    ) -> Option<Vec<i64>> {
        let none = Renaming::default();
        let local = instances
            .iter()
            .flat_map(|i| i.variables.iter().map(move |v| (v, &i.renaming)));
        let all: Vec<_> = globals.iter().map(|v| (v, &none)).chain(local).collect();
        let mut values = Vec::with_capacity(all.len());
        for (index, (variable, renaming)) in all.into_iter().enumerate() {
            let kind = self.range(variable, renaming);
            let init = kind.and_then(|kind| self.initial_value(variable, renaming, kind));
            if let (Some(kind), Some(init)) = (kind, init) {
                self.variables[index].kind = kind;
                self.variables[index].init = init;
            }
            values.push(init);
        }
        values.into_iter().collect()
    }

    fn range(
        &mut self,
        variable: &'a ast::Variable,
        renaming: &Renaming<'a>,
    ) -> Option<VariableKind> {
        let name = &variable.name.text;
        let (low, high) = match &variable.range {
            ast::VariableRange::Bool => return Some(VariableKind::Bool),
            ast::VariableRange::Int { low, high } => (low, high),
            ast::VariableRange::Unbounded => {
                let message =
                    format!("variable `{name}` has no range, so its states cannot be counted.");
                let error = Diagnostic::error("unsupported", variable.span, message);
                self.scope
                    .report(error.remedy(format!("Give it one: `{name} : [0..100];`.")));
                return None;
            }
            ast::VariableRange::Clock => {
                let message = format!("variable `{name}` is a clock, which is not supported.");
                let error = Diagnostic::error("unsupported", variable.span, message);
                self.scope
                    .report(error.remedy("Count time in steps: `t : [0..100];`."));
                return None;
            }
        };
        let what = format!("the range of `{name}`");
        let bound = |scope: &mut Scope<'a>, e| scope.constant_value(e, renaming, Type::Int, &what);
        let (low_value, high_value) = (bound(&mut self.scope, low), bound(&mut self.scope, high));
        let (Some(Value::Int(low_value)), Some(Value::Int(high_value))) = (low_value, high_value)
        else {
            return None;
        };
        if low_value > high_value {
            let message = format!(
                "the range of `{name}` is empty: {low_value} is greater than {high_value}."
            );
            let error = Diagnostic::error("empty-range", low.span.to(high.span), message);
            self.scope
                .report(error.remedy("Write the smaller bound first."));
            return None;
        }
        Some(VariableKind::Int {
            low: low_value,
            high: high_value,
        })
    }

    fn initial_value(
        &mut self,
        variable: &'a ast::Variable,
        renaming: &Renaming<'a>,
        kind: VariableKind,
    ) -> Option<i64> {
        let (low, high) = kind.bounds();
        let Some(init) = &variable.init else {
            return Some(low);
        };
        let name = &variable.name.text;
        if self.has_init {
            let message = format!(
                "`{name}` has an initial value, but the model also has `init ... endinit`."
            );
            let error = Diagnostic::error("two-inits", init.span, message);
            self.scope.report(error.remedy("Keep one of them."));
            return None;
        }
        let ty = match kind {
            VariableKind::Bool => Type::Bool,
            VariableKind::Int { .. } => Type::Int,
        };
        let what = format!("the initial value of `{name}`");
        let value = match self.scope.constant_value(init, renaming, ty, &what)? {
            Value::Bool(value) => i64::from(value),
            Value::Int(value) => value,
            Value::Double(_) => return None,
        };
        if value < low || value > high {
            let message =
                format!("the initial value {value} of `{name}` is not in its range {low}..{high}.");
            let error = Diagnostic::error("init-out-of-range", init.span, message);
            self.scope
                .report(error.remedy("Start within the range, or widen it."));
            return None;
        }
        Some(value)
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
