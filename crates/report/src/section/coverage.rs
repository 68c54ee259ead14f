//! Coverage: what was observed how often, and what by nothing.

use evidence::{Denominator, Evidence, Measure, Subject};
use maud::{Markup, html};

use crate::number;
use crate::view::{View, section};

/// The section.
pub fn render(view: View) -> Markup {
    let lead = html! {
        "How many runs (or, for failure modes, opportunities) each piece of evidence has on each subject. "
        "A rate does not cover what was never observed."
    };
    let body = html! {
        @if !view.study.evidence.is_empty() { (table(view)) (key()) }
        h3 { "Gaps" }
        @if view.study.gaps.is_empty() { p { "No gap was found." } }
        ul class="gaps" {
            @for gap in &view.study.gaps {
                li {
                    b { (view.title(&gap.subject)) }
                    @if gap.evidence.is_empty() { ", in any evidence: " } @else { ", in " (view.links(&gap.evidence)) ": " }
                    (gap.reason)
                }
            }
        }
    };
    section("coverage", "Coverage and gaps", lead, body)
}

fn key() -> Markup {
    html! {
        ul class="key" aria-label="Key to the coverage table" {
            li { "n: runs or opportunities that count; of all runs" }
            li { "∀: every behaviour of the model" }
            li { "○ never covered" }
            li { "⊘ not expressible" }
            li { "· not asked" }
        }
    }
}

fn table(view: View) -> Markup {
    html! {
        div class="scroll" tabindex="0" role="region" aria-label="Coverage" {
            table class="coverage" {
                caption class="visually-hidden" { "Runs or opportunities by subject and evidence" }
                thead { tr {
                    th scope="col" { "Subject" }
                    @for evidence in &view.study.evidence { th scope="col" class="n" { (view.link(&evidence.id)) } }
                } }
                tbody {
                    @for subject in view.subjects() {
                        tr {
                            th scope="row" { (view.title(&subject)) }
                            @for evidence in &view.study.evidence { (cell(view, evidence, &subject)) }
                        }
                    }
                }
            }
        }
    }
}

fn cell(view: View, evidence: &Evidence, subject: &Subject) -> Markup {
    let source = match subject {
        Subject::Requirement(id) => view.requirement(id).map(|r| view.quantity(r)),
        Subject::FailureMode(_) => None,
    };
    let finding = evidence.finding(source.as_ref().unwrap_or(subject));
    let absent = |symbol: &str, words: &str, reason: &str| {
        let class = if symbol == "○" {
            "n hole open"
        } else {
            "n hole"
        };
        html! {
            td class=(class) title=(reason) {
                span aria-hidden="true" { (symbol) } span class="visually-hidden" { (words) }
            }
        }
    };
    let of_all = finding.and_then(|it| match (it.trigger.as_deref(), &it.denominator) {
        (Some(Measure::Counts { trials, .. }), Denominator::Triggered) => Some(*trials),
        _ => None,
    });
    match finding.map(|f| (&f.measure, f.undecided)) {
        None => absent("·", "not asked", ""),
        Some((Measure::NotExpressible { reason }, _)) => absent("⊘", "not expressible", reason),
        Some((Measure::NotCovered { reason, .. }, _)) => absent("○", "never covered", reason),
        Some((Measure::Counts { trials: 0, .. }, _)) => absent("○", "never covered", ""),
        Some((Measure::Counts { trials, .. }, undecided)) => html! {
            td class="n" {
                (number::count(*trials))
                @if let Some(all) = of_all { br; span class="small" { "of " (number::count(all)) } }
                @if undecided > 0 { br; span class="small" { (number::count(undecided)) " undecided" } }
            }
        },
        Some((Measure::Probability { .. }, _)) => html! {
            td class="n" { span aria-hidden="true" { "∀" } span class="visually-hidden" { "every behaviour" } }
        },
    }
}
