//! Lineage: the ledger as a line in time, with an arc from each piece of
//! evidence to those whose assets were set to its counts.

use evidence::{Evidence, Subject};
use maud::{Markup, html};

use crate::plot::glyph;
use crate::view::{View, figures};

/// Height of a row in units of the drawing; the style sheet gives a row the
/// same height in rem (16 units to a rem).
const ROW: usize = 48;
/// Width of the drawing; the line in time is `LINE` units from its left.
const WIDTH: usize = 96;
const LINE: usize = 84;

/// The figure.
pub fn render(view: View) -> Markup {
    let ledger = &view.study.evidence;
    let height = ledger.len() * ROW;
    html! {
        figure class="lineage" {
            figcaption {
                p class="small" {
                    "Oldest first. An arc leads from evidence to what was later tuned to it"
                    @if let Some(first) = view.study.requirements.first() {
                        "; the figures are those of requirement " (first.id)
                    }
                    "."
                }
            }
            div class="lineage-body" {
                svg viewBox={ "0 0 " (WIDTH) " " (height) } style={ "height:" (ledger.len() * ROW / 16) "rem" }
                    role="img" aria-label=(spoken(ledger)) {
                    line class="time" x1=(LINE) x2=(LINE) y1=(ROW / 2) y2=(height.saturating_sub(ROW / 2)) {}
                    @for (from, to) in arcs(ledger) { (arc(from, to)) }
                    @for place in 0..ledger.len() {
                        circle class="node" cx=(LINE) cy=(middle(place)) r="4" {}
                    }
                }
                ol {
                    @for evidence in ledger {
                        li {
                            span class="who" {
                                (glyph(evidence.technique, evidence.reproduced_by.is_some())) " " (view.link(&evidence.id))
                                span class="title" { (evidence.title) }
                            }
                            (headline(view, evidence))
                        }
                    }
                }
            }
        }
    }
}

fn middle(place: usize) -> usize {
    place * ROW + ROW / 2
}

/// Pairs of places in the ledger, each once: calibrated from, to.
fn arcs(ledger: &[Evidence]) -> Vec<(usize, usize)> {
    let mut arcs = Vec::new();
    for (to, evidence) in ledger.iter().enumerate() {
        for calibration in &evidence.calibrated {
            let from = ledger.iter().position(|e| e.id == calibration.from);
            if let Some(from) = from.filter(|from| *from != to && !arcs.contains(&(*from, to))) {
                arcs.push((from, to));
            }
        }
    }
    arcs
}

/// An arc to the left of the line, ending in an arrowhead at its target.
fn arc(from: usize, to: usize) -> Markup {
    let (start, end) = (middle(from), middle(to));
    let reach = (18 + 13 * from.abs_diff(to)).min(LINE - 4);
    let bend = LINE.saturating_sub(reach + reach / 3);
    let (start_x, end_x) = (LINE - 5, LINE - 7);
    html! {
        path class="arc" d={ "M" (start_x) " " (start) "C" (bend) " " (start) " " (bend) " " (end) " " (end_x) " " (end) } {}
        path class="head" d={ "M" (LINE - 5) " " (end) "l-7 -3.5v7z" } {}
    }
}

fn headline(view: View, evidence: &Evidence) -> Markup {
    let finding = view
        .study
        .requirements
        .first()
        .and_then(|first| evidence.finding(&Subject::Requirement(first.id.clone())));
    html! {
        span class="what" {
            @match finding {
                Some(finding) => (figures(&finding.measure)),
                None => span class="absent" { "· not asked" },
            }
        }
    }
}

fn spoken(ledger: &[Evidence]) -> String {
    let sentences: Vec<String> = arcs(ledger)
        .into_iter()
        .map(|(from, to)| format!("{} was calibrated on {}", ledger[to].id, ledger[from].id))
        .collect();
    if sentences.is_empty() {
        "No evidence was calibrated on other evidence.".to_owned()
    } else {
        format!("{}.", sentences.join("; "))
    }
}
