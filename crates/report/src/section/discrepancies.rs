//! Discrepancies: where the evidence disagrees, why, and what to do.

use evidence::Discrepancy;
use maud::{Markup, html};

use crate::view::{View, prose, section, unbroken};
use crate::words;

/// The section.
pub fn render(view: View) -> Markup {
    let lead = html! {
        "Each disagreement with its most likely reason: the tool, the model of the system, "
        "or the model of the requirement. Most important first."
    };
    let body = html! {
        @if view.study.discrepancies.is_empty() {
            p class="empty" { "No disagreement was found among the evidence." }
        }
        @for (i, discrepancy) in view.study.discrepancies.iter().enumerate() {
            (item(view, i + 1, discrepancy))
        }
    };
    section("discrepancies", "Conflicts and their reasons", lead, body)
}

fn item(view: View, place: usize, discrepancy: &Discrepancy) -> Markup {
    html! {
        article class="discrepancy" id={ "discrepancy-" (place) } {
            p class="kind" {
                (words::inaccuracy(discrepancy.inaccuracy))
                @match &discrepancy.resolved_by {
                    Some(id) => span class="status" { "mended in " (view.link(id)) },
                    None => span class="status open" { "still open" },
                }
            }
            h3 { (discrepancy.title) }
            (prose(&unbroken(&discrepancy.explanation)))
            @if let Some(proposal) = &discrepancy.proposal {
                p class="proposal" { b { "Proposal. " } (proposal) }
            }
            dl class="inline" {
                @if !discrepancy.evidence.is_empty() {
                    div { dt { "Evidence" } dd { (view.links(&discrepancy.evidence)) } }
                }
                @if !discrepancy.subjects.is_empty() {
                    div { dt { "Touches" } dd { (view.titles(&discrepancy.subjects)) } }
                }
                @if !discrepancy.witnesses.is_empty() {
                    div { dt { "Runs that show it" } dd class="witnesses" { (discrepancy.witnesses.join(", ")) } }
                }
            }
        }
    }
}
