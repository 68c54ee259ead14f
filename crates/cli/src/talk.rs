//! Talk and progress, on standard error: a bar on a terminal, now and then a
//! line elsewhere.

use indicatif::{ProgressBar, ProgressStyle};
use std::io::{IsTerminal, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
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
            lines: !self.quiet && !self.terminal,
            bar,
        }
    }
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
    lines: bool,
    bar: ProgressBar,
}

impl Stage {
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
