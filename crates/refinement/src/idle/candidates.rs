//! The changes that lead to values which a model declares or asks for.

use super::Idle;
use crate::draws;
use crate::model_change::Read;
use crate::number::commands;
use crate::unreached::{Lacking, of_guards};
use crate::unused::is_used;
use prism_lang::ast::{BinaryOp, Expr, ExprKind, ModuleBody, Variable, VariableRange};
use prism_lang::edit;

/// All changes with their kinds.
pub(super) fn changes(read: &Read<'_>) -> Vec<(u8, Idle)> {
    let mut found = Vec::new();
    for variable in declared(read).filter(|it| is_counter(read, it)) {
        let VariableRange::Int { low, high } = &variable.range else {
            continue;
        };
        let name = &variable.name.text;
        let ends: Vec<(i64, String)> = [low, high]
            .into_iter()
            .filter_map(|end| Some((draws::value_of(end, None, &read.model)?, end.to_string())))
            .collect();
        let mut named: Vec<i64> = limits(read, name)
            .into_iter()
            .map(|(_, value)| value)
            .collect();
        named.sort_unstable();
        named.dedup();
        let between = |value: i64| ends.iter().all(|(end, _)| *end != value);
        if let [old] = named[..]
            && between(old)
        {
            found.extend(ends.iter().map(|(_, new)| {
                let new = new.clone();
                (
                    0,
                    Idle::Limit {
                        variable: name.clone(),
                        old,
                        new,
                    },
                )
            }));
        }
        let begins = variable
            .init
            .as_ref()
            .and_then(|it| draws::value_of(it, None, &read.model));
        if begins.is_some_and(between) {
            found.extend(ends.iter().map(|(_, new)| {
                (
                    1,
                    Idle::Begin {
                        variable: name.clone(),
                        new: new.clone(),
                    },
                )
            }));
        }
    }
    for asked in asked_in_vain(read) {
        let new = asked.value;
        let begins = Idle::Begin {
            variable: asked.variable,
            new,
        };
        if !found.contains(&(1, begins.clone())) {
            found.push((1, begins));
        }
    }
    found.extend(outcomes(read).into_iter().map(|it| (2, it)));
    found.extend(repetitions(read).into_iter().map(|it| (3, it)));
    found
}

/// Updates that lead elsewhere, as often as a variable counts that stands nowhere else.
fn repetitions(read: &Read<'_>) -> Vec<Idle> {
    let mut found = Vec::new();
    let mut first = 0;
    for module in &read.tree.modules {
        let ModuleBody::Written {
            commands: own,
            variables,
            ..
        } = &module.body
        else {
            continue;
        };
        let mut outcomes: Vec<String> = Vec::new();
        for update in own.iter().flat_map(|it| &it.updates) {
            let outcome = edit::outcome(read.text, update);
            if !outcomes.contains(&outcome) {
                outcomes.push(outcome);
            }
        }
        let unused = variables
            .iter()
            .filter(|it| !is_used(read.text, &it.name.text));
        for variable in unused {
            let most = match &variable.range {
                VariableRange::Bool => None,
                VariableRange::Int { high, .. } => Some(high.to_string()),
                VariableRange::Unbounded | VariableRange::Clock => continue,
            };
            for (place, command) in own.iter().enumerate() {
                for (number, update) in command.updates.iter().enumerate() {
                    let own = edit::outcome(read.text, update);
                    let others = outcomes.iter().filter(|it| **it != own);
                    found.extend(others.map(|to| Idle::Again {
                        command: first + place,
                        update: number,
                        variable: variable.name.text.clone(),
                        most: most.clone(),
                        to: to.clone(),
                    }));
                }
            }
        }
        first += own.len();
    }
    found
}

/// The variables that are declared in modules which are written out.
pub(crate) fn declared<'r>(read: &'r Read<'_>) -> impl Iterator<Item = &'r Variable> {
    let of_modules = read
        .tree
        .modules
        .iter()
        .filter_map(|module| match &module.body {
            ModuleBody::Written { variables, .. } => Some(variables),
            ModuleBody::Renamed { .. } => None,
        });
    of_modules.flatten()
}

