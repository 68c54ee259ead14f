//! The ledger: every piece of evidence, how it came about, what it found.

use evidence::{
    ClusterTests, DescriptionGap, Evidence, Finding, Guarantee, Measure, MethodAnswer, Reading,
    RobustBounds, Spread, WorstCase, effective_size,
};
use maud::{Markup, html};

use super::lineage;
use crate::number;
use crate::plot::glyph;
use crate::view::{View, figures, range, section, short_hash};
use crate::words;

/// The section.
pub fn render(view: View) -> Markup {
    let lead = html! {
        "How the evidence came about, step by step: what changed, what was tuned to what, on which files and with which tool."
    };
    let body = html! {
        @if view.study.evidence.is_empty() {
            p class="empty" { "The ledger is empty. Run the study to produce evidence." }
        } @else {
            (lineage::render(view))
            ol class="ledger" { @for evidence in &view.study.evidence { (entry(view, evidence)) } }
        }
    };
    section("ledger", "The ledger", lead, body)
}

fn entry(view: View, evidence: &Evidence) -> Markup {
    html! {
        li class="entry" id=[view.anchor(&evidence.id)] {
            h3 {
                (glyph(evidence.technique, evidence.reproduced_by.is_some()))
                " " span class="id" { (evidence.id) } " " (evidence.title)
            }
            p class="small" {
                (words::technique(evidence.technique)) ", " (evidence.tool.name) " " (evidence.tool.version)
                @if !evidence.tool.settings.is_empty() { ", " (evidence.tool.settings) }
                @if evidence.intermediate { ". A step on the way to later evidence, not compared" }
                @if evidence.published { ". Counts published by others, read here" }
                @if let Some(ours) = &evidence.reproduced_by { ". Reproduced by " (view.link(ours)) }
                "."
            }
            @if !evidence.changed.is_empty() { p class="changed" { (evidence.changed) } }
            dl class="inline" {
                div { dt { "Holds for" } dd { (evidence.conditions) } }
                (calibrations(view, evidence))
                @if !evidence.assets.is_empty() {
                    div { dt { "Files" } dd {
                        @for (i, asset) in evidence.assets.iter().enumerate() {
                            @if i > 0 { ", " }
                            code { (asset.path) } " " (short_hash(&asset.hash))
                        }
                    } }
                }
            }
            @if let Some(clusters) = &evidence.clusters { (cluster_tests(clusters)) }
            (lineage_questions(evidence))
            (failures(evidence))
            (description_gaps(evidence))
            details {
                summary { "All findings of " (evidence.id) }
                (findings(view, evidence))
                (form_differences(view, evidence))
            }
        }
    }
}

fn calibrations(view: View, evidence: &Evidence) -> Markup {
    html! {
        @for (head, chosen) in [("Tuned to", false), ("Chosen to agree with", true)] {
            @let of_kind = evidence.calibrated.iter().filter(|it| it.chosen == chosen);
            @if of_kind.clone().next().is_some() {
                div { dt { (head) } dd {
                    @for (i, calibration) in of_kind.enumerate() {
                        @if i > 0 { "; " }
                        (view.link(&calibration.from)) ", " (view.short_title(&calibration.subject)) ": "
                        @if chosen { (calibration.parameter) } @else { code { (calibration.parameter) } }
                    }
                } }
            }
        }
    }
}

/// What looks taken from other evidence, whether or not the ledger settled it.
fn lineage_questions(evidence: &Evidence) -> Markup {
    html! {
        @if !evidence.lineage_questions.is_empty() {
            div class="note" {
                p { "What looks taken from other evidence, or not independent:" }
                ul class="lines" {
                    @for question in &evidence.lineage_questions {
                        li {
                            (question.finding)
                            @if !question.places.is_empty() { " (" code { (question.places.join(", ")) } ")" }
                            @match &question.settled {
                                Some(reason) => { "; independent: " (reason) },
                                None if question.blocks => { "; " b { "open" } ": " (question.remedy) },
                                None => { "; noted, as chance explains it" },
                            }
                        }
                    }
                }
            }
        }
    }
}

