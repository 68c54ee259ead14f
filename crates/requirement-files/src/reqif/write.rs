//! Changes of a text of ReqIF.

use super::template::TIME;
use super::xhtml::{escaped, written};
use super::{Content, Names, child, elements, identifiers, leads_to_parent, parsed};
use crate::edit::{Edit, applied, line_start};
use crate::mistakes::cannot_write;
use crate::{Change, Document, Field, File, Item};
use diagnostic::Problem;
use roxmltree::Node;
use std::collections::BTreeMap;

pub(crate) fn with(document: &Document, changes: &[Change]) -> Result<Vec<File>, Problem> {
    let texts = texts(document, changes)?;
    let file = |(at, text): (usize, String)| File {
        name: document.sources[at].name.clone(),
        bytes: text.into_bytes(),
    };
    Ok(texts.into_iter().map(file).collect())
}

/// The texts that change, with the numbers of their sources.
pub(super) fn texts(
    document: &Document,
    changes: &[Change],
) -> Result<Vec<(usize, String)>, Problem> {
    let trees = parsed(&document.sources)?;
    let contents: Vec<Content<'_>> = trees
        .iter()
        .map(|it| Content::new(it.root_element()))
        .collect();
    let names = Names::new(&contents, &document.columns, &mut Vec::new());
    let ids = identifiers(&contents, &names);
    let mut writer = Writer {
        document,
        contents: &contents,
        names: &names,
        ids: &ids,
        added: BTreeMap::new(),
        edits: vec![Vec::new(); contents.len()],
        pending: Vec::new(),
    };
    for change in changes {
        if let Change::Add(item) = change {
            let identifier = writer.new_identifier(&item.id);
            writer.added.insert(item.id.clone(), identifier);
        }
    }
    for change in changes {
        match change {
            Change::Set(item, fields) => writer.set(item, fields)?,
            Change::Add(item) => writer.add(item)?,
        }
    }
    writer.insert_pending();
    let edits = writer.edits.into_iter().enumerate();
    let changed = edits.filter(|(_, edits)| !edits.is_empty());
    Ok(changed
        .map(|(at, edits)| (at, applied(&document.sources[at].text, edits)))
        .collect())
}

struct Writer<'w, 'd> {
    document: &'w Document,
    contents: &'w [Content<'d>],
    names: &'w Names,
    ids: &'w BTreeMap<&'d str, String>,
    /// Identifiers of the objects that are added, by their ids.
    added: BTreeMap<String, String>,
    edits: Vec<Vec<Edit>>,
    /// What is put into elements, together for each.
    pending: Vec<Pending<'d>>,
}

/// Elements that are put into or behind another one.
struct Pending<'d> {
    source: usize,
    element: Node<'d, 'd>,
    is_behind: bool,
    /// An element that is made around them.
    within: Option<&'static str>,
    new: Vec<String>,
}

