//! What would decide: further trials for undecided requirements and undecided pairs.

use evidence::{Deciding, Synthesis, Undecided};
use maud::{Markup, html};

use crate::plan;
use crate::view::{View, section, unbroken};

/// The section.
pub fn render(view: View) -> Markup {
    let lead = html! {
        "Where the evidence does not decide yet: the fewest or cheapest further trials that would, with a chance of 80 %. "
        "A trial is one that covers the subject; where trials of one person are alike, it is one of a further person, "
        "since more trials of the same people decide less."
    };
    let synthesis = &view.study.synthesis;
    let current: Vec<&Undecided> = synthesis.undecided.iter().filter(|u| u.current).collect();
    let body = html! {
        @if current.is_empty() && synthesis.deciding.is_empty() && synthesis.not_planned.is_empty() {
            p class="empty" { "No undecided comparisons." }
        } @else {
            p { (plan::pricing(&synthesis.costs)) }
            @if let Some(fixed) = plan::of_fixed_sizes(view.study) {
                p { (fixed) }
            }
            @if let Some(programme) = &synthesis.programme {
                p { b { "All at once: " } (plan::programme(programme, &synthesis.costs)) }
            }
            (requirements(view, synthesis))
            (not_planned(view, synthesis))
            (pairs(view, synthesis, &current))
        }
    };
    section("further", "What would decide", lead, body)
}

/// Plans against the thresholds.
fn requirements(view: View, synthesis: &Synthesis) -> Markup {
    let mut ids: Vec<&str> = Vec::new();
    for one in &synthesis.deciding {
        if !ids.contains(&one.requirement.as_str()) {
            ids.push(&one.requirement);
        }
    }
    let of = |id: &str| -> Vec<&Deciding> {
        let all = synthesis.deciding.iter();
        all.filter(|one| one.requirement == id).collect()
    };
    html! {
        @if !ids.is_empty() {
            h3 { "Whether a requirement holds" }
            ul class="lines" {
                @for id in ids {
                    li {
                        "Requirement " (view.requirement_link(id)) ": "
                        @for (i, one) in of(id).iter().enumerate() {
                            @if i > 0 { "; or " }
                            (plan::deciding(one, &synthesis.costs))
                        }
                        "."
                    }
                }
            }
        }
    }
}

/// Open requirements for which there is no plan, with the reason.
fn not_planned(view: View, synthesis: &Synthesis) -> Markup {
    html! {
        @if !synthesis.not_planned.is_empty() {
            h3 { "Left open without a plan" }
            ul class="lines" {
                @for one in &synthesis.not_planned {
                    li { "Requirement " (view.requirement_link(&one.requirement)) ": " (unbroken(&one.reason)) }
                }
            }
        }
    }
}

/// Plans for pairs of evidence.
fn pairs(view: View, synthesis: &Synthesis, current: &[&Undecided]) -> Markup {
    html! {
        @if !current.is_empty() {
            h3 { "Whether two techniques agree" }
            div class="scroll" tabindex="0" role="region" aria-label="Further trials for undecided pairs" {
                table class="figures cards" {
                    thead { tr {
                        th scope="col" { "Subject" }
                        th scope="col" { "Pair" }
                        th scope="col" { "Cheapest" }
                        th scope="col" { "Or" }
                    } }
                    tbody { @for one in current { (row(view, synthesis, one)) } }
                }
            }
        }
    }
}

fn row(view: View, synthesis: &Synthesis, one: &Undecided) -> Markup {
    html! {
        tr {
            th scope="row" { (view.title(&one.subject)) }
            td data-label="Pair" { (view.link(&one.left)) " → " (view.link(&one.right)) }
            td data-label="Cheapest" {
                @match one.plans.first() {
                    Some(first) => (plan::plan(first, &synthesis.costs)),
                    None => "no number of further trials decides it",
                }
            }
            td data-label="Or" {
                @for (i, other) in one.plans.iter().skip(1).enumerate() {
                    @if i > 0 { "; " }
                    (plan::plan(other, &synthesis.costs))
                }
            }
        }
    }
}
