//! What ends a check before all is answered: an interruption, or the limit of memory or of time.
//!
//! What is being solved then gives the bounds that it has reached ([`checker::Stop`]), answers stay, and what was not
//! begun says so.

use super::form::{PropertyReport, empty};
use super::memory::Memory;
use super::properties::Text;
use crate::args::Check;
use crate::problem::Problem;
use crate::study::Method;
use crate::talk::Interrupt;
use checker::{Bounds, CheckError};
use std::cell::Cell;
use std::time::{Duration, Instant};

/// Whether to end, and why.
#[derive(Debug)]
pub(super) struct Ending {
    interrupt: Interrupt,
    memory: Memory,
    /// How long it may take, and until when.
    time: Option<(Duration, Instant)>,
}

impl Ending {
    pub fn new(arguments: &Check, interrupt: &Interrupt) -> Self {
        Self {
            interrupt: interrupt.clone(),
            memory: Memory::new(arguments.memory_limit),
            time: (arguments.timeout)
                .and_then(|limit| Some((limit, Instant::now().checked_add(limit)?))),
        }
    }

    /// Whether to end.
    pub fn is_due(&self) -> bool {
        self.interrupt.is_set() || self.memory.is_passed() || self.is_late()
    }

    fn is_late(&self) -> bool {
        self.time.is_some_and(|(_, end)| Instant::now() >= end)
    }

    /// Whether to end without the bounds that were reached.
    pub fn is_urgent(&self) -> bool {
        self.memory.is_nearly_full()
    }

    /// Why, if work ended early, in the words of a message.
    pub fn reason(&self) -> &'static str {
        match self.interrupt.is_set() {
            true => "interrupted",
            false if self.memory.is_passed() => "ended by the limit of memory",
            false => "ended by the limit of time",
        }
    }

    /// The problem of a command that ended early.
    pub fn problem(&self) -> Problem {
        self.instead_of(Problem::interrupted())
    }

    /// What ended the work, in place of an interruption; what that says of how far the work came is kept.
    fn instead_of(&self, problem: Problem) -> Problem {
        let problem = self.memory.instead_of(problem);
        match self.time {
            Some((limit, _)) if problem.is_interruption() && !self.interrupt.is_set() => {
                let doing = problem.message().split_once(" while ");
                let doing = doing.map_or(String::new(), |(_, doing)| format!(" while {doing}"));
                let secs = limit.as_secs_f64();
                let message = format!("the {secs} s that it may take are over{doing}");
                Problem::undecided("time-limit", message).remedy(
                    "raise --timeout, or make the model smaller, for example by its constants",
                )
            }
            _ => problem,
        }
    }

    /// Explores by `explore`, which is told whether to go on; an early end says how far it came.
    pub fn exploring<T>(
        &self,
        explore: impl FnOnce(&dyn Fn(usize) -> bool) -> Result<T, Problem>,
    ) -> Result<T, Problem> {
        let found = Cell::new(0);
        let go_on = |states: usize| {
            found.set(states);
            !self.is_due()
        };
        explore(&go_on).map_err(|problem| match problem.is_interruption() {
            true => {
                let states = found.get();
                let doing = format!("states were explored ({states} had been found)");
                self.instead_of(Problem::interrupted_while(&doing))
            }
            false => problem,
        })
    }

    /// Whether a check of the checker ended early, and the bounds that it had then.
    pub fn of_error(error: &CheckError) -> Option<Option<Bounds>> {
        match error {
            CheckError::Cancelled => Some(None),
            CheckError::Stopped { reached } => Some(*reached),
            _ => None,
        }
    }

    /// The report of a property that was being checked.
    pub fn stopped(
        &self,
        (place, name, text): (usize, Option<String>, String),
        method: Method,
        reached: Option<Bounds>,
        check_secs: f64,
    ) -> PropertyReport {
        let mut report = empty(place, name, text, method);
        report.unfinished = Some("stopped".into());
        report.check_secs = check_secs;
        report.error = Some(match reached {
            Some(_) => format!("{}; the bounds hold, but have not converged", self.reason()),
            None => format!("{} before there were bounds", self.reason()),
        });
        if let Some(Bounds { low, high }) = reached {
            report.guarantee = Some("bounded".into());
            (report.low, report.high) = (Some(low), Some(high));
        }
        report
    }

    /// The report of a property that was not begun.
    pub fn not_begun(
        &self,
        (place, name, text): (usize, Option<String>, String),
        method: Method,
    ) -> PropertyReport {
        let mut report = empty(place, name, text, method);
        report.unfinished = Some("not begun".into());
        report.error = Some(format!("not begun: the command was {}", self.reason()));
        report
    }

    /// All properties that were asked for, of which none was begun.
    pub fn none_begun(&self, texts: &[Text], arguments: &Check) -> Vec<PropertyReport> {
        let all = texts.iter().flat_map(|text| &text.tree.properties);
        let named = all.enumerate().map(|(place, property)| {
            let name = property.name.as_ref().map(|name| name.text.clone());
            (place + 1, name, property.text.clone())
        });
        named
            .filter(|(place, name, _)| is_selected(arguments, *place, name.as_deref()))
            .map(|named| self.not_begun(named, arguments.method))
            .collect()
    }
}

/// Whether a property was asked for.
fn is_selected(arguments: &Check, place: usize, name: Option<&str>) -> bool {
    let mut wanted = arguments.selected.iter().flat_map(|names| names.split(','));
    let is_wanted =
        |wanted: &str| name == Some(wanted.trim()) || place.to_string() == wanted.trim();
    arguments.selected.is_empty() || wanted.any(is_wanted)
}
