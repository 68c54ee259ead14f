//! The assurance case: the argument that each requirement holds, and beside it
//! the argument that its evidence can be relied on.

use maud::{Markup, html};

use crate::assurance::{self, Argument, AssuranceCase, Kind, Node, drawing};
use crate::view::{View, section};

/// The section.
pub fn render(view: View) -> Markup {
    let case = assurance::case(view.study);
    let lead = html! {
        "Why each requirement should be believed to hold, and why not, in the Goal Structuring Notation. "
        "Beside each argument stands the one for its confidence. Nothing here is new: it is the "
        "conclusions, comparisons, conflicts and gaps of this page in the order of an argument."
    };
    let body = html! {
        (key())
        @for goal in goals(&case.safety) { (requirement(&case, goal)) }
        @for strategy in second_strategies(&case.confidence) {
            details class="argument" {
                summary { b { "Confidence" } " " (strategy.text) }
                div class="drawings" {
                    @for goal in supports(&case.confidence, strategy) {
                        (drawing::tree(&case.confidence, &goal.id, 9, &goal.text))
                    }
                }
            }
        }
    };
    section("argument", "Argument", lead, body)
}

fn supports<'a>(argument: &'a Argument, node: &'a Node) -> impl Iterator<Item = &'a Node> {
    node.supported_by.iter().filter_map(|id| argument.node(id))
}

/// The goals of the requirements: what the strategy below the top goal leads to.
fn goals(argument: &Argument) -> Vec<&Node> {
    let top = argument.nodes.first();
    let strategies = top.into_iter().flat_map(|top| supports(argument, top));
    strategies
        .flat_map(|strategy| supports(argument, strategy))
        .collect()
}

/// What the confidence argument has beside the claim points.
fn second_strategies(argument: &Argument) -> impl Iterator<Item = &Node> {
    let top = argument.nodes.first();
    let strategies = top.into_iter().flat_map(|top| supports(argument, top));
    strategies.filter(|s| s.kind == Kind::Strategy && s.id != "S-claim-points")
}

/// One requirement: its goal as the line that opens, and both drawings.
fn requirement(case: &AssuranceCase, goal: &Node) -> Markup {
    let confidence = goals(&case.confidence)
        .into_iter()
        .find(|claim| claim.id == goal.id);
    let challenged = case.safety.challengers(&goal.id).next().is_some();
    let (tone, state) = match (goal.defeated, challenged, has_hole(&case.safety, goal)) {
        (true, _, _) => ("bad", "✗ defeated"),
        (_, true, _) => ("bad", "≠ challenged"),
        (_, _, true) => ("open", "◇ supported in part"),
        _ => ("good", "✓ supported"),
    };
    html! {
        details class="argument" {
            summary { span class={ "chip " (tone) } { (state) } " " (goal.text) }
            div class="drawings" {
                figure {
                    figcaption { "The requirement" }
                    (drawing::tree(&case.safety, &goal.id, 9, &goal.text))
                }
                @if let Some(claim) = confidence {
                    figure {
                        figcaption { "Its confidence" }
                        (drawing::tree(&case.confidence, &claim.id, 9, &claim.text))
                    }
                }
            }
        }
    }
}

/// Whether anything below a goal, or itself, is undeveloped.
fn has_hole(argument: &Argument, node: &Node) -> bool {
    node.undeveloped || supports(argument, node).any(|below| has_hole(argument, below))
}

fn key() -> Markup {
    html! {
        ul class="key" aria-label="Key to the arguments" {
            li { "G goal" } li { "S strategy" } li { "C context" } li { "Sn evidence" }
            li { "CG counter goal" } li { "CSn evidence against" }
            li { "◇ undeveloped" } li { "crossed out: defeated" }
            li { "■ claim point: its confidence is argued beside it" }
        }
    }
}
