//! Comparisons: every pair of evidence on every subject, with its outcome.

use evidence::{Comparison, FurtherTrials, Outcome, Subject};
use maud::{Markup, html};

use crate::number;
use crate::plot::{Axis, difference_strip};
use crate::view::{View, chip, section};
use crate::words;

/// The section.
pub fn render(view: View) -> Markup {
    let lead = html! {
        "Every pair of evidence on every requirement and failure mode. Agreement is claimed only if the difference is "
        "shown to be smaller than the declared margin; a conflict only if it is beyond chance, allowing for the number of comparisons, "
        "and its estimate is the margin or more."
    };
    let body = html! {
        (totals(view))
        p class="print-only small" { "The figures of each pair are in this report's form on the screen and in its JSON." }
        @if view.study.comparisons.is_empty() {
            p class="empty" { "Nothing to compare: that takes two pieces of evidence on the same subject." }
        }
        div class="subjects" {
            @for subject in view.subjects() { (card(view, &subject)) }
        }
    };
    section("comparisons", "Comparisons", lead, body)
}

fn totals(view: View) -> Markup {
    html! {
        ul class="key outcomes" aria-label="Outcomes, with the number of pairs" {
            @for outcome in words::OUTCOMES {
                @let pairs = view.study.comparisons.iter().filter(|c| c.outcome == outcome);
                @let slug = slug(outcome);
                li data-filter=(slug) { (chip(&words::outcome(outcome))) " " (number::count(pairs.count() as u64)) }
            }
            li { span class="swatch fit" {} " dashed: a fit, not independent" }
        }
    }
}

/// The outcome's name for the filter.
fn slug(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Corroborates => "corroborates",
        Outcome::Conflicts => "conflicts",
        Outcome::Inconclusive => "inconclusive",
        Outcome::NotComparable => "not-comparable",
    }
}

fn card(view: View, subject: &Subject) -> Markup {
    let pairs: Vec<&Comparison> = view
        .study
        .comparisons
        .iter()
        .filter(|c| &c.subject == subject)
        .collect();
    html! {
        @if !pairs.is_empty() {
            article class="subject" {
                h3 { (view.title(subject)) }
                @if let Subject::Requirement(id) = subject {
                    @if let Some(requirement) = view.requirement(id) { p class="small" { (requirement.text) } }
                }
                (at_once(view, subject))
                (heat(view, subject, &pairs))
                details {
                    summary { "Figures and reasons" }
                    @if pairs.iter().any(|c| c.outcome != Outcome::NotComparable) {
                        (table(view, subject, &pairs))
                    }
                    (not_comparable(view, &pairs))
                }
            }
        }
    }
}

/// All pieces on the subject at once: the outcome in words, the test behind it.
fn at_once(view: View, subject: &Subject) -> Markup {
    html! {
        @if let Some(all) = view.together(subject) {
            p class="small" {
                (chip(&words::comparison(all.outcome, all.independent)))
                " all at once (" (view.links(&all.evidence)) ")"
                @if let Some(spreading) = &all.heterogeneity {
                    "; homogeneity of the " (spreading.degrees + 1) " uncertain rates: p "
                    (number::p_value(spreading.p_corrected))
                    ", corrected (Q = " (number::decimal(spreading.statistic, 1))
                    " on " (spreading.degrees) ", I² " (number::percent(spreading.i_squared)) ")"
                }
                "."
            }
        }
    }
}

