//! Modules: renamed copies, commands and updates.

use std::collections::{BTreeMap, BTreeSet};

use super::Resolver;
use super::scope::{Renaming, Symbol};
use crate::ast::{self, ModuleBody, Type};
use crate::diagnostic::{Diagnostic, Span};
use crate::expr::{Expr, VarIndex};
use crate::resolved::{ActionId, Command, Module, Update};

/// How many names all renamed modules may rename together.
const MOST_RENAMED: usize = 10_000_000;

/// The names in modules that are written out and in formulas: a renaming of others, as in the middle of a chain of copies,
/// changes nothing.
fn words(modules: &[ast::Module], formulas: &[ast::Formula]) -> BTreeSet<String> {
    let is_written = |module: &&ast::Module| matches!(module.body, ModuleBody::Written { .. });
    // Without copies nobody asks, and a large model has many words.
    if modules.iter().all(|module| is_written(&module)) {
        return BTreeSet::new();
    }
    let texts = modules.iter().filter(is_written).map(ToString::to_string);
    let texts = texts.chain(formulas.iter().map(ToString::to_string));
    let is_part = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let mut words = BTreeSet::new();
    for text in texts {
        words.extend(text.split(|c| !is_part(c)).map(str::to_owned));
    }
    words
}

/// A module that is written out, as it is.
fn written(module: &ast::Module) -> Option<Instance<'_>> {
    match &module.body {
        ModuleBody::Written {
            variables,
            commands,
            invariant,
        } => Some(Instance {
            name: &module.name.text,
            variables,
            commands,
            invariant: invariant.as_ref(),
            renaming: Renaming::default(),
        }),
        ModuleBody::Renamed { .. } => None,
    }
}

/// A module as it will run: the text of a written module, read under a renaming.
#[derive(Clone)]
pub(super) struct Instance<'a> {
    pub(super) name: &'a str,
    pub(super) variables: &'a [ast::Variable],
    commands: &'a [ast::Command],
    invariant: Option<&'a ast::Expr>,
    pub(super) renaming: Renaming<'a>,
}

impl<'a> Resolver<'a> {
    /// All modules, copies expanded.
    pub(super) fn instances(
        &mut self,
        modules: &'a [ast::Module],
        formulas: &[ast::Formula],
    ) -> Vec<Instance<'a>> {
        let words = words(modules, formulas);
        let mut by_name: BTreeMap<&str, usize> = BTreeMap::new();
        for (index, module) in modules.iter().enumerate() {
            by_name.entry(&module.name.text).or_insert(index);
        }
        let mut instances: Vec<Option<Instance<'a>>> = Vec::with_capacity(modules.len());
        let mut renamed = 0;
        for (index, module) in modules.iter().enumerate() {
            let instance = match &module.body {
                ModuleBody::Written { .. } => written(module),
                ModuleBody::Renamed { base, renames } => {
                    let found = by_name.get(base.text.as_str()).copied();
                    // A copy can be copied again, behind it.
                    let original = found.and_then(|i| match instances.get(i) {
                        Some(Some(copy)) => Some(copy.clone()),
                        _ => written(&modules[i]),
                    });
                    match (original, found) {
                        (Some(original), _) => {
                            Some(self.copy(index + 1, module, original, renames, &words))
                        }
                        (None, Some(_)) => {
                            self.copy_of_later_copy(base);
                            None
                        }
                        (None, None) => {
                            self.unknown_module(base, modules);
                            None
                        }
                    }
                }
            };
            renamed += instance.as_ref().map_or(0, |i| i.renaming.names.len());
            instances.push(instance);
            if renamed > MOST_RENAMED {
                self.too_many_names(module);
                break;
            }
        }
        instances.into_iter().flatten().collect()
    }

    fn too_many_names(&mut self, module: &ast::Module) {
        let message = "the renamed modules up to here have too many names in all.";
        let error = Diagnostic::error("too-large", module.name.span, message);
        self.scope.report(
            error.remedy("Copy fewer modules, or let formulas name fewer of their variables."),
        );
    }

    fn copy_of_later_copy(&mut self, base: &ast::Name) {
        let message = format!(
            "module `{}` is itself a renamed copy that comes later.",
            base.text
        );
        let error = Diagnostic::error("copy-of-copy", base.span, message);
        self.scope
            .report(error.remedy("Copy the module that is written out, or move the copy up."));
    }

    fn copy(
        &mut self,
        id: usize,
        module: &'a ast::Module,
        original: Instance<'a>,
        renames: &'a [(ast::Name, ast::Name)],
        words: &BTreeSet<String>,
    ) -> Instance<'a> {
        let names = self.renames(renames);
        for variable in original.variables {
            let name = original.renaming.apply(&variable.name.text);
            if !names.contains_key(name) {
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
        // First the names of the original, then those of this copy.
        let new = Renaming { id, names };
        let written = new.names.iter().filter(|(old, _)| words.contains(**old));
        let mut both: BTreeMap<&str, &str> = written.map(|(old, new)| (*old, *new)).collect();
        for (old, once) in &original.renaming.names {
            both.insert(old, new.apply(once));
        }
        Instance {
            name: &module.name.text,
            renaming: Renaming { id, names: both },
            ..original
        }
    }

    fn renames(&mut self, renames: &'a [(ast::Name, ast::Name)]) -> BTreeMap<&'a str, &'a str> {
        let mut names = BTreeMap::new();
        for (old, new) in renames {
            if matches!(
                self.scope.symbol(&old.text),
                Some(Symbol::FormulaDefinition(_))
            ) {
                let message = format!(
                    "formula `{}` cannot be renamed: its contents are, when it is written out.",
                    old.text
                );
                let error = Diagnostic::error("renamed-formula", old.span, message);
                self.scope
                    .report(error.remedy("Rename the variables that the formula is about."));
            }
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
            if let Some(invariant) = instance.invariant {
                let what = "an invariant";
                self.scope
                    .typed(invariant, &instance.renaming, Type::Bool, what);
            }
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
        let guard = self.scope.closed(
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
        let mut updates: Vec<Update> = updates.into_iter().collect::<Option<_>>()?;
        if !self.has_rates {
            self.check_probabilities(&mut updates, command.span);
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

    /// The number of an action, a new one if it has none.
    pub(super) fn action(&mut self, name: &str) -> ActionId {
        if let Some(known) = self.action_ids.get(name) {
            return *known;
        }
        self.action_ids.insert(name.to_owned(), self.actions.len());
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
        let probability = self.probability(update, &instance.renaming);
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

    fn probability(&mut self, update: &'a ast::Update, renaming: &Renaming<'a>) -> Option<Expr> {
        let what = if self.has_rates {
            "a rate"
        } else {
            "a probability"
        };
        match &update.probability {
            None => Some(Expr::int(1, update.span)),
            Some(ast::Expr {
                kind: ast::ExprKind::Interval(low, high),
                ..
            }) => {
                // The model is refused for it, but its other mistakes are reported.
                self.has_intervals = true;
                self.scope.typed(low, renaming, Type::Double, what)?;
                self.scope.typed(high, renaming, Type::Double, what)?;
                None
            }
            Some(p) => self.scope.typed(p, renaming, Type::Double, what),
        }
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
        let value = self.scope.closed(&assignment.value, renaming, ty, &what)?;
        self.check_assigned_range(&value, target);
        Some(value)
    }
}
