//! The source publication's figures beside ours.

use evidence::PublishedFigure;
use maud::{Markup, html};

use crate::view::{View, chip, section};
use crate::words::Mark;

/// The section.
pub fn render(view: View) -> Markup {
    let lead = html! { "What the source publication prints, what was computed here, and how the two were judged." };
    let body = html! {
        @if view.study.published.is_empty() {
            p class="empty" { "This study names no published figures." }
        } @else { (table(view)) }
    };
    section("published", "Published figures", lead, body)
}

fn table(view: View) -> Markup {
    html! {
        div class="scroll" tabindex="0" role="region" aria-label="Published figures" {
            table {
                caption class="visually-hidden" { "Published figures beside ours" }
                thead { tr {
                    th scope="col" { "Evidence" }
                    th scope="col" { "Quantity" }
                    th scope="col" class="n" { "Published" }
                    th scope="col" class="n" { "Ours" }
                    th scope="col" { "Agree" }
                } }
                tbody { @for figure in &view.study.published { (row(view, figure)) } }
            }
        }
    }
}

fn row(view: View, figure: &PublishedFigure) -> Markup {
    let mark = if figure.agrees {
        Mark {
            symbol: "✓",
            word: "yes".to_owned(),
            tone: "good",
        }
    } else {
        Mark {
            symbol: "✗",
            word: "no".to_owned(),
            tone: "bad",
        }
    };
    html! {
        tr {
            th scope="row" { (view.link(&figure.evidence)) }
            td { (figure.quantity) }
            td class="n" { (figure.published) }
            td class="n" { (figure.ours) }
            td class="words" { (chip(&mark)) " " span class="small" { (figure.judged) } }
        }
    }
}
