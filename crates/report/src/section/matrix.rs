//! Requirements by techniques: the whole study in one table.

use evidence::{Measure, Requirement, Technique};
use maud::{Markup, html};

use crate::number;
use crate::view::{View, chip, range, section, unbroken};
use crate::words;

/// The section.
pub fn render(view: View) -> Markup {
    let lead = html! {
        "Each cell shows the current evidence of one technique: how the conclusion judges it, the rate with its interval ("
        (words::intervals(view.study)) "), the runs over which it is taken, and below them what decides: the one-sided limits with p-values" (words::at_looks(view.study)) "."
    };
    section("matrix", "Requirements by techniques", lead, table(view))
}

fn table(view: View) -> Markup {
    html! {
        table class="matrix cards" role="table" {
            caption class="visually-hidden" { "Requirements by techniques, with the conclusion on each" }
            thead role="rowgroup" {
                tr role="row" {
                    th scope="col" role="columnheader" { "Requirement" }
                    @for technique in words::techniques(view.study) {
                        th scope="col" role="columnheader" { (words::technique(technique)) }
                    }
                    th scope="col" role="columnheader" { "Conclusion" }
                }
            }
            tbody role="rowgroup" {
                @for requirement in &view.study.requirements { (row(view, requirement)) }
            }
        }
    }
}

fn row(view: View, requirement: &Requirement) -> Markup {
    let conclusion = view
        .study
        .conclusions
        .iter()
        .find(|c| c.requirement == requirement.id);
    html! {
        tr role="row" {
            th scope="row" role="rowheader" {
                (view.requirement_link(&requirement.id)) " "
                span class="asks" { (words::asked(requirement)) }
                span class="text" { (requirement.text) }
            }
            @for technique in words::techniques(view.study) {
                td role="cell" data-label=(words::technique(technique)) {
                    (cell(view, requirement, technique))
                }
            }
            td role="cell" data-label="Conclusion" class="concluded" {
                @match conclusion {
                    Some(conclusion) => (chip(&words::concluded(conclusion))),
                    None => span class="absent" { "none" },
                }
            }
        }
    }
}

fn cell(view: View, requirement: &Requirement, technique: Technique) -> Markup {
    let subject = view.quantity(requirement);
    let evidence = view.current(requirement, technique);
    html! {
        @if evidence.is_empty() {
            span class="absent" { (words::not_shown(view.study, &subject, technique)) }
        }
        @for item in &evidence {
            div class="entry" {
                @match item.finding(&subject) {
                    Some(finding) => {
                        p { (chip(&view.mark(requirement, &item.id, &finding.measure))) " " (view.link(&item.id)) }
                        (detail(&finding.measure))
                        @if let Some(condition) = view.condition(finding) { p class="counts" { (condition) } }
                        @match (view.apart(requirement, &item.id), view.standing(requirement, &item.id)) {
                            (Some(apart), _) => p class="counts" { (unbroken(&apart.words)) },
                            (None, Some(standing)) => p class="counts" { (unbroken(&standing.words)) },
                            (None, None) => {},
                        }
                    },
                    None => p class="absent" { "· not asked " (view.link(&item.id)) },
                }
            }
        }
    }
}

fn detail(measure: &Measure) -> Markup {
    html! {
        @match measure {
            Measure::Counts { trials: 0, .. } => {},
            Measure::Counts { count, trials, interval, .. } => {
                p { b { (number::percent(*count as f64 / *trials as f64)) } " " (range(*interval)) }
            },
            Measure::Probability { answer, credible: Some(credible), .. } if credible.interval.low < credible.interval.high => {
                p { b { (number::answer(answer)) } " " (range(credible.interval)) }
                p class="counts" {
                    @if credible.ends.is_some() { "credible limits of the range over all schedulers" }
                    @else { "credible interval; solver " (number::guarantee(&answer.guarantee)) }
                }
            },
            Measure::Probability { answer, .. } => {
                p { b { (number::answer(answer)) } }
                p class="counts" { (number::guarantee(&answer.guarantee)) }
            },
            Measure::NotExpressible { reason } | Measure::NotCovered { reason, .. } => {
                p class="reason" { (reason) }
            },
        }
    }
}
