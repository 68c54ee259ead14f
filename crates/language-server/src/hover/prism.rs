//! Constants, formulas, variables and all else that models and property files declare.

use crate::cursor;
use crate::expand::expanded;
use crate::model::ModelView;
use crate::properties::PropertiesView;
use crate::workspace::Workspace;
use diagnostic::counted;
use prism_lang::ast::{self, ModuleBody};
use prism_lang::names::{Role, Space};
use prism_lang::resolved::{Model, VariableKind};
use std::fmt::Write;
use std::path::Path;

/// How long a declaration may be to be shown whole.
const LONGEST: usize = 2_000;

/// What is said of a name, by each model that declares it and by the properties file.
pub fn of_name(workspace: &Workspace, space: Space, name: &str, path: &Path) -> Vec<String> {
    let mut said = Vec::new();
    if let Some(view) = workspace
        .properties(path)
        .filter(|_| is_properties(workspace, path))
    {
        said.extend(in_properties(&view, space, name));
        if !said.is_empty() {
            said.extend(judged_with(&view));
            return said;
        }
    }
    let models = cursor::models_seen_from(workspace, path);
    let several = models.len() > 1;
    for model in models {
        if let Some(mut text) = in_model(&model, space, name) {
            if is_properties(workspace, path) {
                let view = workspace.properties(path);
                let why = view.and_then(|it| judged_with(&it));
                let _ = write!(text, "\n\n{}", why.unwrap_or_default());
            } else if several || model.path != path {
                let _ = write!(text, "\n\nin `{}`", file_name(&model.path));
            }
            said.push(text);
        }
    }
    said
}

fn is_properties(workspace: &Workspace, path: &Path) -> bool {
    workspace.kind(path) == crate::kind::Kind::Properties
}

fn judged_with(view: &PropertiesView) -> Option<String> {
    Some(format!("*{}*", view.judged_with))
}

fn file_name(path: &Path) -> String {
    let name = path.file_name().unwrap_or(path.as_os_str());
    name.to_string_lossy().into_owned()
}

fn code(text: &str) -> String {
    let shown = match text.char_indices().nth(LONGEST) {
        Some((end, _)) => &text[..end],
        None => text,
    };
    format!("```prism\n{}\n```", shown.replace("```", "'''"))
}

fn in_properties(view: &PropertiesView, space: Space, name: &str) -> Option<String> {
    let file = &view.tree;
    let text = view.text.as_str();
    match space {
        Space::Value => {
            if let Some(constant) = file.constants.iter().find(|it| it.name.text == name) {
                return Some(code(constant.span.of(text)));
            }
            let formula = file.formulas.iter().find(|it| it.name.text == name)?;
            Some(with_expansion(
                formula.span.of(text),
                &formula.body,
                &file.formulas,
            ))
        }
        Space::Label => {
            if let Some(label) = file.labels.iter().find(|it| it.name.text == name) {
                return Some(with_expansion(
                    label.span.of(text),
                    &label.body,
                    &file.formulas,
                ));
            }
            let named = |it: &&ast::Property| it.name.as_ref().is_some_and(|it| it.text == name);
            let property = file.properties.iter().find(named)?;
            Some(format!("property\n{}", code(&property.text)))
        }
        _ => None,
    }
}

fn with_expansion(text: &str, body: &ast::Expr, formulas: &[ast::Formula]) -> String {
    let mut said = code(text);
    if let Some(whole) = expanded(body, formulas) {
        let _ = write!(said, "\n\nwritten out:\n{}", code(&whole.to_string()));
    }
    said
}

/// What a model says of a name that it declares.
pub fn in_model(view: &ModelView, space: Space, name: &str) -> Option<String> {
    match space {
        Space::Value => constant(view, name)
            .or_else(|| formula(view, name))
            .or_else(|| variable(view, name)),
        Space::Action => action(view, name),
        Space::Module => module(view, name),
        Space::Label => label(view, name),
        Space::Reward => reward(view, name),
        Space::System | Space::Observable => {
            let at = view.names.definition(space, name)?;
            let what = if space == Space::System {
                "composition"
            } else {
                "observable"
            };
            let line = prism_lang::line_and_column(view.text.as_str(), at.span.start).0;
            Some(format!("{what} `{name}`, line {line}"))
        }
    }
}

fn constant(view: &ModelView, name: &str) -> Option<String> {
    let constant = view.constant(name)?;
    let mut said = code(constant.span.of(view.text.as_str()));
    let value = view.value(name);
    match (value, &constant.value) {
        (Some(value), None) => {
            let _ = write!(
                said,
                "\n\nno value here: one is given when the model is checked (`--const {name}=...`). The editor takes {value} for it."
            );
        }
        (Some(value), Some(_)) => {
            let _ = write!(said, "\n\nvalue: {value}");
            if !view.stand_ins().is_empty() && view.needed_by(name).1 {
                said.push_str(", with what the editor takes for the constants without a value");
            }
        }
        (None, None) => {
            let _ = write!(
                said,
                "\n\nno value here: one is given when the model is checked (`--const {name}=...`)"
            );
        }
        (None, Some(_)) => {}
    }
    Some(said)
}

