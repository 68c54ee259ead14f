//! The typed tree: nodes with names, and what may be asked of them before anything is computed.

use std::collections::BTreeMap;
use std::ops::Range;

use diagnostic::{Problem, did_you_mean};

use crate::data::EventData;

/// A node of a [`FaultTree`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct NodeId(pub(crate) u32);

impl NodeId {
    pub(crate) fn index(self) -> usize {
        self.0 as usize
    }
}

/// What a gate says of its arguments.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Connective {
    /// All occur.
    And,
    /// At least one occurs.
    Or,
    /// At least so many occur.
    AtLeast(usize),
    /// The one argument does not occur.
    Not,
    /// One of two occurs, and not both.
    Xor,
    /// Not all occur.
    Nand,
    /// None occurs.
    Nor,
}

/// What a node is.
#[derive(Clone, Debug, PartialEq)]
pub enum NodeKind {
    /// A basic event, with what is known of it.
    Basic(Option<EventData>),
    /// A house event: known to occur, or not to.
    House(bool),
    /// A gate over other nodes.
    Gate(Connective, Vec<NodeId>),
}

/// A node with its name and place.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// The name; `None` for a formula within a gate of Open-PSA.
    pub name: Option<String>,
    /// What it is.
    pub kind: NodeKind,
    /// Where it is defined, in bytes of the text.
    pub span: Range<usize>,
}

/// A static fault tree: without cycles, every name defined once.
#[derive(Clone, Debug, PartialEq)]
pub struct FaultTree {
    /// Arguments stand before the gates that have them.
    pub(crate) nodes: Vec<Node>,
    pub(crate) by_name: BTreeMap<String, NodeId>,
    pub(crate) top: Option<NodeId>,
}

impl FaultTree {
    /// The top event: as the text says, or the only gate that no other gate has as an argument.
    pub fn top(&self) -> Option<NodeId> {
        self.top
    }

    /// The same tree with this top event.
    pub fn with_top(mut self, top: NodeId) -> Self {
        self.top = Some(top);
        self
    }

    /// The node of a name.
    pub fn find(&self, name: &str) -> Option<NodeId> {
        self.by_name.get(name).copied()
    }

    /// The node of a name, or what is said of a name that there is not.
    ///
    /// # Errors
    /// The code is `unknown-fault-tree-event`.
    pub fn event(&self, name: &str) -> Result<NodeId, Problem> {
        self.find(name).ok_or_else(|| self.unknown(name))
    }

    fn unknown(&self, name: &str) -> Problem {
        let similar = did_you_mean(name, self.by_name.keys().map(String::as_str));
        let remedy = similar.map_or(
            "name a gate or a basic event of the tree".to_owned(),
            |it| format!("did you mean `{it}`?"),
        );
        let message = format!("the fault tree has no event `{name}`");
        Problem::new("unknown-fault-tree-event", message).remedy(remedy)
    }

    /// A node.
    pub fn node(&self, id: NodeId) -> &Node {
        &self.nodes[id.index()]
    }

    /// The name of a node; empty for a formula without one.
    pub fn name(&self, id: NodeId) -> &str {
        self.node(id).name.as_deref().unwrap_or_default()
    }

    /// All nodes; arguments stand before the gates that have them.
    pub fn nodes(&self) -> impl ExactSizeIterator<Item = (NodeId, &Node)> {
        let nodes = self.nodes.iter().enumerate();
        nodes.map(|(index, node)| (NodeId(index as u32), node))
    }

    /// The basic events, in the order of their places.
    pub fn basic_events(&self) -> Vec<NodeId> {
        let nodes = self.nodes();
        let basic = nodes.filter(|(_, node)| matches!(node.kind, NodeKind::Basic(_)));
        let mut basic: Vec<NodeId> = basic.map(|(id, _)| id).collect();
        basic.sort_by_key(|id| self.node(*id).span.start);
        basic
    }

    /// The named gates that are no argument, in the order of their names.
    pub fn roots(&self) -> Vec<NodeId> {
        let mut used = vec![false; self.nodes.len()];
        for node in &self.nodes {
            if let NodeKind::Gate(_, arguments) = &node.kind {
                arguments.iter().for_each(|it| used[it.index()] = true);
            }
        }
        let named = self.by_name.values().copied();
        let is_gate = |id: &NodeId| matches!(self.node(*id).kind, NodeKind::Gate(..));
        named
            .filter(|id| !used[id.index()] && is_gate(id))
            .collect()
    }

    /// The same tree with data for some of its basic events, in place of what the text says of them: the clean way to give
    /// counts or intervals to a tree in a format that has none.
    ///
    /// # Errors
    /// All of the table's mistakes at once: a name that is no basic event of the tree (`unknown-fault-tree-event`), data that
    /// cannot be (`bad-event-data`).
    pub fn with_data(mut self, table: &BTreeMap<String, EventData>) -> Result<Self, Problem> {
        let mut problems = Vec::new();
        for (name, data) in table {
            match self.place_of_data(name, data) {
                Ok(id) => self.nodes[id.index()].kind = NodeKind::Basic(Some(data.clone())),
                Err(problem) => problems.push(problem),
            }
        }
        match Problem::all(problems) {
            None => Ok(self),
            Some(problem) => Err(problem),
        }
    }

    fn place_of_data(&self, name: &str, data: &EventData) -> Result<NodeId, Problem> {
        let id = self.event(name)?;
        if !matches!(self.node(id).kind, NodeKind::Basic(_)) {
            let message = format!("`{name}` is not a basic event, so it cannot be given data");
            return Err(Problem::new("bad-event-data", message).remedy("name a basic event"));
        }
        match data.mistake() {
            None => Ok(id),
            Some(mistake) => Err(
                Problem::new("bad-event-data", format!("`{name}`: {mistake}"))
                    .remedy("correct the numbers"),
            ),
        }
    }
}
