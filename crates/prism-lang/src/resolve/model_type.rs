//! Which kind of model it is, whether that kind has a meaning here, and which constants stay open.
//!
//! As in PRISM, a model without a keyword is a labelled transition system if no update has a probability, else
//! an mdp; clocks, observables and intervals of probabilities make it a model of a richer kind.

use super::Resolver;
use crate::ast::{self, ModuleBody, Type, VariableRange};
use crate::diagnostic::{Diagnostic, Span};
use crate::resolved::{ModelType, Parameter};
use crate::suggest::suggest;

impl<'a> Resolver<'a> {
    /// The model's kind; reports a kind that is not supported, once, with what is missing.
    pub(super) fn model_type(&mut self, model: &ast::Model) -> Option<ModelType> {
        let found = match model.model_type {
            Some((ast::ModelType::Dtmc, _)) => ModelType::Dtmc,
            Some((ast::ModelType::Mdp, _)) => ModelType::Mdp,
            Some((ast::ModelType::Ctmc, _)) => ModelType::Ctmc,
            Some((richer, span)) => {
                self.not_yet(richer, span);
                return None;
            }
            None => self.assumed_type(model),
        };
        let span = model
            .model_type
            .map_or_else(Span::default, |(_, span)| span);
        if let Some(clock) = clock(model) {
            let can_have = found.has_choices();
            if can_have {
                self.not_yet(ast::ModelType::Pta, clock);
            } else {
                self.misplaced("clocks", found, clock, "Write `pta` in its first line");
            }
            return None;
        }
        if let Some(observed) = model.observables.first() {
            let place = match observed {
                ast::Observables::Variables { span, .. }
                | ast::Observables::Defined { span, .. } => *span,
            };
            if found.has_choices() {
                self.not_yet(ast::ModelType::Pomdp, place);
            } else {
                self.misplaced(
                    "observables",
                    found,
                    place,
                    "Write `pomdp` in its first line",
                );
            }
            return None;
        }
        if self.has_intervals {
            self.intervals_not_yet(found, span);
            return None;
        }
        Some(found)
    }

    fn assumed_type(&mut self, model: &ast::Model) -> ModelType {
        let has_probabilities = model.modules.iter().any(|module| match &module.body {
            ModuleBody::Written { commands, .. } => {
                let mut updates = commands.iter().flat_map(|c| &c.updates);
                updates.any(|u| u.probability.is_some())
            }
            ModuleBody::Renamed { .. } => false,
        });
        let (assumed, article, why) = if has_probabilities {
            (ModelType::Mdp, "an", "")
        } else {
            (ModelType::Lts, "an", ", for it has no probabilities")
        };
        let message = format!(
            "the model does not say what type it has; PRISM takes it as {article} {}{why}.",
            assumed.keyword()
        );
        let warning = Diagnostic::warning("no-model-type", Span::default(), message);
        self.scope
            .report(warning.remedy("Write `dtmc` in its first line, or the type that is meant."));
        assumed
    }

    fn not_yet(&mut self, model_type: ast::ModelType, span: Span) {
        let (what, missing) = match model_type {
            ast::ModelType::Pomdp => (
                "partially observable models (`pomdp`)",
                "schedulers that see observations only",
            ),
            ast::ModelType::Popta => (
                "partially observable timed automata (`popta`)",
                "clocks, and schedulers that see observations only",
            ),
            _ => ("timed automata (`pta`)", "clocks and invariants"),
        };
        let message = format!("{what} are not supported yet: what is missing are {missing}.");
        let error = Diagnostic::error("unsupported", span, message);
        self.scope
            .report(error.remedy("Use a `dtmc`, `ctmc` or `mdp`; time can be counted in steps."));
    }

    fn intervals_not_yet(&mut self, found: ModelType, span: Span) {
        let message = match found {
            ModelType::Ctmc => "a ctmc cannot have intervals of rates.",
            _ => {
                "intervals of probabilities are not supported yet: what is missing is choosing the worst probabilities."
            }
        };
        let error = Diagnostic::error("unsupported", span, message);
        self.scope
            .report(error.remedy("Write one probability for each update."));
    }

    fn misplaced(&mut self, what: &str, found: ModelType, span: Span, remedy: &str) {
        let message = format!("a {} cannot have {what}.", found.keyword());
        let error = Diagnostic::error("unsupported", span, message);
        self.scope
            .report(error.remedy(format!("{remedy}, or remove them.")));
    }

    /// Checks what belongs to models of a richer kind: the names of observables.
    pub(super) fn check_observables(&mut self, model: &'a ast::Model) {
        let none = super::scope::Renaming::default();
        for observed in &model.observables {
            match observed {
                ast::Observables::Defined { body, .. } => {
                    self.scope.expression(body, &none);
                }
                ast::Observables::Variables { names, .. } => {
                    for name in names {
                        if self.scope.symbol(&name.text).is_none() {
                            self.scope.unknown_name(&name.text, name.span);
                        }
                    }
                }
            }
        }
    }

    /// Reports a clock with an initial value.
    pub(super) fn check_clock(&mut self, variable: &ast::Variable) {
        if let Some(init) = &variable.init {
            let message = "a clock starts at 0 and cannot be given an initial value.";
            let error = Diagnostic::error("init-out-of-range", init.span, message);
            self.scope.report(error.remedy("Remove `init`."));
        }
    }

    /// Notes which constants get no value.
    pub(super) fn open_parameters(&mut self, model: &ast::Model, open: &[&str]) {
        for constant in &model.constants {
            if open.contains(&constant.name.text.as_str()) {
                self.parameters.push(Parameter {
                    name: constant.name.text.clone(),
                    ty: constant.ty,
                    span: constant.span,
                });
            }
        }
        for name in open {
            let found = self.parameters.iter().find(|p| p.name == *name);
            let (span, message, remedy) = match found {
                Some(parameter) if parameter.ty == Type::Bool => (
                    parameter.span,
                    format!("constant `{name}` is a bool and cannot be left open."),
                    "Give it the value `true` or `false`.".to_owned(),
                ),
                Some(_) => continue,
                None => {
                    let known = model.constants.iter().map(|c| c.name.text.as_str());
                    let remedy = match suggest(name, known) {
                        Some(near) => format!("Did you mean `{near}`?"),
                        None => "Declare it in the model.".to_owned(),
                    };
                    let message = format!("the model has no constant `{name}` to leave open.");
                    (Span::default(), message, remedy)
                }
            };
            let error = Diagnostic::error("unknown-constant", span, message);
            self.scope.report(error.remedy(remedy));
        }
    }
}

/// The place of the first clock, or else of an invariant.
fn clock(model: &ast::Model) -> Option<Span> {
    let is_clock = |v: &&ast::Variable| v.range == VariableRange::Clock;
    let global = model.globals.iter().find(is_clock).map(|v| v.span);
    global.or_else(|| {
        model.modules.iter().find_map(|module| match &module.body {
            ModuleBody::Written {
                variables,
                invariant,
                ..
            } => {
                let clock = variables.iter().find(is_clock).map(|v| v.span);
                clock.or_else(|| invariant.as_ref().map(|i| i.span))
            }
            ModuleBody::Renamed { .. } => None,
        })
    })
}