fn formula(view: &ModelView, name: &str) -> Option<String> {
    let formula = view.formula(name)?;
    let text = formula.span.of(view.text.as_str());
    Some(with_expansion(text, &formula.body, &view.tree.formulas))
}

fn label(view: &ModelView, name: &str) -> Option<String> {
    if let Some(label) = view.label(name) {
        let text = label.span.of(view.text.as_str());
        return Some(with_expansion(text, &label.body, &view.tree.formulas));
    }
    match name {
        "init" => Some("the initial states (built in)".into()),
        "deadlock" => Some("states in which no command is enabled (built in)".into()),
        _ => None,
    }
}

fn variable(view: &ModelView, name: &str) -> Option<String> {
    let known = view.resolved().and_then(|model| {
        let index = model.variable(name)?;
        Some((model, &model.variables[index]))
    });
    let mut said = match view.variable(name) {
        Some((variable, module)) => {
            let global = if module.is_none() { "global " } else { "" };
            code(&format!("{global}{}", variable.span.of(view.text.as_str())))
        }
        None => {
            let (_, variable) = known?;
            let text = variable.span.of(view.text.as_str());
            format!("{}\n\ncopied from there as `{name}`", code(text))
        }
    };
    if let Some((model, variable)) = known {
        let owner = match &variable.module {
            Some(module) => format!("of module `{module}`"),
            None => "global: every module may change it".into(),
        };
        let _ = write!(said, "\n\n{owner}; {}", range_and_start(model, variable));
    } else if let Some((_, Some(module))) = view.variable(name) {
        let _ = write!(said, "\n\nof module `{}`", module.name.text);
    }
    Some(said)
}

fn range_and_start(model: &Model, variable: &prism_lang::resolved::Variable) -> String {
    let shown = |value: i64| match variable.kind {
        VariableKind::Bool => (value != 0).to_string(),
        _ => value.to_string(),
    };
    let range = match variable.kind {
        VariableKind::Bool => "false or true".to_owned(),
        VariableKind::Int { low, high } => {
            let count = (high as i128) - (low as i128) + 1;
            format!("{low} to {high} ({count} values)")
        }
        VariableKind::Unbounded => "any integer".to_owned(),
    };
    match model.init {
        prism_lang::resolved::Init::Single(_) => {
            format!("{range}; initially {}", shown(variable.init))
        }
        prism_lang::resolved::Init::Predicate(_) => {
            format!("{range}; initial states as `init ... endinit` says")
        }
    }
}

fn module(view: &ModelView, name: &str) -> Option<String> {
    let module = view.tree.modules.iter().find(|it| it.name.text == name)?;
    let text = view.text.as_str();
    match &module.body {
        ModuleBody::Renamed { base, .. } => {
            let said = format!("module `{name}`, a copy of `{}`", base.text);
            Some(format!("{said}\n{}", code(module.span.of(text))))
        }
        ModuleBody::Written {
            variables,
            commands,
            ..
        } => {
            let mut actions: Vec<&str> = commands
                .iter()
                .filter_map(|it| it.action.as_ref())
                .map(|it| it.text.as_str())
                .collect();
            actions.sort_unstable();
            actions.dedup();
            let mut said = format!(
                "module `{name}`: {}, {}",
                counted(variables.len(), "variable"),
                counted(commands.len(), "command")
            );
            if !actions.is_empty() {
                let _ = write!(said, "; actions {}", actions.join(", "));
            }
            let lines: Vec<&str> = variables.iter().map(|it| it.span.of(text)).collect();
            Some(format!("{said}\n{}", code(&lines.join("\n"))))
        }
    }
}

fn action(view: &ModelView, name: &str) -> Option<String> {
    let resolved = view.resolved();
    let by_module = resolved.and_then(|model| {
        let id = model.actions.iter().position(|it| it == name)?;
        let modules = model.modules.iter().filter_map(|module| {
            let count = module.commands.iter().filter(|it| it.action == Some(id));
            let count = count.count();
            (count > 0).then(|| format!("`{}` ({})", module.name, counted(count, "command")))
        });
        Some(modules.collect::<Vec<_>>())
    });
    let Some(modules) = by_module else {
        let count = view.names.of(Space::Action, name);
        let count = count.filter(|it| it.role == Role::Definition).count();
        return (count > 0).then(|| format!("action `{name}`: {}", counted(count, "command")));
    };
    let all = modules.join(", ");
    Some(match modules.len() {
        0 => format!("action `{name}`: no module has it"),
        1 => format!("action `{name}` of {all}: nothing else synchronises on it"),
        _ => format!("action `{name}`: {all} synchronise on it"),
    })
}

fn reward(view: &ModelView, name: &str) -> Option<String> {
    let named = |it: &&ast::RewardStructure| it.name.as_ref().is_some_and(|it| it.text == name);
    let structure = view.tree.rewards.iter().find(named)?;
    let of_states = |it: &&ast::RewardItem| matches!(it.kind, ast::RewardKind::State);
    let states = structure.items.iter().filter(of_states).count();
    let said = format!(
        "reward structure `{name}`: {} of states, {} of transitions",
        counted(states, "item"),
        structure.items.len() - states
    );
    Some(format!(
        "{said}\n{}",
        code(structure.span.of(view.text.as_str()))
    ))
}
