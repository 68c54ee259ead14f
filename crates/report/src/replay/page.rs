//! The page of a replay.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::data::{Packed, packed, tone};
use super::strip::{Span, draw, short, ticks};
use super::{Mark, Replay, Role, Verdict};
use crate::page::head;
use crate::view::prose;

const STYLE: &str = concat!(include_str!("../style.css"), include_str!("replay.css"));
const SCRIPT: &str = concat!(include_str!("view3d.js"), include_str!("player.js"));

/// SHA-256 of the script, in base64: the only script that may run. A test says
/// what it must be when the script changes.
const SCRIPT_HASH: &str = "L2/EVoR6lTqJhklJyMS996weQxYrCr3FzOCKutno/Sc=";

/// The whole page.
pub(super) fn render(replay: &Replay) -> String {
    let span = span_of(replay);
    let packed = packed(replay);
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            (head(&replay.title, STYLE, SCRIPT_HASH))
            body class="replay" {
                (masthead(replay))
                main {
                    (watch(replay, span))
                    (plots(replay, span))
                    (actions(replay))
                }
                (footer(replay, &packed))
                script type="application/json" id="data" data-start=(start(replay, span)) { (PreEscaped(&packed.json)) }
                script { (PreEscaped(SCRIPT)) }
            }
        }
    };
    page.into_string()
}

/// From the first to the last time that anything is known of.
fn span_of(replay: &Replay) -> Span {
    let times = &replay.scene.times_secs;
    let signals = replay.signals.iter().flat_map(|signal| &signal.times_secs);
    let all = || {
        let own = times.iter().chain(signals.clone());
        own.copied().filter(|time| time.is_finite())
    };
    // Where there are poses, the slider runs over their times, and plots with it.
    match (times.first(), times.last()) {
        (Some(from), Some(to)) => Span {
            from_secs: *from,
            to_secs: *to,
        },
        _ => Span {
            from_secs: all().reduce(f64::min).unwrap_or(0.0),
            to_secs: all().reduce(f64::max).unwrap_or(0.0),
        },
    }
}

/// Where the page begins: a second before the first bad moment.
fn start(replay: &Replay, span: Span) -> f64 {
    let bad = replay
        .marks
        .iter()
        .find(|mark| mark.tone == super::Tone::Bad);
    bad.map_or(span.from_secs, |mark| {
        (mark.time_secs - 1.0).max(span.from_secs)
    })
}

fn masthead(replay: &Replay) -> Markup {
    html! {
        header class="masthead" {
            p class="kicker" { "Replay of one episode" }
            h1 { (replay.title) }
            div class="summary" { (prose(&replay.summary)) }
            button id="theme" type="button" hidden { "Dark" }
        }
    }
}

/// The moving picture, its controls, and what was judged.
fn watch(replay: &Replay, span: Span) -> Markup {
    html! {
        section id="watch" aria-label="Replay" {
            div class="watch" {
                div {
                    div id="stage" data-script hidden {
                        canvas id="view" tabindex="0" role="application"
                            aria-label="The scene in three dimensions. Arrow keys turn it, with shift they move it, plus and minus zoom, 0 shows all, space plays." {}
                        div class="overlay" { span id="clock" {} span id="state" class="state" {} }
                    }
                    p id="no-view" class="no-view" {
                        "The moving picture needs JavaScript and WebGL, which this browser does not give. Verdicts, moments and signals are all here without it."
                    }
                    (controls(replay, span))
                }
                (side(replay))
            }
        }
    }
}

fn controls(replay: &Replay, span: Span) -> Markup {
    html! {
        div class="timeline" data-script hidden {
            input id="time" type="range" aria-label="Time" min=(span.from_secs) max=(span.to_secs) step="0.01" value=(span.from_secs);
        }
        div class="controls" data-script hidden {
            button id="play" type="button" aria-pressed="false" { "Play" }
            label { "Speed" select id="speed" {
                @for speed in ["0.1", "0.25", "0.5", "1", "2", "4", "8"] {
                    option value=(speed) selected[speed == "1"] { (speed) " ×" }
                }
            } }
            label data-camera { "Follow" select id="follow" {
                option value="" { "nothing" }
                @for (body, name) in followed(replay) { option value=(body) { (name) } }
            } }
            span class="camera" data-camera {
                @for (act, sign, label) in [
                    ("left", "←", "Turn left"), ("right", "→", "Turn right"), ("up", "↑", "Look from higher"),
                    ("down", "↓", "Look from lower"), ("nearer", "+", "Nearer"), ("farther", "−", "Farther"), ("fit", "All", "Show all"),
                ] { button type="button" data-act=(act) aria-label=(label) title=(label) { (sign) } }
            }
        }
        @if !replay.marks.is_empty() {
            div class="marks" {
                @for mark in &replay.marks { (moment(mark)) }
            }
        }
    }
}

