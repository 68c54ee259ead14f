//! Suspects: which asset is to blame, the strongest first, and the matrix behind it.

use evidence::{Cell, Diagnosis, Suspect};
use maud::{Markup, html};

use crate::view::{View, prose, section, unbroken};
use crate::words;

/// Suspects that are shown in full; the rest is folded.
const SHOWN: usize = 5;

/// The section.
pub fn render(view: View) -> Markup {
    let suspects = view.study.suspected();
    let lead = html! {
        "Which file to look at first, with the most likely reason: the tool, the model of the system, or the model of the "
        "requirement. The score says how much disagreement goes away without it, in powers of ten; above 2 is decisive."
    };
    let body = html! {
        @if suspects.is_empty() {
            p class="empty" { "Nothing is suspected." }
        }
        @for suspect in suspects.iter().take(SHOWN) { (item(view, suspect)) }
        @if suspects.len() > SHOWN {
            details {
                summary { (suspects.len() - SHOWN) " more, weaker ones" }
                @for suspect in suspects.iter().skip(SHOWN) { (item(view, suspect)) }
            }
        }
        @match &view.study.diagnosis {
            Some(diagnosis) => (behind(view, diagnosis)),
            None => p class="small" {
                "From the evidence alone. " code { "corroborate diagnose" } " also changes one asset at a time, and "
                code { "corroborate refine" } " offers changes against each."
            },
        }
    };
    section("suspects", "Suspects", lead, body)
}

fn item(view: View, suspect: &Suspect) -> Markup {
    let asset = suspect.asset.place_in_words();
    html! {
        article class="suspect" id={ "suspect-" (suspect.rank) } {
            p class="kind" {
                (words::inaccuracy(suspect.inaccuracy))
                @match suspect.resolution() {
                    Some((before, id, behind)) => span class="status" { (before) (view.link(id)) (behind) },
                    None => span class="status open" { "still open" },
                }
            }
            h3 { (suspect.rank) ". " (asset) ": " (suspect.title) }
            (prose(&unbroken(&suspect.explanation)))
            @if let Some(others) = suspect.asset.together_in_words() { p class="small" { (others) } }
            dl class="inline" {
                div { dt { "Score" } dd { (format!("{:.1}", suspect.score)) } }
                @if !suspect.asset.evidence.is_empty() {
                    div { dt { "Evidence" } dd { (view.links(&suspect.asset.evidence)) } }
                }
                @if !suspect.subjects.is_empty() {
                    div { dt { "Touches" } dd { (view.titles(&suspect.subjects)) } }
                }
                @if !suspect.ruled_out.is_empty() {
                    div { dt { "Ruled out" } dd { (suspect.ruled_out.join("; ")) } }
                }
                @if !suspect.witnesses.is_empty() {
                    div { dt { "See it" } dd class="witnesses" {
                        @for witness in &suspect.witnesses { code { (witness.replay) } " " }
                    } }
                }
            }
        }
    }
}

fn behind(view: View, diagnosis: &Diagnosis) -> Markup {
    html! {
        details {
            summary { "The matrix: properties and monitors on the traces of models, simulators and recordings" }
            div class="scroll" {
                table {
                    thead { tr {
                        th { "Cell" } th { "Traces of" } th { "Subject" } th { "Counts" } th { "Interval (" (words::intervals(view.study)) ")" }
                    } }
                    tbody { @for cell in &diagnosis.cells { (row(view, cell)) } }
                }
            }
        }
        @if !diagnosis.in_order.is_empty() {
            details {
                summary { "What was found in order" }
                ul { @for line in &diagnosis.in_order { li { (line) } } }
            }
        }
        @if !diagnosis.not_done.is_empty() {
            details {
                summary { "What was not looked at" }
                ul { @for line in &diagnosis.not_done { li { (line) } } }
            }
        }
    }
}

fn row(view: View, cell: &Cell) -> Markup {
    html! {
        tr {
            td { (cell.cell) }
            td { (view.link(&cell.evidence)) }
            td { (cell.subject.id().replace('_', " ")) }
            @match &cell.not_judged {
                Some(why) => td colspan="2" { (why) },
                None => {
                    td { (cell.count) " of " (cell.trials) }
                    td { @if let Some(i) = cell.interval { (format!("{:.3} to {:.3}", i.low, i.high)) } }
                },
            }
        }
    }
}
