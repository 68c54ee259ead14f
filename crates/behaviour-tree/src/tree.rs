//! The typed tree: what each node does with the results of its children.

/// A node by its place in the tree: nodes are numbered as BehaviorTree.CPP makes them, parents before children.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct NodeId(pub usize);

/// How a node ends once it is executed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Outcome {
    /// `SUCCESS`.
    Success,
    /// `FAILURE`.
    Failure,
    /// `SKIPPED`: a precondition said that it is not to be executed now (format 4).
    Skipped,
}

/// What a leaf is, as far as the text tells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Leaf {
    /// An action.
    Action,
    /// A condition.
    Condition,
    /// Neither the text nor a list of known nodes says it.
    Unknown,
    /// A node whose inside is not modelled: it and all below it are one leaf. A note says why.
    Whole,
}

/// What a node does.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Kind {
    /// It ends in success or failure by itself.
    Leaf(Leaf),
    /// It always ends so: `AlwaysSuccess`, `Script`, a `Repeat` of no cycle.
    Always(Outcome),
    /// Children in order until one fails.
    Sequence {
        /// Whether it resumes at the child that failed (`SequenceWithMemory`).
        memory: bool,
        /// What it gives if all children are skipped.
        all_skipped: Outcome,
    },
    /// Children in order until one succeeds.
    Fallback,
    /// All children; ends with enough successes or failures.
    Parallel {
        /// Successes that it needs.
        successes: usize,
        /// Failures that end it.
        failures: usize,
        /// Whether children that are skipped count as successes: where all have to succeed (`success_count="-1"`).
        all: bool,
    },
    /// All children; fails with this many failures (`ParallelAll`).
    ParallelAll {
        /// Failures with which it fails.
        failures: usize,
    },
    /// The second child if the first succeeds, else the third (`IfThenElse`, `WhileDoElse`).
    Choice,
    /// One child by the value of an entry of the blackboard; the last by default.
    Switch,
    /// All but the last as a sequence; the last if one fails, and then failure.
    TryCatch,
    /// Success and failure exchanged.
    Inverter,
    /// Success and failure replaced.
    Force(Outcome),
    /// The child again while it fails, this often at most; `None` without end.
    Retry(Option<u32>),
    /// The child this often while it succeeds; `None` without end.
    Repeat(Option<u32>),
    /// The child until it fails.
    KeepRunningUntilFailure,
    /// The child once; then skipped, or the same result again.
    RunOnce {
        /// Whether it is skipped from the second time on.
        then_skip: bool,
    },
    /// The child if a value of the blackboard says so, else this.
    Gate(Outcome),
    /// The child if the time suffices, else failure (`Timeout`).
    Deadline,
    /// The child's result (`SubTree`, `Delay`, `RateController`).
    Pass,
    /// The first child; if it fails, the second and the first again, this often (`RecoveryNode`).
    Recovery(u32),
    /// Children in turn until one succeeds; goes on behind it next time (`RoundRobin`).
    RoundRobin {
        /// Whether it goes on with the first child behind the last.
        wraps: bool,
    },
}

/// A precondition of a node, in the order in which BehaviorTree.CPP looks at them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Precondition {
    /// `_failureIf`.
    FailureIf,
    /// `_successIf`.
    SuccessIf,
    /// `_skipIf`.
    SkipIf,
    /// `_while`.
    While,
}

impl Precondition {
    /// All of them, in their order.
    pub const ALL: [Self; 4] = [Self::FailureIf, Self::SuccessIf, Self::SkipIf, Self::While];

    /// Its attribute without the underscore.
    pub fn word(self) -> &'static str {
        match self {
            Self::FailureIf => "failureIf",
            Self::SuccessIf => "successIf",
            Self::SkipIf => "skipIf",
            Self::While => "while",
        }
    }

    /// How the node ends where its script has this value; `None` if it goes on.
    pub fn ends(self, value: bool) -> Option<Outcome> {
        match (self, value) {
            (Self::FailureIf, true) => Some(Outcome::Failure),
            (Self::SuccessIf, true) => Some(Outcome::Success),
            (Self::SkipIf, true) | (Self::While, false) => Some(Outcome::Skipped),
            _ => None,
        }
    }
}

/// A script that decides something, as far as its value is known.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Script {
    /// The text.
    pub text: String,
    /// Its value where it is a literal.
    pub literal: Option<bool>,
}

/// What is drawn: one constant of the model each.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Draw {
    /// Whether a leaf succeeds once it is executed.
    Leaf,
    /// Whether the script of a precondition is true.
    Precondition(Precondition),
    /// Whether the blackboard lets a gate's child be executed.
    Gate,
    /// Whether the time of a deadline suffices.
    Deadline,
    /// Whether a switch takes this case, given that it takes none before (counted from zero).
    Case(usize),
}

