//! The outline of a document.

use crate::kind::Kind;
use crate::model::ModelView;
use crate::properties::PropertiesView;
use crate::text::Text;
use crate::toml_tree::{self, Node};
use crate::workspace::Workspace;
use ls_types::{DocumentSymbol, SymbolKind};
use prism_lang::Span;
use prism_lang::ast::{self, ModuleBody};
use std::ops::Range;
use std::path::Path;

/// What a document declares, in the order of the text.
#[must_use]
pub fn of_file(workspace: &Workspace, path: &Path) -> Vec<DocumentSymbol> {
    let mut all = match workspace.kind(path) {
        Kind::Model => workspace.model(path).map_or(Vec::new(), |it| of_model(&it)),
        Kind::Properties => workspace
            .properties(path)
            .map_or(Vec::new(), |it| of_properties(&it)),
        Kind::Toml => workspace.read(path).map_or(Vec::new(), |it| of_toml(&it)),
        Kind::Other => Vec::new(),
    };
    all.sort_by_key(|it| it.range.start);
    all
}

/// A symbol; the name's place has to lie within the whole.
fn symbol(
    text: &Text,
    name: &str,
    kind: SymbolKind,
    whole: Range<usize>,
    named: Range<usize>,
    children: Vec<DocumentSymbol>,
) -> DocumentSymbol {
    let whole = whole.start.min(named.start)..whole.end.max(named.end);
    #[expect(deprecated, reason = "the field has to be given")]
    DocumentSymbol {
        name: if name.is_empty() {
            "(no name)".into()
        } else {
            name.to_owned()
        },
        detail: None,
        kind,
        tags: None,
        deprecated: None,
        range: text.range(whole),
        selection_range: text.range(named),
        children: (!children.is_empty()).then_some(children),
    }
}

fn of_name(text: &Text, name: &ast::Name, kind: SymbolKind, whole: Span) -> DocumentSymbol {
    let named = name.span.start..name.span.end;
    symbol(
        text,
        &name.text,
        kind,
        whole.start..whole.end,
        named,
        Vec::new(),
    )
}

fn of_model(view: &ModelView) -> Vec<DocumentSymbol> {
    let (text, tree) = (&*view.text, &view.tree);
    let mut all = declarations(text, &tree.constants, &tree.formulas, &tree.labels);
    let variable = |it: &ast::Variable| of_name(text, &it.name, SymbolKind::VARIABLE, it.span);
    all.extend(tree.globals.iter().map(variable));
    for module in &tree.modules {
        let children = match &module.body {
            ModuleBody::Written { variables, .. } => variables.iter().map(variable).collect(),
            ModuleBody::Renamed { .. } => Vec::new(),
        };
        let mut one = of_name(text, &module.name, SymbolKind::MODULE, module.span);
        one.children = Some(children);
        all.push(one);
    }
    for rewards in &tree.rewards {
        let span = rewards.span;
        all.push(match &rewards.name {
            Some(name) => of_name(text, name, SymbolKind::STRUCT, span),
            None => symbol(
                text,
                "rewards",
                SymbolKind::STRUCT,
                span.start..span.end,
                span.start..span.start,
                Vec::new(),
            ),
        });
    }
    all
}

fn declarations(
    text: &Text,
    constants: &[ast::Constant],
    formulas: &[ast::Formula],
    labels: &[ast::Label],
) -> Vec<DocumentSymbol> {
    let constants = constants.iter();
    let constants = constants.map(|it| of_name(text, &it.name, SymbolKind::CONSTANT, it.span));
    let formulas = formulas.iter();
    let formulas = formulas.map(|it| of_name(text, &it.name, SymbolKind::FUNCTION, it.span));
    let labels = labels.iter();
    let labels = labels.map(|it| of_name(text, &it.name, SymbolKind::ENUM_MEMBER, it.span));
    constants.chain(formulas).chain(labels).collect()
}

fn of_properties(view: &PropertiesView) -> Vec<DocumentSymbol> {
    let (text, tree) = (&*view.text, &view.tree);
    let mut all = declarations(text, &tree.constants, &tree.formulas, &tree.labels);
    for property in &tree.properties {
        let span = property.span.start..property.span.end;
        all.push(match &property.name {
            Some(name) => of_name(text, name, SymbolKind::PROPERTY, property.span),
            None => {
                let shown: String = property.text.chars().take(60).collect();
                symbol(
                    text,
                    &shown,
                    SymbolKind::PROPERTY,
                    span.clone(),
                    span,
                    Vec::new(),
                )
            }
        });
    }
    all
}

/// Tables and entries by their identifiers; keys of tables stay out.
fn of_toml(text: &Text) -> Vec<DocumentSymbol> {
    let nodes = toml_tree::nodes(text.as_str());
    let is_element = |node: &&Node| {
        let number = node
            .path
            .last()
            .is_some_and(|it| it.parse::<usize>().is_ok());
        node.has_parts && (node.path.len() == 1 || node.path.len() == 2 && number)
    };
    let is_list = |node: &Node| {
        let first = [node.path[0].clone(), "0".to_owned()];
        node.path.len() == 1 && nodes.iter().any(|it| it.path == first && it.has_parts)
    };
    let mut all = Vec::new();
    for node in nodes.iter().filter(is_element).filter(|it| !is_list(it)) {
        let id = nodes.iter().find(|it| {
            it.path.len() == node.path.len() + 1
                && it.path.starts_with(&node.path)
                && it.path.last().is_some_and(|key| key == "id")
        });
        let name = match id.and_then(|it| it.text.clone()) {
            Some(id) => format!("{} {id}", node.path[0]),
            None => node.path.join("."),
        };
        let named = id.map_or(node.key.clone(), |it| it.value.clone());
        all.push(symbol(
            text,
            &name,
            SymbolKind::OBJECT,
            node.value.clone(),
            named,
            Vec::new(),
        ));
    }
    all
}
