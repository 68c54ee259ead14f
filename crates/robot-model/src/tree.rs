//! Links and connections in any order to a tree in which parents come first.

use std::collections::BTreeMap;

/// Why connections are no tree. Indices are those of the given connections and links.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum NoTree {
    /// The second connection gives a link another parent.
    TwoParents { link: usize, second: usize },
    /// The connection lies on a cycle.
    Cycle { connection: usize },
}

/// A connection: child link, parent link (`None`: the world).
pub(crate) type Connection = (usize, Option<usize>);

/// The order in which links come, parents first; each with its connection, if it has one. Depth first from the links
/// without a connection or connected to the world, in the order of the links, so it is what a reader expects.
pub(crate) fn order(
    links: usize,
    connections: &[Connection],
) -> Result<Vec<(usize, Option<usize>)>, NoTree> {
    let mut of_child: Vec<Option<usize>> = vec![None; links];
    let mut children: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (index, (child, parent)) in connections.iter().enumerate() {
        if of_child[*child].is_some() {
            return Err(NoTree::TwoParents {
                link: *child,
                second: index,
            });
        }
        of_child[*child] = Some(index);
        if let Some(parent) = parent {
            children.entry(*parent).or_default().push(*child);
        }
    }
    let is_root = |link: &usize| of_child[*link].is_none_or(|index| connections[index].1.is_none());
    let mut stack: Vec<usize> = (0..links).filter(is_root).rev().collect();
    let mut found = Vec::with_capacity(links);
    while let Some(link) = stack.pop() {
        found.push((link, of_child[link]));
        if let Some(below) = children.get(&link) {
            stack.extend(below.iter().rev());
        }
    }
    if found.len() == links {
        return Ok(found);
    }
    // Whatever cannot be reached from a root hangs on a cycle; following parents from it ends on the cycle.
    let reached: std::collections::BTreeSet<usize> = found.iter().map(|(link, _)| *link).collect();
    let mut link = (0..links).find(|link| !reached.contains(link)).unwrap_or(0);
    for _ in 0..links {
        let parent = of_child[link].and_then(|index| connections[index].1);
        link = parent.unwrap_or(link);
    }
    Err(NoTree::Cycle {
        connection: of_child[link].unwrap_or(0),
    })
}