fn moment(mark: &Mark) -> Markup {
    html! {
        button type="button" class=(tone(mark.tone)) data-go=(mark.time_secs) {
            b { (format!("{:.2} s", mark.time_secs)) } " " (mark.text)
        }
    }
}

/// Bodies that are worth following: those with shapes that are no surroundings,
/// the first of each robot or person and every object.
fn followed(replay: &Replay) -> Vec<(usize, &str)> {
    let scene = &replay.scene;
    let mut chosen: Vec<(usize, &str)> = Vec::new();
    let mut groups: Vec<(Role, &str)> = Vec::new();
    for shape in &scene.shapes {
        let Some(body) = shape.body else { continue };
        let Some(name) = scene.bodies.get(body) else {
            continue;
        };
        // Parts of one thing are named `thing/part`.
        let group = (shape.role, name.split('/').next().unwrap_or(name));
        let is_known = chosen.iter().any(|(known, _)| *known == body) || groups.contains(&group);
        if !is_known && chosen.len() < 60 {
            groups.push(group);
            chosen.push((body, name));
        }
    }
    chosen
}

fn side(replay: &Replay) -> Markup {
    let present = |role: Role| replay.scene.shapes.iter().any(|shape| shape.role == role);
    html! {
        aside class="side card" {
            @for verdict in &replay.verdicts { (judged(verdict)) }
            @if !replay.facts.is_empty() {
                dl class="facts" {
                    @for (name, value) in &replay.facts { div { dt { (name) } dd { (value) } } }
                }
            }
            p class="key" {
                @for (role, class, name) in [
                    (Role::Robot, "robot", "robot"), (Role::Object, "object", "objects"),
                    (Role::Person, "person", "people"), (Role::Surroundings, "surroundings", "surroundings"),
                ] { @if present(role) { span { span class={ "swatch " (class) } {} (name) } } }
            }
        }
    }
}

fn judged(verdict: &Verdict) -> Markup {
    html! {
        div class="verdict" {
            p { b class="req" { (verdict.id) } " " span class={ "chip " (tone(verdict.tone)) } { (verdict.verdict) } }
            p class="words" { (verdict.text) }
            @for reason in &verdict.reasons { p class="small" { (reason) } }
        }
    }
}

fn plots(replay: &Replay, span: Span) -> Markup {
    if replay.signals.is_empty() {
        return html! {};
    }
    html! {
        section id="signals" {
            h2 { "Signals" }
            p class="lead" { "What was read to judge it. Shaded: while it was part of the reason for a violation. Dashed: the moments above." }
            div class="plots" {
                @for (index, signal) in replay.signals.iter().enumerate() {
                    div class="plot" data-signal=(index) {
                        div class="name" { (signal.name) span class="now" {} }
                        div class="strip-box" { (draw(signal, span)) (flag_lines(replay, span)) }
                    }
                }
                div class="plot" {
                    div class="name" { span class="small" { "seconds" } }
                    div class="ticks" aria-hidden="true" {
                        @for tick in ticks(span) {
                            span style=(format!("left:{:.2}%", 100.0 * span.part(tick))) { (short(tick)) }
                        }
                    }
                }
            }
        }
    }
}

fn flag_lines(replay: &Replay, span: Span) -> Markup {
    html! {
        @for mark in &replay.marks {
            span class={ "flag-line " (tone(mark.tone)) } style=(format!("left:{:.3}%", 100.0 * span.part(mark.time_secs))) {}
        }
    }
}

fn actions(replay: &Replay) -> Markup {
    if replay.actions.is_empty() {
        return html! {};
    }
    html! {
        section id="actions" {
            h2 { "What was done" }
            ol class="actions" { @for action in &replay.actions { li { (action) } } }
        }
    }
}

fn footer(replay: &Replay, packed: &Packed) -> Markup {
    let recorded = replay.scene.times_secs.len();
    html! {
        footer {
            p class="small" {
                "Produced by " (replay.produced_by) ". This file is complete in itself and loads nothing. "
                @if recorded > 0 {
                    "Poses are rounded to 1/65000 of each body's range"
                    @if packed.stride > 1 { ", and one of " (packed.stride) " of " (recorded) " recorded frames is kept" }
                    ". "
                }
                "The recording beside it has every number."
            }
        }
    }
}
