//! What a study's files in TOML name: propositions, parameters, identifiers, and what the formal models declare.

use crate::kind;
use crate::study_view::StudyView;
use crate::toml_tree::{self, Node};
use prism_lang::Span;
use prism_lang::names::{Names, Role, Space};
use std::collections::BTreeSet;
use std::ops::Range;
use std::path::Path;
use std::path::PathBuf;

/// What can be named across files.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Thing {
    /// What a model or a properties file declares.
    Prism(Space, String),
    /// A proposition of the vocabulary.
    Proposition(String),
    /// A parameter of the study.
    Parameter(String),
    /// A requirement or a failure mode.
    Subject(String),
    /// An entry of the ledger.
    Evidence(String),
    /// A condition under which evidence holds.
    Condition(String),
}

impl Thing {
    /// Its name.
    #[must_use]
    pub fn name(&self) -> &str {
        match self {
            Self::Prism(_, name)
            | Self::Proposition(name)
            | Self::Parameter(name)
            | Self::Subject(name)
            | Self::Evidence(name)
            | Self::Condition(name) => name,
        }
    }
}

/// A place that names something.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mention {
    /// The file.
    pub path: PathBuf,
    /// The place: the name alone.
    pub span: Range<usize>,
    /// What it names.
    pub thing: Thing,
    /// What is done with it.
    pub role: Role,
}

/// What the names of a study are.
#[derive(Clone, Debug, Default)]
pub struct Known {
    /// The propositions.
    pub propositions: BTreeSet<String>,
    /// The parameters.
    pub parameters: BTreeSet<String>,
    /// The entries of the ledger.
    pub evidence: BTreeSet<String>,
}

/// All mentions in one of a study's files: its own, explorations and variants; none in others.
#[must_use]
pub fn of_file(study: &StudyView, path: &Path, text: &str) -> Vec<Mention> {
    let name = path.file_name().and_then(|it| it.to_str()).unwrap_or("");
    let mut reader = Reader {
        path,
        text,
        known: &study.known,
        found: Vec::new(),
    };
    for node in toml_tree::nodes(text) {
        match name {
            "vocabulary.toml" => reader.vocabulary(&node),
            "parameters.toml" if node.path.len() == 1 => {
                reader.whole(
                    &node.key,
                    Thing::Parameter(node.path[0].clone()),
                    Role::Definition,
                );
            }
            "requirements.toml" => reader.requirements(&node),
            "study.toml" => reader.about(&node),
            "ledger.toml" => reader.ledger(&node),
            _ => match kind::schema_name(path) {
                Some("exploration.toml") => reader.exploration(&node),
                Some("variant.toml") => reader.variant(&node),
                _ => {}
            },
        }
    }
    reader.found.sort_by_key(|it| it.span.start);
    reader.found.dedup();
    reader.found
}

struct Reader<'r> {
    path: &'r Path,
    text: &'r str,
    known: &'r Known,
    found: Vec<Mention>,
}

