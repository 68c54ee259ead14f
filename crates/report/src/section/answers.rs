//! The five questions, before anything else.

use maud::{Markup, html};

use crate::answers::{Answer, Part, answers};
use crate::view::{View, section, unbroken};

/// The section.
pub fn render(view: View) -> Markup {
    let body = html! {
        ol class="answers" {
            @for answer in answers(view) { (item(&answer)) }
        }
    };
    let lead = html! { "Five questions and what this study answers. Each figure leads to where it comes from." };
    section("answers", "In a minute", lead, body)
}

fn item(answer: &Answer) -> Markup {
    html! {
        li {
            h3 { (answer.question) }
            p class="short" { (unbroken(&answer.short)) }
            @if !answer.lines.is_empty() {
                ul class="lines" {
                    @for line in &answer.lines {
                        li { @for part in line { (shown(part)) } }
                    }
                }
            }
        }
    }
}

fn shown(part: &Part) -> Markup {
    html! {
        @match part {
            Part::Text(text) => (unbroken(text)),
            Part::Link(anchor, text) => a href={ "#" (anchor) } { (unbroken(text)) },
        }
    }
}
