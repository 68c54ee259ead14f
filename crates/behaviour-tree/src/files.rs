//! The files of a tree: the one that is asked for and those that it includes, and what they define.

use std::collections::{BTreeMap, BTreeSet};

use diagnostic::{Problem, Source};
use roxmltree::{Document, Node, ParsingOptions};

use crate::mistakes::{Mistakes, Spot};
use crate::tree::Leaf;

/// Nodes that one text may hold (elements, texts, comments).
const MAX_NODES: u32 = 2_000_000;
/// Files that may be included, all together.
const MAX_FILES: usize = 256;

/// What `<include path>` names: the path as written, and the name of the file that has it, to that file.
pub type Includer<'a> = dyn FnMut(&str, &str) -> Result<Source, Problem> + 'a;

/// The file that is asked for, then those that are included, each once, in the order in which they are met.
pub(crate) fn with_included(
    source: &Source,
    include: &mut Includer<'_>,
    mistakes: &mut Mistakes,
) -> Vec<Source> {
    let mut files = vec![source.clone()];
    let mut at = 0;
    while at < files.len() {
        let file = files[at].clone();
        // What is not well-formed is said once, when it is read in full.
        let text = lenient(&file.text);
        let document = parsed(&text);
        let elements = document.iter().flat_map(|it| it.root_element().children());
        for element in elements.filter(|it| it.has_tag_name("include")) {
            let spot = Spot::new(at, tag(element));
            let Some(path) = element.attribute("path") else {
                mistakes.add(spot, "`include` has no path", "write `path=\"...\"`");
                continue;
            };
            if element.attribute("ros_pkg").is_some() {
                let message = format!("`{path}` is included from a package of ROS");
                mistakes.refuse(spot, message, "write its path without `ros_pkg`");
                continue;
            }
            if files.len() >= MAX_FILES {
                let message = format!("more than {MAX_FILES} files are included");
                mistakes.refuse(spot, message, "include fewer files");
                return files;
            }
            match include(path, &file.name) {
                Ok(found) if files.iter().all(|it| it.name != found.name) => files.push(found),
                Ok(_) => {}
                Err(problem) => {
                    let message = format!("`{path}` cannot be included: {}", problem.message());
                    mistakes.add(spot, message, "correct the path, or take the line away");
                }
            }
        }
        at += 1;
    }
    files
}

/// What stands for an `&` that begins no reference.
const BARE: char = '\u{7f}';

/// The text as the parser that BehaviorTree.CPP uses takes it: an `&` that begins no reference, as in a script's `a && b`, stands
/// for itself. It is replaced by another character of one byte, so that places stay.
pub(crate) fn lenient(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for (at, c) in text.char_indices() {
        let is_bare = c == '&' && !begins_reference(&text[at + 1..]);
        out.push(if is_bare { BARE } else { c });
    }
    out
}

/// A text from [`lenient`] as it was written.
pub(crate) fn as_written(text: &str) -> String {
    text.replace(BARE, "&")
}

fn begins_reference(behind: &str) -> bool {
    let name = behind.split(';').next().unwrap_or_default();
    let is_known = ["amp", "lt", "gt", "quot", "apos"].contains(&name) || name.starts_with('#');
    is_known && name.len() < behind.len()
}

/// Each file as a document; what is not well-formed is a mistake.
pub(crate) fn documents<'d>(
    files: &'d [String],
    mistakes: &mut Mistakes,
) -> Vec<Option<Document<'d>>> {
    let mut found = Vec::with_capacity(files.len());
    for (number, file) in files.iter().enumerate() {
        let document = parsed(file);
        if let Err(error) = &document {
            let at = offset(file, error.pos());
            let message = format!("this is not well-formed XML: {error}");
            mistakes.add(Spot::new(number, at..at + 1), message, "correct it here");
        }
        found.push(document.ok());
    }
    found
}

