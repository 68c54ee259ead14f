//! The verdict: what the study concludes, before anything else.

use evidence::{Conclusion, StudyResult, Suspect};
use maud::{Markup, html};

use crate::number;
use crate::view::{View, chip, left_out_of_all, merged, section, unbroken};
use crate::words;

/// Suspects named with the verdict; the section on them has them all.
const FIRST: usize = 10;

/// The section.
pub fn render(view: View) -> Markup {
    let study = view.study;
    let common = left_out_of_all(study);
    let body = html! {
        (tally(study))
        @if study.conclusions.is_empty() {
            p class="empty" { "This study draws no conclusion yet: no requirement has evidence. Run it to produce some." }
        }
        ol class="conclusions" {
            @for conclusion in &study.conclusions { (conclusion_item(view, conclusion, &common)) }
        }
        @if !common.is_empty() {
            p class="small" { b { "Left out of every verdict:" } }
            ul class="lines small" { @for words in &common { li { (unbroken(words)) } } }
        }
        @if let Some(words) = words::error_rates(study) { p class="small" { (unbroken(&words)) } }
        (agreement(study))
        (first_suspects(view, study.suspected()))
        (misses(study))
    };
    let lead = html! { "What the evidence amounts to, requirement by requirement. Everything below shows how it was reached." };
    section("verdict", "Verdict", lead, body)
}

fn tally(study: &StudyResult) -> Markup {
    html! {
        ul class="tally" {
            @for (mark, ids) in words::tally(study) {
                li { (chip(&mark)) " " span class="ids" { (ids.join(", ")) } }
            }
        }
    }
}

/// A conclusion, without what `common` says for all.
fn conclusion_item(view: View, conclusion: &Conclusion, common: &[&str]) -> Markup {
    let mark = words::concluded(conclusion);
    let own = || conclusion.left_out().filter(|it| !common.contains(it));
    html! {
        li class={ "conclusion " (mark.tone) } {
            div class="badge" {
                span class="symbol" aria-hidden="true" { (mark.symbol) }
                b { (view.requirement_link(&conclusion.requirement)) }
                span { (mark.word) }
            }
            div {
                @if let Some(requirement) = view.requirement(&conclusion.requirement) {
                    p class="asked" { (requirement.text) }
                }
                p class="statement" { (unbroken(&conclusion.statement)) }
                (conditions(view, conclusion))
                @if let Some(combined) = view.combined(&conclusion.requirement) {
                    p class="small" { b { "Together: " } (unbroken(&combined.statement)) }
                }
                @if own().next().is_some() {
                    p class="small" { b { "Left out:" } }
                    ul class="lines small" {
                        @for words in own() { li { (unbroken(words)) } }
                    }
                }
                @for looking in &conclusion.looking {
                    p class="small" { b { "If trials are added: " } (unbroken(&looking.statement)) }
                }
                @for sensitivity in &conclusion.clustering {
                    p class="small" { b { "If trials were alike: " } (unbroken(&sensitivity.statement)) }
                }
                p class="small" {
                    @if !conclusion.rests_on.is_empty() {
                        "Rests on " (view.links(&conclusion.rests_on)) ". "
                    }
                    @if let Some(common) = view.combined(&conclusion.requirement).and_then(|c| c.common.as_ref()) {
                        (unbroken(&common.statement))
                    } @else if let Some(bound) = conclusion.common_lower_bound {
                        "All of them support a rate of at least " (number::lower_bound(bound)) "."
                    }
                }
            }
        }
    }
}

/// Over which runs each figure of the statement is taken.
fn conditions(view: View, conclusion: &Conclusion) -> Markup {
    html! {
        @let conditions = conclusion.conditions();
        @if !conditions.is_empty() {
            p class="small" {
                b { "Over which runs: " }
                @for (i, (id, condition)) in conditions.iter().enumerate() {
                    @if i > 0 { "; " }
                    (view.link(id)) ": " (unbroken(condition))
                }
                "."
            }
        }
    }
}

fn agreement(study: &StudyResult) -> Markup {
    let independent = merged(&study.conclusions, |c| &c.independent_agreement);
    let fitted = merged(&study.conclusions, |c| &c.fitted_agreement);
    if independent.is_empty() && fitted.is_empty() {
        return html! {};
    }
    html! {
        div class="pair" {
            (agreement_list("Agreement that is independent",
                "No constant of one that bears on the requirement was set to counts of the other, and neither is a copy.",
                "No agreement between techniques is independent.", &independent))
            (agreement_list("Agreement that is only a fit",
                "One side was calibrated on the other, so it had to agree: this is not confirmation.",
                "No agreement is a fit.", &fitted))
        }
    }
}

fn agreement_list(heading: &str, meaning: &str, none: &str, lines: &[(&str, Vec<&str>)]) -> Markup {
    html! {
        div class="card" {
            h3 { (heading) }
            p class="small" { (meaning) }
            @if lines.is_empty() { p { (none) } }
            ul class="lines" {
                @for (line, ids) in lines {
                    li { b class="ids" { (ids.join(", ")) } " " (unbroken(line)) }
                }
            }
        }
    }
}

fn first_suspects(view: View, suspects: &[Suspect]) -> Markup {
    html! {
        @if !suspects.is_empty() {
            h3 { "Where the evidence disagrees, and why" }
            ol class="headlines" {
                @for suspect in suspects.iter().take(FIRST) {
                    li {
                        a href={ "#suspect-" (suspect.rank) } { (suspect.title) }
                        span class="small" {
                            " " (words::inaccuracy(suspect.inaccuracy))
                            @match suspect.resolution() {
                                Some((before, id, behind)) => { ", " (before) (view.link(id)) (behind) },
                                None => ", still open",
                            }
                        }
                    }
                }
            }
            @if suspects.len() > FIRST {
                p class="small" {
                    a href="#suspects" { "and " (suspects.len() - FIRST) " more" }
                }
            }
        }
    }
}

/// Figures that did not come out as published.
fn misses(study: &StudyResult) -> Markup {
    let missed = study.published.iter().filter(|f| !f.agrees).count();
    html! {
        @if missed > 0 {
            p { a href="#published" { "Not as published: " (missed) " of " (study.published.len()) " figures" } }
        }
    }
}
