//! The page around the sections: head, navigation, style and script.

use evidence::StudyResult;
use maud::{DOCTYPE, Markup, PreEscaped, html};

use crate::section;
use crate::view::{View, prose};

const STYLE: &str = include_str!("style.css");
const SCRIPT: &str = include_str!("script.js");

/// SHA-256 of `script.js`, in base64: the only script that may run. A test
/// says what it must be when the script changes.
const SCRIPT_HASH: &str = "YYBZcrAcuVMDv7a2n8ZDuvMtKc2Iocym0mjujSYP9ek=";

/// Anchor and name of each section, in order.
pub const SECTIONS: [(&str, &str); 17] = [
    ("answers", "Answers"),
    ("verdict", "Verdict"),
    ("matrix", "Matrix"),
    ("forest", "Evidence"),
    ("modes", "Failure modes"),
    ("suspects", "Suspects"),
    ("parting", "Parting"),
    ("found", "Found"),
    ("fitted", "Fitted"),
    ("comparisons", "Comparisons"),
    ("further", "What would decide"),
    ("argument", "Argument"),
    ("ledger", "Ledger"),
    ("coverage", "Coverage"),
    ("published", "Published"),
    ("cost", "Cost"),
    ("provenance", "Provenance"),
];

/// The whole page.
pub fn render(study: &StudyResult) -> String {
    let view = View { study };
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            (head(&study.title, STYLE, SCRIPT_HASH))
            body {
                a class="skip" href="#answers" { "Skip to the answers" }
                (masthead(study))
                (navigation(study))
                main { (sections(view)) }
                footer { p { "Produced by " (study.produced_by) ". This file is complete in itself and loads nothing." } }
                script { (PreEscaped(SCRIPT)) }
            }
        }
    };
    diagnostic::printable(&page.into_string()).into_owned()
}

/// The head of a page that is complete in itself and runs no script but the one with this hash.
pub(crate) fn head(title: &str, style: &str, script_hash: &str) -> Markup {
    let policy = format!(
        "default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'sha256-{script_hash}'; base-uri 'none'; form-action 'none'"
    );
    html! {
        head {
            meta charset="utf-8";
            meta http-equiv="Content-Security-Policy" content=(policy);
            meta name="viewport" content="width=device-width, initial-scale=1";
            meta name="color-scheme" content="light dark";
            title { (title) }
            link rel="icon" href="data:,";
            style { (PreEscaped(style)) }
        }
    }
}

fn masthead(study: &StudyResult) -> Markup {
    html! {
        header class="masthead" {
            p class="kicker" { "Corroborative verification and validation" }
            h1 { (study.title) }
            div class="summary" { (prose(&study.summary)) }
            p class="small" { "New to such reports? " a href="#reading" { "How to read this one" } "." }
        }
    }
}

/// Whether a section is on the page; some are only where there is something to show.
fn is_there(study: &StudyResult, id: &str) -> bool {
    match id {
        "parting" => study.disagreement.is_some(),
        "found" => study.exploration.is_some(),
        "fitted" => study.calibration.is_some(),
        _ => true,
    }
}

fn navigation(study: &StudyResult) -> Markup {
    html! {
        nav aria-label="Sections" {
            ul {
                @for (id, name) in SECTIONS {
                    @if is_there(study, id) { li { a href={ "#" (id) } { (name) } } }
                }
                li { a href="#reading" { "How to read" } }
            }
            button id="theme" type="button" hidden { "Dark" }
        }
    }
}

fn sections(view: View) -> Markup {
    html! {
        (section::answers::render(view))
        (section::verdict::render(view))
        (section::matrix::render(view))
        (section::forest::render(view))
        (section::modes::render(view))
        (section::suspects::render(view))
        (section::parting::render(view))
        (section::found::render(view))
        (section::fitted::render(view))
        (section::comparisons::render(view))
        (section::further::render(view))
        (section::assurance::render(view))
        (section::ledger::render(view))
        (section::coverage::render(view))
        (section::published::render(view))
        (section::cost::render(view))
        (section::provenance::render(view))
        (section::glossary::render(view))
    }
}
