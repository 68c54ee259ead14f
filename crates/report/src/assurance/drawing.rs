//! Arguments drawn as trees that read from top to bottom.
//!
//! An element takes one row; what belongs to it stands below, one step to the
//! right, on a line from its left side. A drawing is therefore as narrow as a
//! phone however many elements it has, and its text is text. Shapes are those
//! of the notation: goals are rectangles, strategies parallelograms, contexts
//! and justifications have round ends, solutions a circle before their text;
//! counter elements have dashed outlines. A diamond below a goal says that it
//! is undeveloped, a cross that it is defeated, a black square that its
//! confidence is argued in the other argument.
//!
//! Browsers choose the font, so lines are broken at a width that letters of
//! common sans-serif fonts do not reach on average.

use super::node::{Argument, Kind, Node};
use maud::{Markup, html};
use std::collections::BTreeSet;
use unicode_width::{UnicodeWidthChar, UnicodeWidthStr};

/// Width of a drawing, in its own units: CSS pixels where there is room.
const WIDTH: f64 = 360.0;
/// How far a level is set in.
const STEP: f64 = 16.0;
/// Height of a line of text.
const LINE: f64 = 15.0;
/// Space between the outline and the text.
const PAD: f64 = 7.0;
/// Space between rows, for the marks below them.
const GAP: f64 = 9.0;
/// Width that a letter of the 12-pixel font takes at most, on average.
const LETTER: f64 = 7.2;
/// Radius of a solution's circle.
const CIRCLE: f64 = 7.0;

/// An element with its place.
struct Row<'a> {
    node: &'a Node,
    relation: Relation,
    /// Row of the element that it belongs to.
    parent: Option<usize>,
    level: usize,
    lines: Vec<String>,
    top: f64,
    height: f64,
}

/// How an element belongs to the one above it.
#[derive(Clone, Copy, PartialEq)]
enum Relation {
    Supports,
    InContext,
    Challenges,
}

impl Row<'_> {
    fn left(&self) -> f64 {
        1.0 + STEP * self.level as f64
    }

    fn middle(&self) -> f64 {
        self.top + PAD + LINE / 2.0
    }
}

/// The elements from `root` on, down to `depth` levels below it.
///
/// `label` says to a reader who does not see it what is drawn.
pub fn tree(argument: &Argument, root: &str, depth: usize, label: &str) -> Markup {
    let mut rows = Vec::new();
    let mut seen = BTreeSet::new();
    if let Some(node) = argument.node(root) {
        let first = (node, Relation::Supports, None, 0);
        lay_out(argument, first, depth, &mut rows, &mut seen);
    }
    let height = place(&mut rows);
    html! {
        svg class="gsn" viewBox={ "0 0 " (WIDTH) " " (height) } role="img" aria-label=(label) {
            @for row in &rows { (link(row, &rows)) (element(row)) }
        }
    }
}

type Next<'a> = (&'a Node, Relation, Option<usize>, usize);

fn lay_out<'a>(
    argument: &'a Argument,
    (node, relation, parent, level): Next<'a>,
    depth: usize,
    rows: &mut Vec<Row<'a>>,
    seen: &mut BTreeSet<&'a str>,
) {
    if !seen.insert(&node.id) {
        return;
    }
    let lines = wrapped(&shown(node), room(node.kind, level));
    let height = lines.len() as f64 * LINE + 2.0 * PAD;
    rows.push(Row {
        node,
        relation,
        parent,
        level,
        lines,
        top: 0.0,
        height,
    });
    if level == depth {
        return;
    }
    let place = Some(rows.len() - 1);
    let named = |ids: &'a [String], relation| {
        ids.iter()
            .filter_map(|id| argument.node(id))
            .map(move |node| (node, relation))
    };
    let challenges = argument
        .challengers(&node.id)
        .map(|node| (node, Relation::Challenges));
    let below = named(&node.in_context_of, Relation::InContext)
        .chain(named(&node.supported_by, Relation::Supports))
        .chain(challenges);
    for (child, relation) in below {
        lay_out(
            argument,
            (child, relation, place, level + 1),
            depth,
            rows,
            seen,
        );
    }
}

/// The text of an element with its identifier before it.
fn shown(node: &Node) -> String {
    format!("{}  {}", node.id, node.text)
}

/// Columns of text that an element has.
fn room(kind: Kind, level: usize) -> usize {
    let taken = match kind {
        Kind::Solution | Kind::CounterSolution => 2.0 * CIRCLE + PAD,
        Kind::Goal | Kind::CounterGoal => 2.0 * PAD,
        Kind::Strategy | Kind::Context | Kind::Justification => 4.0 * PAD,
    };
    let width = WIDTH - 2.0 - STEP * level as f64 - taken;
    (width / LETTER).floor().max(8.0) as usize
}

