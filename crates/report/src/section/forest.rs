//! Forest plots: all evidence on each requirement along one axis.

use evidence::{Evidence, Finding, Measure, Requirement, Subject};
use maud::{Markup, html};

use crate::plot::{Axis, Strip, glyph, spoken};
use crate::view::{View, figures, section};
use crate::words;

/// The section.
pub fn render(view: View) -> Markup {
    let lead = html! {
        "All evidence on each requirement, oldest first. A mark is the rate or the computed probability; "
        "the line through it is its interval (" (words::intervals(view.study)) "); the dashed line is what is required. Where no runs are named, all runs count."
    };
    let body = html! {
        (key(view))
        @for group in groups(view) { (figure(view, &group)) }
    };
    section("forest", "The evidence", lead, body)
}

/// What the marks mean.
pub fn key(view: View) -> Markup {
    html! {
        ul class="key" aria-label="Key to the marks" {
            @for technique in words::techniques(view.study) {
                li { (glyph(technique, false)) " " (words::technique(technique)) }
            }
            li { (glyph(evidence::Technique::Simulation, true)) " hollow: published, reproduced by ours" }
            li { span class="swatch line" {} " interval of counts" }
            li { span class="swatch band" {} " credible interval of a formal answer" }
            li { span class="swatch dash" {} " required" }
        }
    }
}

/// Requirements that share a quantity, with the subject that supplies it.
fn groups<'a>(view: View<'a>) -> Vec<(Subject, Vec<&'a Requirement>)> {
    let mut groups: Vec<(Subject, Vec<&Requirement>)> = Vec::new();
    for requirement in &view.study.requirements {
        let first = requirement.same_quantity_as.as_ref();
        let leader = groups
            .iter_mut()
            .find(|(_, members)| first.is_some_and(|id| members.iter().any(|m| &m.id == id)));
        match leader {
            Some((_, members)) => members.push(requirement),
            None => groups.push((view.quantity(requirement), vec![requirement])),
        }
    }
    groups
}

fn figure(view: View, (subject, members): &(Subject, Vec<&Requirement>)) -> Markup {
    let rows = rows(view, subject);
    let thresholds: Vec<f64> = members
        .iter()
        .map(|r| r.threshold.map_or(1.0, |t| t.value))
        .collect();
    let named: Vec<(f64, String)> = members
        .iter()
        .filter_map(|r| {
            Some((
                r.threshold?.value,
                words::threshold_label(&r.id, r.threshold?),
            ))
        })
        .collect();
    let axis = Axis::of_rates(extent(&rows).into_iter().chain(thresholds.iter().copied()));
    html! {
        figure class="forest" {
            figcaption {
                @for requirement in members {
                    p id=[view.requirement_anchor(&requirement.id)] {
                        span class="req" { (requirement.id) } " " (requirement.text)
                        " " span class="asks" { (words::asked(requirement)) }
                    }
                }
            }
            @if rows.is_empty() {
                p class="empty" { "No evidence covers this requirement." }
            } @else {
                ol class="rows" {
                    @if !named.is_empty() {
                        li class="row names" aria-hidden="true" { span class="who" {} (axis.names(&named)) span class="what" {} }
                    }
                    @for (evidence, finding) in &rows {
                        (row(view, &axis, &thresholds, evidence, finding))
                    }
                    @if rows.iter().any(|(_, it)| it.measure.estimate().is_some()) { (axis_row(&axis)) }
                }
            }
        }
    }
}

/// All findings on a subject, in the order of the ledger.
pub fn rows<'a>(view: View<'a>, subject: &Subject) -> Vec<(&'a Evidence, &'a Finding)> {
    view.study
        .evidence
        .iter()
        .filter_map(|e| Some((e, e.finding(subject)?)))
        .collect()
}

/// Every value that the rows' strips show.
pub fn extent(rows: &[(&Evidence, &Finding)]) -> Vec<f64> {
    rows.iter()
        .flat_map(|(_, Finding { measure, .. })| {
            let ends = measure.interval().map(|i| [i.low, i.high]);
            measure
                .estimate()
                .into_iter()
                .chain(ends.into_iter().flatten())
        })
        .collect()
}

/// One finding: its evidence, its strip, its figures.
pub fn row(
    view: View,
    axis: &Axis,
    thresholds: &[f64],
    evidence: &Evidence,
    finding: &Finding,
) -> Markup {
    let measure = &finding.measure;
    let condition = view.condition(finding).filter(|_| finding.is_conditional());
    let strip = Strip {
        axis,
        measure,
        technique: evidence.technique,
        hollow: evidence.reproduced_by.is_some(),
        thresholds,
        label: spoken(&evidence.id, measure),
    };
    html! {
        li class="row" {
            span class="who" title=(evidence.title) {
                (glyph(evidence.technique, evidence.reproduced_by.is_some())) " " (view.link(&evidence.id))
                span class="title" { (evidence.title) }
            }
            @match absence(measure) {
                Some((what, reason)) => span class="nothing" title=(reason) {
                    span class="absent" { (what) } span class="reason" { (reason) }
                },
                None => { (strip.draw()) span class="what" { (figures(measure)) } },
            }
            @if let Some(condition) = condition { span class="condition" { (condition) } }
        }
    }
}

/// What is said in place of a strip where nothing was found, and why.
fn absence(measure: &Measure) -> Option<(&'static str, &str)> {
    match measure {
        Measure::NotExpressible { reason } => Some(("⊘ not expressible", reason)),
        Measure::NotCovered { reason, .. } => Some(("○ not covered", reason)),
        Measure::Counts { trials: 0, .. } => {
            Some(("○ not covered", "No run met the precondition."))
        }
        _ => None,
    }
}

/// The row with the axis.
pub fn axis_row(axis: &Axis) -> Markup {
    html! {
        li class="row axis" aria-hidden="true" {
            span class="who" {}
            (axis.labels("\u{a0}%"))
            span class="what" {}
        }
    }
}
