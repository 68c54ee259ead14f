//! What was found by looking for what nobody has thought of: by cause, each with its smallest scenario and the command
//! that runs it again.
//!
//! One cause shows itself in several findings (an object that slips is a failure mode, a violated requirement and a step
//! that the model does not have), so causes come first and findings stand under them.

use std::collections::BTreeMap;

use evidence::{CauseFound, CauseSetting, Discovery, Exploration, Stopped, Subject};
use maud::{Markup, html};

use crate::number;
use crate::view::{View, chip, prose, section, unbroken};
use crate::words;

/// Where `run` finds the exploration, and `replay` its files.
const FOLDER: &str = "results/exploration";
/// Episodes without numbers that are listed, at most.
const LISTED: usize = 5;

/// A finding with one of its causes.
type Shown<'a> = (&'a Discovery, &'a CauseFound);

/// The section; nothing where nothing was explored.
pub fn render(view: View) -> Markup {
    let Some(found) = &view.study.exploration else {
        return html! {};
    };
    let lead = html! {
        (number::count(found.episodes)) " episodes of " (view.link(&found.evidence))
        @if let Some(model) = &found.model { ", held against " (view.link(model)) "," }
        " were chosen to show unexpected behaviour"
        @match found.stopped {
            Stopped::Budget => {},
            Stopped::NothingNew => { ", until more of them had stopped paying" },
            Stopped::Interrupted => { ", until they were interrupted" },
        }
        @if found.confirmation.is_some() {
            ". The search ran in the fast physics; each finding was run again in the full physics, which shows it, too"
        }
        ". Each finding is a witness that can be run again; how often an exploration came there is not how often it happens."
    };
    let causes = by_cause(found);
    let body = html! {
        @if found.findings.is_empty() {
            p class="empty" { "Nothing was found: no violation, no way to fail, no step that the model does not have." }
        }
        @for shown in causes.values() { (cause(view, found, shown)) }
        (others(view, found, causes.is_empty()))
        (not_confirmed(view, found))
        (broken(found))
        div class="small shares" { (prose(&found.statement)) }
    };
    section("found", "Unexpected behaviour", lead, body)
}

/// What only the fast physics showed.
fn not_confirmed(view: View, found: &Exploration) -> Markup {
    let confirmation = found.confirmation.iter();
    let others: Vec<&Discovery> = confirmation.flat_map(|it| &it.not_confirmed).collect();
    html! {
        @if !others.is_empty() {
            h3 { "Not confirmed by the full physics" }
            p class="small" { "Episodes of the fast physics showed these, and the same episodes in the full physics did not. They are not findings." }
            ul class="small" {
                @for one in others {
                    li { (what(view, one)) " (in " (number::count(one.episodes)) " of " (number::count(found.episodes)) " episodes of the fast physics)" }
                }
            }
        }
    }
}

/// The findings of each cause, by its number; of each finding the first scenario.
fn by_cause(found: &Exploration) -> BTreeMap<u64, Vec<Shown<'_>>> {
    let mut causes: BTreeMap<u64, Vec<Shown<'_>>> = BTreeMap::new();
    for finding in &found.findings {
        for cause in &finding.causes {
            causes
                .entry(cause.number)
                .or_default()
                .push((finding, cause));
        }
    }
    causes
}