impl<'d> Writer<'_, 'd> {
    fn text(&self, at: usize) -> &str {
        &self.document.sources[at].text
    }

    /// The prefix of the format's own elements, with its colon.
    fn prefix(&self, at: usize) -> String {
        let start = self.contents[at].root.range().start + 1;
        let name = self.text(at)[start..]
            .split(|it: char| it.is_whitespace() || it == '>')
            .next();
        match name.and_then(|name| name.split_once(':')) {
            Some((prefix, _)) => format!("{prefix}:"),
            None => String::new(),
        }
    }

    fn object(&self, id: &str) -> Option<(usize, Node<'d, 'd>)> {
        let contents = self.contents.iter().enumerate();
        let mut all =
            contents.flat_map(|(at, it)| it.objects.iter().map(move |object| (at, *object)));
        all.find(|(_, object)| {
            let identifier = object.attribute("IDENTIFIER").unwrap_or_default();
            self.ids.get(identifier).is_some_and(|known| known == id)
        })
    }

    fn set(&mut self, item: &Item, fields: &[Field]) -> Result<(), Problem> {
        let (at, object) = self
            .object(&item.id)
            .ok_or_else(|| cannot_write(&item.id, "the file does not have it"))?;
        for field in fields {
            match field {
                Field::Parents => self.set_parents(at, object, item)?,
                _ => self.set_value(at, object, item, *field)?,
            }
        }
        Ok(())
    }

    fn set_value(
        &mut self,
        at: usize,
        object: Node<'d, 'd>,
        item: &Item,
        field: Field,
    ) -> Result<(), Problem> {
        let name = self.names.of(field).ok_or_else(|| {
            cannot_write(
                &item.id,
                &format!("the file has no attribute for the {field}"),
            )
        })?;
        let value = item.value(field);
        let content = &self.contents[at];
        match content.value(object, name) {
            Some((element, _)) => {
                let definition = super::referred(element, "DEFINITION").unwrap_or_default();
                let definition = content.definitions.get(definition).map(|(_, node)| *node);
                self.check_length(at, definition, &item.id, field.name(), &value)?;
                self.replace(at, element, &item.id, &value)
            }
            None => {
                let kind = content.type_of(object);
                let definition = self.definition(at, kind, name);
                self.check_length(at, definition, &item.id, field.name(), &value)?;
                let new = self.new_value(at, kind, name, &item.id, &value)?;
                match child(object, "VALUES") {
                    Some(values) => self.put(at, values, None, new),
                    None => self.put(at, object, Some("VALUES"), new),
                }
                Ok(())
            }
        }
    }

    /// A value in the place of another.
    fn replace(
        &mut self,
        at: usize,
        element: Node<'d, 'd>,
        id: &str,
        value: &str,
    ) -> Result<(), Problem> {
        let prefix = self.prefix(at);
        let (part, new) = match element.tag_name().name() {
            "ATTRIBUTE-VALUE-XHTML" => {
                let new = format!("<{prefix}THE-VALUE>{}</{prefix}THE-VALUE>", written(value));
                ("THE-VALUE", new)
            }
            "ATTRIBUTE-VALUE-ENUMERATION" => {
                let definition = super::referred(element, "DEFINITION").unwrap_or_default();
                let references = self.references(at, definition, id, value)?;
                (
                    "VALUES",
                    format!("<{prefix}VALUES>{references}</{prefix}VALUES>"),
                )
            }
            _ => {
                let old = element.attribute_node("THE-VALUE");
                let old = old.ok_or_else(|| {
                    cannot_write(id, "the attribute has no value that could be replaced")
                })?;
                self.edits[at].push(Edit::replace(old.range_value(), attribute(value)));
                return Ok(());
            }
        };
        match child(element, part) {
            Some(old) => self.edits[at].push(Edit::replace(old.range(), new)),
            None => self.put(at, element, None, new),
        }
        Ok(())
    }

    /// References to the values of an enumeration, by their names.
    fn references(
        &self,
        at: usize,
        definition: &str,
        id: &str,
        value: &str,
    ) -> Result<String, Problem> {
        let content = &self.contents[at];
        let prefix = self.prefix(at);
        let known = content.definitions.get(definition);
        let datatype = known
            .and_then(|(_, node)| super::referred(*node, "TYPE"))
            .unwrap_or_default();
        let mut datatypes = content.root.descendants();
        let datatype = datatypes.find(|it| {
            it.tag_name().name() == "DATATYPE-DEFINITION-ENUMERATION"
                && it.attribute("IDENTIFIER") == Some(datatype)
        });
        let values: Vec<Node<'_, '_>> = datatype.map_or(Vec::new(), |it| {
            it.descendants()
                .filter(|it| it.tag_name().name() == "ENUM-VALUE")
                .collect()
        });
        let mut out = String::new();
        for name in crate::listed(value) {
            let found = values
                .iter()
                .find(|it| it.attribute("LONG-NAME") == Some(&name));
            let Some(found) = found.and_then(|it| it.attribute("IDENTIFIER")) else {
                let names: Vec<&str> = values
                    .iter()
                    .filter_map(|it| it.attribute("LONG-NAME"))
                    .collect();
                let reason = format!(
                    "its value must be one that the file has ({}), got `{name}`",
                    names.join(", ")
                );
                return Err(cannot_write(id, &reason));
            };
            out.push_str(&format!(
                "<{prefix}ENUM-VALUE-REF>{}</{prefix}ENUM-VALUE-REF>",
                escaped(found)
            ));
        }
        Ok(out)
    }

    /// The definition of an attribute of objects of this type.
    fn definition(
        &self,
        at: usize,
        kind: Option<Node<'d, 'd>>,
        name: &str,
    ) -> Option<Node<'d, 'd>> {
        let mut inner = kind?.descendants();
        inner.find(|it| {
            let identifier = it.attribute("IDENTIFIER").unwrap_or_default();
            let known = self.contents[at].definitions.get(identifier);
            known.is_some_and(|(known, _)| *known == name)
        })
    }

    /// Fails if a text is longer than the attribute's type allows: a tool that reads the file may refuse it, or cut it.
    fn check_length(
        &self,
        at: usize,
        definition: Option<Node<'d, 'd>>,
        id: &str,
        what: &str,
        value: &str,
    ) -> Result<(), Problem> {
        let Some(definition) = definition else {
            return Ok(());
        };
        let datatype = super::referred(definition, "TYPE").unwrap_or_default();
        let mut datatypes = self.contents[at].root.descendants();
        let most = datatypes
            .find(|it| {
                it.tag_name().name() == "DATATYPE-DEFINITION-STRING"
                    && it.attribute("IDENTIFIER") == Some(datatype)
            })
            .and_then(|it| it.attribute("MAX-LENGTH")?.trim().parse::<usize>().ok());
        let length = value.chars().count();
        match most.filter(|most| length > *most) {
            None => Ok(()),
            Some(most) => {
                let name = definition.attribute("LONG-NAME").unwrap_or_default();
                let reason = format!(
                    "its {what} has {}, and the attribute `{name}` of the file takes {most} at most (MAX-LENGTH)",
                    diagnostic::counted(length, "character")
                );
                Err(cannot_write(id, &reason)
                    .remedy("shorten it, or raise MAX-LENGTH in the other tool"))
            }
        }
    }

    /// The element of a value that an object of this type does not have yet.
    fn new_value(
        &self,
        at: usize,
        kind: Option<Node<'d, 'd>>,
        name: &str,
        id: &str,
        value: &str,
    ) -> Result<String, Problem> {
        let Some(definition) = self.definition(at, kind, name) else {
            return Err(cannot_write(
                id,
                &format!("objects of its type have no attribute `{name}`"),
            ));
        };
        let identifier = definition.attribute("IDENTIFIER").unwrap_or_default();
        let kind = definition
            .tag_name()
            .name()
            .trim_start_matches("ATTRIBUTE-DEFINITION-");
        let p = self.prefix(at);
        let reference = format!(
            "<{p}DEFINITION><{p}ATTRIBUTE-DEFINITION-{kind}-REF>{}</{p}ATTRIBUTE-DEFINITION-{kind}-REF></{p}DEFINITION>",
            escaped(identifier)
        );
        Ok(match kind {
            "XHTML" => format!(
                "<{p}ATTRIBUTE-VALUE-XHTML>{reference}<{p}THE-VALUE>{}</{p}THE-VALUE></{p}ATTRIBUTE-VALUE-XHTML>",
                written(value)
            ),
            "ENUMERATION" => format!(
                "<{p}ATTRIBUTE-VALUE-ENUMERATION>{reference}<{p}VALUES>{}</{p}VALUES></{p}ATTRIBUTE-VALUE-ENUMERATION>",
                self.references(at, identifier, id, value)?
            ),
            _ => format!(
                "<{p}ATTRIBUTE-VALUE-{kind} THE-VALUE=\"{}\">{reference}</{p}ATTRIBUTE-VALUE-{kind}>",
                attribute(value)
            ),
        })
    }

    /// Has an element put into another one, if wanted in one that is made there.
    fn put(
        &mut self,
        source: usize,
        element: Node<'d, 'd>,
        within: Option<&'static str>,
        new: String,
    ) {
        self.put_at(source, element, false, within, new);
    }

    fn put_at(
        &mut self,
        source: usize,
        element: Node<'d, 'd>,
        is_behind: bool,
        within: Option<&'static str>,
        new: String,
    ) {
        let known = self.pending.iter_mut().find(|it| {
            it.source == source
                && it.element == element
                && it.is_behind == is_behind
                && it.within == within
        });
        match known {
            Some(known) => known.new.push(new),
            None => self.pending.push(Pending {
                source,
                element,
                is_behind,
                within,
                new: vec![new],
            }),
        }
    }

    fn insert_pending(&mut self) {
        for pending in std::mem::take(&mut self.pending) {
            let edit = self.insertion(&pending);
            self.edits[pending.source].push(edit);
        }
    }

    /// Put behind the last child of an element, or behind it, laid out as what is there.
    fn insertion(&self, pending: &Pending<'d>) -> Edit {
        let text = self.text(pending.source);
        let element = pending.element;
        let range = element.range();
        let indent = |from: usize| {
            let line = &text[line_start(text, from)..from];
            let is_layout = line.trim().is_empty();
            if is_layout {
                line.to_owned()
            } else {
                String::new()
            }
        };
        let outer = indent(range.start);
        let first = elements(element).next();
        let inner = match (pending.is_behind, first) {
            (true, _) => outer.clone(),
            (false, Some(first)) => indent(first.range().start),
            (false, None) => format!("{outer}  "),
        };
        let p = self.prefix(pending.source);
        let (deeper, open, close) = match pending.within {
            Some(name) => (
                format!("{inner}  "),
                format!("\n{inner}<{p}{name}>"),
                format!("\n{inner}</{p}{name}>"),
            ),
            None => (inner, String::new(), String::new()),
        };
        let all: String = pending
            .new
            .iter()
            .map(|new| format!("\n{deeper}{new}"))
            .collect();
        let new = format!("{open}{all}{close}");
        let whole = &text[range.clone()];
        if pending.is_behind {
            return Edit::insert(range.end, new);
        }
        if let Some(open) = whole.strip_suffix("/>") {
            let end = whole.find(|it: char| it.is_whitespace() || it == '/');
            let name = &whole[1..end.unwrap_or(whole.len())];
            return Edit::replace(
                range,
                format!("{}>{new}\n{outer}</{name}>", open.trim_end()),
            );
        }
        match elements(element).last() {
            Some(last) => Edit::insert(last.range().end, new),
            None => {
                let open = range.start + whole.find('>').map_or(whole.len(), |it| it + 1);
                let is_one_line = !whole.contains('\n');
                let new = if is_one_line {
                    format!("{new}\n{outer}")
                } else {
                    new
                };
                Edit::insert(open, new)
            }
        }
    }

    fn new_identifier(&self, id: &str) -> String {
        let plain: String = id
            .chars()
            .map(|it| if it.is_ascii_alphanumeric() { it } else { '-' })
            .collect();
        let is_taken = |name: &str| (0..self.contents.len()).any(|at| self.text(at).contains(name));
        let mut name = format!("_corroborate-{plain}");
        let mut count = 2;
        while is_taken(&name) || self.added.values().any(|it| *it == name) {
            name = format!("_corroborate-{plain}-{count}");
            count += 1;
        }
        name
    }

    fn add(&mut self, item: &Item) -> Result<(), Problem> {
        let at = 0;
        let p = self.prefix(at);
        let content = &self.contents[at];
        let kind = self.type_for_new(at).ok_or_else(|| {
            cannot_write(
                &item.id,
                "no type of objects in the file has an attribute for the text",
            )
        })?;
        let identifier = self.added.get(&item.id).cloned().unwrap_or_default();
        let mut values = String::new();
        match &self.names.id {
            Some(name) => {
                let definition = self.definition(at, Some(kind), name);
                self.check_length(at, definition, &item.id, "id", &item.id)?;
                values.push_str(&self.new_value(at, Some(kind), name, &item.id, &item.id)?);
            }
            None if identifier != item.id => {
                return Err(cannot_write(
                    &item.id,
                    "the file has no attribute for ids like this one",
                ));
            }
            None => {}
        }
        for field in [Field::Text, Field::Rationale, Field::Status] {
            let value = item.value(field);
            if let Some(name) = self.names.of(field).filter(|_| !value.is_empty()) {
                let definition = self.definition(at, Some(kind), name);
                self.check_length(at, definition, &item.id, field.name(), &value)?;
                values.push_str(&self.new_value(at, Some(kind), name, &item.id, &value)?);
            }
        }
        let type_id = kind.attribute("IDENTIFIER").unwrap_or_default();
        let object = format!(
            "<{p}SPEC-OBJECT IDENTIFIER=\"{identifier}\" LAST-CHANGE=\"{TIME}\"><{p}TYPE><{p}SPEC-OBJECT-TYPE-REF>{}\
             </{p}SPEC-OBJECT-TYPE-REF></{p}TYPE><{p}VALUES>{values}</{p}VALUES></{p}SPEC-OBJECT>",
            escaped(type_id)
        );
        self.put_within(at, "SPEC-OBJECTS", object, &item.id)?;
        if let Some(specification) = content.specifications.first() {
            let place = format!(
                "<{p}SPEC-HIERARCHY IDENTIFIER=\"{identifier}-place\" LAST-CHANGE=\"{TIME}\"><{p}OBJECT><{p}SPEC-OBJECT-REF>\
                 {identifier}</{p}SPEC-OBJECT-REF></{p}OBJECT></{p}SPEC-HIERARCHY>"
            );
            match child(*specification, "CHILDREN") {
                Some(children) => self.put(at, children, None, place),
                None => self.put(at, *specification, Some("CHILDREN"), place),
            }
        }
        for parent in &item.parents {
            self.relate(at, &identifier, parent, &item.id)?;
        }
        Ok(())
    }

    /// The type of the objects that have a text, else the first type that has an attribute for it.
    fn type_for_new(&self, at: usize) -> Option<Node<'d, 'd>> {
        let content = &self.contents[at];
        let name = self.names.of(Field::Text)?;
        let has_text = |kind: &Node<'d, 'd>| {
            let mut inner = kind
                .descendants()
                .filter_map(|it| it.attribute("IDENTIFIER"));
            inner.any(|id| {
                content
                    .definitions
                    .get(id)
                    .is_some_and(|(known, _)| *known == name)
            })
        };
        let with_text = content
            .objects
            .iter()
            .rev()
            .find(|it| content.value(**it, name).is_some());
        let used = with_text.and_then(|it| content.type_of(*it));
        used.or_else(|| {
            let mut types = content.root.descendants();
            types.find(|it| it.tag_name().name() == "SPEC-OBJECT-TYPE" && has_text(it))
        })
    }

    /// Has an element put into a part of the content, which is made if there is none.
    fn put_within(
        &mut self,
        at: usize,
        part: &'static str,
        new: String,
        id: &str,
    ) -> Result<(), Problem> {
        let content = &self.contents[at];
        let named = |name: &str| {
            let mut all = content.root.descendants();
            all.find(|it| it.tag_name().name() == name)
        };
        if let Some(found) = named(part) {
            self.put(at, found, None, new);
            return Ok(());
        }
        // The parts have an order: relations stand behind objects, objects behind types.
        let before = match part {
            "SPEC-RELATIONS" => named("SPEC-OBJECTS").or_else(|| named("SPEC-TYPES")),
            _ => named("SPEC-TYPES"),
        };
        let before = before.ok_or_else(|| cannot_write(id, "the file has no types of objects"))?;
        self.put_at(at, before, true, Some(part), new);
        Ok(())
    }

    fn set_parents(&mut self, at: usize, object: Node<'d, 'd>, item: &Item) -> Result<(), Problem> {
        let identifier = object.attribute("IDENTIFIER").unwrap_or_default();
        let content = &self.contents[at];
        let mut known = Vec::new();
        for relation in &content.relations {
            let Some((from, to)) = Content::ends(*relation) else {
                continue;
            };
            if from != identifier || !leads_to_parent(content, *relation, self.names) {
                continue;
            }
            let to = self.ids.get(to).cloned().unwrap_or_else(|| to.to_owned());
            if item.parents.contains(&to) {
                known.push(to);
            } else {
                let text = self.text(at);
                let range = relation.range();
                let from = text[..range.start]
                    .trim_end_matches([' ', '\t', '\n', '\r'])
                    .len();
                self.edits[at].push(Edit::replace(from..range.end, ""));
            }
        }
        let missing: Vec<String> = item
            .parents
            .iter()
            .filter(|it| !known.contains(it))
            .cloned()
            .collect();
        for parent in missing {
            self.relate(at, identifier, &parent, &item.id)?;
        }
        Ok(())
    }

    fn relate(&mut self, at: usize, from: &str, parent: &str, id: &str) -> Result<(), Problem> {
        let added = self.added.get(parent).cloned();
        let known = || {
            let found = self.ids.iter().find(|(_, known)| *known == parent);
            found.map(|(identifier, _)| (*identifier).to_owned())
        };
        let Some(to) = added.or_else(known) else {
            return Err(cannot_write(
                id,
                &format!("its parent `{parent}` is not in the file"),
            ));
        };
        let mut types = self.contents[at].root.descendants();
        let kind = types.find(|it| {
            it.tag_name().name() == "SPEC-RELATION-TYPE"
                && it.attribute("LONG-NAME") == self.names.relation.as_deref()
        });
        let kind = kind.and_then(|it| it.attribute("IDENTIFIER"));
        let kind =
            kind.ok_or_else(|| cannot_write(id, "the file has no type of relations to parents"))?;
        let p = self.prefix(at);
        let identifier = self.new_identifier(&format!("{from}-{parent}"));
        self.added
            .insert(format!("{from} to {parent}"), identifier.clone());
        let relation = format!(
            "<{p}SPEC-RELATION IDENTIFIER=\"{identifier}\" LAST-CHANGE=\"{TIME}\"><{p}TYPE><{p}SPEC-RELATION-TYPE-REF>{}\
             </{p}SPEC-RELATION-TYPE-REF></{p}TYPE><{p}SOURCE><{p}SPEC-OBJECT-REF>{}</{p}SPEC-OBJECT-REF></{p}SOURCE>\
             <{p}TARGET><{p}SPEC-OBJECT-REF>{}</{p}SPEC-OBJECT-REF></{p}TARGET></{p}SPEC-RELATION>",
            escaped(kind),
            escaped(from),
            escaped(&to)
        );
        self.put_within(at, "SPEC-RELATIONS", relation, id)
    }
}

/// A value as an attribute of XML, whose line breaks are kept.
fn attribute(value: &str) -> String {
    escaped(value).replace('\n', "&#10;").replace('\t', "&#9;")
}
