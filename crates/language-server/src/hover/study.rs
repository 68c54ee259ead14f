//! Propositions, parameters, requirements, evidence and conditions of a study.

use crate::mentions::Thing;
use crate::model::ModelView;
use crate::toml_tree::{self, Node};
use crate::workspace::Workspace;
use prism_lang::Constants;
use std::fmt::Write;
use std::path::Path;

/// What a study says of a thing.
pub fn of_thing(workspace: &Workspace, thing: &Thing, path: &Path) -> Option<String> {
    let view = workspace.study_of(path)?;
    let study = view.study.as_ref()?;
    match thing {
        Thing::Prism(..) => None,
        Thing::Proposition(name) => {
            let proposition = study.vocabulary.propositions.get(name)?;
            let mut said = format!("`{name}`: {}", proposition.meaning);
            let bindings = [
                ("model", &proposition.model),
                ("trace", &proposition.trace),
                ("graded", &proposition.graded),
                ("column", &proposition.column),
            ];
            for (what, binding) in bindings {
                let _ = match binding {
                    Some(binding) => write!(said, "\n- {what}: `{}`", binding.text.trim()),
                    None if what == "graded" => continue,
                    None => write!(said, "\n- {what}: not bound"),
                };
            }
            if let Some(binding) = &proposition.model {
                for model in view.models().iter().filter_map(|it| workspace.model(it)) {
                    let _ = write!(said, "\n- {}", expressed(&model, &binding.text));
                }
            }
            Some(said)
        }
        Thing::Parameter(name) => {
            let parameter = study.parameters.declared.get(name)?;
            Some(format!(
                "`{name}` = {}: {}",
                parameter.text, parameter.meaning
            ))
        }
        Thing::Subject(id) => subject(study, id),
        Thing::Evidence(id) => {
            let entry = study.ledger.iter().find(|it| it.id == *id)?;
            Some(format!(
                "evidence `{id}`: {}\n\n{}",
                entry.title, entry.changed
            ))
        }
        Thing::Condition(name) => {
            let meaning = study.about.conditions.get(name)?;
            Some(format!("condition `{name}`: {meaning}"))
        }
    }
}

/// Whether a model can express a binding.
fn expressed(model: &ModelView, binding: &str) -> String {
    let name = model.path.file_name().unwrap_or(model.path.as_os_str());
    let name = name.to_string_lossy();
    let Some(resolved) = model.resolved() else {
        return format!("`{name}`: not known while it has mistakes");
    };
    let text = format!("label \"x\" = {binding};\n\"x\"");
    let tree = prism_lang::parse_properties(&text).tree;
    match prism_lang::resolve_properties(&tree, resolved, &Constants::new()) {
        Ok(_) => format!("`{name}` expresses it"),
        Err(found) => {
            let first = found.first().map_or("", |it| it.message.as_str());
            format!("`{name}` does not express it: {first}")
        }
    }
}

fn subject(study: &study::Study, id: &str) -> Option<String> {
    if let Some(requirement) = study.requirements.iter().find(|it| it.id == id) {
        let mut said = format!("requirement {id}: {}", requirement.text);
        if let Some(sentence) = &requirement.sentence {
            let _ = write!(said, "\n- sentence: {sentence}");
        }
        if let Some(property) = &requirement.property {
            let _ = write!(said, "\n- property: `{property}`");
        }
        if let Some(monitor) = &requirement.monitor {
            let _ = write!(said, "\n- monitor: `{monitor}`");
        }
        return Some(said);
    }
    let mode = study.failure_modes.iter().find(|it| it.id == id)?;
    Some(format!(
        "failure mode `{id}`, {}: {}",
        mode.name, mode.meaning
    ))
}

/// What a requirement's sentence means, and the forms that are made of it.
pub fn of_sentence(workspace: &Workspace, path: &Path, node: &Node) -> Option<String> {
    let view = workspace.study_of(path)?;
    let text = workspace.read(path)?;
    let (start, _) = toml_tree::inside(text.as_str(), &node.value);
    let study = view.study.as_ref()?;
    let forms = study.forms.subjects.iter();
    let mut sentences = forms.filter_map(|form| Some((form, form.sentence.as_ref()?)));
    let Some((form, sentence)) = sentences.find(|(_, it)| it.span.start == start) else {
        // It could not be read with the study; what can be said of it alone is said.
        let context = requirement_lang::Context::default();
        let parsed = requirement_lang::parse(node.text.as_deref()?, &context);
        return (!parsed.tree.is_incomplete()).then(|| meaning(&parsed.tree));
    };
    let mut said = meaning(&sentence.tree);
    if let Some(property) = &form.property {
        let origin = if property.from_sentence {
            "made of it"
        } else {
            "written by hand"
        };
        let _ = write!(said, "\n- property ({origin}): `{}`", property.text);
    } else if let Some(reason) = &form.no_property {
        let _ = write!(said, "\n- no property: {reason}");
    }
    match &sentence.monitor {
        Ok(monitor) => {
            if let study::Rule::Formula(rule) = &monitor.rule {
                let _ = write!(said, "\n- monitor (made of it): `{}`", rule.text);
            }
        }
        Err(reason) => {
            let _ = write!(said, "\n- no monitor: {reason}");
        }
    }
    Some(said)
}

fn meaning(tree: &requirement_lang::Sentence) -> String {
    let explanation = requirement_lang::explain(tree);
    let diagram = explanation.diagram.trim_end();
    format!(
        "{}\n```text\n{diagram}\n```",
        explanation.words.join("  \n")
    )
}
