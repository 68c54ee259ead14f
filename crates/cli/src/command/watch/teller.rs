//! Telling what happens: JSON lines, plain lines, or a view in place on a
//! terminal with the events above it.

use super::event::{LiveVerdict, WatchEvent};
use crate::args::Format;
use live::Topic;
use std::collections::BTreeMap;
use std::io::{IsTerminal, Write};

/// How often the view is drawn anew.
const DRAW_EVERY_NANOS: i64 = 250_000_000;

/// Tells on standard output.
pub struct Teller {
    form: Form,
    began_nanos: i64,
    drawn_nanos: i64,
    /// Lines of the view that stand on the terminal.
    lines: usize,
    verdicts: Vec<LiveVerdict>,
    /// The messages of each topic: all, and since the last drawing.
    counts: BTreeMap<u32, (String, u64, u64)>,
    /// Whether standard output can no longer be written.
    deaf: bool,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Form {
    Json,
    Lines,
    View,
}

impl Teller {
    /// Tells as `format` says, from `began_nanos` on.
    pub fn new(format: Format, began_nanos: i64) -> Self {
        let form = match format {
            Format::Json => Form::Json,
            Format::Text if std::io::stdout().is_terminal() => Form::View,
            Format::Text => Form::Lines,
        };
        Self {
            form,
            began_nanos,
            drawn_nanos: began_nanos,
            lines: 0,
            verdicts: Vec::new(),
            counts: BTreeMap::new(),
            deaf: false,
        }
    }

    /// Whether nobody can be told any more.
    pub fn is_deaf(&self) -> bool {
        self.deaf
    }

    /// Counts a message.
    pub fn count(&mut self, topic: &Topic) {
        let entry = self.counts.entry(topic.id);
        let counts = entry.or_insert_with(|| (topic.name.clone(), 0, 0));
        counts.1 += 1;
        counts.2 += 1;
    }

    /// Tells an event, at once.
    pub fn tell(&mut self, at_nanos: i64, event: &WatchEvent, json: &str) {
        let text = match self.form {
            Form::Json => format!("{json}\n"),
            Form::Lines | Form::View => {
                let at_secs = (at_nanos - self.began_nanos) as f64 / 1e9;
                format!("{at_secs:>10.3} s  {}\n", event.text())
            }
        };
        let shown = match self.form {
            Form::View => format!("{}{text}{}", self.erased(), self.view(None)),
            _ => text,
        };
        self.write(&shown);
    }

    /// Whether the view is to be drawn, and so wants to know the verdicts.
    pub fn is_due(&self, now_nanos: i64) -> bool {
        self.form == Form::View && now_nanos - self.drawn_nanos >= DRAW_EVERY_NANOS
    }

    /// The verdicts so far.
    pub fn know(&mut self, verdicts: Vec<LiveVerdict>) {
        self.verdicts = verdicts;
    }

    /// Draws the view anew, if it is time.
    pub fn draw_when_due(&mut self, now_nanos: i64) {
        if self.is_due(now_nanos) {
            let past_secs = (now_nanos - self.drawn_nanos) as f64 / 1e9;
            self.drawn_nanos = now_nanos;
            let shown = format!("{}{}", self.erased(), self.view(Some(past_secs)));
            for counts in self.counts.values_mut() {
                counts.2 = 0;
            }
            self.write(&shown);
        }
    }

    /// Takes the view away, for what comes after it.
    pub fn finish(&mut self) {
        let erased = self.erased();
        self.write(&erased);
    }

    /// What takes the view off the terminal.
    fn erased(&mut self) -> String {
        match std::mem::take(&mut self.lines) {
            0 => String::new(),
            // Up by so many lines, then erase to the end of the screen.
            lines => format!("\x1b[{lines}A\x1b[J"),
        }
    }

    /// The view; without the time past, rates are left out.
    fn view(&mut self, past_secs: Option<f64>) -> String {
        let mut view = format!(
            "\n{:<34} {:<12} {:>8} {:>8} {:>8} {:>22}\n",
            "requirement or failure mode", "state", "covered", "passed", "failed", "robustness"
        );
        for verdict in &self.verdicts {
            view.push_str(&row(verdict));
        }
        for (name, all, new) in self.counts.values() {
            let rate = past_secs.map(|secs| format!(", {:.0} a second", *new as f64 / secs));
            view.push_str(&format!("{name}: {all}{}\n", rate.unwrap_or_default()));
        }
        self.lines = view.lines().count();
        view
    }

    fn write(&mut self, text: &str) {
        let mut out = std::io::stdout().lock();
        let written = out.write_all(text.as_bytes()).and_then(|()| out.flush());
        self.deaf |= written.is_err();
    }
}

/// A monitor's line in the view and in the summary.
pub fn row(verdict: &LiveVerdict) -> String {
    let state = match verdict.verdict.as_str() {
        "inconclusive" => "open",
        "not-covered" => "not covered",
        other => other,
    };
    let robustness = verdict.robustness.map_or(String::new(), |bounds| {
        let [low, high] = bounds.map(|b| b.map_or("?".to_owned(), |value| format!("{value:.4}")));
        if low == high {
            low
        } else {
            format!("{low} to {high}")
        }
    });
    let line = format!(
        "{:<34} {:<12} {:>8} {:>8} {:>8} {:>22}",
        verdict.label(),
        state,
        verdict.covered,
        verdict.passed,
        verdict.failed,
        robustness
    );
    format!("{}\n", line.trim_end())
}
