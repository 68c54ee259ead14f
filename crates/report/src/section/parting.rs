//! Where model and simulation part: the contexts that a search found, in words and as a map.
//!
//! The map shows the first two parameters. Squares are estimates of the search's first episodes; only the frames, which
//! are regions with fresh episodes of their own, carry a decision.

use evidence::{ContextParameter, ContextRegion, DisagreementMap, MapPlace, RegionOutcome};
use maud::{Markup, html};

use crate::number;
use crate::view::{View, chip, prose, range, section};
use crate::words;

/// Width and height of the drawing, in its own units.
const SIDE: f64 = 100.0;
/// The difference at which a square has its full colour, in margins.
const FULL: f64 = 4.0;

/// The section; nothing where no search was made.
pub fn render(view: View) -> Markup {
    let Some(map) = &view.study.disagreement else {
        return html! {};
    };
    let lead = html! {
        "Contexts in which " (view.link(&map.model)) " predicts one thing and " (view.link(&map.simulation))
        " shows another, on requirement " (view.requirement_link(&map.requirement)) ". Differences up to "
        (number::decimal(100.0 * map.margin, 0)) " points do not matter. "
        "Found by a search over " (number::count(map.episodes)) " episodes, not by a grid."
    };
    let body = html! {
        (regions(map))
        p class="small shares" {
            "Of all contexts, by their declared distributions, " (number::percent(map.shares.differs))
            " lie in regions that differ, " (number::percent(map.shares.agrees)) " in regions that agree, "
            (number::percent(map.shares.undecided)) " in undecided ones. With a probability of at least "
            (number::percent(map.confidence)) " no region is wrongly decided."
        }
        (drawing(map))
        div class="small" { (prose(&map.statement)) }
    };
    section("parting", "Where they part", lead, body)
}

fn regions(map: &DisagreementMap) -> Markup {
    if map.regions.is_empty() {
        return html! { p class="empty" { "No region was drawn: the search had too few episodes." } };
    }
    html! {
        div class="scroll" tabindex="0" role="region" aria-label="Regions" {
            table class="regions" {
                caption class="visually-hidden" { "Regions of contexts, and whether model and simulation differ in them" }
                thead { tr {
                    th scope="col" { "Contexts" } th scope="col" class="n" { "Share" }
                    th scope="col" class="n" { (map.model) } th scope="col" { (map.simulation) }
                    th scope="col" { "Differ by" } th scope="col" { "Outcome" }
                } }
                tbody { @for region in &map.regions { (row(region)) } }
            }
        }
    }
}

fn row(region: &ContextRegion) -> Markup {
    let least = number::decimal(100.0 * region.sure_difference, 0);
    let most = number::decimal(100.0 * region.largest_difference(), 0);
    html! {
        tr {
            th scope="row" { (region.place()) }
            td class="n" { (number::percent(region.share)) }
            td class="n" { (number::percent(region.predicted)) }
            td {
                span class="counts" { (number::count(region.successes)) "/" (number::count(region.trials)) } " "
                (range(region.rate))
            }
            td { (least) " to " (most) " points" }
            td {
                (chip(&words::region(region.decided)))
                @if let Some(further) = region.further_episodes.filter(|n| *n < 1e6) {
                    " " span class="small" { "about " (number::count(further.ceil() as u64)) " more episodes" }
                }
            }
        }
    }
}

/// The map over the first two parameters; nothing where there are fewer.
fn drawing(map: &DisagreementMap) -> Markup {
    let [across, up, others @ ..] = &map.parameters[..] else {
        return html! {};
    };
    let [columns, rows] = [across, up].map(|parameter| values(&map.map, parameter));
    if columns.len() < 2 || rows.len() < 2 {
        return html! {};
    }
    let others: Vec<&str> = others.iter().map(|p| p.name.as_str()).collect();
    html! {
        figure class="parting" {
            div class="up" { (label(up)) }
            svg viewBox={ "0 0 " (SIDE) " " (SIDE) } preserveAspectRatio="none" role="img"
                aria-label={ "Map of " (across.name) " against " (up.name) "; its figures follow" } {
                @for place in &map.map { (cell(place, (across, &columns), (up, &rows), map.margin)) }
                @for region in &map.regions { (frame(region, across, up)) }
            }
            div class="across" {
                span { (number::decimal(across.support[0], 2)) }
                span { (label(across)) }
                span { (number::decimal(across.support[1], 2)) }
            }
            ul class="key" aria-label="Key to the map" {
                li { span class="swatch low" {} " the simulation's rate is lower" }
                li { span class="swatch high" {} " higher" }
                li { span class="swatch decided" {} " region that differs" }
                li { span class="swatch open" {} " undecided or agreeing" }
            }
            figcaption class="small" {
                "Colours are estimates of the first episodes"
                @if !others.is_empty() { ", with " (others.join(" and ")) " at the nominal value" }
                "; frames are the regions of the table."
            }
        }
        details {
            summary { "The figures of the map" }
            (figures(map, across, up))
        }
    }
}

