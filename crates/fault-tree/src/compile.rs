//! From a tree to the decision diagram of one of its events.
//!
//! Gates of one kind that stand within each other, the inner one used only there, are one gate. The arguments of a gate are
//! joined from the one furthest down in the order to the one furthest up, so that each join touches little of what is there.
//! "At least k of n" is built by `T(i, k) = if a_i then T(i+1, k-1) else T(i+1, k)`; as the first contains the second,
//! that is `(a_i and T(i+1, k-1)) or T(i+1, k)`.

use diagnostic::{Cancel, Problem};

use crate::bdd::{Diagram, FALSE, Operation, TRUE};
use crate::draft::below;
use crate::tree::{Connective, FaultTree, NodeId, NodeKind};

/// The diagram of `top` over events in an order, and its function in it.
pub(crate) fn compile<'a>(
    tree: &FaultTree,
    top: NodeId,
    events: &[NodeId],
    limit: usize,
    cancel: &'a Cancel,
) -> Result<(Diagram<'a>, u32), Problem> {
    let mut diagram = Diagram::new(limit, cancel);
    let mut functions = vec![FALSE; tree.nodes.len()];
    for (level, event) in events.iter().enumerate() {
        functions[event.index()] = diagram.decision(level as u32, FALSE, TRUE)?;
    }
    let used = below(tree, top);
    let inner = inner_gates(tree, &used);
    let mut parts: Vec<Vec<u32>> = vec![Vec::new(); tree.nodes.len()];
    for index in (0..=top.index()).filter(|it| used[*it]) {
        diagram.step()?;
        match &tree.nodes[index].kind {
            NodeKind::Basic(_) => {}
            NodeKind::House(value) => functions[index] = if *value { TRUE } else { FALSE },
            NodeKind::Gate(connective, arguments) => {
                let joined = join_parts(arguments, &inner, &functions, &mut parts);
                match inner[index] && index != top.index() {
                    true => parts[index] = joined,
                    false => functions[index] = gate(&mut diagram, *connective, joined)?,
                }
            }
        }
    }
    Ok((diagram, functions[top.index()]))
}

/// Which gates are arguments of one gate alone, which is of the same kind, `and` or `or`.
fn inner_gates(tree: &FaultTree, used: &[bool]) -> Vec<bool> {
    let kind = |index: usize| match tree.nodes[index].kind {
        NodeKind::Gate(connective @ (Connective::And | Connective::Or), _) => Some(connective),
        _ => None,
    };
    let mut users = vec![0_u32; tree.nodes.len()];
    let mut inner = vec![false; tree.nodes.len()];
    for index in (0..tree.nodes.len()).filter(|it| used[*it]) {
        if let NodeKind::Gate(_, arguments) = &tree.nodes[index].kind {
            for argument in arguments {
                let argument = argument.index();
                users[argument] = users[argument].saturating_add(1);
                inner[argument] =
                    users[argument] == 1 && kind(index).is_some() && kind(index) == kind(argument);
            }
        }
    }
    inner
}

/// The functions of a gate's arguments, with those of inner gates in their place: appended to the longest list, so that a
/// chain of gates is not copied at each of them.
fn join_parts(
    arguments: &[NodeId],
    inner: &[bool],
    functions: &[u32],
    parts: &mut [Vec<u32>],
) -> Vec<u32> {
    let lists = arguments.iter().filter(|it| inner[it.index()]);
    let longest = lists.max_by_key(|it| parts[it.index()].len()).copied();
    let mut joined = longest.map_or(Vec::new(), |it| std::mem::take(&mut parts[it.index()]));
    for argument in arguments {
        match inner[argument.index()] {
            true => joined.append(&mut parts[argument.index()]),
            false => joined.push(functions[argument.index()]),
        }
    }
    joined
}

fn gate(
    diagram: &mut Diagram<'_>,
    connective: Connective,
    mut arguments: Vec<u32>,
) -> Result<u32, Problem> {
    // From the bottom of the order up.
    arguments.sort_by_key(|it| std::cmp::Reverse((diagram.level(*it), *it)));
    match connective {
        Connective::And => fold(diagram, Operation::And, TRUE, &arguments),
        Connective::Or => fold(diagram, Operation::Or, FALSE, &arguments),
        Connective::Xor => fold(diagram, Operation::Xor, FALSE, &arguments),
        Connective::Not | Connective::Nor => {
            let any = fold(diagram, Operation::Or, FALSE, &arguments)?;
            diagram.negation(any)
        }
        Connective::Nand => {
            let all = fold(diagram, Operation::And, TRUE, &arguments)?;
            diagram.negation(all)
        }
        Connective::AtLeast(least) => at_least(diagram, least, &arguments),
    }
}

fn fold(
    diagram: &mut Diagram<'_>,
    operation: Operation,
    start: u32,
    arguments: &[u32],
) -> Result<u32, Problem> {
    arguments.iter().try_fold(start, |joined, argument| {
        diagram.apply(operation, *argument, joined)
    })
}

fn at_least(diagram: &mut Diagram<'_>, least: usize, arguments: &[u32]) -> Result<u32, Problem> {
    // `counts[k]`: at least k of the arguments so far.
    let mut counts = vec![FALSE; least + 1];
    counts[0] = TRUE;
    for (number, argument) in arguments.iter().enumerate() {
        // What can still become `least` of all.
        let missing = least.saturating_sub(arguments.len() - number - 1);
        for k in (missing.max(1)..=least.min(number + 1)).rev() {
            let with = diagram.apply(Operation::And, *argument, counts[k - 1])?;
            counts[k] = diagram.apply(Operation::Or, with, counts[k])?;
        }
    }
    Ok(counts[least])
}
