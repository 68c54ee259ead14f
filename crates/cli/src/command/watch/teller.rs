//! Telling what happens: JSON lines, plain lines, or a view in place on a
//! terminal with the events above it.

use crate::args::Format;
use corroborate::watch::{Audience, LiveVerdict, WatchEvent};
use evidence::RunVerdict;
use std::collections::BTreeMap;
use std::io::{IsTerminal, Write};

/// How often the view is drawn anew.
const DRAW_EVERY_NANOS: i64 = 250_000_000;

/// Tells on standard output.
pub struct Teller {
    form: Form,
    /// When the first event was told.
    began_nanos: Option<i64>,
    drawn_nanos: i64,
    /// The lengths of the view's lines that stand on the terminal.
    lines: Vec<usize>,
    verdicts: Vec<LiveVerdict>,
    /// The messages of each topic: all, and since the last drawing.
    counts: BTreeMap<String, (u64, u64)>,
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
    /// Tells as `format` says.
    pub fn new(format: Format) -> Self {
        let form = match format {
            Format::Json => Form::Json,
            Format::Text if std::io::stdout().is_terminal() => Form::View,
            Format::Text => Form::Lines,
        };
        Self {
            form,
            began_nanos: None,
            drawn_nanos: i64::MIN,
            lines: Vec::new(),
            verdicts: Vec::new(),
            counts: BTreeMap::new(),
            deaf: false,
        }
    }

    /// Draws the view anew, if it is time.
    fn draw_when_due(&mut self, now_nanos: i64) {
        if self.wants_verdicts(now_nanos) {
            let past_secs = now_nanos.saturating_sub(self.drawn_nanos) as f64 / 1e9;
            self.drawn_nanos = now_nanos;
            let shown = format!("{}{}", self.erased(), self.view(Some(past_secs)));
            for counts in self.counts.values_mut() {
                counts.1 = 0;
            }
            self.write(&shown);
        }
    }

    /// What takes the view off the terminal.
    fn erased(&mut self) -> String {
        let columns = window().columns;
        let lines = std::mem::take(&mut self.lines);
        match lines.iter().map(|length| rows_of(*length, columns)).sum() {
            0 => String::new(),
            // Up by so many rows, then erase to the end of the screen.
            rows => format!("\r\x1b[{rows}A\x1b[J"),
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
        for (name, (all, new)) in &self.counts {
            let rate = past_secs.map(|secs| format!(", {:.0} a second", *new as f64 / secs));
            view.push_str(&format!("{name}: {all}{}\n", rate.unwrap_or_default()));
        }
        let fitted = fitted(&view, window());
        self.lines = fitted.iter().map(|line| line.chars().count()).collect();
        fitted.iter().map(|line| format!("{line}\n")).collect()
    }

    fn write(&mut self, text: &str) {
        let mut out = std::io::stdout().lock();
        let written = out.write_all(text.as_bytes()).and_then(|()| out.flush());
        self.deaf |= written.is_err();
    }
}

impl Audience for Teller {
    fn told(&mut self, at_nanos: i64, event: &WatchEvent, json: &str) {
        let began_nanos = *self.began_nanos.get_or_insert_with(|| {
            self.drawn_nanos = at_nanos;
            at_nanos
        });
        let text = match self.form {
            Form::Json => format!("{json}\n"),
            Form::Lines | Form::View => {
                let at_secs = (at_nanos - began_nanos) as f64 / 1e9;
                format!("{at_secs:>10.3} s  {}\n", event.text())
            }
        };
        let shown = match self.form {
            Form::View => format!("{}{text}{}", self.erased(), self.view(None)),
            _ => text,
        };
        self.write(&shown);
    }

    fn message(&mut self, topic: &str) {
        if !self.counts.contains_key(topic) {
            self.counts.insert(topic.to_owned(), (0, 0));
        }
        if let Some((all, new)) = self.counts.get_mut(topic) {
            *all += 1;
            *new += 1;
        }
    }

    fn wants_verdicts(&self, now_nanos: i64) -> bool {
        self.form == Form::View && now_nanos.saturating_sub(self.drawn_nanos) >= DRAW_EVERY_NANOS
    }

    fn verdicts(&mut self, now_nanos: i64, verdicts: Vec<LiveVerdict>) {
        self.verdicts = verdicts;
        self.draw_when_due(now_nanos);
    }

    fn idle(&mut self, now_nanos: i64) {
        self.draw_when_due(now_nanos);
    }

    fn is_gone(&self) -> bool {
        self.deaf
    }

    /// Takes the view away, for what comes after it.
    fn ended(&mut self) {
        let erased = self.erased();
        self.write(&erased);
    }
}

/// The size of the terminal.
#[derive(Clone, Copy)]
struct Window {
    columns: usize,
    rows: usize,
}

/// The size of the terminal now; it may change at any time.
fn window() -> Window {
    let size = terminal_size::terminal_size_of(std::io::stdout());
    let known = size.filter(|(width, height)| width.0 > 0 && height.0 > 0);
    known.map_or(
        Window {
            columns: 80,
            rows: 24,
        },
        |(width, height)| Window {
            columns: usize::from(width.0),
            rows: usize::from(height.0),
        },
    )
}

/// How many rows a line of so many characters takes where it was wrapped.
fn rows_of(length: usize, columns: usize) -> usize {
    length.div_ceil(columns.max(1)).max(1)
}

/// The lines of a view, cut so that each takes one row and all of them stand
/// above the cursor's; otherwise they could not be taken away again.
fn fitted(view: &str, window: Window) -> Vec<String> {
    let cut = |line: &str| match line.chars().count() > window.columns {
        true => line
            .chars()
            .take(window.columns.saturating_sub(1))
            .chain(['…'])
            .collect(),
        false => line.to_owned(),
    };
    let mut lines: Vec<String> = view.lines().map(cut).collect();
    let room = window.rows.saturating_sub(1).max(1);
    if lines.len() > room {
        let more = lines.len() - (room - 1);
        lines.truncate(room - 1);
        lines.push(cut(&format!("… and {more} lines more")));
    }
    lines
}

/// A monitor's line in the view and in the summary.
pub fn row(verdict: &LiveVerdict) -> String {
    let state = match verdict.verdict {
        RunVerdict::Inconclusive => "open",
        RunVerdict::NotCovered | RunVerdict::Satisfied | RunVerdict::Violated => {
            verdict.verdict.words()
        }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_view_fits_the_terminal_or_says_that_it_is_cut() {
        let window = |columns, rows| Window { columns, rows };
        assert_eq!(fitted("\nabc\nd\n", window(3, 4)), ["", "abc", "d"]);
        assert_eq!(fitted("abcd\nä b\n", window(3, 4)), ["ab…", "ä b"]);
        let cut = fitted("a\nb\nc\nd\n", window(30, 4));
        assert_eq!(cut, ["a", "b", "… and 2 lines more"]);
        assert_eq!(fitted("a\nb\n", window(30, 1)), ["… and 2 lines more"]);
    }

    #[test]
    fn lines_that_a_narrower_terminal_wraps_take_several_rows() {
        let rows = [(0, 80), (80, 80), (81, 80), (80, 40), (5, 0)];
        assert_eq!(
            rows.map(|(length, columns)| rows_of(length, columns)),
            [1, 1, 2, 2, 5]
        );
    }
}
