//! Through a syntax tree, noting the names.

use super::{Occurrence, Role, Space};
use crate::ast::{
    Command, Expr, ExprKind, Model, ModuleBody, Name, Observables, PropertyFile, Reward,
    RewardIndex, RewardKind, RewardObjective, StateFilter, StepBound, SystemExpr, SystemKind,
    Variable, VariableRange,
};
use crate::diagnostic::Span;

/// What was found so far.
pub(super) struct Walk<'t> {
    text: &'t str,
    pub(super) found: Vec<Occurrence>,
}

impl<'t> Walk<'t> {
    pub(super) fn new(text: &'t str) -> Self {
        Self {
            text,
            found: Vec::new(),
        }
    }

    pub(super) fn add(&mut self, space: Space, role: Role, name: &str, span: Span) {
        // A quoted name has its quotes in its span, perhaps with blanks inside, an assigned one its prime.
        let Some(start) = span.of(self.text).find(name).filter(|_| !name.is_empty()) else {
            return;
        };
        let start = span.start + start;
        self.found.push(Occurrence {
            name: name.to_owned(),
            space,
            role,
            span: Span::new(start, start + name.len()),
        });
    }

    fn name(&mut self, space: Space, role: Role, name: &Name) {
        self.add(space, role, &name.text, name.span);
    }

    pub(super) fn model(&mut self, model: &Model) {
        for constant in &model.constants {
            self.name(Space::Value, Role::Definition, &constant.name);
            self.maybe(constant.value.as_ref());
        }
        for formula in &model.formulas {
            self.name(Space::Value, Role::Definition, &formula.name);
            self.expr(&formula.body);
        }
        for label in &model.labels {
            self.name(Space::Label, Role::Definition, &label.name);
            self.expr(&label.body);
        }
        model.globals.iter().for_each(|it| self.variable(it));
        for module in &model.modules {
            self.name(Space::Module, Role::Definition, &module.name);
            self.module(&module.body);
        }
        for structure in &model.rewards {
            if let Some(name) = &structure.name {
                self.name(Space::Reward, Role::Definition, name);
            }
            for item in &structure.items {
                if let RewardKind::Transition(Some(action)) = &item.kind {
                    self.name(Space::Action, Role::Use, action);
                }
                self.expr(&item.guard);
                self.expr(&item.value);
            }
        }
        self.maybe(model.init.as_ref());
        for system in &model.systems {
            if let Some(name) = &system.name {
                self.name(Space::System, Role::Definition, name);
            }
            self.composition(&system.body);
        }
        model.observables.iter().for_each(|it| self.observables(it));
    }

    fn module(&mut self, body: &ModuleBody) {
        match body {
            ModuleBody::Written {
                variables,
                invariant,
                commands,
            } => {
                variables.iter().for_each(|it| self.variable(it));
                self.maybe(invariant.as_ref());
                commands.iter().for_each(|it| self.command(it));
            }
            // What the renamed names are is found once all modules are known.
            ModuleBody::Renamed { base, .. } => self.name(Space::Module, Role::Use, base),
        }
    }

    fn variable(&mut self, variable: &Variable) {
        self.name(Space::Value, Role::Definition, &variable.name);
        if let VariableRange::Int { low, high } = &variable.range {
            self.expr(low);
            self.expr(high);
        }
        self.maybe(variable.init.as_ref());
    }

    fn command(&mut self, command: &Command) {
        if let Some(action) = &command.action {
            // No place declares an action: each command that has it does.
            self.name(Space::Action, Role::Definition, action);
        }
        self.expr(&command.guard);
        for update in &command.updates {
            self.maybe(update.probability.as_ref());
            for assignment in &update.assignments {
                self.name(Space::Value, Role::Assignment, &assignment.variable);
                self.expr(&assignment.value);
            }
        }
    }

    fn composition(&mut self, composition: &SystemExpr) {
        match &composition.kind {
            SystemKind::Module(name) => self.name(Space::Module, Role::Use, name),
            SystemKind::Reference(name) => self.name(Space::System, Role::Use, name),
            SystemKind::Full(parts) | SystemKind::Interleaved(parts) => {
                parts.iter().for_each(|it| self.composition(it));
            }
            SystemKind::On(a, actions, b) => {
                self.composition(a);
                self.actions(actions.iter());
                self.composition(b);
            }
            SystemKind::Hide(part, actions) => {
                self.composition(part);
                self.actions(actions.iter());
            }
            SystemKind::Rename(part, renames) => {
                self.composition(part);
                self.actions(renames.iter().flat_map(|(old, new)| [old, new]));
            }
            SystemKind::Error => {}
        }
    }