impl Reader<'_> {
    fn add(&mut self, span: Range<usize>, thing: Thing, role: Role) {
        // What is escaped or written otherwise is not at its place, and is left alone.
        if self.text.get(span.clone()) == Some(thing.name()) {
            self.found.push(Mention {
                path: self.path.to_owned(),
                span,
                thing,
                role,
            });
        }
    }

    /// A key or a value that is nothing but a name, perhaps in quotes.
    fn whole(&mut self, place: &Range<usize>, thing: Thing, role: Role) {
        let (start, inside) = toml_tree::inside(self.text, place);
        let end = start + inside.len();
        self.add(start..end, thing, role);
    }

    fn value(&mut self, node: &Node, thing: impl Fn(String) -> Thing) {
        if let Some(text) = &node.text {
            self.whole(&node.value, thing(text.clone()), Role::Use);
        }
    }

    fn vocabulary(&mut self, node: &Node) {
        if let [name] = node.path.as_slice() {
            self.whole(
                &node.key,
                Thing::Proposition(name.clone()),
                Role::Definition,
            );
            return;
        }
        match node.last() {
            "model" => self.expression(node),
            "trace" | "graded" => self.predicate(node),
            _ => {}
        }
    }

    fn requirements(&mut self, node: &Node) {
        let subject = ["requirement", "failure_mode"];
        let is_own = |key: &str| subject.iter().any(|it| node.is(&[it, "*", key]));
        if is_own("id") {
            let Some(text) = node.text.clone() else {
                return;
            };
            return self.whole(&node.value, Thing::Subject(text), Role::Definition);
        }
        match node.last() {
            "same_as" => self.value(node, Thing::Subject),
            "shall" => self.sentence(node),
            "property" | "occurs" | "opportunity" => self.property(node),
            "experiment" => self.value(node, Thing::Proposition),
            "parameters" => self.value(node, Thing::Parameter),
            "on" | "evidence" | "shown_by" => self.evidence(node),
            "trigger" if !node.path.iter().any(|it| it == "monitor") => self.predicate(node),
            "when" | "assert" | "wait_for" | "hold" | "until" | "formula" => self.predicate(node),
            _ => {}
        }
    }

    fn about(&mut self, node: &Node) {
        let key = || node.last().to_owned();
        match node.path.first().map(String::as_str) {
            Some("conditions") if node.path.len() == 2 => {
                self.whole(&node.key, Thing::Condition(key()), Role::Definition);
            }
            Some("weights") if node.path.len() == 2 => {
                self.whole(&node.key, Thing::Evidence(key()), Role::Use);
            }
            Some("costs") if node.is(&["costs", "evidence", "*"]) => {
                self.whole(&node.key, Thing::Evidence(key()), Role::Use);
            }
            Some("model") if node.is(&["model", "units", "*"]) => {
                self.whole(&node.key, Thing::Prism(Space::Value, key()), Role::Use);
            }
            _ => {}
        }
    }

    fn ledger(&mut self, node: &Node) {
        if node.is(&["evidence", "*", "id"]) {
            let Some(text) = node.text.clone() else {
                return;
            };
            return self.whole(&node.value, Thing::Evidence(text), Role::Definition);
        }
        match node.last() {
            "conditions" => self.value(node, Thing::Condition),
            "from" | "reproduced_by" => self.value(node, Thing::Evidence),
            "failure_mode" | "requirement" => self.value(node, Thing::Subject),
            "constant" => self.value(node, |name| Thing::Prism(Space::Value, name)),
            key if self.known.evidence.contains(key) => {
                self.whole(&node.key, Thing::Evidence(key.to_owned()), Role::Use);
            }
            _ => {}
        }
    }

    fn exploration(&mut self, node: &Node) {
        if node.is(&["abstraction", "proposition", "*", "name"]) {
            // One that the vocabulary does not have is the exploration's own.
            if node
                .text
                .as_ref()
                .is_some_and(|it| self.known.propositions.contains(it))
            {
                self.value(node, Thing::Proposition);
            }
            return;
        }
        if node.is(&["disagreement", "constant", "*", "name"]) {
            return self.value(node, |name| Thing::Prism(Space::Value, name));
        }
        let is_of_model = node.is(&["abstraction", "proposition", "*", "model"])
            || node.is(&["trigger", "*", "model"])
            || node.is(&["goal", "*", "model"]);
        match node.last() {
            "model" if is_of_model => self.expression(node),
            "trace" | "when" | "proposition" => self.predicate(node),
            "evidence" | "model" => self.evidence(node),
            "requirement" => self.value(node, Thing::Subject),
            _ => {}
        }
    }

    fn variant(&mut self, node: &Node) {
        if node.is(&["change", "*", "constants", "*"]) {
            let name = node.last().to_owned();
            self.whole(&node.key, Thing::Prism(Space::Value, name), Role::Use);
            self.expression(node);
        } else if node.is(&["change", "*", "evidence"]) {
            self.evidence(node);
        }
    }

    fn evidence(&mut self, node: &Node) {
        let known = |text: &&String| self.known.evidence.contains(*text);
        if let Some(text) = node.text.as_ref().filter(known) {
            self.whole(&node.value, Thing::Evidence(text.clone()), Role::Use);
        }
    }

    /// An expression over a model's variables.
    fn expression(&mut self, node: &Node) {
        if node.text.is_none() {
            return;
        }
        let (start, inside) = toml_tree::inside(self.text, &node.value);
        let head = "label \"x\" = ";
        let whole = format!("{head}{inside};");
        let parsed = prism_lang::parse_properties(&whole);
        let names = Names::of_properties(&parsed.tree, &whole);
        for it in names.iter().filter(|it| it.span.start >= head.len()) {
            let span = start + it.span.start - head.len()..start + it.span.end - head.len();
            self.add(span, Thing::Prism(it.space, it.name.clone()), Role::Use);
        }
    }

    /// A property whose labels are propositions, or else the model's own.
    fn property(&mut self, node: &Node) {
        if node.text.is_none() {
            return;
        }
        let (start, inside) = toml_tree::inside(self.text, &node.value);
        let parsed = prism_lang::parse_properties(&inside);
        let names = Names::of_properties(&parsed.tree, &inside);
        for it in names.iter() {
            let is_proposition =
                it.space == Space::Label && self.known.propositions.contains(&it.name);
            let thing = match is_proposition {
                true => Thing::Proposition(it.name.clone()),
                false => Thing::Prism(it.space, it.name.clone()),
            };
            self.add(shifted(it.span, start), thing, Role::Use);
        }
    }

    fn sentence(&mut self, node: &Node) {
        if node.text.is_none() {
            return;
        }
        let (start, inside) = toml_tree::inside(self.text, &node.value);
        let context = requirement_lang::Context::default();
        let tree = requirement_lang::parse(&inside, &context).tree;
        let place = |span: requirement_lang::Span| start + span.start..start + span.end;
        for atom in tree.expressions().into_iter().flat_map(|it| it.atoms()) {
            self.name_or_predicate(&inside, start, atom.span.start..atom.span.end);
        }
        for duration in tree.stages.iter().filter_map(|it| it.timing.duration()) {
            if self.known.parameters.contains(&duration.text) {
                let thing = Thing::Parameter(duration.text.clone());
                self.add(place(duration.span), thing, Role::Use);
            }
        }
    }

    /// A proposition by its name, or a predicate over signals that has names in it.
    fn predicate(&mut self, node: &Node) {
        if node.text.is_some() {
            let (start, inside) = toml_tree::inside(self.text, &node.value);
            self.name_or_predicate(&inside, start, 0..inside.len());
        }
    }

    fn name_or_predicate(&mut self, text: &str, start: usize, part: Range<usize>) {
        let Some(words) = text.get(part.clone()) else {
            return;
        };
        for (at, word) in words_of_predicate(words) {
            let thing = match () {
                () if self.known.propositions.contains(word) => Thing::Proposition(word.to_owned()),
                () if self.known.parameters.contains(word) => Thing::Parameter(word.to_owned()),
                () => continue,
            };
            let from = start + part.start + at;
            self.add(from..from + word.len(), thing, Role::Use);
        }
    }
}

