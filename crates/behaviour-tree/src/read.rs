//! Reading a tree: files, definitions, nodes, labels, and what is noted of them.

use diagnostic::{MOST_SHOWN, Problem, Source};

use crate::expand::{Drafted, Expansion, cannot_go_on, with_preconditions};
use crate::files::{Definitions, Includer, documents, lenient, with_included};
use crate::mistakes::Mistakes;
use crate::tree::{BehaviourTree, Kind, Leaf, Node};
use crate::{expand, names, notes};

/// A tree, and what its model leaves out or assumes.
#[derive(Clone, Debug)]
pub struct Reading {
    /// The tree.
    pub tree: BehaviourTree,
    /// What is abstracted, each with its place and a remedy; at most as many as are shown.
    pub notes: Vec<Problem>,
}

/// Reads a behaviour tree in the XML of BehaviorTree.CPP, format 3 or 4, with the files that it includes.
///
/// `main` names the tree that is executed; otherwise it is the one that the file names, or the only one.
///
/// # Errors
/// All mistakes of the files as one problem, each with its place and a remedy: what is not well-formed, not defined, defined
/// twice or contains itself (`bad-behaviour-tree`), and what is beyond what is read (`unsupported-behaviour-tree`).
pub fn read(
    source: &Source,
    main: Option<&str>,
    include: &mut Includer<'_>,
) -> Result<Reading, Problem> {
    let mut mistakes = Mistakes::default();
    let files = with_included(source, include, &mut mistakes);
    let texts: Vec<String> = files.iter().map(|it| lenient(&it.text)).collect();
    let documents = documents(&texts, &mut mistakes);
    let definitions = Definitions::of(&documents, &mut mistakes);
    let main = match mistakes.is_empty() {
        true => definitions.main_tree(main, &mut mistakes),
        false => None,
    };
    let mut drafted = Vec::new();
    let mut id = String::new();
    let mut found = Mistakes::default();
    if let Some(main) = main {
        let mut expansion = Expansion::new(&definitions, &files, &mut mistakes);
        let open = main.element.attribute("ID").unwrap_or_default();
        expansion.tree(open, main.element);
        drafted = expansion.nodes;
        if !main.is_named {
            let message =
                format!("`{open}` is taken for the tree to execute: it is part of no other");
            let remedy = "write `main_tree_to_execute` on `<root>` if it is another one";
            found.note(main.element.spot(), message, remedy);
        }
        id = main.id;
    }
    if let Some(problem) = mistakes.into_problem(&files) {
        return Err(problem);
    }
    make_whole(&mut drafted);
    let tree = labelled(id, &mut drafted);
    let mut is_inside = vec![false; drafted.len()];
    tree.nodes().for_each(|(id, _)| is_inside[id.0] = true);
    notes::add(&drafted, &is_inside, &mut found);
    Ok(Reading {
        notes: found.into_problems(&files, MOST_SHOWN),
        tree,
    })
}

/// Makes leaves of nodes that cannot go on with what their children may give.
fn make_whole(drafted: &mut [Drafted]) {
    let mut found = vec![[false; 3]; drafted.len()];
    for at in (0..drafted.len()).rev() {
        let node = &drafted[at].node;
        let of_children: Vec<[bool; 3]> = node.children.iter().map(|it| found[it.0]).collect();
        let may_skip: Vec<bool> = of_children.iter().map(|it| it[2]).collect();
        if let Some(why) = cannot_go_on(&node.kind, &node.type_name, &may_skip) {
            drafted[at].node.kind = Kind::Leaf(Leaf::Whole);
            drafted[at].node.is_reactive = false;
            drafted[at].why = Some(why);
        }
        let node = &drafted[at].node;
        let own = expand::outcomes(&node.kind, &of_children);
        found[at] = with_preconditions(own, &node.preconditions);
    }
}

/// The tree; the drafted nodes are labelled, too.
fn labelled(id: String, drafted: &mut [Drafted]) -> BehaviourTree {
    let mut nodes: Vec<Node> = drafted.iter().map(|it| it.node.clone()).collect();
    names::give(&mut nodes);
    BehaviourTree { id, nodes }
}

/// Which results each node may give: success, failure, skipped.
pub(crate) fn outcomes(tree: &BehaviourTree) -> Vec<[bool; 3]> {
    let nodes = tree.all_nodes();
    let mut found = vec![[false; 3]; nodes.len()];
    for (at, node) in nodes.iter().enumerate().rev() {
        let of_children: Vec<[bool; 3]> = node.children.iter().map(|it| found[it.0]).collect();
        let own = expand::outcomes(&node.kind, &of_children);
        found[at] = with_preconditions(own, &node.preconditions);
    }
    found
}