    fn actions<'n>(&mut self, names: impl Iterator<Item = &'n Name>) {
        names.for_each(|name| self.name(Space::Action, Role::Use, name));
    }

    fn observables(&mut self, observables: &Observables) {
        match observables {
            Observables::Variables { names, .. } => {
                (names.iter()).for_each(|it| self.name(Space::Value, Role::Use, it));
            }
            Observables::Defined { name, body, .. } => {
                self.name(Space::Observable, Role::Definition, name);
                self.expr(body);
            }
        }
    }

    pub(super) fn properties(&mut self, file: &PropertyFile) {
        for constant in &file.constants {
            self.name(Space::Value, Role::Definition, &constant.name);
            self.maybe(constant.value.as_ref());
        }
        for formula in &file.formulas {
            self.name(Space::Value, Role::Definition, &formula.name);
            self.expr(&formula.body);
        }
        for label in &file.labels {
            self.name(Space::Label, Role::Definition, &label.name);
            self.expr(&label.body);
        }
        for property in &file.properties {
            if let Some(name) = &property.name {
                self.name(Space::Label, Role::Definition, name);
            }
            self.expr(&property.formula);
        }
        for name in file.unread.iter().filter_map(|it| it.name.as_ref()) {
            self.name(Space::Label, Role::Definition, name);
        }
    }

    fn maybe(&mut self, expr: Option<&Expr>) {
        expr.into_iter().for_each(|it| self.expr(it));
    }

    fn each<'e>(&mut self, exprs: impl IntoIterator<Item = &'e Expr>) {
        exprs.into_iter().for_each(|it| self.expr(it));
    }

    fn expr(&mut self, expr: &Expr) {
        match &expr.kind {
            ExprKind::Name(name) => self.add(Space::Value, Role::Use, name, expr.span),
            ExprKind::Label(name) => self.add(Space::Label, Role::Use, name, expr.span),
            ExprKind::Unary(_, a) | ExprKind::Quantified(_, a) => self.expr(a),
            ExprKind::Binary(_, a, b) | ExprKind::Interval(a, b) => self.each([&**a, &**b]),
            ExprKind::IfThenElse(a, b, c) => self.each([&**a, &**b, &**c]),
            ExprKind::Call(_, arguments) => self.each(arguments),
            ExprKind::Probability {
                bound,
                path,
                condition,
                filter,
                ..
            } => {
                self.maybe(bound.as_ref().map(|(_, bound)| &**bound));
                self.expr(path);
                self.maybe(condition.as_deref());
                self.filter(filter.as_deref());
            }
            ExprKind::Reward(reward) => self.reward(reward),
            ExprKind::LongRun {
                bound,
                states,
                filter,
            } => {
                self.maybe(bound.as_ref().map(|(_, bound)| &**bound));
                self.expr(states);
                self.filter(filter.as_deref());
            }
            ExprKind::Strategy(strategy) => self.expr(&strategy.operand),
            ExprKind::Filter(filter) => {
                self.expr(&filter.operand);
                self.maybe(filter.states.as_deref());
            }
            ExprKind::Temporal {
                bound, left, right, ..
            } => {
                match bound.as_deref() {
                    Some(StepBound::Compare(_, a) | StepBound::Exactly(a)) => self.expr(a),
                    Some(StepBound::Between(a, b)) => self.each([a, b]),
                    None => {}
                }
                self.maybe(left.as_deref());
                self.expr(right);
            }
            ExprKind::Bool(_) | ExprKind::Int(_) | ExprKind::Double(_) | ExprKind::Error => {}
        }
    }

    fn reward(&mut self, reward: &Reward) {
        for index in [&reward.structure, &reward.divisor].into_iter().flatten() {
            match index {
                RewardIndex::Name(name) => self.name(Space::Reward, Role::Use, name),
                RewardIndex::Index(number) => self.expr(number),
            }
        }
        self.maybe(reward.bound.as_ref().map(|(_, bound)| &**bound));
        match &reward.objective {
            RewardObjective::Cumulative(a)
            | RewardObjective::Instantaneous(a)
            | RewardObjective::Path(a) => self.expr(a),
            RewardObjective::Total | RewardObjective::LongRun => {}
        }
        self.filter(reward.filter.as_ref());
    }

    fn filter(&mut self, filter: Option<&StateFilter>) {
        self.maybe(filter.map(|filter| &filter.states));
    }
}
