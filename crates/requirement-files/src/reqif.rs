//! The Requirements Interchange Format.
//!
//! # What is read
//! Every `SPEC-OBJECT` that has a text is a requirement. Its id is the attribute `ReqIF.ForeignID` where it has one, else its
//! `IDENTIFIER`; text, rationale and status are the attributes of the usual names ([`USUAL`]) or of those declared, of kind
//! `STRING`, `XHTML` or `ENUMERATION` (other kinds as they are written). Its parents are the targets of the `SPEC-RELATION`s that
//! it is the source of: of the only type of relations, or of the one called `Parent`, or of the one declared. The order is that
//! of the first place in a specification's hierarchy. Objects without a text (headings), attributes of other names, files and
//! tool extensions stay as they are.
//!
//! # Source
//! OMG, *Requirements Interchange Format (ReqIF)*, version 1.2, 2016, and its implementation guide by prostep ivip (the attributes
//! `ReqIF.Text`, `ReqIF.ForeignID` and their like).
//!
//! # Deviation
//! Default values of attributes are not taken for values. A document type declaration is refused, so no entity expands.

pub(crate) mod archive;
mod template;
mod write;
mod xhtml;

pub(crate) use template::empty;
pub(crate) use write::with;

use crate::mistakes::{Mistakes, bad};
use crate::{Columns, Document, Field, Format, Item, Placed};
use diagnostic::{Problem, Source, counted};
use roxmltree::{Node, ParsingOptions};
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// Nodes that one text may hold (elements, texts, comments).
const MAX_NODES: u32 = 5_000_000;

/// How attributes are usually called; the first of each list goes before the others.
const USUAL: [(Option<Field>, &[&str]); 4] = [
    (None, &["ReqIF.ForeignID", "UID", "Requirement ID"]),
    (
        Some(Field::Text),
        &[
            "ReqIF.Text",
            "STATEMENT",
            "Object Text",
            "Primary Text",
            "Text",
            "Statement",
            "Description",
        ],
    ),
    (
        Some(Field::Rationale),
        &["ReqIF.Rationale", "RATIONALE", "Rationale"],
    ),
    (
        Some(Field::Status),
        &[
            "ReqIF.Status",
            "STATUS",
            "Status",
            "ReqIF.ForeignState",
            "State",
        ],
    ),
];

/// Where attributes are that only sometimes exist.
pub(super) fn child<'d>(node: Node<'d, 'd>, name: &str) -> Option<Node<'d, 'd>> {
    let mut children = node.children();
    children.find(|it| it.tag_name().name() == name)
}

pub(super) fn elements<'d>(node: Node<'d, 'd>) -> impl Iterator<Item = Node<'d, 'd>> {
    node.children().filter(Node::is_element)
}

/// The text of the only element in a child, such as a reference.
fn referred<'d>(node: Node<'d, 'd>, name: &str) -> Option<&'d str> {
    let inner = elements(child(node, name)?).next()?;
    inner.text().map(str::trim)
}

/// The content of one text.
pub(super) struct Content<'d> {
    /// Of each attribute's definition: its name, its element.
    pub(super) definitions: HashMap<&'d str, (&'d str, Node<'d, 'd>)>,
    /// The names of enumerations' values.
    pub(super) values: HashMap<&'d str, &'d str>,
    pub(super) types: HashMap<&'d str, Node<'d, 'd>>,
    pub(super) objects: Vec<Node<'d, 'd>>,
    pub(super) relations: Vec<Node<'d, 'd>>,
    pub(super) specifications: Vec<Node<'d, 'd>>,
    pub(super) root: Node<'d, 'd>,
}

pub(super) fn options<'i>() -> ParsingOptions<'i> {
    ParsingOptions {
        allow_dtd: false,
        nodes_limit: MAX_NODES,
        ..ParsingOptions::default()
    }
}

impl<'d> Content<'d> {
    pub(super) fn new(root: Node<'d, 'd>) -> Self {
        let mut content = Self {
            definitions: HashMap::new(),
            values: HashMap::new(),
            types: HashMap::new(),
            objects: Vec::new(),
            relations: Vec::new(),
            specifications: Vec::new(),
            root,
        };
        for node in root.descendants().filter(Node::is_element) {
            let name = node.tag_name().name();
            let id = node.attribute("IDENTIFIER").unwrap_or_default();
            let long = node.attribute("LONG-NAME").unwrap_or_default();
            match name {
                "SPEC-OBJECT" => content.objects.push(node),
                "SPEC-RELATION" => content.relations.push(node),
                "SPECIFICATION" => content.specifications.push(node),
                "ENUM-VALUE" => _ = content.values.insert(id, long),
                "SPEC-OBJECT-TYPE" | "SPEC-RELATION-TYPE" => _ = content.types.insert(id, node),
                _ if name.starts_with("ATTRIBUTE-DEFINITION-") && !id.is_empty() => {
                    // Without a name it is called by its identifier.
                    let long = if long.is_empty() { id } else { long };
                    content.definitions.insert(id, (long, node));
                }
                _ => {}
            }
        }
        content
    }

