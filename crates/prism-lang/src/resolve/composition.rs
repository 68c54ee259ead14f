//! `system ... endsystem`: names bound, references followed, every module in it once.

use std::collections::BTreeSet;

use super::Resolver;
use super::modules::Instance;
use crate::ast::{Name, System, SystemExpr, SystemKind};
use crate::diagnostic::{Diagnostic, Span};
use crate::resolved::{ActionId, Composition};
use crate::suggest::suggest;

/// How many references may be followed in all.
const MAX_REFERENCES: usize = 1_000;

/// Where the composition is found, and what it has used so far.
struct Search<'a, 's> {
    systems: &'a [System],
    instances: &'s [Instance<'a>],
    /// Names of the references that are being followed.
    active: Vec<&'a str>,
    references: usize,
    /// Modules that occurred, with the first place.
    used: Vec<Option<Span>>,
}

impl<'a> Resolver<'a> {
    /// How the modules are composed: `Some(None)` if as in a model that does not say.
    pub(super) fn composition(
        &mut self,
        systems: &'a [System],
        instances: &[Instance<'a>],
    ) -> Option<Option<Composition>> {
        self.check_system_names(systems);
        self.introduce_actions(systems);
        let Some(main) = main_system(systems) else {
            return Some(None);
        };
        let mut search = Search {
            systems,
            instances,
            active: main.name.iter().map(|n| n.text.as_str()).collect(),
            references: 0,
            used: vec![None; instances.len()],
        };
        let composition = self.system(&main.body, &mut search);
        for (module, used) in instances.iter().zip(&search.used) {
            if composition.is_some() && used.is_none() {
                let message = format!("module `{}` does not occur in `system`.", module.name);
                let error = Diagnostic::error("system-modules", main.span, message);
                self.scope
                    .report(error.remedy("Add it, for example with `||`."));
            }
        }
        let composition = composition?;
        Some(Some(composition).filter(|c| !c.is_standard()))
    }

    fn check_system_names(&mut self, systems: &[System]) {
        let mut names = BTreeSet::new();
        for system in systems {
            let name = system.name.as_ref().map(|n| n.text.as_str());
            if !names.insert(name) {
                let message = match name {
                    Some(name) => format!("there are two systems with the name \"{name}\"."),
                    None => "there are two `system ... endsystem` without a name.".to_owned(),
                };
                let error = Diagnostic::error("duplicate-name", system.span, message);
                self.scope.report(error.remedy("Choose another name."));
            }
        }
    }

    /// Numbers the actions that only renaming introduces, so that rewards can name them.
    fn introduce_actions(&mut self, systems: &'a [System]) {
        let mut open: Vec<&SystemExpr> = systems.iter().rev().map(|s| &s.body).collect();
        while let Some(system) = open.pop() {
            match &system.kind {
                SystemKind::Full(parts) | SystemKind::Interleaved(parts) => {
                    open.extend(parts.iter().rev());
                }
                SystemKind::On(left, _, right) => open.extend([&**right, &**left]),
                SystemKind::Hide(inside, _) => open.push(inside),
                SystemKind::Rename(inside, renames) => {
                    for (_, new) in renames {
                        self.action(&new.text);
                    }
                    open.push(inside);
                }
                _ => {}
            }
        }
    }

    fn system(
        &mut self,
        system: &'a SystemExpr,
        search: &mut Search<'a, '_>,
    ) -> Option<Composition> {
        let boxed =
            |r: &mut Self, s: &'a SystemExpr, search: &mut _| r.system(s, search).map(Box::new);
        match &system.kind {
            SystemKind::Module(name) => self.system_module(name, search),
            SystemKind::Reference(name) => self.system_reference(name, search),
            SystemKind::Full(parts) => self.systems(parts, search).map(Composition::Full),
            SystemKind::Interleaved(parts) => {
                self.systems(parts, search).map(Composition::Interleaved)
            }
            SystemKind::On(left, actions, right) => {
                let (left, right) = (boxed(self, left, search), boxed(self, right, search));
                let actions = self.system_actions(actions.iter());
                Some(Composition::On(left?, actions?, right?))
            }
            SystemKind::Hide(inside, actions) => {
                let inside = boxed(self, inside, search);
                let actions = self.system_actions(actions.iter());
                Some(Composition::Hide(inside?, actions?))
            }
            SystemKind::Rename(inside, renames) => {
                let inside = boxed(self, inside, search);
                let old = self.system_actions(renames.iter().map(|(old, _)| old));
                let new = renames.iter().map(|(_, new)| self.action(&new.text));
                let pairs = old?.into_iter().zip(new).collect();
                Some(Composition::Rename(inside?, pairs))
            }
            SystemKind::Error => None,
        }
    }

    fn systems(
        &mut self,
        parts: &'a [SystemExpr],
        search: &mut Search<'a, '_>,
    ) -> Option<Vec<Composition>> {
        let parts: Vec<_> = parts.iter().map(|p| self.system(p, search)).collect();
        parts.into_iter().collect()
    }

    fn system_module(&mut self, name: &Name, search: &mut Search<'a, '_>) -> Option<Composition> {
        let Some(index) = search.instances.iter().position(|m| m.name == name.text) else {
            let known = search.instances.iter().map(|m| m.name);
            let remedy = match suggest(&name.text, known) {
                Some(near) => format!("Did you mean `{near}`?"),
                None => "Name a module of this model.".to_owned(),
            };
            let message = format!("there is no module `{}` to compose.", name.text);
            let error = Diagnostic::error("unknown-module", name.span, message);
            self.scope.report(error.remedy(remedy));
            return None;
        };
        if let Some(first) = search.used[index] {
            let message = format!("module `{}` occurs twice in `system`.", name.text);
            let error = Diagnostic::error("system-modules", name.span, message);
            let remedy =
                "Copy the module under another name: `module copy = original [x=y] endmodule`.";
            self.scope
                .report(error.related(first, "first here").remedy(remedy));
            return None;
        }
        search.used[index] = Some(name.span);
        Some(Composition::Module(index))
    }

    fn system_reference(
        &mut self,
        name: &'a Name,
        search: &mut Search<'a, '_>,
    ) -> Option<Composition> {
        let named = |s: &&System| s.name.as_ref().is_some_and(|n| n.text == name.text);
        let Some(system) = search.systems.iter().find(named) else {
            let message = format!("there is no system \"{}\".", name.text);
            let error = Diagnostic::error("unknown-name", name.span, message);
            let remedy = format!("Define it with `system \"{}\" ... endsystem`.", name.text);
            self.scope.report(error.remedy(remedy));
            return None;
        };
        search.references += 1;
        if search.active.contains(&name.text.as_str()) || search.references > MAX_REFERENCES {
            let message = format!("system \"{}\" is defined by itself.", name.text);
            let error = Diagnostic::error("cyclic-definition", name.span, message);
            self.scope.report(error.remedy("Remove this reference."));
            return None;
        }
        search.active.push(&name.text);
        let composition = self.system(&system.body, search);
        search.active.pop();
        composition
    }

    /// Actions that are known, each once.
    fn system_actions<'n>(
        &mut self,
        names: impl Iterator<Item = &'n Name>,
    ) -> Option<Vec<ActionId>> {
        let mut actions = Some(Vec::new());
        for name in names {
            let action = self.known_action(name);
            let Some((known, action)) = actions.as_mut().zip(action) else {
                actions = None;
                continue;
            };
            if known.contains(&action) {
                let message = format!("action `{}` is named twice here.", name.text);
                let error = Diagnostic::error("duplicate-name", name.span, message);
                self.scope.report(error.remedy("Keep one."));
            }
            known.push(action);
        }
        actions
    }
}

/// The system without a name, or else the first.
fn main_system(systems: &[System]) -> Option<&System> {
    let unnamed = systems.iter().find(|s| s.name.is_none());
    unnamed.or(systems.first())
}
