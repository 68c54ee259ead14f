//! Signals as strips of SVG, as wide as their place.
//!
//! Times run from 0 to 1000 along a strip. Of a signal with more samples than
//! can be told apart, each stretch of time keeps its least and greatest value,
//! so that no peak is lost.

use maud::{Markup, html};

use super::{Signal, SignalKind};

/// Stretches of time that are told apart.
const STRETCHES: usize = 900;
/// Height of the drawing of numbers.
const HEIGHT: f64 = 100.0;
/// Names are written where they have this share of the width.
const LEAST_NAMED: f64 = 0.05;

/// From when until when, in seconds.
#[derive(Clone, Copy, Debug)]
pub(super) struct Span {
    pub(super) from_secs: f64,
    pub(super) to_secs: f64,
}

impl Span {
    /// Where a time is, 0 to 1.
    pub(super) fn part(&self, time_secs: f64) -> f64 {
        let width_secs = self.to_secs - self.from_secs;
        if width_secs > 0.0 {
            ((time_secs - self.from_secs) / width_secs).clamp(0.0, 1.0)
        } else {
            0.0
        }
    }

    /// The same in the strip's units.
    fn x(&self, time_secs: f64) -> f64 {
        (self.part(time_secs) * 10_000.0).round() / 10.0
    }
}

/// The samples that are shown of a signal: changes of what is no number, and
/// extremes of numbers where there are too many.
pub(super) fn thinned(signal: &Signal) -> Vec<(f64, f64)> {
    let all = signal
        .times_secs
        .iter()
        .copied()
        .zip(signal.values.iter().copied());
    let all: Vec<(f64, f64)> = all.collect();
    if !matches!(signal.kind, SignalKind::Number(_)) {
        let mut changes: Vec<(f64, f64)> = Vec::new();
        for sample in all {
            let is_same = |(_, last): &(f64, f64)| last.to_bits() == sample.1.to_bits();
            if !changes.last().is_some_and(is_same) {
                changes.push(sample);
            }
        }
        return changes;
    }
    if all.len() <= 2 * STRETCHES {
        return all;
    }
    let length = all.len().div_ceil(STRETCHES);
    all.chunks(length).flat_map(extremes).collect()
}

/// The least and the greatest sample of a stretch, in the order of time.
fn extremes(stretch: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let by_value = |a: &&(f64, f64), b: &&(f64, f64)| a.1.total_cmp(&b.1);
    let known = || stretch.iter().filter(|sample| !sample.1.is_nan());
    let (Some(least), Some(greatest)) = (known().min_by(by_value), known().max_by(by_value)) else {
        return stretch.first().copied().into_iter().collect();
    };
    let mut both = vec![*least, *greatest];
    both.sort_by(|a, b| a.0.total_cmp(&b.0));
    both.dedup();
    both
}

/// The strip of a signal.
pub(super) fn draw(signal: &Signal, span: Span) -> Markup {
    let samples = thinned(signal);
    match &signal.kind {
        SignalKind::Number(unit) => numbers(signal, &samples, unit, span),
        SignalKind::Flag => flags(signal, &samples, span),
        SignalKind::Names(list) => names(signal, &samples, list, span),
    }
}

fn causes(signal: &Signal, span: Span) -> Markup {
    html! {
        @for (from, to) in &signal.causes {
            @let x = span.x(*from);
            // An instant is shown as well.
            rect class="cause" x=(x) width=((span.x(*to) - x).max(3.0)) y="0" height="100" {}
        }
    }
}

fn numbers(signal: &Signal, samples: &[(f64, f64)], unit: &str, span: Span) -> Markup {
    let finite = samples
        .iter()
        .map(|(_, value)| *value)
        .filter(|v| v.is_finite());
    let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
        (low.min(v), high.max(v))
    });
    let range = if high > low { high - low } else { 1.0 };
    let middle = if high > low { 0.0 } else { 0.5 };
    let y = |value: f64| {
        let part = ((value - low) / range).clamp(0.0, 1.0) + middle;
        ((1.0 - part) * 94.0 + 3.0).round()
    };
    let mut path = String::new();
    let mut is_down = false;
    for (time_secs, value) in samples {
        if value.is_finite() {
            let letter = if is_down { 'L' } else { 'M' };
            path.push_str(&format!("{letter}{} {}", span.x(*time_secs), y(*value)));
        }
        is_down = value.is_finite();
    }
    html! {
        svg class="signal" viewBox=(format!("0 0 1000 {HEIGHT}")) preserveAspectRatio="none" aria-hidden="true" {
            (causes(signal, span))
            path d=(path) {}
        }
        @if low <= high {
            span class="range-text top" { (short(high)) " " (unit) }
            @if high > low { span class="range-text bottom" { (short(low)) " " (unit) } }
        }
    }
}

/// Each value with the time until which it holds.
fn held(samples: &[(f64, f64)], span: Span) -> Vec<(f64, f64, f64)> {
    let next = samples.iter().skip(1).map(|(time_secs, _)| *time_secs);
    let until = next.chain([span.to_secs]);
    let held = samples.iter().zip(until);
    held.map(|((from, value), until)| (*from, until, *value))
        .collect()
}

