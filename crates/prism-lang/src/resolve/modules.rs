//! Modules: renamed copies, commands and updates.

use std::collections::BTreeMap;

use super::Resolver;
use super::scope::{Renaming, Symbol};
use crate::ast::{self, ModuleBody, Type};
use crate::diagnostic::{Diagnostic, Span};
use crate::expr::{Expr, VarIndex};
use crate::resolved::{ActionId, Command, Module, Update};

/// A module as it will run: the text of a written module, read under a renaming.
pub(super) struct Instance<'a> {
    pub(super) name: &'a str,
    pub(super) variables: &'a [ast::Variable],
    commands: &'a [ast::Command],
    pub(super) renaming: Renaming<'a>,
}

impl<'a> Resolver<'a> {
    /// All modules, copies expanded.
    pub(super) fn instances(&mut self, modules: &'a [ast::Module]) -> Vec<Instance<'a>> {
        let mut instances = Vec::new();
        for (index, module) in modules.iter().enumerate() {
            let instance = match &module.body {
                ModuleBody::Written {
                    variables,
                    commands,
                    invariant,
                } => {
                    if let Some(invariant) = invariant {
                        let message =
                            "invariants belong to timed automata, which are not supported.";
                        let error = Diagnostic::error("unsupported", invariant.span, message);
                        self.scope
                            .report(error.remedy("Put the condition into the guards."));
                    }
                    Some(Instance {
                        name: &module.name.text,
                        variables,
                        commands,
                        renaming: Renaming::default(),
                    })
                }
                ModuleBody::Renamed { base, renames } => {
                    self.copy(index + 1, module, base, renames, modules)
                }
            };
            instances.extend(instance);
        }
        instances
    }

    fn copy(
        &mut self,
        id: usize,
        module: &'a ast::Module,
        base: &'a ast::Name,
        renames: &'a [(ast::Name, ast::Name)],
        modules: &'a [ast::Module],
    ) -> Option<Instance<'a>> {
        let Some(original) = modules.iter().find(|m| m.name.text == base.text) else {
            self.unknown_module(base, modules);
            return None;
        };
        let ModuleBody::Written {
            variables,
            commands,
            ..
        } = &original.body
        else {
            let message = format!("module `{}` is itself a renamed copy.", base.text);
            let error = Diagnostic::error("copy-of-copy", base.span, message);
            self.scope
                .report(error.remedy("Copy the module that is written out."));
            return None;
        };
        let names = self.renames(renames);
        for variable in variables {
            if !names.contains_key(variable.name.text.as_str()) {
                let name = &variable.name.text;
                let message = format!(
                    "the copy `{}` does not rename variable `{name}`.",
                    module.name.text
                );
                let error = Diagnostic::error("variable-not-renamed", module.span, message);
                let error = error.related(variable.span, "declared here");
                self.scope
                    .report(error.remedy(format!("Add `{name}=...` to the renaming.")));
            }
        }
        Some(Instance {
            name: &module.name.text,
            variables,
            commands,
            renaming: Renaming { id, names },
        })
    }

    fn renames(&mut self, renames: &'a [(ast::Name, ast::Name)]) -> BTreeMap<&'a str, &'a str> {
        let mut names = BTreeMap::new();
        for (old, new) in renames {
            if names.insert(old.text.as_str(), new.text.as_str()).is_some() {
                let message = format!("`{}` is renamed twice.", old.text);
                let error = Diagnostic::error("renamed-twice", old.span, message);
                self.scope.report(error.remedy("Keep one of the two."));
            }
        }
        names
    }

    fn unknown_module(&mut self, base: &ast::Name, modules: &[ast::Module]) {
        let known = modules.iter().map(|m| m.name.text.as_str());
        let remedy = match crate::suggest::suggest(&base.text, known) {
            Some(near) => format!("Did you mean `{near}`?"),
            None => "Name a module of this model.".to_owned(),
        };
        let message = format!("there is no module `{}` to copy.", base.text);
        self.scope
            .report(Diagnostic::error("unknown-module", base.span, message).remedy(remedy));
    }