/// Identifiers in the order of the ledger that occur in the pairs.
fn members<'a>(view: View<'a>, pairs: &[&'a Comparison]) -> Vec<&'a str> {
    let ledger = view.study.evidence.iter().map(|e| e.id.as_str());
    ledger
        .filter(|id| pairs.iter().any(|c| c.left == *id || c.right == *id))
        .collect()
}

fn heat(view: View, subject: &Subject, pairs: &[&Comparison]) -> Markup {
    let ids = members(view, pairs);
    let (columns, lines) = match ids.len() {
        0 => (&ids[..], &ids[..]),
        n => (&ids[..n - 1], &ids[1..]),
    };
    html! {
        table class="heat" {
            caption class="visually-hidden" { "Pairs of evidence on " (view.short_title(subject)) }
            thead {
                tr { td {} @for id in columns { th scope="col" { span { (id) } } } }
            }
            tbody {
                @for (i, line) in lines.iter().enumerate() {
                    tr {
                        th scope="row" { (line) }
                        @for column in &columns[..=i.min(columns.len() - 1)] {
                            (heat_cell(pairs, column, line))
                        }
                    }
                }
            }
        }
    }
}

fn heat_cell(pairs: &[&Comparison], a: &str, b: &str) -> Markup {
    let pair = pairs
        .iter()
        .find(|c| (c.left == a && c.right == b) || (c.left == b && c.right == a));
    html! {
        @match pair {
            None => td {},
            Some(pair) => {
                @let mark = words::pair(pair);
                @let fit = if pair.independent { "" } else { " fit" };
                td class={ (mark.tone) (fit) } title={ (pair.left) ", " (pair.right) ": " (mark.word) } {
                    span aria-hidden="true" { (mark.symbol) }
                    span class="visually-hidden" { (mark.word) @if !pair.independent { " (not independent)" } }
                }
            },
        }
    }
}

fn table(view: View, subject: &Subject, pairs: &[&Comparison]) -> Markup {
    let axis = Axis::of_differences(pairs.iter().flat_map(|c| {
        let ends = c.difference_interval.map(|i| [i.low, i.high]);
        c.difference
            .into_iter()
            .chain([c.margin])
            .chain(ends.into_iter().flatten())
    }));
    let mut sorted: Vec<_> = pairs
        .iter()
        .filter(|c| c.outcome != Outcome::NotComparable)
        .collect();
    sorted.sort_by_key(|c| words::OUTCOMES.iter().position(|o| *o == c.outcome));
    html! {
        div class="scroll" tabindex="0" role="region" aria-label={ "Figures on " (view.short_title(subject)) } {
            table class="figures cards" {
                caption class="visually-hidden" { "Differences and tests on " (view.short_title(subject)) }
                thead { tr {
                    th scope="col" { "Pair" }
                    th scope="col" { "Outcome" }
                    th scope="col" class="wide" { "Difference, points" (axis.labels("")) }
                    th scope="col" class="n" { "p, no difference" br; span class="small" { "corrected" } }
                    th scope="col" class="n" { "p, beyond margin" }
                    th scope="col" class="n" { "P, within margin" }
                    th scope="col" { "Why, and what would decide" }
                } }
                tbody { @for pair in &sorted { (pair_row(view, &axis, pair)) } }
            }
        }
    }
}

/// Pairs that are not comparable, once for each reason.
fn not_comparable(view: View, pairs: &[&Comparison]) -> Markup {
    let mut reasons: Vec<(&str, Vec<&Comparison>)> = Vec::new();
    for pair in pairs.iter().filter(|c| c.outcome == Outcome::NotComparable) {
        match reasons
            .iter_mut()
            .find(|(reason, _)| *reason == pair.reason)
        {
            Some((_, same)) => same.push(pair),
            None => reasons.push((&pair.reason, vec![pair])),
        }
    }
    html! {
        ul class="lines" {
            @for (reason, same) in &reasons {
                li data-outcome=(slug(Outcome::NotComparable)) {
                    (chip(&words::outcome(Outcome::NotComparable))) " "
                    @for (i, pair) in same.iter().enumerate() {
                        @if i > 0 { ", " }
                        (view.link(&pair.left)) " → " (view.link(&pair.right))
                    }
                    ": " (reason)
                }
            }
        }
    }
}

fn pair_row(view: View, axis: &Axis, pair: &Comparison) -> Markup {
    let optional = |p: Option<f64>| p.map_or(number::NONE.to_owned(), number::p_value);
    html! {
        tr data-outcome=(slug(pair.outcome)) {
            th scope="row" { (view.link(&pair.left)) " → " (view.link(&pair.right)) }
            td data-label="Outcome" {
                (chip(&words::pair(pair)))
                @if let Some(relation) = pair.relation { " " span class="small" { (relation.words()) } " " }
                @if !pair.independent && pair.outcome != Outcome::Corroborates {
                    span class="small" { "not independent" }
                }
            }
            td data-label="Difference" { @if let Some(difference) = pair.difference { (difference_cell(axis, pair, difference)) } }
            td class="n" data-label="p, no difference" {
                (optional(pair.p_difference)) " "
                @if pair.p_difference_corrected.is_some() {
                    br; span class="small corrected" { (optional(pair.p_difference_corrected)) }
                }
            }
            td class="n" data-label="p, beyond margin" { (optional(pair.p_equivalence)) }
            td class="n" data-label="P, within margin" { (optional(pair.probability_within_margin)) }
            td class="why" data-label="Why" {
                (pair.reason)
                @if let Some(sensitivity) = &pair.clustering { " " (sensitivity.statement) }
                @if let Some(trigger) = &pair.trigger {
                    span class="further" { "How often it is triggered, a quantity of its own: " (trigger.reason) }
                }
                @if let Some(reason) = &pair.trigger_not_compared {
                    span class="further" { "How often it is triggered, a quantity of its own, is not compared: " (reason) }
                }
                @if !pair.further_trials.is_empty() {
                    span class="further" {
                        "Would decide: "
                        @for (i, further) in pair.further_trials.iter().enumerate() {
                            @if i > 0 { "; " }
                            (further_words(view, further))
                        }
                        "."
                    }
                }
            }
        }
    }
}

fn difference_cell(axis: &Axis, pair: &Comparison, difference: f64) -> Markup {
    let interval = pair.difference_interval;
    let text = match interval {
        Some(i) => format!(
            "{} [{}, {}]",
            number::points(difference),
            number::points(i.low),
            number::points(i.high)
        ),
        None => number::points(difference),
    };
    html! {
        (difference_strip(axis, pair.margin, difference, interval))
        span class="difference-text" { (text) }
    }
}

fn further_words(view: View, further: &FurtherTrials) -> Markup {
    html! {
        @match further.trials {
            Some(trials) => { (number::count(trials)) " more trials of " (view.link(&further.evidence)) },
            None => { "no plan of trials of " (view.link(&further.evidence)) " alone was found" },
        }
    }
}
