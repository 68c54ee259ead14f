//! Provenance: from which bytes and programs every number came.

use evidence::{Asset, Requirement};
use maud::{Markup, html};

use crate::number;
use crate::view::{View, section};
use crate::words;

/// The section.
pub fn render(view: View) -> Markup {
    let study = view.study;
    let lead = html! { "From which files and programs every number here came. A file is known by the BLAKE3 hash of its content." };
    let body = html! {
        dl class="facts" {
            div { dt { "Produced by" } dd { (study.produced_by) } }
            div { dt { "Level of intervals" } dd { (number::level(study.confidence)) } }
            div { dt { "Format of the data" } dd { (study.format) } }
        }
        h3 { "Requirements as they were checked" }
        @for requirement in &study.requirements { (as_checked(requirement)) }
        h3 { "Assets" }
        (assets(view))
        h3 { "Tools and inputs" }
        (inputs(view))
    };
    section("provenance", "Provenance", lead, body)
}

fn as_checked(requirement: &Requirement) -> Markup {
    html! {
        details class="checked" {
            summary { span class="req" { (requirement.id) } " " (requirement.text) }
            dl class="facts" {
                div { dt { "Asked" } dd { (words::asked(requirement)) } }
                div { dt { "Margin" } dd { (number::level(requirement.margin)) } }
                @if let Some(first) = &requirement.same_quantity_as {
                    div { dt { "Quantity" } dd { "that of requirement " (first) } }
                }
                @if let Some(sentence) = &requirement.sentence {
                    div { dt { "In structured English" } dd { (sentence) } }
                }
                div { dt { "Logical property" } dd {
                    @match &requirement.property { Some(p) => code { (p) }, None => "none" }
                } }
                div { dt { "Monitor" } dd { (requirement.monitor.as_deref().unwrap_or("none")) } }
            }
        }
    }
}

/// Every asset once, with the evidence that uses it, in the ledger's order.
fn distinct<'a>(view: View<'a>) -> Vec<(&'a Asset, Vec<String>)> {
    let mut distinct: Vec<(&Asset, Vec<String>)> = Vec::new();
    for evidence in &view.study.evidence {
        for asset in &evidence.assets {
            match distinct.iter_mut().find(|(known, _)| *known == asset) {
                Some((_, users)) => users.push(evidence.id.clone()),
                None => distinct.push((asset, vec![evidence.id.clone()])),
            }
        }
    }
    distinct
}

fn assets(view: View) -> Markup {
    html! {
        div class="scroll" tabindex="0" role="region" aria-label="Assets" {
            table class="assets" {
                caption class="visually-hidden" { "Assets with their hashes" }
                thead { tr {
                    th scope="col" { "File" } th scope="col" { "Role" }
                    th scope="col" { "Used by" } th scope="col" { "Hash" }
                } }
                tbody {
                    @for (asset, users) in distinct(view) {
                        tr {
                            th scope="row" { code { (asset.path) } }
                            td { (words::role(asset.role)) }
                            td { (view.links(&users)) }
                            td { code class="hash whole" { (asset.hash) } }
                        }
                    }
                }
            }
        }
    }
}

fn inputs(view: View) -> Markup {
    html! {
        div class="scroll" tabindex="0" role="region" aria-label="Tools and inputs" {
            table class="assets" {
                caption class="visually-hidden" { "Tools and hash of all inputs, by evidence" }
                thead { tr {
                    th scope="col" { "Evidence" } th scope="col" { "Tool" }
                    th scope="col" { "Settings" } th scope="col" { "Hash of all inputs" }
                } }
                tbody {
                    @for evidence in &view.study.evidence {
                        tr {
                            th scope="row" { (view.link(&evidence.id)) }
                            td { (evidence.tool.name) " " (evidence.tool.version) }
                            td { (evidence.tool.settings) }
                            td { code class="hash whole" { (evidence.inputs) } }
                        }
                    }
                }
            }
        }
    }
}
