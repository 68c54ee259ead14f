//! A label for each node: unique, of letters, digits and underscores, and near to what the text calls it.
//!
//! Leaves come first, since their labels are read most. Those that share a name are told apart by the names around them,
//! the nearest first; where that does not do it, and for nodes with children, by numbers.

use std::collections::{BTreeMap, BTreeSet};

use crate::tree::{Draw, Kind, Node};

/// Names around a leaf that are tried.
const MOST_AROUND: usize = 4;

/// Gives each node its label.
pub(crate) fn give(nodes: &mut [Node]) {
    let mut taken = BTreeSet::new();
    let mut groups: BTreeMap<String, Vec<usize>> = BTreeMap::new();
    let mut order = Vec::new();
    for (at, node) in nodes.iter().enumerate() {
        if matches!(node.kind, Kind::Leaf(_)) {
            let group = groups.entry(plain(&node.name)).or_default();
            if group.is_empty() {
                order.push(plain(&node.name));
            }
            group.push(at);
        }
    }
    for name in order {
        let members = &groups[&name];
        let labels = told_apart(nodes, &name, members);
        for (at, label) in members.iter().zip(labels) {
            nodes[*at].label = free(&label, &nodes[*at].draws(), &mut taken);
        }
    }
    for node in nodes.iter_mut().filter(|it| it.label.is_empty()) {
        node.label = free(&plain(&node.name), &node.draws(), &mut taken);
    }
}

/// Labels for leaves of one name: with as many names around them as tell all apart.
fn told_apart(nodes: &[Node], name: &str, members: &[usize]) -> Vec<String> {
    for around in 0..=MOST_AROUND {
        let labels: Vec<String> = members
            .iter()
            .map(|it| within(nodes, *it, around))
            .collect();
        if labels.iter().collect::<BTreeSet<_>>().len() == members.len() {
            return labels;
        }
    }
    vec![name.to_owned(); members.len()]
}

/// A node's name behind those of the nearest nodes around it that have one of their own.
fn within(nodes: &[Node], at: usize, around: usize) -> String {
    let mut parts = vec![plain(&nodes[at].name)];
    let mut parent = nodes[at].parent;
    while let Some((id, _)) = parent.filter(|_| parts.len() <= around) {
        let node = &nodes[id.0];
        if node.is_named {
            parts.push(plain(&node.name));
        }
        parent = node.parent;
    }
    parts.reverse();
    parts.join("_")
}

/// A name, or with a number behind it, that is not taken, neither for the node nor for what of it is drawn.
fn free(name: &str, draws: &[Draw], taken: &mut BTreeSet<String>) -> String {
    let mut label = name.to_owned();
    let mut number = 2;
    loop {
        let names = draws.iter().map(|draw| draw.named(&label));
        let mut names: BTreeSet<String> = names.collect();
        names.insert(label.clone());
        if names.is_disjoint(taken) {
            taken.append(&mut names);
            return label;
        }
        label = format!("{name}_{number}");
        number += 1;
    }
}

/// Letters, digits and single underscores of a name, at most forty of them.
fn plain(name: &str) -> String {
    let mut label = String::new();
    for c in name.chars() {
        let c = if c.is_ascii_alphanumeric() { c } else { '_' };
        if !(c == '_' && label.ends_with('_')) {
            label.push(c);
        }
    }
    let label: String = label.trim_matches('_').chars().take(40).collect();
    match label.chars().next() {
        None => "node".to_owned(),
        Some(first) if first.is_ascii_digit() => format!("n{label}"),
        Some(_) => label,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_are_plain_and_unique() {
        assert_eq!(plain("Clear-Costmap (local)"), "Clear_Costmap_local");
        assert_eq!(plain("2nd"), "n2nd");
        assert_eq!(plain("—"), "node");
        let mut taken = BTreeSet::new();
        assert_eq!(free("a", &[], &mut taken), "a");
        assert_eq!(free("a", &[], &mut taken), "a_2");
    }
}