fn shifted(span: Span, by: usize) -> Range<usize> {
    span.start + by..span.end + by
}

/// The words of a predicate that may be names: not those of signals (`/robot.speed`), of texts (`'lift'`), of units behind a
/// number, or of functions.
#[must_use]
pub fn words_of_predicate(text: &str) -> Vec<(usize, &str)> {
    let mut found = Vec::new();
    let bytes = text.as_bytes();
    let is_part = |byte: u8| byte.is_ascii_alphanumeric() || byte == b'_';
    let mut at = 0;
    while at < bytes.len() {
        match bytes[at] {
            b'\'' => {
                let end = text[at + 1..].find('\'');
                at = end.map_or(bytes.len(), |end| at + end + 2);
            }
            // A topic and its fields, or a number with its unit.
            first if first == b'/' && bytes.get(at + 1).copied().is_some_and(is_part) => {
                at += 1;
                while at < bytes.len() && (is_part(bytes[at]) || matches!(bytes[at], b'/' | b'.')) {
                    at += 1;
                }
            }
            digit if digit.is_ascii_digit() => {
                while at < bytes.len() && (is_part(bytes[at]) || bytes[at] == b'.') {
                    at += 1;
                }
                let unit = text[at..].trim_start_matches(' ');
                let blanks = text.len() - at - unit.len();
                let length = unit.bytes().take_while(|it| is_part(*it)).count();
                if length > 0 && !matches!(&unit[..length], "and" | "or" | "U" | "R" | "S") {
                    at += blanks + length;
                }
            }
            first if first.is_ascii_alphabetic() || first == b'_' => {
                let length = bytes[at..].iter().take_while(|it| is_part(**it)).count();
                let word = &text[at..at + length];
                if !text[at + length..].trim_start().starts_with('(') {
                    found.push((at, word));
                }
                at += length;
                // What follows a point is a part of it.
                while bytes.get(at) == Some(&b'.') {
                    at += 1;
                    at += bytes[at..].iter().take_while(|it| is_part(**it)).count();
                }
            }
            _ => at += 1,
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_of_predicates_are_names_and_nothing_else() {
        let words = |text| -> Vec<&str> {
            words_of_predicate(text)
                .into_iter()
                .map(|it| it.1)
                .collect()
        };
        assert_eq!(
            words("released & /truth.grip_force < grip_released & distance(/a.b, /c) < 20 cm"),
            ["released", "grip_released"]
        );
        assert_eq!(
            words("!runtime_error | /robot.state == 'lift off' & x"),
            ["runtime_error", "x"]
        );
        assert_eq!(words("'open"), Vec::<&str>::new());
        assert_eq!(words("abs(/h.x - 10 cm) < near"), ["near"]);
        assert_eq!(words("é near"), ["near"]);
    }
}
