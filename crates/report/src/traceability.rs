//! The table of traceability as a page of its own: each requirement with its forms, its evidence, its tests, its verdict, and
//! what is missing.

use crate::assurance::words::figures;
use crate::page::head;
use crate::words;
use evidence::{StudyResult, TraceRow};
use maud::{DOCTYPE, Markup, html};

/// The style of the table, which has no script and loads nothing.
const STYLE: &str = "body{font:14px/1.45 system-ui,sans-serif;margin:2em;color:#222;background:#fff}\
table{border-collapse:collapse;width:100%}th,td{border:1px solid #bbb;padding:.35em .5em;text-align:left;vertical-align:top}\
th{background:#eee}code{font-size:12px;overflow-wrap:anywhere}td.gap{background:#fff3d6}td.files{min-width:10em}.form{color:#555}\
@media print{body{margin:0;font-size:9px}}";

/// SHA-256 of the empty script in base64: no other may run.
const NO_SCRIPT: &str = "47DEQpj8HBSa+/TImW+5JCeuQeRkm5NMpJWZG3hSuFU=";

/// The page of these rows.
#[must_use]
pub fn traceability(study: &StudyResult, rows: &[TraceRow<'_>]) -> String {
    let groups = rows.chunk_by(|a, b| a.requirement.id == b.requirement.id);
    let title = format!("Traceability: {}", study.title);
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            (head(&title, STYLE, NO_SCRIPT))
            body {
                h1 { (title) }
                p { "Each requirement with its forms, the evidence about it, its tests and its verdict. A coloured cell says what is missing. The same table is in traceability.csv." }
                table {
                    thead { tr { @for name in ["Requirement", "Verdict", "Evidence", "Finding", "Part in the verdict", "Rests on", "Tests", "Missing"] { th scope="col" { (name) } } } }
                    @for group in groups { tbody { (requirement(group)) } }
                }
            }
        }
    };
    diagnostic::printable(&page.into_string()).into_owned()
}

fn requirement(group: &[TraceRow<'_>]) -> Markup {
    html! {
        @for (number, row) in group.iter().enumerate() {
            tr {
                @if number == 0 {
                    td rowspan=(group.len()) { (forms(row)) }
                    td rowspan=(group.len()) {
                        (row.verdict.words())
                        @if let Some(step) = row.step { br; (step.words()) }
                    }
                }
                (piece(row))
                @if number == 0 {
                    td.gap[row.tests.is_empty()] rowspan=(group.len()) {
                        @if row.tests.is_empty() { "no test names it" }
                        @for test in &row.tests { code { (test) } br; }
                    }
                }
                td.gap[!row.gap.is_empty()] { (row.gap) }
            }
        }
    }
}

fn forms(row: &TraceRow<'_>) -> Markup {
    let requirement = row.requirement;
    let forms = [
        ("sentence", &requirement.sentence),
        ("formula", &requirement.property),
        ("monitor", &requirement.monitor),
    ];
    html! {
        b { (requirement.id) } " " (requirement.text)
        br; span.form { "asks: " (words::asked(requirement)) }
        @for (name, form) in forms {
            br;
            span.form {
                (name) ": "
                @match form {
                    Some(form) => { code { (form) } }
                    None => { "none" }
                }
            }
        }
    }
}

fn piece(row: &TraceRow<'_>) -> Markup {
    let Some((piece, finding)) = row.shown_by else {
        return html! { td.gap colspan="4" { "no evidence" } };
    };
    html! {
        td { b { (piece.id) } " " (piece.title) br; span.form { (words::technique(piece.technique)) ", " (piece.conditions) } }
        td { (figures(&finding.measure)) }
        td { (row.part) }
        td.files { @for asset in &piece.assets { code { (asset.path) } br; } }
    }
}