/// A node of the tree.
#[derive(Clone, Debug)]
pub struct Node {
    /// What it does.
    pub kind: Kind,
    /// As logs name it: the attribute `name`, or else the name of its type.
    pub name: String,
    /// The name of its type, for example `Sequence` or `ComputePathToPose`.
    pub type_name: String,
    /// Unique among all nodes, of letters, digits and underscores.
    pub label: String,
    /// Names from the root on, separated by `/`.
    pub path: String,
    /// The file that it stands in.
    pub file: String,
    /// Its line, counted from one.
    pub line: usize,
    /// Its parent, and its place among the children there.
    pub parent: Option<(NodeId, usize)>,
    /// Its children.
    pub children: Vec<NodeId>,
    /// Its preconditions, in their order.
    pub preconditions: Vec<(Precondition, Script)>,
    /// Whether it asks its first children again while a later one runs.
    pub is_reactive: bool,
    pub(crate) is_named: bool,
}

impl Node {
    /// What of it is drawn, but for what follows from literals.
    pub fn draws(&self) -> Vec<Draw> {
        let open = self.preconditions.iter();
        let open = open.filter(|(_, script)| script.literal.is_none());
        let mut found: Vec<Draw> = open.map(|(which, _)| Draw::Precondition(*which)).collect();
        match &self.kind {
            Kind::Leaf(_) => found.push(Draw::Leaf),
            Kind::Gate(_) => found.push(Draw::Gate),
            Kind::Deadline => found.push(Draw::Deadline),
            Kind::Switch => found.extend((1..self.children.len()).map(|at| Draw::Case(at - 1))),
            _ => {}
        }
        found
    }

    /// What names of the model's states begin with in which a leaf has ended (`ok`, `failed`), or it is known whether the time of a
    /// deadline suffices (`in_time`, `late`).
    pub fn ends(&self) -> [&'static str; 2] {
        match self.kind {
            Kind::Deadline => ["in_time", "late"],
            _ => ["ok", "failed"],
        }
    }

    /// The name of a draw, unique in the tree: the leaf's label, or one made of it.
    pub fn draw_name(&self, draw: Draw) -> String {
        draw.named(&self.label)
    }
}

impl Draw {
    pub(crate) fn named(self, label: &str) -> String {
        match self {
            Self::Leaf => label.to_owned(),
            Self::Precondition(which) => format!("{label}_{}", which.word()),
            Self::Gate => format!("{label}_if"),
            Self::Deadline => format!("{label}_in_time"),
            Self::Case(at) => format!("{label}_case_{}", at + 1),
        }
    }
}

/// A behaviour tree with its subtrees put in their places.
#[derive(Clone, Debug)]
pub struct BehaviourTree {
    /// The name of the tree that is executed; may be empty.
    pub id: String,
    /// All nodes; the first is the root. Below a leaf that stands for a whole subtree there are nodes that are not reached.
    pub(crate) nodes: Vec<Node>,
}

impl BehaviourTree {
    /// The root.
    pub fn root(&self) -> NodeId {
        NodeId(0)
    }

    /// A node.
    pub fn node(&self, id: NodeId) -> &Node {
        &self.nodes[id.0]
    }

    /// All nodes that are part of the model, parents before children.
    pub fn nodes(&self) -> impl Iterator<Item = (NodeId, &Node)> {
        let mut inside = vec![false; self.nodes.len()];
        inside[0] = true;
        for (at, node) in self.nodes.iter().enumerate() {
            let is_opaque = matches!(node.kind, Kind::Leaf(_) | Kind::Always(_));
            for child in &node.children {
                inside[child.0] = inside[at] && !is_opaque;
            }
        }
        let all = self.nodes.iter().enumerate();
        all.filter(move |(at, _)| inside[*at])
            .map(|(at, node)| (NodeId(at), node))
    }

    /// All nodes of the text, parents before children, also those that stand within a leaf.
    pub fn all_nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// The leaves: nodes with a chance of their own to succeed.
    pub fn leaves(&self) -> impl Iterator<Item = (NodeId, &Node)> {
        let is_leaf = |(_, node): &(NodeId, &Node)| matches!(node.kind, Kind::Leaf(_));
        self.nodes().filter(is_leaf)
    }

    /// The number of children of a node.
    pub(crate) fn arity(&self, id: NodeId) -> usize {
        self.nodes[id.0].children.len()
    }
}
