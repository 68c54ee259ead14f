//! Executions counted from logs of changes of status, and which node they belong to.
//!
//! # Definition
//! A change of a node's status to `SUCCESS` or `FAILURE` is one execution that ended so, whatever it was before; one from
//! `RUNNING` to `IDLE` is one that was halted, and counts neither as success nor as failure.
//!
//! # Source
//! `BT::StatusChangeLogger` of BehaviorTree.CPP, which Nav2 publishes as `nav2_msgs/msg/BehaviorTreeLog`. A node is logged
//! under its name; since version 4 also under a number, counted from 1 in the order in which nodes are made.
//!
//! # Assumes
//! The log is of the tree that is read. Whether its numbers are those of the tree is checked by the names; where they are
//! not, or there are none, nodes are told apart by name alone.
//!
//! # Guarantee
//! No execution is counted for a node of another name. Nodes of one name that cannot be told apart share their counts, if
//! all are leaves; if one is not, none of them is given any, and it is said ([`Shared::is_mixed`]). Not logged, and so not
//! counted, is an execution that ends like the one before without a reset between them.

use std::collections::{BTreeMap, BTreeSet};

use crate::tree::{BehaviourTree, Kind, Node, NodeId};

/// A node's status.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// Not executed.
    Idle,
    /// Under way.
    Running,
    /// Ended with success.
    Success,
    /// Ended with failure.
    Failure,
    /// Not executed, since a precondition said so.
    Skipped,
}

impl Status {
    /// From its name, in any case.
    pub fn parse(text: &str) -> Option<Self> {
        let all = [
            ("IDLE", Self::Idle),
            ("RUNNING", Self::Running),
            ("SUCCESS", Self::Success),
            ("FAILURE", Self::Failure),
            ("SKIPPED", Self::Skipped),
        ];
        let found = all
            .iter()
            .find(|(name, _)| name.eq_ignore_ascii_case(text.trim()));
        found.map(|(_, status)| *status)
    }
}

/// One change of status.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Event<'a> {
    /// The node's name.
    pub node: &'a str,
    /// Its number, where the log has one.
    pub uid: Option<u32>,
    /// Its status before.
    pub previous: Status,
    /// Its status from then on.
    pub current: Status,
}

/// How often a node was executed, and how that ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Ended with success.
    pub succeeded: u64,
    /// Ended with failure.
    pub failed: u64,
    /// Halted before they ended.
    pub halted: u64,
}

impl Counts {
    /// Executions that ended by themselves.
    pub fn ended(&self) -> u64 {
        self.succeeded + self.failed
    }

    /// Adds the counts of another run.
    pub fn add(&mut self, other: &Self) {
        self.succeeded += other.succeeded;
        self.failed += other.failed;
        self.halted += other.halted;
    }
}

/// The executions of one run: of one recording, or of one session of it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Executions {
    by: BTreeMap<(String, Option<u32>), Counts>,
    /// Whether a name that is the label of a leaf means that leaf.
    by_label: bool,
}

impl Executions {
    /// Of a table that was made for the model: a name that is the label of a leaf means that leaf, even if other nodes are
    /// called so.
    pub fn by_label() -> Self {
        Self {
            by_label: true,
            ..Self::default()
        }
    }

    /// Counts what a change of status says.
    pub fn add(&mut self, event: &Event<'_>) {
        let more = match (event.previous, event.current) {
            (_, Status::Success) => Counts {
                succeeded: 1,
                ..Counts::default()
            },
            (_, Status::Failure) => Counts {
                failed: 1,
                ..Counts::default()
            },
            (Status::Running, Status::Idle) => Counts {
                halted: 1,
                ..Counts::default()
            },
            _ => return,
        };
        let key = (event.node.to_owned(), event.uid);
        self.by.entry(key).or_default().add(&more);
    }

    /// Whether nothing was executed.
    pub fn is_empty(&self) -> bool {
        self.by.is_empty()
    }
}

/// Nodes that share their counts: one, or several leaves of one name that the log does not tell apart.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Group {
    /// The nodes.
    pub nodes: Vec<NodeId>,
    /// Their counts, by run.
    pub by_run: Vec<Counts>,
}

impl Group {
    /// Over all runs.
    pub fn total(&self) -> Counts {
        let mut total = Counts::default();
        self.by_run.iter().for_each(|it| total.add(it));
        total
    }
}

/// A name that several nodes share where the log does not tell them apart.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Shared {
    /// The name.
    pub name: String,
    /// The nodes.
    pub nodes: Vec<NodeId>,
    /// Whether nodes with children are among them, so that their counts are not those of leaves.
    pub is_mixed: bool,
}