    /// The value of an attribute of an object, with its element.
    pub(super) fn value(&self, object: Node<'d, 'd>, name: &str) -> Option<(Node<'d, 'd>, String)> {
        let mut values = elements(child(object, "VALUES")?);
        let found = values.find(|value| {
            let definition = referred(*value, "DEFINITION");
            let known = definition.and_then(|it| self.definitions.get(it));
            known.is_some_and(|(long, _)| *long == name)
        })?;
        Some((found, self.as_text(found)))
    }

    fn as_text(&self, value: Node<'d, 'd>) -> String {
        match value.tag_name().name() {
            "ATTRIBUTE-VALUE-XHTML" => child(value, "THE-VALUE").map_or(String::new(), xhtml::text),
            "ATTRIBUTE-VALUE-ENUMERATION" => {
                let references = child(value, "VALUES").into_iter().flat_map(elements);
                let names = references.filter_map(|it| {
                    let id = it.text()?.trim();
                    Some(self.values.get(id).copied().unwrap_or(id))
                });
                names.collect::<Vec<_>>().join(", ")
            }
            _ => value.attribute("THE-VALUE").unwrap_or_default().to_owned(),
        }
    }

    /// The type of a relation or an object.
    pub(super) fn type_of(&self, node: Node<'d, 'd>) -> Option<Node<'d, 'd>> {
        self.types.get(referred(node, "TYPE")?).copied()
    }

    /// Source and target of a relation.
    pub(super) fn ends(relation: Node<'d, 'd>) -> Option<(&'d str, &'d str)> {
        Some((referred(relation, "SOURCE")?, referred(relation, "TARGET")?))
    }
}

/// How the attributes of a document are called.
#[derive(Clone, Debug)]
pub(super) struct Names {
    pub(super) id: Option<String>,
    pub(super) fields: Vec<(Field, String)>,
    /// The type of relations that lead to parents; `None` if none is.
    pub(super) relation: Option<String>,
}

impl Names {
    pub(super) fn of(&self, field: Field) -> Option<&str> {
        let mut fields = self.fields.iter();
        fields
            .find(|(known, _)| *known == field)
            .map(|(_, name)| name.as_str())
    }

