//! Failure modes side by side: where headline rates hide a disagreement.

use evidence::{FailureMode, Subject};
use maud::{Markup, html};

use super::forest::{axis_row, extent, row, rows};
use crate::number;
use crate::plot::Axis;
use crate::view::{View, section};

/// The section.
pub fn render(view: View) -> Markup {
    let lead = html! {
        "Two success rates can agree while the reasons for failure do not. So each way of failing is counted on its own, "
        "against the number of times at which it could have occurred. All panels have the same axis."
    };
    let modes = &view.study.failure_modes;
    let axis = Axis::of_rates(
        modes
            .iter()
            .flat_map(|mode| extent(&rows(view, &subject(mode))))
            .chain([0.0]),
    );
    let body = html! {
        @if modes.is_empty() { p class="empty" { "This study declares no failure modes." } }
        div class="panels" {
            @for mode in modes { (panel(view, mode, &axis)) }
        }
    };
    section("modes", "Failure modes", lead, body)
}

fn subject(mode: &FailureMode) -> Subject {
    Subject::FailureMode(mode.id.clone())
}

fn panel(view: View, mode: &FailureMode, axis: &Axis) -> Markup {
    let rows = rows(view, &subject(mode));
    html! {
        figure class="forest small-multiple" {
            figcaption {
                h3 { (mode.name) }
                p class="small" { (mode.meaning) " Margin " (number::level(mode.margin)) "." }
            }
            @if rows.is_empty() { p class="empty" { "No evidence counts this failure mode." } }
            ol class="rows" {
                @for (evidence, finding) in &rows { (row(view, axis, &[], evidence, finding)) }
                @if rows.iter().any(|(_, it)| it.measure.estimate().is_some()) { (axis_row(axis)) }
            }
        }
    }
}