/// Whose executions they are.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Attributed {
    /// The leaves that were executed, in the order of the tree.
    pub leaves: Vec<Group>,
    /// The nodes `Timeout` whose executions and whose child's the log tells from others: `succeeded` are those in which the child
    /// ended in time, whatever its result, `failed` those in which it did not, `halted` those that were halted from outside.
    pub deadlines: Vec<Group>,
    /// The root by run, where the log tells it from other nodes.
    pub root: Option<Vec<Counts>>,
    /// Names that several nodes share.
    pub shared: Vec<Shared>,
    /// Names in the log that the tree does not have.
    pub unknown: BTreeSet<String>,
}

impl BehaviourTree {
    /// Whose executions those of some runs are.
    pub fn attributed(&self, runs: &[Executions]) -> Attributed {
        let by_number = self.has_numbers_of(runs);
        let mut found = Attributed::default();
        let mut of_nodes: BTreeMap<Vec<NodeId>, Vec<Counts>> = BTreeMap::new();
        for (at, run) in runs.iter().enumerate() {
            for ((name, uid), counts) in &run.by {
                let nodes = match uid.filter(|_| by_number) {
                    Some(uid) => vec![NodeId(uid as usize - 1)],
                    None => self.named(name, run.by_label),
                };
                if nodes.is_empty() {
                    found.unknown.insert(name.clone());
                    continue;
                }
                let counted = of_nodes.entry(nodes);
                let by_run = counted.or_insert_with(|| vec![Counts::default(); runs.len()]);
                by_run[at].add(counts);
            }
        }
        let leaves: BTreeSet<NodeId> = self.leaves().map(|(id, _)| id).collect();
        found.deadlines = self.deadlines(&of_nodes);
        for (nodes, by_run) in of_nodes {
            found.take(self, &leaves, nodes, by_run);
        }
        found
    }

    /// Whether the times of deadlines sufficed. A `Timeout` ends as its child does, or fails where it halts it.
    fn deadlines(&self, of_nodes: &BTreeMap<Vec<NodeId>, Vec<Counts>>) -> Vec<Group> {
        let mut found = Vec::new();
        for (id, node) in self.nodes() {
            // One with preconditions may fail without its child.
            if node.kind != Kind::Deadline || !node.preconditions.is_empty() {
                continue;
            }
            let of = |id: NodeId| of_nodes.get(&vec![id]);
            let (Some(own), Some(child)) = (of(id), of(node.children[0])) else {
                continue;
            };
            let runs = own.iter().zip(child).map(|(own, child)| {
                let late = own.failed.checked_sub(child.failed)?;
                (own.succeeded == child.succeeded).then_some(Counts {
                    succeeded: child.ended(),
                    failed: late,
                    halted: own.halted,
                })
            });
            // Where the log lacks changes, it does not say which executions ended in time.
            if let Some(by_run) = runs.collect::<Option<Vec<Counts>>>() {
                found.push(Group {
                    nodes: vec![id],
                    by_run,
                });
            }
        }
        found
    }

    /// Whether the numbers of the log are those of this tree: each has the name that the node of this number has.
    fn has_numbers_of(&self, runs: &[Executions]) -> bool {
        let mut keys = runs.iter().flat_map(|run| run.by.keys());
        keys.all(|(name, uid)| {
            let node = uid.and_then(|uid| self.nodes.get((uid as usize).checked_sub(1)?));
            node.is_some_and(|node| node.name == *name)
        })
    }

    /// The nodes of a name; if there are none, the one that has it as its label or path.
    fn named(&self, name: &str, by_label: bool) -> Vec<NodeId> {
        let mut leaves = self.leaves();
        if let Some((id, _)) = leaves.find(|(_, node)| by_label && node.label == name) {
            return vec![id];
        }
        let with = |is: &dyn Fn(&Node) -> bool| -> Vec<NodeId> {
            let nodes = self.nodes.iter().enumerate();
            let nodes = nodes.filter(|(_, node)| is(node));
            nodes.map(|(at, _)| NodeId(at)).collect()
        };
        let by_name = with(&|node| node.name == name);
        match by_name.is_empty() {
            true => with(&|node| node.label == name || node.path == name),
            false => by_name,
        }
    }
}

impl Attributed {
    fn take(
        &mut self,
        tree: &BehaviourTree,
        leaves: &BTreeSet<NodeId>,
        nodes: Vec<NodeId>,
        by_run: Vec<Counts>,
    ) {
        let are_leaves = nodes.iter().all(|it| leaves.contains(it));
        let has_leaf = nodes.iter().any(|it| leaves.contains(it));
        if nodes.len() > 1 && has_leaf {
            self.shared.push(Shared {
                name: tree.node(nodes[0]).name.clone(),
                nodes: nodes.clone(),
                is_mixed: !are_leaves,
            });
        }
        if nodes == [tree.root()] {
            self.root = Some(by_run.clone());
        }
        if are_leaves {
            self.leaves.push(Group { nodes, by_run });
        }
    }
}

impl Node {
    /// Whether it has a chance of its own to succeed.
    pub fn is_leaf(&self) -> bool {
        matches!(self.kind, Kind::Leaf(_))
    }
}