fn cluster_tests(clusters: &ClusterTests) -> Markup {
    html! {
        div class="note" {
            p {
                @if let Some(because) = &clusters.one_for_all {
                    "All trials are of one person or session, declared to stand for all: " (because)
                } @else if clusters.subjects == 1 {
                    "All trials are of one person or session, of whom alone they tell."
                } @else {
                    "Trials are grouped: intraclass correlation " (number::decimal(clusters.intraclass_correlation, 3))
                    ", effective sample size " (effective_size(clusters.effective_trials)) "."
                }
            }
            @if !clusters.tests.is_empty() {
                ul class="lines" { @for test in &clusters.tests { li { (test) } } }
            }
        }
    }
}

fn findings(view: View, evidence: &Evidence) -> Markup {
    html! {
        div class="scroll" tabindex="0" role="region" aria-label={ "All findings of " (evidence.id) } {
            table class="findings cards" {
                caption class="visually-hidden" { "All findings of " (evidence.id) }
                thead { tr {
                    th scope="col" { "Subject" }
                    th scope="col" { "Found; intervals of counts are " (words::intervals_in_short(view.study)) }
                    th scope="col" { "In detail" }
                } }
                tbody {
                    @for finding in &evidence.findings {
                        tr {
                            th scope="row" { (view.title(&finding.subject)) }
                            td data-label="Found" { (figures(&finding.measure)) }
                            td class="detail" data-label="In detail" { (detail(view, finding)) }
                        }
                    }
                }
            }
        }
    }
}

/// Episodes that did not end by themselves: a failure mode that no study has to declare.
fn failures(evidence: &Evidence) -> Markup {
    html! {
        @if !evidence.failures.is_empty() {
            div class="note" {
                p { "Episodes that were ended by a failure, judged up to there:" }
                ul class="lines" {
                    @for failure in &evidence.failures {
                        li {
                            (failure.kind) " (" code { (failure.kind.name()) } "): " (figures(&failure.measure))
                            ", such as " span class="witnesses" { (failure.witnesses.join(", ")) }
                        }
                    }
                }
            }
        }
    }
}

/// What was simulated is what was understood of the descriptions.
fn description_gaps(evidence: &Evidence) -> Markup {
    let gaps = &evidence.description_gaps;
    html! {
        @if !gaps.is_empty() {
            details class="note description-gaps" open[gaps.iter().any(DescriptionGap::can_matter)] {
                summary { "Not simulated as it is described: " (DescriptionGap::in_short(gaps)) }
                ul class="lines" {
                    @for gap in gaps {
                        li {
                            b { (gap.effect) } " " code { (gap.file) @if let Some(line) = gap.line { ":" (line) } } ": "
                            @if !gap.element.is_empty() { code { (gap.element) } " " }
                            (gap.what) "; " (gap.consequence)
                        }
                    }
                }
            }
        }
    }
}

/// Forms of one requirement that do not agree on the same runs.
fn form_differences(view: View, evidence: &Evidence) -> Markup {
    html! {
        @if !evidence.form_differences.is_empty() {
            div class="note" {
                p { "Forms of one requirement that judge the same runs otherwise:" }
                ul class="lines" {
                    @for found in &evidence.form_differences {
                        li {
                            (view.title(&found.subject)) ": " (found.reference) " " (found.reference_verdict.words())
                            ", " b { (found.form) } " " (found.verdict.words()) " on " (number::count(found.count))
                            " of " (number::count(found.runs)) " runs, such as "
                            span class="witnesses" { (found.witnesses.join(", ")) }
                        }
                    }
                }
            }
        }
    }
}

/// A verdict as the JSON has it, without hyphens.
fn detail(view: View, finding: &Finding) -> Markup {
    html! {
        @let is_plain = !finding.is_conditional() && finding.trigger.is_none();
        @if let Some(condition) = view.condition(finding).filter(|_| !is_plain) { p { "Over which runs: " (condition) "." } }
        (measure_detail(&finding.measure))
        @for reading in &finding.readings { (other_reading(reading)) }
        @if !finding.witnesses.is_empty() {
            p { "Runs that show it: " span class="witnesses" { (finding.witnesses.join(", ")) } }
        }
    }
}

/// What the worst scheduler does, and how it is tried.
fn worst_case(worst: &WorstCase) -> Markup {
    html! {
        p {
            "Worst scheduler"
            @if let Some(probability) = worst.probability {
                ": its most probable path on which this fails has probability " (number::full(probability))
            }
            ". " (worst.note) "."
        }
        @if !worst.steps.is_empty() {
            ol { @for step in &worst.steps { li { (step) } } }
        }
    }
}