fn parsed(text: &str) -> Result<Document<'_>, roxmltree::Error> {
    let options = ParsingOptions {
        allow_dtd: false,
        nodes_limit: MAX_NODES,
        ..ParsingOptions::default()
    };
    Document::parse_with_options(text, options)
}

/// An element of one of the files.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Element<'d> {
    pub file: usize,
    pub node: Node<'d, 'd>,
}

impl<'d> Element<'d> {
    /// The beginning of its tag.
    pub fn spot(self) -> Spot {
        Spot::new(self.file, tag(self.node))
    }

    /// The value of one of its attributes.
    pub fn spot_of(self, attribute: &str) -> Spot {
        let found = self.node.attribute_node(attribute);
        found.map_or(self.spot(), |it| Spot::new(self.file, it.range_value()))
    }

    /// Its child elements.
    pub fn children(self) -> impl Iterator<Item = Self> {
        let file = self.file;
        let elements = self.node.children().filter(Node::is_element);
        elements.map(move |node| Element { file, node })
    }

    /// An attribute that is not empty.
    pub fn attribute(self, name: &str) -> Option<&'d str> {
        self.node.attribute(name).filter(|it| !it.trim().is_empty())
    }
}

/// The tree that is executed.
pub(crate) struct Main<'d> {
    /// Its ID; may be empty.
    pub id: String,
    pub element: Element<'d>,
    /// Whether it is named, or the only one.
    pub is_named: bool,
}

/// What the files define.
#[derive(Debug, Default)]
pub(crate) struct Definitions<'d> {
    /// The trees by their IDs, each the element `BehaviorTree`.
    pub trees: BTreeMap<&'d str, Element<'d>>,
    /// The tree of a file whose only tree has no ID.
    pub nameless: Option<Element<'d>>,
    /// The types of leaves and of others, as `TreeNodesModel` and explicit tags say it; `None` for those with children.
    pub types: BTreeMap<&'d str, Option<Leaf>>,
    /// By file, whether it is of format 4.
    pub is_format_4: Vec<bool>,
    /// The tree that the first file says is to be executed.
    pub main: Option<&'d str>,
}

