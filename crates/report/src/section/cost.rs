//! What producing the evidence took.

use evidence::Cost;
use maud::{Markup, html};

use crate::number;
use crate::view::{View, section};

/// The section.
pub fn render(view: View) -> Markup {
    let lead = html! { "What each piece of evidence took here, and what the source publication reports for it." };
    let body = html! {
        @if view.study.costs.is_empty() {
            p class="empty" { "No costs were recorded." }
        } @else { (table(view)) }
    };
    section("cost", "Computational cost", lead, body)
}

fn table(view: View) -> Markup {
    html! {
        div class="scroll" tabindex="0" role="region" aria-label="Computational cost" {
            table {
                caption class="visually-hidden" { "Computational cost by evidence" }
                thead { tr {
                    th scope="col" { "Evidence" }
                    th scope="col" class="n" { "Elapsed" }
                    th scope="col" class="n" { "Simulated" }
                    th scope="col" class="n" { "Processor" }
                    th scope="col" class="n" { "Real time" }
                    th scope="col" class="n" { "States" }
                    th scope="col" class="n" { "Transitions" }
                    th scope="col" { "As published" }
                } }
                tbody { @for cost in &view.study.costs { (row(view, cost)) } }
            }
        }
    }
}

fn row(view: View, cost: &Cost) -> Markup {
    let time = |secs: Option<f64>| secs.map_or(number::NONE.to_owned(), number::duration);
    let size = |count: Option<u64>| count.map_or(number::NONE.to_owned(), number::count);
    html! {
        tr {
            th scope="row" { (view.link(&cost.evidence)) }
            td class="n" { (number::duration(cost.wall_secs)) }
            td class="n" { (time(cost.simulated_secs)) }
            td class="n" { (time(cost.cpu_secs)) }
            td class="n" { (cost.real_time_factor.map_or(number::NONE.to_owned(), |f| format!("× {f:.0}"))) }
            td class="n" { (size(cost.states)) }
            td class="n" { (size(cost.transitions)) }
            td class="words" { (cost.published.as_deref().unwrap_or(number::NONE)) }
        }
    }
}