/// The text in lines of at most so many columns; longer words are cut.
fn wrapped(text: &str, columns: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    let mut line = String::new();
    for word in text
        .split([' ', '\n', '\t'])
        .filter(|word| !word.is_empty())
    {
        let space = usize::from(!line.is_empty());
        if line.width() + space + word.width() > columns && !line.is_empty() {
            lines.push(std::mem::take(&mut line));
        }
        if !line.is_empty() {
            line.push(' ');
        }
        for c in word.chars().filter(|c| !c.is_control()) {
            if line.width() + c.width().unwrap_or(0) > columns {
                lines.push(std::mem::take(&mut line));
            }
            line.push(c);
        }
    }
    lines.push(line);
    lines
}

/// Gives every row its place; the height of all.
fn place(rows: &mut [Row]) -> f64 {
    let mut top = 1.0;
    for row in rows {
        row.top = top;
        top += row.height + GAP;
    }
    top
}

/// The line from the element that a row belongs to.
fn link(row: &Row, rows: &[Row]) -> Markup {
    let Some(parent) = row.parent.map(|place| &rows[place]) else {
        return html! {};
    };
    let (x, from) = (parent.left() + STEP / 2.0 - 1.0, parent.top + parent.height);
    let (y, to) = (row.middle(), row.left());
    let class = match row.relation {
        Relation::Supports => "line",
        Relation::InContext => "line context",
        Relation::Challenges => "line challenge",
    };
    let is_point = is_claim_point(parent.node, row.node);
    html! {
        path class=(class) d={ "M" (x) " " (from) "V" (y) "H" (to) } {}
        @if is_point {
            rect class="point" x=(x - 3.5) y=(y - 3.5) width="7" height="7" {}
        }
    }
}

/// Whether the confidence of the relation between two elements, or of one
/// itself, is argued.
fn is_claim_point(from: &Node, to: &Node) -> bool {
    let point = from.claim_point.as_ref();
    point.is_some_and(|point| point.at == to.id)
}

/// The element's shape, marks and text.
fn element(row: &Row) -> Markup {
    let node = row.node;
    let counter = matches!(node.kind, Kind::CounterGoal | Kind::CounterSolution);
    let class = match (node.defeated, node.undeveloped, counter) {
        (true, _, _) => "element defeated",
        (_, _, true) => "element counter",
        (_, true, _) => "element undeveloped",
        _ => "element",
    };
    let indent = match node.kind {
        Kind::Solution | Kind::CounterSolution => 2.0 * CIRCLE + PAD,
        Kind::Goal | Kind::CounterGoal => PAD,
        Kind::Strategy | Kind::Context | Kind::Justification => 2.0 * PAD,
    };
    html! {
        g class=(class) {
            (outline(row))
            (marks(row))
            text x=(row.left() + indent) y=(row.top + PAD + LINE * 0.75) {
                @for (place, line) in row.lines.iter().enumerate() {
                    @let shift = if place == 0 { 0.0 } else { LINE };
                    tspan x=(row.left() + indent) dy=(shift) {
                        @match line.strip_prefix(node.id.as_str()) {
                            Some(rest) if place == 0 => {
                                tspan class="name" { (node.id) } (rest)
                            },
                            _ => (line),
                        }
                    }
                }
            }
        }
    }
}

fn outline(row: &Row) -> Markup {
    let (x, y, height) = (row.left(), row.top, row.height);
    let width = WIDTH - 1.0 - x;
    match row.node.kind {
        Kind::Goal | Kind::CounterGoal => {
            html! { rect x=(x) y=(y) width=(width) height=(height) {} }
        }
        Kind::Strategy => {
            let (right, bottom, slant) = (x + width, y + height, PAD);
            let d = format!("M{} {y}H{right}L{} {bottom}H{x}Z", x + slant, right - slant);
            html! { path d=(d) {} }
        }
        Kind::Context | Kind::Justification => {
            let round = (height / 2.0).min(14.0);
            html! { rect x=(x) y=(y) width=(width) height=(height) rx=(round) {} }
        }
        Kind::Solution | Kind::CounterSolution => {
            html! { circle cx=(x + CIRCLE) cy=(row.middle()) r=(CIRCLE) {} }
        }
    }
}

/// The diamond of what is undeveloped and the cross of what is defeated.
fn marks(row: &Row) -> Markup {
    let (x, y) = (WIDTH / 2.0, row.top + row.height);
    html! {
        @if row.node.undeveloped {
            path class="diamond" d={ "M" (x) " " (y) "l4 4l-4 4l-4 -4Z" } {}
        }
        @if is_claim_point(row.node, row.node) {
            rect class="point" x=(row.left()) y=(row.top) width="7" height="7" {}
        }
        @if row.node.defeated {
            path class="cross" d={ "M" (row.left()) " " (row.top) "L" (WIDTH - 1.0) " " (y)
                "M" (row.left()) " " (y) "L" (WIDTH - 1.0) " " (row.top) } {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_keep_every_letter_and_their_width() {
        let text =
            "G-1a  Requirement 1a holds: averyverylongwordthatdoesnotfit 手渡し手渡し手渡し手渡し";
        for columns in 8..60 {
            let lines = wrapped(text, columns);
            assert!(
                lines.iter().all(|line| line.width() <= columns),
                "{lines:?}"
            );
            let letters = |text: &str| text.replace(' ', "");
            assert_eq!(letters(&lines.concat()), letters(text));
        }
    }
}