impl<'d> Definitions<'d> {
    pub fn of(documents: &'d [Option<Document<'d>>], mistakes: &mut Mistakes) -> Self {
        let mut found = Self::default();
        for (file, document) in documents.iter().enumerate() {
            found.is_format_4.push(false);
            let Some(document) = document else { continue };
            let root = Element {
                file,
                node: document.root_element(),
            };
            if !root.node.has_tag_name("root") {
                let message = format!("the outermost element is `{}`", root.node.tag_name().name());
                let remedy = "a file of BehaviorTree.CPP begins with `<root BTCPP_format=\"4\">`";
                mistakes.add(root.spot(), message, remedy);
                continue;
            }
            found.format(root, mistakes);
            if file == 0 {
                found.main = root.attribute("main_tree_to_execute");
            }
            root.children().for_each(|it| found.define(it, mistakes));
        }
        found
    }

    fn format(&mut self, root: Element<'d>, mistakes: &mut Mistakes) {
        let format = root.attribute("BTCPP_format").map(str::trim);
        match format {
            Some("4") => self.is_format_4[root.file] = true,
            None | Some("3") => {}
            Some(other) => {
                let message = format!("BTCPP_format is `{other}`; 3 and 4 are read");
                mistakes.refuse(root.spot_of("BTCPP_format"), message, "write format 3 or 4");
            }
        }
    }

    fn define(&mut self, element: Element<'d>, mistakes: &mut Mistakes) {
        match element.node.tag_name().name() {
            "BehaviorTree" => self.define_tree(element, mistakes),
            "TreeNodesModel" => element.children().for_each(|it| self.define_type(it)),
            // Groot keeps its own notes beside the trees.
            _ => {}
        }
    }

    fn define_tree(&mut self, element: Element<'d>, mistakes: &mut Mistakes) {
        let Some(id) = element.attribute("ID") else {
            if self.nameless.replace(element).is_some() {
                let message = "this `BehaviorTree` has no ID, and there is another one";
                mistakes.add(element.spot(), message, "write `ID=\"...\"`");
            }
            return;
        };
        if self.trees.insert(id, element).is_some() {
            let message = format!("the tree `{id}` is defined twice");
            mistakes.add(element.spot_of("ID"), message, "keep one of them");
        }
    }

    fn define_type(&mut self, element: Element<'d>) {
        let is = match element.node.tag_name().name() {
            "Action" => Some(Leaf::Action),
            "Condition" => Some(Leaf::Condition),
            _ => None,
        };
        if let Some(id) = element.attribute("ID") {
            self.types.insert(id, is);
        }
    }

    /// The tree that is executed: as asked for, as the first file says, the only one, or the only one that is part of no other.
    pub fn main_tree(&self, asked: Option<&str>, mistakes: &mut Mistakes) -> Option<Main<'d>> {
        let main = |id: &str, element: Element<'d>, is_named: bool| Main {
            id: id.to_owned(),
            element,
            is_named,
        };
        if let Some(id) = asked.or(self.main) {
            if let Some(element) = self.trees.get(id) {
                return Some(main(id, *element, true));
            }
            let message = format!("the tree to execute, `{id}`, is not defined");
            mistakes.add(Spot::new(0, 0..0), message, self.known_trees(id));
            return None;
        }
        let outer = self.outer_trees();
        match (&outer[..], self.nameless) {
            ([(id, element)], None) => Some(main(id, *element, self.trees.len() == 1)),
            ([], Some(element)) if self.trees.is_empty() => Some(main("", element, true)),
            ([], None) if self.trees.is_empty() => {
                let message = "there is no `BehaviorTree`";
                mistakes.add(Spot::new(0, 0..0), message, "name a file that has one");
                None
            }
            _ => {
                let message = "several trees are defined, and none is named as the one to execute";
                mistakes.add(Spot::new(0, 0..0), message, self.known_trees(""));
                None
            }
        }
    }

    /// The trees that are part of no other.
    fn outer_trees(&self) -> Vec<(&'d str, Element<'d>)> {
        let elements = self.trees.values().flat_map(|it| it.node.descendants());
        let inner = elements.filter(|it| matches!(it.tag_name().name(), "SubTree" | "SubTreePlus"));
        let inner: BTreeSet<&str> = inner.filter_map(|it| it.attribute("ID")).collect();
        let trees = self.trees.iter().filter(|(id, _)| !inner.contains(*id));
        trees.map(|(id, element)| (*id, *element)).collect()
    }

    fn known_trees(&self, id: &str) -> String {
        let similar = diagnostic::did_you_mean(id, self.trees.keys().copied());
        match (similar, self.trees.keys().next()) {
            (Some(similar), _) => format!("did you mean `{similar}`?"),
            (None, Some(first)) => {
                format!(
                    "write `main_tree_to_execute=\"{first}\"` on `<root>`, or another tree's ID"
                )
            }
            (None, None) => "define it with `<BehaviorTree ID=\"...\">`".to_owned(),
        }
    }
}

/// The place of an element: the beginning of its tag.
fn tag(node: Node<'_, '_>) -> std::ops::Range<usize> {
    let start = node.range().start;
    start..start + 1 + node.tag_name().name().len()
}

/// The byte of a line and a column, as the parser of XML counts them.
fn offset(text: &str, position: roxmltree::TextPos) -> usize {
    let mut lines = text.split_inclusive('\n');
    let before = lines.by_ref().take(position.row.saturating_sub(1) as usize);
    let before: usize = before.map(str::len).sum();
    let line = lines.next().unwrap_or_default();
    let column = line
        .char_indices()
        .nth(position.col.saturating_sub(1) as usize);
    before + column.map_or(line.len(), |(index, _)| index)
}