fn flags(signal: &Signal, samples: &[(f64, f64)], span: Span) -> Markup {
    html! {
        svg class="signal low" viewBox="0 0 1000 100" preserveAspectRatio="none" aria-hidden="true" {
            rect class="base" x="0" width="1000" y="40" height="20" {}
            (causes(signal, span))
            @for (from, until, value) in held(samples, span) {
                @if value == 1.0 {
                    @let x = span.x(from);
                    rect class="on" x=(x) width=((span.x(until) - x).max(0.8)) y="15" height="70" {}
                }
            }
        }
    }
}

fn names(signal: &Signal, samples: &[(f64, f64)], list: &[String], span: Span) -> Markup {
    let held = held(samples, span);
    let named = |value: f64| (value >= 0.0).then(|| list.get(value as usize)).flatten();
    html! {
        svg class="signal low" viewBox="0 0 1000 100" preserveAspectRatio="none" aria-hidden="true" {
            @for (index, (from, until, value)) in held.iter().enumerate() {
                @if value.is_finite() {
                    @let x = span.x(*from);
                    rect class=(if index % 2 == 1 { "named odd" } else { "named" })
                        x=(x) width=((span.x(*until) - x).max(0.8)) y="0" height="100" {}
                }
            }
            (causes(signal, span))
        }
        @for (from, until, value) in &held {
            @let width = span.part(*until) - span.part(*from);
            @if width >= LEAST_NAMED {
                @if let Some(name) = named(*value) {
                    span class="name-text" style=(format!("left:{:.2}%;width:{:.2}%", 100.0 * span.part(*from), 100.0 * width)) { (name) }
                }
            }
        }
    }
}

/// A number with at most four digits that count.
pub(super) fn short(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let places = (3 - value.abs().log10().floor() as i32).clamp(0, 6) as usize;
    let text = format!("{value:.places$}");
    let text = match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.'),
        false => &text,
    };
    text.replace('-', "\u{2212}")
}

/// Round times along the axis, about eight of them.
pub(super) fn ticks(span: Span) -> Vec<f64> {
    let width_secs = span.to_secs - span.from_secs;
    if !(width_secs.is_finite() && width_secs > 0.0) {
        return vec![span.from_secs];
    }
    let rough = width_secs / 8.0;
    let power = 10f64.powf(rough.log10().floor());
    let steps = [1.0, 2.0, 5.0, 10.0].map(|m| m * power);
    let step = steps
        .into_iter()
        .find(|s| *s >= rough)
        .unwrap_or(10.0 * power);
    let first = (span.from_secs / step).ceil();
    let count = ((span.to_secs / step).floor() - first) as usize;
    (0..=count).map(|i| (first + i as f64) * step).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn signal(kind: SignalKind, values: Vec<f64>) -> Signal {
        Signal {
            name: "s".into(),
            kind,
            times_secs: (0..values.len()).map(|i| i as f64).collect(),
            values,
            causes: vec![],
        }
    }

    #[test]
    fn thinning_keeps_every_peak_and_every_change() {
        let mut values = vec![0.0; 10_000];
        values[4_321] = 7.0;
        values[8_765] = -3.0;
        let kept = thinned(&signal(SignalKind::Number("m".into()), values));
        assert!(kept.len() <= 2 * STRETCHES, "{}", kept.len());
        assert!(kept.contains(&(4_321.0, 7.0)) && kept.contains(&(8_765.0, -3.0)));
        assert!(kept.windows(2).all(|pair| pair[0].0 <= pair[1].0));
        let kept = thinned(&signal(SignalKind::Flag, vec![0.0, 0.0, 1.0, 1.0, 0.0]));
        assert_eq!(kept, [(0.0, 0.0), (2.0, 1.0), (4.0, 0.0)]);
    }

    #[test]
    fn what_is_unknown_breaks_the_line_and_a_constant_is_in_the_middle() {
        let span = Span {
            from_secs: 0.0,
            to_secs: 3.0,
        };
        let kind = SignalKind::Number("m".into());
        let drawn = draw(&signal(kind.clone(), vec![1.0, f64::NAN, 3.0, 2.0]), span);
        assert!(drawn.into_string().contains("M0 97M666.7 3L1000 50"));
        let drawn = draw(&signal(kind, vec![2.0, 2.0]), span).into_string();
        assert!(drawn.contains("M0 50L333.3 50"), "{drawn}");
    }

    #[test]
    fn numbers_are_short_and_ticks_round() {
        let shown = [0.0, 12345.678, -0.25, 1.0, 0.000_123].map(short);
        assert_eq!(shown, ["0", "12346", "\u{2212}0.25", "1", "0.000123"]);
        let span = Span {
            from_secs: 0.0,
            to_secs: 35.2,
        };
        assert_eq!(ticks(span), [0.0, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0]);
        assert_eq!(
            ticks(Span {
                from_secs: 2.0,
                to_secs: 2.0
            }),
            [2.0]
        );
    }
}