fn cause(view: View, found: &Exploration, shown: &[Shown<'_>]) -> Markup {
    let Some((_, first)) = shown.first() else {
        return html! {};
    };
    html! {
        article class="cause" id={ "cause-" (first.number) } {
            p class="kind" { "Cause " (first.number) }
            h3 { (settings(&first.settings)) }
            p class="done" { @if first.test.is_empty() { "Nothing is done." } @else { "What is done: " (unbroken(&first.test)) } }
            p class="again" {
                code { (command(&first.file)) }
                @if !first.is_minimal { " " span class="small" { "perhaps not as small as it goes" } }
            }
            div class="scroll" tabindex="0" role="region" aria-label={ "What cause " (first.number) " shows" } {
                table class="shown cards" {
                    caption class="visually-hidden" { "What cause " (first.number) " shows, and the smallest scenario of each" }
                    thead { tr {
                        th scope="col" { "It shows" } th scope="col" { "In this exploration" }
                        th scope="col" { "Smallest scenario" }
                    } }
                    tbody { @for one in shown { (row(view, found, one, first)) } }
                }
            }
        }
    }
}

fn row(
    view: View,
    found: &Exploration,
    (finding, cause): &Shown<'_>,
    first: &CauseFound,
) -> Markup {
    html! {
        tr {
            th scope="row" { (what(view, finding)) }
            td data-label="Explored" {
                (number::count(cause.episodes)) " of the " (number::count(finding.episodes)) " episodes that showed it, of "
                (number::count(found.episodes)) "; first in episode " (number::count(finding.first_episode))
                @if !finding.replayed { " " (chip(&words::not_shown_again())) }
            }
            td data-label="Scenario" {
                @if cause.settings != first.settings { (settings(&cause.settings)) br; }
                code { (file_name(&cause.file)) }
            }
        }
    }
}

/// What a finding is, with what it is about.
fn what(view: View, finding: &Discovery) -> Markup {
    let meaning = match &finding.subject {
        Some(Subject::Requirement(id)) => view.requirement(id).map(|r| r.text.as_str()),
        Some(Subject::FailureMode(id)) => {
            let mut modes = view.study.failure_modes.iter();
            modes
                .find(|mode| &mode.id == id)
                .map(|mode| mode.meaning.as_str())
        }
        None => None,
    };
    html! {
        @match &finding.subject {
            Some(Subject::Requirement(id)) => { "Requirement " (view.requirement_link(id)) " is violated" },
            Some(subject) => (view.title(subject)),
            None => (capitalised(&finding.in_words)),
        }
        @if let Some(meaning) = meaning { span class="text" { (meaning) } }
        @if finding.is_after_task() { span class="text" { "Only after the task was over." } }
        @if let Some(told) = &finding.told_apart { span class="text" { "What is recorded: " (told.in_words()) "." } }
    }
}

/// Findings of which no cause is known, or episodes that met none.
fn others(view: View, found: &Exploration, none_known: bool) -> Markup {
    let without = |finding: &&Discovery| {
        finding.causes.is_empty() || finding.without_cause.is_some_and(|episodes| episodes > 0)
    };
    let others: Vec<&Discovery> = found.findings.iter().filter(without).collect();
    html! {
        @if !others.is_empty() {
            h3 { @if none_known { "Findings" } @else { "Episodes of which no cause is known" } }
            div class="scroll" tabindex="0" role="region" aria-label="Findings without a cause" {
                table class="shown cards" {
                    caption class="visually-hidden" { "Findings, or episodes of them, of which no cause is known" }
                    thead { tr {
                        th scope="col" { "Finding" } th scope="col" { "In this exploration" } th scope="col" { "To run it again" }
                    } }
                    tbody {
                        @for finding in others {
                            tr {
                                th scope="row" { (what(view, finding)) }
                                td data-label="Explored" {
                                    @let count = finding.without_cause.unwrap_or(finding.episodes);
                                    (number::count(count)) " of " (number::count(found.episodes)) " episodes; first found in episode "
                                    (number::count(finding.first_episode)) " by " (finding.found_by)
                                    @if !finding.replayed { " " (chip(&words::not_shown_again())) }
                                }
                                td data-label="Again" { code { (command(&finding.file)) } }
                            }
                        }
                    }
                }
            }
            @if none_known {
                p class="small" {
                    code { "corroborate explore STUDY FILE --causes 100" }
                    " makes the episodes of each as small as they go, and groups them by what is left."
                }
            }
        }
    }
}

fn broken(found: &Exploration) -> Markup {
    html! {
        @if !found.broken.is_empty() {
            p class="note" {
                "The physics gave no numbers in " (number::count(found.broken.len() as u64)) " of "
                (number::count(found.episodes)) " episodes, which is not evidence about the robot: "
                @for (i, episode) in found.broken.iter().take(LISTED).enumerate() {
                    @if i > 0 { "; " }
                    "episode " (number::count(episode.episode)) " (" (episode.reason) ")"
                }
                @if found.broken.len() > LISTED { "; and others" }
                "."
            }
        }
    }
}

/// Settings that are not nominal, as a heading.
fn settings(settings: &[CauseSetting]) -> Markup {
    html! {
        @if settings.is_empty() { "All other parameters are at their nominal values" }
        @for (i, setting) in settings.iter().enumerate() {
            @if i > 0 { ", " }
            span class="setting" {
                code { (setting.key) } " = " b title=(setting.value) { (short(&setting.value)) }
                @if let Some(nominal) = &setting.nominal { " " span class="asks" { "nominal " (short(nominal)) } }
            }
        }
    }
}

/// A number to four significant digits, as shrinking leaves it where it goes on to the end; any other text as it is.
fn short(value: &str) -> String {
    let parsed = value.parse::<f64>().ok();
    match parsed.filter(|number| number.is_finite() && *number != 0.0) {
        Some(number) if value.len() > 8 => {
            let magnitude = number.abs().log10().floor();
            let decimals = (3.0 - magnitude).clamp(0.0, 8.0) as usize;
            number::decimal(number, decimals)
        }
        _ => value.to_owned(),
    }
}

fn command(file: &str) -> String {
    format!("corroborate replay STUDY {FOLDER}/{file}")
}

fn file_name(file: &str) -> &str {
    file.rsplit('/').next().unwrap_or(file)
}

fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    match letters.next() {
        Some(first) => first.to_uppercase().chain(letters).collect(),
        None => String::new(),
    }
}