    /// Resolves all commands.
    pub(super) fn modules(&mut self, instances: &[Instance<'a>]) -> Option<Vec<Module>> {
        let mut modules = Vec::new();
        for (owner, instance) in instances.iter().enumerate() {
            let commands: Vec<Option<Command>> = instance
                .commands
                .iter()
                .map(|command| self.command(command, owner, instance))
                .collect();
            modules.push(
                commands
                    .into_iter()
                    .collect::<Option<_>>()
                    .map(|commands| Module {
                        name: instance.name.to_owned(),
                        commands,
                    }),
            );
        }
        modules.into_iter().collect()
    }

    fn command(
        &mut self,
        command: &'a ast::Command,
        owner: usize,
        instance: &Instance<'a>,
    ) -> Option<Command> {
        let renaming = &instance.renaming;
        let action = command
            .action
            .as_ref()
            .map(|name| self.action(renaming.apply(&name.text)));
        let guard = self.scope.typed(
            &command.guard,
            renaming,
            Type::Bool,
            "the guard of a command",
        );
        let updates: Vec<Option<Update>> = command
            .updates
            .iter()
            .map(|update| self.update(update, owner, instance, action.is_some()))
            .collect();
        let updates: Vec<Update> = updates.into_iter().collect::<Option<_>>()?;
        if self.is_probabilistic {
            self.check_probabilities(&updates, command.span);
        }
        let guard = guard?;
        self.check_guard(&guard, command.span);
        Some(Command {
            action,
            guard,
            updates,
            span: command.span,
        })
    }

    fn action(&mut self, name: &str) -> ActionId {
        if let Some(known) = self.actions.iter().position(|a| a == name) {
            return known;
        }
        self.actions.push(name.to_owned());
        self.actions.len() - 1
    }

    fn update(
        &mut self,
        update: &'a ast::Update,
        owner: usize,
        instance: &Instance<'a>,
        synchronised: bool,
    ) -> Option<Update> {
        let what = if self.is_probabilistic {
            "a probability"
        } else {
            "a rate"
        };
        let probability = match &update.probability {
            None => Some(Expr::int(1, update.span)),
            Some(p) => self.scope.typed(p, &instance.renaming, Type::Double, what),
        };
        let mut assignments: Vec<(VarIndex, Expr)> = Vec::new();
        let mut complete = true;
        for assignment in &update.assignments {
            let target = self.target(assignment, owner, instance, synchronised);
            let value = target.and_then(|t| self.assigned_value(assignment, t, &instance.renaming));
            let (Some(target), Some(value)) = (target, value) else {
                complete = false;
                continue;
            };
            if assignments.iter().any(|(earlier, _)| *earlier == target) {
                let name = &assignment.variable.text;
                let message = format!("`{name}` is assigned twice in one update.");
                let error = Diagnostic::error("assigned-twice", assignment.span, message);
                self.scope.report(error.remedy("Keep one assignment."));
                complete = false;
            }
            assignments.push((target, value));
        }
        let probability = probability?;
        complete.then_some(Update {
            probability,
            assignments,
            span: update.span,
        })
    }

    /// The variable that is assigned, if this command may assign it.
    fn target(
        &mut self,
        assignment: &'a ast::Assignment,
        owner: usize,
        instance: &Instance<'a>,
        synchronised: bool,
    ) -> Option<VarIndex> {
        let name = instance.renaming.apply(&assignment.variable.text);
        let span = assignment.variable.span;
        let index = match self.scope.symbol(name) {
            Some(Symbol::Variable(index, _)) => *index,
            Some(Symbol::Broken) => return None,
            Some(other) => {
                let message = format!(
                    "`{name}` is {}, not a variable, and cannot be assigned.",
                    other.noun()
                );
                let error = Diagnostic::error("not-a-variable", span, message);
                self.scope
                    .report(error.remedy("Assign a variable of this module."));
                return None;
            }
            None => {
                self.scope.unknown_name(name, span);
                return None;
            }
        };
        match self.owners[index] {
            Some(other) if other != owner => {
                self.foreign_variable(name, index, span, instance.name);
                None
            }
            None if synchronised => {
                self.synchronised_global(name, index, span);
                None
            }
            _ => Some(index),
        }
    }

    fn foreign_variable(&mut self, name: &str, index: VarIndex, span: Span, module: &str) {
        let owner = self.variables[index].module.clone().unwrap_or_default();
        let message = format!(
            "`{name}` belongs to module `{owner}` and cannot be assigned in module `{module}`."
        );
        let error = Diagnostic::error("foreign-variable", span, message)
            .related(self.variables[index].span, "declared here")
            .remedy(format!(
                "Assign it in `{owner}`, in a command that synchronises on the same action, or declare it as `global`."
            ));
        self.scope.report(error);
    }

    fn synchronised_global(&mut self, name: &str, index: VarIndex, span: Span) {
        let message =
            format!("the global variable `{name}` cannot be assigned by a command with an action.");
        let error = Diagnostic::error("synchronised-global", span, message)
            .related(self.variables[index].span, "declared here");
        self.scope.report(error.remedy(
            "Remove the action (`[]`), or move the variable into the module that assigns it: two synchronised commands might disagree.",
        ));
    }

    fn assigned_value(
        &mut self,
        assignment: &'a ast::Assignment,
        target: VarIndex,
        renaming: &Renaming<'a>,
    ) -> Option<Expr> {
        let name = &self.variables[target].name;
        let what = format!("the value assigned to `{name}`");
        let ty = match self.scope.symbol(name) {
            Some(Symbol::Variable(_, ty)) => *ty,
            _ => return None,
        };
        let value = self.scope.typed(&assignment.value, renaming, ty, &what)?;
        self.check_assigned_range(&value, target);
        Some(value)
    }
}
