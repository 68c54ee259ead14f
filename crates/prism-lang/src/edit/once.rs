//! Commands that are taken at most once in a run.

use super::{Edit, EditError, binds_weaker_than_and, declares, indentation, line_end};
use crate::ast::{Command, Model, Module, ModuleBody, Name, Variable};

/// The variable that says whether a draw was made, by the variable that the draw sets.
fn latch(variable: &str) -> String {
    format!("{variable}Drawn")
}

/// Lets the commands of a written module that assign `variable` be taken only once together; so do the commands of
/// the module's renamed copies, each copy once.
///
/// # Errors
/// If no written module owns the variable, nothing assigns it, or a name that is needed is taken.
pub fn draw_once(text: &str, tree: &Model, variable: &str) -> Result<Vec<Edit>, EditError> {
    let (module, variables, commands) =
        owner(tree, variable).ok_or_else(|| EditError::NoVariable(variable.to_owned()))?;
    let name = latch(variable);
    if declares(tree, &name) {
        return Err(EditError::NameTaken(name));
    }
    let assigning: Vec<&Command> = commands.iter().filter(|c| assigns(c, variable)).collect();
    let (Some(last), false) = (variables.last(), assigning.is_empty()) else {
        return Err(EditError::NeverAssigned(variable.to_owned()));
    };
    let indent = indentation(text, last.span.start);
    let declared = format!("{indent}{name} : bool init false;\n");
    let mut edits = vec![Edit::insert(line_end(text, last.span.end), declared)];
    for command in assigning {
        edits.extend(once(text, command, &name));
    }
    for copy in copies(tree, module) {
        edits.extend(renamed(tree, copy, variable, &name)?);
    }
    Ok(edits)
}

type Owner<'a> = (&'a Module, &'a [Variable], &'a [Command]);

fn owner<'a>(tree: &'a Model, variable: &str) -> Option<Owner<'a>> {
    tree.modules.iter().find_map(|module| match &module.body {
        ModuleBody::Written {
            variables,
            commands,
            ..
        } => {
            let is_owner = variables.iter().any(|v| v.name.text == variable);
            is_owner.then_some((module, variables.as_slice(), commands.as_slice()))
        }
        ModuleBody::Renamed { .. } => None,
    })
}

fn assigns(command: &Command, variable: &str) -> bool {
    let mut all = command.updates.iter().flat_map(|u| &u.assignments);
    all.any(|assignment| assignment.variable.text == variable)
}

fn once(text: &str, command: &Command, latch: &str) -> Vec<Edit> {
    let guard = command.guard.span;
    let mut edits = Vec::new();
    if binds_weaker_than_and(&command.guard) {
        edits.push(Edit::insert(guard.start, "("));
        edits.push(Edit::insert(guard.end, format!(") & !{latch}")));
    } else {
        edits.push(Edit::insert(guard.end, format!(" & !{latch}")));
    }
    for update in &command.updates {
        let end = update.span.end;
        edits.push(match update.assignments.is_empty() {
            false => Edit::insert(end, format!(" & ({latch}'=true)")),
            true => {
                let start = text[..end].rfind("true").unwrap_or(end);
                Edit::replace(crate::Span::new(start, end), format!("({latch}'=true)"))
            }
        });
    }
    edits
}

/// Renamed copies of a module, and copies of those.
fn copies<'a>(tree: &'a Model, module: &Module) -> Vec<&'a Module> {
    let mut names = vec![module.name.text.as_str()];
    let mut found = Vec::new();
    for other in &tree.modules {
        if let ModuleBody::Renamed { base, .. } = &other.body
            && names.contains(&base.text.as_str())
        {
            names.push(&other.name.text);
            found.push(other);
        }
    }
    found
}

/// The latch under a name of the copy's own.
fn renamed(
    tree: &Model,
    copy: &Module,
    variable: &str,
    name: &str,
) -> Result<Option<Edit>, EditError> {
    let ModuleBody::Renamed { renames, base } = &copy.body else {
        return Ok(None);
    };
    // A copy of a copy has the first copy's names on its left.
    let old = old_names(tree, base, variable);
    let of_copy = |old: &str| {
        let pair = renames.iter().find(|(from, _)| from.text == old);
        pair.map(|(_, new): &(Name, Name)| new.text.clone())
    };
    let Some((own, end)) = of_copy(&old).zip(renames.last().map(|(_, new)| new.span.end)) else {
        return Err(EditError::NoVariable(variable.to_owned()));
    };
    let (from, to) = match old == variable {
        true => (name.to_owned(), latch(&own)),
        false => (latch(&old), latch(&own)),
    };
    if declares(tree, &to) {
        return Err(EditError::NameTaken(to));
    }
    Ok(Some(Edit::insert(end, format!(", {from}={to}"))))
}

/// What a variable of the written module is called in the module `base`.
fn old_names(tree: &Model, base: &Name, variable: &str) -> String {
    let module = tree.modules.iter().find(|m| m.name.text == base.text);
    let body = module.and_then(|module| super::body_of(tree, module));
    body.map_or_else(|| variable.to_owned(), |b| b.renamed(variable).to_owned())
}