    fn new(contents: &[Content<'_>], columns: &Columns, problems: &mut Vec<String>) -> Self {
        let defined: BTreeSet<&str> = contents
            .iter()
            .flat_map(|content| content.definitions.values())
            .filter(|(_, node)| {
                let mut above = node.ancestors();
                above.any(|it| it.tag_name().name() == "SPEC-OBJECT-TYPE")
            })
            .map(|(long, _)| *long)
            .collect();
        let mut of = |field: Option<Field>, declared: Option<&str>| {
            if let Some(name) = declared {
                if !defined.contains(name) {
                    problems.push(format!("no object has an attribute `{name}`"));
                }
                return Some(name.to_owned());
            }
            let usual = USUAL.iter().find(|(known, _)| *known == field)?;
            let mut usual = usual.1.iter();
            usual
                .find(|name| defined.contains(**name))
                .map(|name| (*name).to_owned())
        };
        let id = of(None, columns.id.as_deref());
        let fields = [Field::Text, Field::Rationale, Field::Status];
        let fields: Vec<_> = fields
            .into_iter()
            .filter_map(|field| Some((field, of(Some(field), columns.of(field))?)))
            .collect();
        let has_objects = contents.iter().any(|content| !content.objects.is_empty());
        if has_objects && !fields.iter().any(|(field, _)| *field == Field::Text) {
            let names: Vec<&str> = defined.into_iter().take(20).collect();
            problems.push(match names.is_empty() {
                true => "its objects have no attributes, so no text".to_owned(),
                false => format!(
                    "no attribute is known as the text of requirements: the attributes are {}",
                    names.join(", ")
                ),
            });
        }
        let mut names = Self {
            id,
            fields,
            relation: relation(contents, columns, problems),
        };
        // Ids that people see are not always unique; identifiers are.
        if columns.id.is_none() && has_duplicates(contents, &names) {
            names.id = None;
        }
        names
    }
}

/// Whether two requirements have the same id.
fn has_duplicates(contents: &[Content<'_>], names: &Names) -> bool {
    let ids = identifiers(contents, names);
    let mut seen = BTreeSet::new();
    let mut placed = contents
        .iter()
        .enumerate()
        .flat_map(|(at, it)| placed(it, at, names, &ids));
    placed.any(|placed| !seen.insert(placed.item.id))
}

/// Whether objects have an attribute that usually is the id.
fn usual_id(contents: &[Content<'_>]) -> bool {
    let mut names = contents.iter().flat_map(|it| it.definitions.values());
    names.any(|(name, _)| USUAL[0].1.contains(name))
}

/// The type of relations that lead to parents.
fn relation(
    contents: &[Content<'_>],
    columns: &Columns,
    problems: &mut Vec<String>,
) -> Option<String> {
    let types = contents.iter().flat_map(|content| content.types.values());
    let types = types.filter(|it| it.tag_name().name() == "SPEC-RELATION-TYPE");
    let names: BTreeSet<&str> = types.filter_map(|it| it.attribute("LONG-NAME")).collect();
    if let Some(name) = columns.of(Field::Parents) {
        if !names.contains(name) {
            problems.push(format!("no relation has a type `{name}`"));
        }
        return Some(name.to_owned());
    }
    let parent = names
        .iter()
        .find(|name| name.eq_ignore_ascii_case("parent"));
    match (parent, names.len()) {
        (Some(name), _) => Some((*name).to_owned()),
        (None, 1) => names.first().map(|name| (*name).to_owned()),
        _ => None,
    }
}

pub(crate) fn read(source: Source, columns: &Columns) -> Result<Document, Problem> {
    of_sources(Format::ReqIf, vec![source], columns)
}

/// Reads the texts of a file or of an archive together.
pub(super) fn of_sources(
    format: Format,
    sources: Vec<Source>,
    columns: &Columns,
) -> Result<Document, Problem> {
    let trees = parsed(&sources)?;
    let contents: Vec<Content<'_>> = trees
        .iter()
        .map(|it| Content::new(it.root_element()))
        .collect();
    let mut problems = Vec::new();
    let names = Names::new(&contents, columns, &mut problems);
    if let Some(first) = problems.into_iter().next() {
        return Err(bad(format!("{}: {first}", sources[0].name))
            .remedy("name it with `--field`, for example `--field text=Description`"));
    }
    let mut items = Vec::new();
    let mut notes = Vec::new();
    let ids = identifiers(&contents, &names);
    for (at, content) in contents.iter().enumerate() {
        items.extend(placed(content, at, &names, &ids));
    }
    let objects: usize = contents.iter().map(|content| content.objects.len()).sum();
    if objects > items.len() {
        notes.push(format!(
            "Kept in the file: {} without a text (headings and the like).",
            counted(objects - items.len(), "object")
        ));
    }
    if names.id.is_none() && usual_id(&contents) {
        notes
            .push("The ids that people see are not unique, so identifiers are the ids.".to_owned());
    }
    let relations = contents.iter().flat_map(|it| &it.relations).count();
    let known: usize = items.iter().map(|it: &Placed| it.item.parents.len()).sum();
    if relations > known {
        notes.push(format!(
            "Kept in the file: {} of other types, or of objects without a text.",
            counted(relations - known, "relation")
        ));
    }
    let mut fields: Vec<Field> = names.fields.iter().map(|(field, _)| *field).collect();
    if names.relation.is_some() {
        fields.push(Field::Parents);
    }
    drop(contents);
    drop(trees);
    Ok(Document {
        format,
        sources,
        items,
        fields,
        notes,
        columns: columns.clone(),
        archive: Vec::new(),
        members: Vec::new(),
        archive_name: String::new(),
    })
}

/// The trees of the texts, or all mistakes of their form.
pub(super) fn parsed(sources: &[Source]) -> Result<Vec<roxmltree::Document<'_>>, Problem> {
    let mut trees = Vec::new();
    for source in sources {
        let mut mistakes = Mistakes::new(source);
        match roxmltree::Document::parse_with_options(&source.text, options()) {
            Ok(tree) => {
                let root = tree.root_element();
                if root.tag_name().name() != "REQ-IF" {
                    let message = format!("the outermost element is `{}`", root.tag_name().name());
                    let start = root.range().start;
                    mistakes.add(
                        start..start + 1,
                        message,
                        "a file of ReqIF begins with `<REQ-IF>`",
                    );
                }
                trees.push(tree);
            }
            Err(error) => {
                let at = offset(&source.text, error.pos());
                mistakes.add(
                    at..at + 1,
                    format!("this is not well-formed XML: {error}"),
                    "correct it here",
                );
            }
        }
        mistakes.or(())?;
    }
    Ok(trees)
}

/// The id of each object by its `IDENTIFIER`.
pub(super) fn identifiers<'d>(
    contents: &[Content<'d>],
    names: &Names,
) -> BTreeMap<&'d str, String> {
    let objects = contents
        .iter()
        .flat_map(|content| content.objects.iter().map(move |it| (content, *it)));
    let own = |(content, object): (&Content<'d>, Node<'d, 'd>)| {
        let identifier = object.attribute("IDENTIFIER").unwrap_or_default();
        let named = names
            .id
            .as_ref()
            .and_then(|name| content.value(object, name));
        let named = named.map(|(_, value)| value.trim().to_owned());
        let id = named
            .filter(|it| !it.is_empty())
            .unwrap_or_else(|| identifier.to_owned());
        (identifier, id)
    };
    objects.map(own).collect()
}

fn placed(
    content: &Content<'_>,
    source: usize,
    names: &Names,
    ids: &BTreeMap<&str, String>,
) -> Vec<Placed> {
    let mut order: HashMap<&str, usize> = HashMap::new();
    let in_hierarchy = |it: &Node<'_, '_>| {
        let above = it.parent_element().map(|it| it.tag_name().name());
        it.tag_name().name() == "SPEC-OBJECT-REF" && above == Some("OBJECT")
    };
    let references = content.root.descendants().filter(in_hierarchy);
    for (at, reference) in references.enumerate() {
        order
            .entry(reference.text().unwrap_or_default().trim())
            .or_insert(at);
    }
    let mut parents: HashMap<&str, Vec<String>> = HashMap::new();
    for relation in &content.relations {
        if leads_to_parent(content, *relation, names)
            && let Some((from, to)) = Content::ends(*relation)
        {
            let to = ids.get(to).cloned().unwrap_or_else(|| to.to_owned());
            let all = parents.entry(from).or_default();
            if !all.contains(&to) {
                all.push(to);
            }
        }
    }
    let mut found: Vec<(usize, Placed)> = Vec::new();
    for object in &content.objects {
        let value = |field: Field| {
            let name = names.of(field)?;
            content.value(*object, name).map(|(_, value)| value)
        };
        let text = value(Field::Text).unwrap_or_default();
        if text.trim().is_empty() {
            continue;
        }
        let identifier = object.attribute("IDENTIFIER").unwrap_or_default();
        let item = Item {
            id: ids.get(identifier).cloned().unwrap_or_default(),
            text,
            rationale: value(Field::Rationale).unwrap_or_default(),
            status: value(Field::Status).unwrap_or_default(),
            parents: parents.remove(identifier).unwrap_or_default(),
        };
        let start = object.range().start;
        let placed = Placed {
            item,
            source,
            span: start..start + 1 + object.tag_name().name().len(),
            formulas: None,
        };
        found.push((order.get(identifier).copied().unwrap_or(usize::MAX), placed));
    }
    found.sort_by_key(|(at, _)| *at);
    found.into_iter().map(|(_, placed)| placed).collect()
}

/// Whether a relation is of the type that leads to parents.
pub(super) fn leads_to_parent<'d>(
    content: &Content<'d>,
    relation: Node<'d, 'd>,
    names: &Names,
) -> bool {
    let Some(wanted) = &names.relation else {
        return false;
    };
    let kind = content
        .type_of(relation)
        .and_then(|it| it.attribute("LONG-NAME"));
    kind == Some(wanted)
}

/// The byte of a line and a column, as the parser of XML counts them.
fn offset(text: &str, position: roxmltree::TextPos) -> usize {
    let mut lines = text.split_inclusive('\n');
    let before: usize = lines
        .by_ref()
        .take((position.row as usize).saturating_sub(1))
        .map(str::len)
        .sum();
    let line = lines.next().unwrap_or_default();
    let column = line
        .char_indices()
        .nth((position.col as usize).saturating_sub(1));
    before + column.map_or(line.len(), |(index, _)| index)
}