/// Whether an update counts a variable up or down.
fn is_counter(read: &Read<'_>, variable: &Variable) -> bool {
    let name = variable.name.text.as_str();
    let is_name = |expr: &Expr| matches!(&expr.kind, ExprKind::Name(it) if it == name);
    let counts = |expr: &Expr| match &expr.kind {
        ExprKind::Binary(BinaryOp::Plus, left, right) => is_name(left) || is_name(right),
        ExprKind::Binary(BinaryOp::Minus, left, _) => is_name(left),
        _ => false,
    };
    let all = commands(&read.tree);
    let mut assignments = all
        .iter()
        .flat_map(|it| &it.updates)
        .flat_map(|it| &it.assignments);
    assignments.any(|it| it.variable.text == name && counts(&it.value))
}

/// What guards compare a variable with, where that is a number or a constant.
pub(super) fn limits<'r>(read: &'r Read<'_>, variable: &str) -> Vec<(&'r Expr, i64)> {
    fn collect<'e>(expr: &'e Expr, variable: &str, into: &mut Vec<&'e Expr>) {
        let is_own = |it: &Expr| matches!(&it.kind, ExprKind::Name(name) if name == variable);
        match &expr.kind {
            ExprKind::Binary(
                BinaryOp::Equal
                | BinaryOp::NotEqual
                | BinaryOp::Less
                | BinaryOp::LessEqual
                | BinaryOp::Greater
                | BinaryOp::GreaterEqual,
                left,
                right,
            ) => {
                if is_own(left) {
                    into.push(right);
                } else if is_own(right) {
                    into.push(left);
                }
            }
            ExprKind::Binary(_, left, right) => {
                collect(left, variable, into);
                collect(right, variable, into);
            }
            ExprKind::Unary(_, inner) => collect(inner, variable, into),
            _ => {}
        }
    }
    let mut found = Vec::new();
    for command in commands(&read.tree) {
        collect(&command.guard, variable, &mut found);
    }
    let with_value = |expr: &'r Expr| Some((expr, draws::value_of(expr, None, &read.model)?));
    found.into_iter().filter_map(with_value).collect()
}

/// What guards ask for and no update leads to. What a variable comes to by counting or computing is not read off the text.
pub(super) fn asked_in_vain(read: &Read<'_>) -> Vec<Lacking> {
    let all = commands(&read.tree);
    let is_computed = |name: &str| {
        let mut assignments = all
            .iter()
            .flat_map(|it| &it.updates)
            .flat_map(|it| &it.assignments);
        assignments.any(|it| {
            it.variable.text == name && draws::value_of(&it.value, None, &read.model).is_none()
        })
    };
    // What holds at the beginning is not read off a predicate.
    let asked = of_guards(read)
        .into_iter()
        .filter(|_| read.tree.init.is_none());
    asked.filter(|it| !is_computed(&it.variable)).collect()
}

/// A step towards what a guard asks for, where that is more than one step from the beginning.
fn counted(read: &Read<'_>, asked: &Lacking) -> Option<String> {
    let mut variables = read.model.variables.iter();
    let init = variables.find(|it| it.name == asked.variable)?.init;
    let parsed = prism_lang::parse_properties(&asked.value);
    let wanted = draws::value_of(&parsed.tree.properties.first()?.formula, None, &read.model)?;
    match wanted - init {
        2.. => Some(format!("{}+1", asked.variable)),
        ..=-2 => Some(format!("{}-1", asked.variable)),
        _ => None,
    }
}

/// The updates of the module that owns what a guard asks for, which lead there in place of what they do, or with it.
fn outcomes(read: &Read<'_>) -> Vec<Idle> {
    let lacking = asked_in_vain(read);
    let mut found = Vec::new();
    let mut first = 0;
    for module in &read.tree.modules {
        let ModuleBody::Written {
            commands: own,
            variables,
            ..
        } = &module.body
        else {
            continue;
        };
        let is_own = |name: &str| variables.iter().any(|own| own.name.text == name);
        for asked in lacking.iter().filter(|it| is_own(&it.variable)) {
            let values = [Some(asked.value.clone()), counted(read, asked)];
            for (place, command) in own.iter().enumerate() {
                for (number, update) in command.updates.iter().enumerate() {
                    let all = values.iter().flatten().flat_map(|value| {
                        let alone = format!("({}'={value})", asked.variable);
                        let with = edit::with_value(read.text, update, &asked.variable, value);
                        [alone, with]
                    });
                    let mut all: Vec<String> = all.collect();
                    all.dedup();
                    found.extend(all.into_iter().map(|to| Idle::Outcome {
                        command: first + place,
                        update: number,
                        asked: asked.meaning.clone(),
                        to,
                    }));
                }
            }
        }
        first += own.len();
    }
    found
}
