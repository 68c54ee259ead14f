//! Elements of an argument in the Goal Structuring Notation.

use std::collections::BTreeSet;

/// The kind of an element (GSN Community Standard 3, parts 1 and 2).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A claim.
    Goal,
    /// How a claim follows from the claims below it.
    Strategy,
    /// A reference to evidence.
    Solution,
    /// Under which a claim or a strategy is to be read.
    Context,
    /// Why a strategy is adequate.
    Justification,
    /// A claim that challenges another element (dialectic extension).
    CounterGoal,
    /// Evidence for a counter goal.
    CounterSolution,
}

impl Kind {
    /// The prefix of identifiers of this kind.
    pub fn prefix(self) -> &'static str {
        match self {
            Kind::Goal => "G",
            Kind::Strategy => "S",
            Kind::Solution => "Sn",
            Kind::Context => "C",
            Kind::Justification => "J",
            Kind::CounterGoal => "CG",
            Kind::CounterSolution => "CSn",
        }
    }
}

/// The evidence that a solution refers to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Citation {
    /// Its identifier in the ledger.
    pub evidence: String,
    /// BLAKE3 hash of everything that its findings depend on, in hexadecimal.
    pub inputs: String,
}

/// A place of the safety argument whose confidence is argued elsewhere.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ClaimPoint {
    /// Its name, for example `ACP-1a`.
    pub name: String,
    /// The element at the other end of the relation, or the element itself.
    pub at: String,
}

/// An element of an argument.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Node {
    /// Unique in its argument; begins with the prefix of its kind.
    pub id: String,
    /// What it is.
    pub kind: Kind,
    /// What it says.
    pub text: String,
    /// Identifiers of the elements that support it.
    pub supported_by: Vec<String>,
    /// Identifiers of contexts and justifications.
    pub in_context_of: Vec<String>,
    /// A goal or strategy without support.
    pub undeveloped: bool,
    /// Shown not to hold by an element that challenges it.
    pub defeated: bool,
    /// The element that this counter goal challenges.
    pub challenges: Option<String>,
    /// Whose confidence is argued in the confidence argument.
    pub claim_point: Option<ClaimPoint>,
    /// The claim point of the other argument whose confidence this goal argues.
    pub argues: Option<String>,
    /// The evidence, for solutions.
    pub citation: Option<Citation>,
}

/// An argument: elements with the claim that all of them serve first.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Argument {
    /// Name of the argument as a module.
    pub name: String,
    /// What it is about, in a sentence.
    pub brief: String,
    /// The elements, each after the one that refers to it.
    pub nodes: Vec<Node>,
}

impl Argument {
    /// The element with this identifier.
    pub fn node(&self, id: &str) -> Option<&Node> {
        self.nodes.iter().find(|node| node.id == id)
    }

    /// The elements that challenge this one.
    pub fn challengers<'a>(&'a self, id: &'a str) -> impl Iterator<Item = &'a Node> {
        let challenges = move |node: &&Node| node.challenges.as_deref() == Some(id);
        self.nodes.iter().filter(challenges)
    }
}

/// Puts an argument together; every element is made with its place in it.
pub(super) struct Builder {
    nodes: Vec<Node>,
    used: BTreeSet<String>,
}

impl Builder {
    pub fn new() -> Self {
        Self {
            nodes: Vec::new(),
            used: BTreeSet::new(),
        }
    }

    /// Adds an element; `name` is made into an identifier of its own.
    pub fn add(&mut self, kind: Kind, name: &str, text: impl Into<String>) -> usize {
        let id = self.free(&format!("{}-{}", kind.prefix(), identifier(name)));
        self.nodes.push(Node {
            id,
            kind,
            text: text.into(),
            supported_by: Vec::new(),
            in_context_of: Vec::new(),
            undeveloped: false,
            defeated: false,
            challenges: None,
            claim_point: None,
            argues: None,
            citation: None,
        });
        self.nodes.len() - 1
    }

