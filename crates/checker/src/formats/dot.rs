//! State spaces as graphs in Graphviz's language.
//!
//! States are boxes; a choice of a state is a point between its edges, unless it has one sure target.

use std::io::{Result, Write};

use super::{Explicit, Written};

impl<N: Written> Explicit<'_, N> {
    /// Writes the state space as a graph, with the states' values if `with_values`.
    ///
    /// # Errors
    /// Those of writing.
    pub fn write_dot(&self, with_values: bool, out: &mut dyn Write) -> Result<()> {
        writeln!(out, "digraph M {{")?;
        writeln!(out, "node [label=\"\",shape=\"box\"];")?;
        for (number, state) in self.order.iter().enumerate() {
            match with_values {
                true => {
                    let values = self.values(*state);
                    writeln!(out, "{number} [label=\"{number}\\n{values}\"];")?;
                }
                false => writeln!(out, "{number} [label=\"{number}\"];")?,
            }
            for (choice, row) in self.space.choices(*state).enumerate() {
                self.write_edges(number, choice, row, out)?;
            }
        }
        writeln!(out, "}}")
    }

    fn write_edges(
        &self,
        number: usize,
        choice: usize,
        row: usize,
        out: &mut dyn Write,
    ) -> Result<()> {
        let edge = |(target, at): (usize, usize)| (target, self.space.matrix.value[at].written());
        let edges: Vec<(usize, String)> = self.row(row).into_iter().map(edge).collect();
        if !self.space.kind.has_choices() {
            let mut edges = edges.iter();
            return edges.try_for_each(|(target, value)| {
                writeln!(out, "{number} -> {target} [label=\"{value}\"];")
            });
        }
        let action = self.space.action(row).map(|a| &self.space.actions()[a]);
        let label = action.map_or(choice.to_string(), |a| format!("{choice}:{a}"));
        if let [(target, value)] = &edges[..]
            && value == "1"
        {
            return writeln!(out, "{number} -> {target} [label=\"{label}\"];");
        }
        writeln!(out, "n{number}_{choice} [shape=\"point\"];")?;
        writeln!(
            out,
            "{number} -> n{number}_{choice} [label=\"{label}\",arrowhead=\"none\"];"
        )?;
        edges.iter().try_for_each(|(target, value)| {
            writeln!(out, "n{number}_{choice} -> {target} [label=\"{value}\"];")
        })
    }
}
