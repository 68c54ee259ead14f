//! Talk and progress, on standard error: a bar on a terminal, now and then a
//! line elsewhere.

use indicatif::{ProgressBar, ProgressStyle};
use std::io::{IsTerminal, Write};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};
use testbench::Cancel;

/// Whether the user has asked to stop.
#[derive(Clone, Debug, Default)]
pub struct Interrupt(Arc<Cancel>);

impl Interrupt {
    /// Catches Ctrl-C and termination: the first asks the work to stop, a
    /// second ends the process at once.
    pub fn install() -> Self {
        let interrupt = Self::default();
        let flag = interrupt.clone();
        // Without a handler the default action still ends the process, and
        // every file is written whole or not at all.
        let _ = ctrlc::set_handler(move || {
            if flag.is_set() {
                std::process::exit(130);
            }
            flag.0.cancel();
        });
        interrupt
    }

    /// Whether to stop.
    pub fn is_set(&self) -> bool {
        self.0.is_cancelled()
    }

    /// The flag that an episode under way looks at.
    pub fn cancel(&self) -> &Cancel {
        &self.0
    }
}

/// Writes a line to standard error. Where nobody can be told (it is closed, or
/// the disk behind it is full), the work goes on all the same.
pub fn to_stderr(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

/// Says what is going on.
#[derive(Clone, Debug)]
pub struct Talk {
    quiet: bool,
    terminal: bool,
}

impl Talk {
    /// Talks unless `quiet`.
    pub fn new(quiet: bool) -> Self {
        Self {
            quiet,
            terminal: std::io::stderr().is_terminal(),
        }
    }

    /// Says one line.
    pub fn say(&self, line: &str) {
        if !self.quiet {
            to_stderr(line);
        }
    }

    /// Begins a stage of `total` steps.
    pub fn begin(&self, title: &str, total: u64) -> Stage {
        let bar = if self.quiet || !self.terminal {
            ProgressBar::hidden()
        } else {
            ProgressBar::new(total).with_style(bar_style())
        };
        bar.set_message(title.to_owned());
        bar.enable_steady_tick(std::time::Duration::from_millis(200));
        Stage {
            title: title.to_owned(),
            total,
            done: AtomicU64::new(0),
            skipped: AtomicU64::new(0),
            began: Instant::now(),
            lines: !self.quiet && !self.terminal,
            told: Mutex::new(Instant::now()),
            bar,
        }
    }
}

/// A bar with a line of details below.
fn detailed_style() -> ProgressStyle {
    ProgressStyle::with_template("{msg} {wide_bar} {pos} of {len}, {eta} left\n  {prefix}")
        .unwrap_or_else(|_| ProgressStyle::default_bar())
}

fn bar_style() -> ProgressStyle {
    ProgressStyle::with_template("{msg} {wide_bar} {pos} of {len}, {eta} left")
        .unwrap_or_else(|_| ProgressStyle::default_bar())
}

/// A stage of work under way; may be advanced from many threads.
#[derive(Debug)]
pub struct Stage {
    title: String,
    total: u64,
    done: AtomicU64,
    /// Steps that were done by an earlier call.
    skipped: AtomicU64,
    began: Instant,
    lines: bool,
    /// When details were last told.
    told: Mutex<Instant>,
    bar: ProgressBar,
}

/// How often details are told: on a terminal, and as lines.
const DETAILS_EVERY: Duration = Duration::from_millis(500);
const LINES_EVERY: Duration = Duration::from_secs(30);

impl Stage {
    /// So many steps were done by an earlier call.
    pub fn skip(&self, steps: u64) {
        self.done.fetch_add(steps, Ordering::Relaxed);
        self.skipped.fetch_add(steps, Ordering::Relaxed);
        self.bar.inc(steps);
        self.bar.reset_eta();
        if self.lines && steps > 0 {
            to_stderr(&format!(
                "{}: {steps} of {} are there",
                self.title, self.total
            ));
        }
    }

    /// One step is done; now and then `details` are shown with it.
    pub fn advance_with(&self, details: impl FnOnce() -> String) {
        self.bar.inc(1);
        let done = self.done.fetch_add(1, Ordering::Relaxed) + 1;
        let mut told = self.told.lock().unwrap_or_else(PoisonError::into_inner);
        let since = told.elapsed();
        let tenth = |steps: u64| steps * 10 / self.total.max(1);
        if self.lines && (since >= LINES_EVERY || tenth(done) != tenth(done - 1)) {
            *told = Instant::now();
            let left = self.time_left(done);
            let (title, total) = (&self.title, self.total);
            to_stderr(&format!("{title}: {done} of {total}{left}, {}", details()));
        } else if !self.bar.is_hidden() && since >= DETAILS_EVERY {
            *told = Instant::now();
            self.bar.set_style(detailed_style());
            self.bar.set_prefix(details());
        }
    }

    /// The time that the rest may take, if it can be told.
    fn time_left(&self, done: u64) -> String {
        let new = done.saturating_sub(self.skipped.load(Ordering::Relaxed));
        let secs = self.began.elapsed().as_secs_f64() / new.max(1) as f64;
        let left_secs = secs * self.total.saturating_sub(done) as f64;
        match left_secs < 1.0 {
            true => String::new(),
            false => format!(
                ", {} left",
                indicatif::HumanDuration(Duration::from_secs_f64(left_secs.min(1e9)))
            ),
        }
    }

    /// One step is done.
    pub fn advance(&self) {
        self.bar.inc(1);
        let done = self.done.fetch_add(1, Ordering::Relaxed) + 1;
        let tenth = |steps: u64| steps * 10 / self.total.max(1);
        if self.lines && tenth(done) != tenth(done - 1) {
            to_stderr(&format!("{}: {done} of {}", self.title, self.total));
        }
    }
}

impl Drop for Stage {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
