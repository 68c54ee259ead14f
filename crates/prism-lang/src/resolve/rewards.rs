//! Reward structures.

use std::collections::BTreeSet;

use super::Resolver;
use super::scope::Renaming;
use crate::ast::{self, Type};
use crate::diagnostic::Diagnostic;
use crate::resolved::{RewardItem, RewardStructure};

impl<'a> Resolver<'a> {
    /// Resolves all reward structures; actions must be known by now.
    pub(super) fn rewards(
        &mut self,
        rewards: &'a [ast::RewardStructure],
    ) -> Option<Vec<RewardStructure>> {
        let mut structures = Vec::new();
        let mut names = BTreeSet::new();
        for structure in rewards {
            if let Some(name) = &structure.name
                && !names.insert(name.text.as_str())
            {
                let message = format!(
                    "there are two reward structures with the name `{}`.",
                    name.text
                );
                let error = Diagnostic::error("duplicate-name", name.span, message);
                self.scope.report(error.remedy("Choose another name."));
            }
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
            .closed(&item.guard, &none, Type::Bool, "the guard of a reward");
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
            span: item.span,
        })
    }

    pub(super) fn known_action(&mut self, name: &ast::Name) -> Option<usize> {
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
}