/// A parameter with its range and unit.
fn label(parameter: &ContextParameter) -> String {
    let [low, high] = parameter.support.map(|value| number::decimal(value, 2));
    let unit = parameter.unit.as_deref().unwrap_or("");
    format!("{}, {low} to {high} {unit}", parameter.name)
        .trim_end()
        .to_owned()
}

/// Where a value lies between a parameter's ends, from 0 to 1.
fn share(parameter: &ContextParameter, value: f64) -> f64 {
    let [low, high] = parameter.support;
    match high > low {
        true => ((value - low) / (high - low)).clamp(0.0, 1.0),
        false => 0.5,
    }
}

/// The values of a parameter on the map, as shares of its range, ascending.
fn values(map: &[MapPlace], parameter: &ContextParameter) -> Vec<f64> {
    let values = map.iter().filter_map(|p| p.parameters.get(&parameter.name));
    let mut values: Vec<f64> = values.map(|value| share(parameter, *value)).collect();
    values.sort_by(f64::total_cmp);
    values.dedup();
    values
}

/// What is nearer to a value than to the others: from the middle between it and the one before to the middle between it
/// and the next.
fn nearest(values: &[f64], value: f64) -> [f64; 2] {
    let before = values.iter().rev().find(|other| **other < value);
    let next = values.iter().find(|other| **other > value);
    [
        before.map_or(0.0, |other| f64::midpoint(*other, value)),
        next.map_or(1.0, |other| f64::midpoint(*other, value)),
    ]
}

fn cell(
    place: &MapPlace,
    (across, columns): (&ContextParameter, &[f64]),
    (up, rows): (&ContextParameter, &[f64]),
    margin: f64,
) -> Markup {
    let at = |parameter: &ContextParameter| {
        let value = place.parameters.get(&parameter.name);
        value.map(|value| share(parameter, *value))
    };
    let (Some(x), Some(y)) = (at(across), at(up)) else {
        return html! {};
    };
    let difference = place.simulated - place.predicted;
    let tone = if difference < 0.0 { "low" } else { "high" };
    let strength = (difference.abs() / (FULL * margin)).clamp(0.0, 1.0);
    let [left, right] = nearest(columns, x);
    let [bottom, top] = nearest(rows, y);
    html! {
        rect class=(tone) x=(fixed(SIDE * left)) y=(fixed(SIDE * (1.0 - top)))
            width=(fixed(SIDE * (right - left))) height=(fixed(SIDE * (top - bottom)))
            fill-opacity=(fixed(strength)) {}
    }
}

fn frame(region: &ContextRegion, across: &ContextParameter, up: &ContextParameter) -> Markup {
    let ends = |parameter: &ContextParameter| {
        let range = region.ranges.iter().find(|r| r.parameter == parameter.name);
        range.map_or((0.0, 1.0), |r| {
            (share(parameter, r.low), share(parameter, r.high))
        })
    };
    let ((left, right), (bottom, top)) = (ends(across), ends(up));
    let class = match region.decided {
        RegionOutcome::Differs => "frame differs",
        RegionOutcome::Undecided | RegionOutcome::Agrees => "frame",
    };
    html! {
        rect class=(class) x=(fixed(SIDE * left)) y=(fixed(SIDE * (1.0 - top)))
            width=(fixed(SIDE * (right - left))) height=(fixed(SIDE * (top - bottom)))
            vector-effect="non-scaling-stroke" {}
    }
}

fn figures(map: &DisagreementMap, across: &ContextParameter, up: &ContextParameter) -> Markup {
    html! {
        div class="scroll" tabindex="0" role="region" aria-label="Figures of the map" {
            table {
                caption class="visually-hidden" { "What the map is drawn from" }
                thead { tr {
                    th scope="col" class="n" { (across.name) } th scope="col" class="n" { (up.name) }
                    th scope="col" class="n" { (map.model) } th scope="col" class="n" { (map.simulation) ", estimated" }
                    th scope="col" class="n" { "standard deviation" }
                } }
                tbody {
                    @for place in &map.map {
                        tr {
                            @for parameter in [across, up] {
                                td class="n" {
                                    @if let Some(value) = place.parameters.get(&parameter.name) { (number::decimal(*value, 3)) }
                                }
                            }
                            td class="n" { (number::percent(place.predicted)) }
                            td class="n" { (number::percent(place.simulated)) }
                            td class="n" { (number::points(place.sd).replace('+', "")) }
                        }
                    }
                }
            }
        }
    }
}

/// A length of the drawing.
fn fixed(value: f64) -> String {
    format!("{value:.2}")
}