fn measure_detail(measure: &Measure) -> Markup {
    html! {
        @match measure {
            Measure::Counts { effective_trials: Some(effective), .. } => {
                p { "Effective sample size: " (effective_size(*effective)) ", which is as many independent trials as have an interval as wide." }
            },
            Measure::Counts { .. } => {},
            Measure::Probability { answer, others, credible } => {
                (method_answer(answer))
                @if let Guarantee::Schedulers { worst: Some(worst), .. } = &answer.guarantee { (worst_case(worst)) }
                @for other in others { (method_answer(other)) }
                @if let Some(ends) = credible.as_ref().and_then(|credible| credible.ends.as_deref()) {
                    p {
                        "Over all schedulers with the uncertainty of its constants: at least mean "
                        (number::percent(ends.least.mean)) " (" (number::interval(ends.least.interval)) "), at most mean "
                        (number::percent(ends.greatest.mean)) " (" (number::interval(ends.greatest.interval))
                        "). The whole range lies between the outer limits at the study's level. What follows is of the \
                         worst scheduler."
                    }
                }
                @if let Some(credible) = credible {
                    p {
                        "With the uncertainty of its constants: mean " (number::percent(credible.mean))
                        ", from " (number::count(credible.solves))
                        @if credible.by_function { " points of its rational function." } @else { " solutions of the model." }
                    }
                    @if !credible.spread.is_empty() {
                        p {
                            "Shares in the variance: "
                            @for (i, spread) in credible.spread.iter().enumerate() {
                                @if i > 0 { ", " }
                                code { (spread.constant) } " " (share(spread))
                            }
                            " (Sobol' indices of first order with their errors)."
                            @if let Some(first) = credible.spread.first() {
                                " Measuring " code { (first.constant) } " better would narrow it most."
                            }
                        }
                    }
                    @if let Some(robust) = &credible.robust { (robust_bounds(robust)) }
                }
            },
            Measure::NotExpressible { reason } | Measure::NotCovered { reason, .. } => p { (reason) },
        }
    }
}

/// A share in the variance in digits that mean something: `41.2 ± 0.3 %`.
fn share(spread: &Spread) -> String {
    let points = 100.0 * spread.share;
    match spread.error.map(|error| 100.0 * error) {
        // No figure is finer than its own error.
        Some(error) if error < 0.5 => format!("{points:.1} ± {:.1} %", error.max(0.1)),
        Some(error) => format!("{points:.0} ± {error:.0} %"),
        None => format!("{points:.0} %"),
    }
}

/// Bounds over every value of the constants, or why there are none.
fn robust_bounds(robust: &RobustBounds) -> Markup {
    html! {
        p {
            @match (&robust.interval, &robust.reason) {
                (Some(interval), _) => {
                    "Whatever the constants within their intervals: " (range(*interval))
                    ". These bounds hold for all of them at once (interval model) and are conservative."
                },
                (None, reason) => {
                    "No robust bounds: " (reason.as_deref().unwrap_or("the reason is not known")) "."
                },
            }
        }
    }
}

fn method_answer(answer: &MethodAnswer) -> Markup {
    html! {
        p class="method" {
            b { (answer.method) } " " span class="digits" { (number::full(answer.value)) }
            @if let Some(rest) = answer.complement {
                ", one minus it " span class="digits" { (number::full(rest)) }
            }
            ", " (number::guarantee(&answer.guarantee))
            @if let evidence::Guarantee::Estimated { reason } = &answer.guarantee { " (" (reason) ")" }
            @if let Some(iterations) = answer.iterations { ", " (number::count(iterations)) " iterations" }
        }
    }
}

fn other_reading(reading: &Reading) -> Markup {
    html! {
        p {
            "Read otherwise (" b { (reading.name) } "): " (reading.meaning) " "
            (number::count(reading.count)) " of " (number::count(reading.trials)) " pass; "
            (number::count(reading.differing)) " runs have another verdict"
            @if !reading.witnesses.is_empty() {
                ", such as " span class="witnesses" { (reading.witnesses.join(", ")) }
            }
            "."
        }
    }
}
