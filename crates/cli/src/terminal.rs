//! Events on standard error: a bar on a terminal, now and then a line elsewhere.

use crate::shown_problem::rendered;
use diagnostic::{Problem, Source, printable, printable_line};
use host::files::{MOST_BYTES, too_large};
use host::{Cancel, Event, Events};
use indicatif::{ProgressBar, ProgressStyle};
use std::collections::BTreeMap;
use std::io::{IsTerminal, Write};
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Catches Ctrl-C and termination: the first asks the work to stop, a second ends the process at once.
pub fn cancel_on_interrupt() -> Arc<Cancel> {
    let cancel = Arc::new(Cancel::default());
    let flag = cancel.clone();
    // Without a handler the default action still ends the process, and every file is written whole or not at all.
    let _ = ctrlc::set_handler(move || {
        if flag.is_cancelled() {
            std::process::exit(130);
        }
        flag.cancel();
    });
    cancel
}

/// Writes a line to standard error. Where nobody can be told (it is closed, or
/// the disk behind it is full), the work goes on all the same.
pub fn to_stderr(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

/// Columns of the terminal that shows the summary.
pub fn terminal_width() -> usize {
    let columns = std::env::var("COLUMNS").ok().and_then(|c| c.parse().ok());
    columns.unwrap_or(100).clamp(40, 160)
}

/// Whether the summary may use colour.
pub fn use_colour() -> bool {
    std::io::stdout().is_terminal() && std::env::var_os("NO_COLOR").is_none()
}

/// Events as a person at a terminal, or a log, is told of them; `quiet` tells nothing.
pub fn events(quiet: bool) -> Events {
    if quiet {
        return Events::none();
    }
    let is_terminal = std::io::stderr().is_terminal();
    let stages: Mutex<BTreeMap<u64, Shown>> = Mutex::default();
    Events::new(move |event| {
        let mut stages = stages.lock().unwrap_or_else(PoisonError::into_inner);
        show(&mut stages, is_terminal, event);
    })
}

/// A stage under way, as it is shown.
struct Shown {
    title: String,
    total: u64,
    /// Where there is no terminal.
    lines: bool,
    /// When a line was last told.
    told: Instant,
    bar: ProgressBar,
}

/// How often a stage without a new tenth is told in lines.
const LINES_EVERY: Duration = Duration::from_secs(30);

fn show(stages: &mut BTreeMap<u64, Shown>, is_terminal: bool, event: Event) {
    match event {
        Event::Note { text } => to_stderr(&printable(&text)),
        Event::Mistake { problem } => to_stderr(&rendered(&problem, false)),
        Event::Started {
            stage,
            title,
            total,
        } => {
            let title = printable_line(&title).into_owned();
            stages.insert(stage, Shown::new(title, total, is_terminal));
        }
        Event::Skipped { stage, steps } => {
            if let Some(shown) = stages.get(&stage) {
                shown.skip(steps);
            }
        }
        Event::Advanced {
            stage,
            done,
            left_secs,
            details,
        } => {
            if let Some(shown) = stages.get_mut(&stage) {
                let details = details.map(|it| printable_line(&it).into_owned());
                shown.advance(done, left_secs, details);
            }
        }
        Event::Finished { stage } => {
            if let Some(shown) = stages.remove(&stage) {
                shown.bar.finish_and_clear();
            }
        }
    }
}

impl Shown {
    fn new(title: String, total: u64, is_terminal: bool) -> Self {
        let bar = match is_terminal {
            true => ProgressBar::new(total).with_style(style("")),
            false => ProgressBar::hidden(),
        };
        bar.set_message(title.clone());
        bar.enable_steady_tick(Duration::from_millis(200));
        Self {
            title,
            total,
            lines: !is_terminal,
            told: Instant::now(),
            bar,
        }
    }

    fn skip(&self, steps: u64) {
        self.bar.inc(steps);
        self.bar.reset_eta();
        if self.lines && steps > 0 {
            to_stderr(&format!(
                "{}: {steps} of {} are there",
                self.title, self.total
            ));
        }
    }

    fn advance(&mut self, done: u64, left_secs: f64, details: Option<String>) {
        self.bar.inc(1);
        let tenth = |steps: u64| steps * 10 / self.total.max(1);
        let is_due = match &details {
            Some(_) => self.told.elapsed() >= LINES_EVERY || tenth(done) != tenth(done - 1),
            None => tenth(done) != tenth(done - 1),
        };
        if self.lines && is_due {
            self.told = Instant::now();
            let told = match details {
                Some(details) => format!("{}, {details}", time_left(left_secs)),
                None => String::new(),
            };
            to_stderr(&format!("{}: {done} of {}{told}", self.title, self.total));
        } else if let Some(details) = details.filter(|_| !self.bar.is_hidden()) {
            self.bar.set_style(style("\n  {prefix}"));
            self.bar.set_prefix(details);
        }
    }
}

/// The time that the rest may take, if it is worth telling.
fn time_left(left_secs: f64) -> String {
    match left_secs < 1.0 {
        true => String::new(),
        false => format!(
            ", {} left",
            indicatif::HumanDuration(Duration::from_secs_f64(left_secs.min(1e9)))
        ),
    }
}

/// A bar, with what stands below it.
fn style(below: &str) -> ProgressStyle {
    let template = format!("{{msg}} {{wide_bar}} {{pos}} of {{len}}, {{eta}} left{below}");
    ProgressStyle::with_template(&template).unwrap_or_else(|_| ProgressStyle::default_bar())
}

/// What standard input gives, as text.
pub fn read_standard_input() -> Result<Source, Problem> {
    use std::io::Read;
    let name = "<standard input>".to_owned();
    let mut text = String::new();
    let stdin = std::io::stdin().lock();
    let read = stdin.take(MOST_BYTES + 1).read_to_string(&mut text);
    if text.len() as u64 > MOST_BYTES {
        return Err(too_large(&name, MOST_BYTES));
    }
    read.map_err(|error| Problem::cannot_read(Path::new(&name), &error))?;
    Ok(Source { name, text })
}