    /// Adds an element that supports the one at `parent`.
    pub fn support(
        &mut self,
        parent: usize,
        kind: Kind,
        name: &str,
        text: impl Into<String>,
    ) -> usize {
        let place = self.add(kind, name, text);
        let id = self.nodes[place].id.clone();
        self.nodes[parent].supported_by.push(id);
        place
    }

    /// Adds a context of the element at `parent`.
    pub fn context(&mut self, parent: usize, kind: Kind, name: &str, text: impl Into<String>) {
        let place = self.add(kind, name, text);
        let id = self.nodes[place].id.clone();
        self.nodes[parent].in_context_of.push(id);
    }

    /// Adds a counter goal that challenges the element at `target`; if the
    /// challenge succeeds, the target is defeated.
    pub fn challenge(
        &mut self,
        target: usize,
        name: &str,
        text: impl Into<String>,
        succeeds: bool,
    ) -> usize {
        let place = self.add(Kind::CounterGoal, name, text);
        self.nodes[place].challenges = Some(self.nodes[target].id.clone());
        self.nodes[target].defeated |= succeeds;
        place
    }

    /// Names the evidence of the solution at `place`.
    pub fn cite(&mut self, place: usize, citation: Citation) {
        self.nodes[place].citation = Some(citation);
    }

    /// Marks the relation from `from` to `to` as a claim point; the element
    /// itself if they are the same.
    pub fn claim_point(&mut self, from: usize, to: usize, name: String) {
        let at = self.nodes[to].id.clone();
        self.nodes[from].claim_point = Some(ClaimPoint { name, at });
    }

    /// Says which claim point's confidence the goal at `place` argues.
    pub fn argue(&mut self, place: usize, name: String) {
        self.nodes[place].argues = Some(name);
    }

    /// The argument; what has no support is undeveloped.
    pub fn finish(mut self, name: &str, brief: String) -> Argument {
        for node in &mut self.nodes {
            let needs_support = matches!(node.kind, Kind::Goal | Kind::Strategy);
            node.undeveloped = needs_support && node.supported_by.is_empty();
        }
        Argument {
            name: name.to_owned(),
            brief,
            nodes: self.nodes,
        }
    }

    /// The identifier itself, or with the first number that makes it unique.
    fn free(&mut self, wanted: &str) -> String {
        let numbered = (2..).map(|n: u64| format!("{wanted}-{n}"));
        let mut candidates = std::iter::once(wanted.to_owned()).chain(numbered);
        let free = candidates.find(|candidate| !self.used.contains(candidate));
        // The candidates never end, so one of them is free.
        let id = free.unwrap_or_default();
        self.used.insert(id.clone());
        id
    }
}

/// Letters, digits and hyphens of a name; what else it has becomes `_`.
pub(super) fn identifier(name: &str) -> String {
    let plain = |c: char| {
        if c.is_ascii_alphanumeric() || c == '-' {
            c
        } else {
            '_'
        }
    };
    name.chars().map(plain).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_look_alike_get_identifiers_of_their_own() {
        let mut builder = Builder::new();
        for name in ["a b", "a_b", "a:b", "a b-2"] {
            builder.add(Kind::Goal, name, "");
        }
        let argument = builder.finish("x", String::new());
        let ids: Vec<&str> = argument.nodes.iter().map(|n| n.id.as_str()).collect();
        assert_eq!(ids, ["G-a_b", "G-a_b-2", "G-a_b-3", "G-a_b-2-2"]);
    }

    #[test]
    fn only_what_lacks_support_is_undeveloped() {
        let mut builder = Builder::new();
        let top = builder.add(Kind::Goal, "top", "");
        builder.support(top, Kind::Goal, "below", "");
        let counter = builder.challenge(top, "no", "", true);
        builder.support(counter, Kind::CounterSolution, "no", "");
        let argument = builder.finish("x", String::new());
        let open: Vec<&str> = argument
            .nodes
            .iter()
            .filter(|n| n.undeveloped)
            .map(|n| n.id.as_str())
            .collect();
        assert_eq!(open, ["G-below"]);
        assert!(argument.nodes[0].defeated);
        assert_eq!(argument.challengers("G-top").count(), 1);
    }
}
