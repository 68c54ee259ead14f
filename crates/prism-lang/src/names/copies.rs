//! What the names in renamed copies stand for.
//!
//! An old name is a value if the copied module, or a formula, speaks of a value of that name, and an action if the module has a
//! command with it; it may be both. The new name is of the same spaces, and declares the copy's variable where the old one
//! declares the original's.

use super::walk::Walk;
use super::{Occurrence, Role, Space};
use crate::ast::{Model, Module, ModuleBody, Name};
use crate::diagnostic::Span;
use std::collections::{BTreeMap, BTreeSet};

/// The names that a module has, as its copies see them.
#[derive(Clone, Default)]
struct Has<'m> {
    values: BTreeSet<&'m str>,
    actions: BTreeSet<&'m str>,
    variables: BTreeSet<&'m str>,
}

impl<'m> Has<'m> {
    /// The names of a module that is written out: those that were found within it.
    fn written(module: &'m Module, all: &'m [Occurrence]) -> Self {
        let mut has = Self::default();
        for it in within(all, module.span) {
            match it.space {
                Space::Value => has.values.insert(&it.name),
                Space::Action => has.actions.insert(&it.name),
                _ => false,
            };
        }
        if let ModuleBody::Written { variables, .. } = &module.body {
            has.variables = variables.iter().map(|it| it.name.text.as_str()).collect();
        }
        has
    }

    fn renamed(&self, renames: &BTreeMap<&'m str, &'m str>) -> Self {
        let apply = |names: &BTreeSet<&'m str>| {
            let renamed = names.iter();
            renamed
                .map(|it| renames.get(it).copied().unwrap_or(it))
                .collect()
        };
        Self {
            values: apply(&self.values),
            actions: apply(&self.actions),
            variables: apply(&self.variables),
        }
    }
}

/// Those of a part of the text; they are in the order of their places.
fn within(all: &[Occurrence], part: Span) -> impl Iterator<Item = &Occurrence> {
    let begun = all.partition_point(|it| it.span.start < part.start);
    all[begun..]
        .iter()
        .take_while(move |it| it.span.start < part.end)
}

/// Adds the names of all renamed copies to those that were found elsewhere.
pub(super) fn add(model: &Model, walk: &mut Walk<'_>) {
    if !model.modules.iter().any(is_copy) {
        return;
    }
    let mut all = walk.found.clone();
    all.sort_by_key(|it| it.span);
    let known = Known::new(model, &all);
    for (module, base) in model.modules.iter().zip(&known.bases) {
        if let ModuleBody::Renamed { renames, .. } = &module.body {
            renames
                .iter()
                .for_each(|entry| known.entry(base, entry, walk));
        }
    }
}

fn is_copy(module: &Module) -> bool {
    matches!(module.body, ModuleBody::Renamed { .. })
}

/// What the names of a model are, as far as its copies need it.
struct Known<'m> {
    /// All values that are declared, those of copies, too.
    declared: BTreeSet<&'m str>,
    /// A copy that uses a formula renames what the formula speaks of.
    in_formulas: BTreeSet<&'m str>,
    /// For each module, what the one that it copies has.
    bases: Vec<Has<'m>>,
}

impl<'m> Known<'m> {
    fn new(model: &'m Model, all: &'m [Occurrence]) -> Self {
        let declared = all.iter();
        let declared =
            declared.filter(|it| it.space == Space::Value && it.role == Role::Definition);
        let in_formulas = model.formulas.iter();
        let in_formulas = in_formulas.flat_map(|formula| within(all, formula.body.span));
        let mut known = Self {
            declared: declared.map(|it| it.name.as_str()).collect(),
            in_formulas: in_formulas.map(|it| it.name.as_str()).collect(),
            bases: Vec::new(),
        };
        let mut has: BTreeMap<&str, Has<'m>> = BTreeMap::new();
        for module in model.modules.iter().filter(|it| !is_copy(it)) {
            let name = module.name.text.as_str();
            has.entry(name).or_insert_with(|| Has::written(module, all));
        }
        for module in &model.modules {
            let ModuleBody::Renamed { base, renames } = &module.body else {
                known.bases.push(Has::default());
                continue;
            };
            let base = has.get(base.text.as_str()).cloned().unwrap_or_default();
            let map = renames.iter();
            let map: BTreeMap<&str, &str> = map
                .map(|(old, new)| (old.text.as_str(), new.text.as_str()))
                .collect();
            let copy = base.renamed(&map);
            known.declared.extend(&copy.variables);
            has.entry(&module.name.text).or_insert(copy);
            known.bases.push(base);
        }
        known
    }

    /// Adds the two names of an entry, in all spaces in which the copied module has the old one.
    fn entry(&self, base: &Has<'_>, (old, new): &(Name, Name), walk: &mut Walk<'_>) {
        let name = old.text.as_str();
        let is_action = base.actions.contains(name);
        // What the module does not speak of is renamed in vain, but stays the name of what there is.
        let is_value = base.values.contains(name)
            || self.in_formulas.contains(name)
            || !is_action && self.declared.contains(name);
        let role = match base.variables.contains(name) {
            true => Role::Definition,
            false => Role::Use,
        };
        if is_value {
            walk.add(Space::Value, Role::Replaced, name, old.span);
            walk.add(Space::Value, role, &new.text, new.span);
        }
        if is_action || !is_value {
            walk.add(Space::Action, Role::Replaced, name, old.span);
            walk.add(Space::Action, Role::Use, &new.text, new.span);
        }
    }
}
