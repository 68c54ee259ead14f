//! What ends a check before all is answered: an interruption, or the limit of memory or of time.
//!
//! What is being solved then gives the bounds that it has reached ([`checker::Stop`]), answers stay, and what was not
//! begun says so.

use crate::properties::Text;
use crate::report::{PropertyReport, empty};
use crate::request::CheckRequest;
use checker::{Bounds, CheckError};
use diagnostic::Problem;
use host::{Cancel, Host, MemoryBudget};
use std::cell::Cell;
use std::sync::Arc;
use std::time::{Duration, Instant};
use study::Method;

/// Whether to end, and why.
#[derive(Debug)]
pub(crate) struct Ending {
    interrupt: Arc<Cancel>,
    memory: Arc<dyn MemoryBudget>,
    /// How long it may take, and until when.
    time: Option<(Duration, Instant)>,
}

impl Ending {
    pub fn new(request: &CheckRequest, host: &Host) -> Self {
        Self {
            interrupt: host.cancel.clone(),
            memory: host.memory.clone(),
            time: (request.timeout)
                .and_then(|limit| Some((limit, Instant::now().checked_add(limit)?))),
        }
    }

    /// Whether to end.
    pub fn is_due(&self) -> bool {
        self.interrupt.is_cancelled() || self.memory.must_stop() || self.is_late()
    }

    fn is_late(&self) -> bool {
        self.time.is_some_and(|(_, end)| Instant::now() >= end)
    }

    /// Whether to end without the bounds that were reached.
    pub fn is_urgent(&self) -> bool {
        self.memory.must_give_up()
    }

    /// Why, if work ended early, in the words of a message.
    pub fn reason(&self) -> &'static str {
        match self.interrupt.is_cancelled() {
            true => "interrupted",
            false if self.memory.must_stop() => "ended by the limit of memory",
            false => "ended by the limit of time",
        }
    }

    /// The problem of a command that ended early.
    pub fn problem(&self) -> Problem {
        self.instead_of(Problem::interrupted())
    }

    /// What ended the work, in place of an interruption; what that says of how far the work came is kept.
    fn instead_of(&self, problem: Problem) -> Problem {
        if !problem.is_interruption() {
            return problem;
        }
        let doing = problem.message().split_once(" while ");
        let doing = doing.map_or(String::new(), |(_, doing)| format!(" while {doing}"));
        if self.memory.must_stop() {
            return self.memory.problem(&doing);
        }
        match self.time {
            Some((limit, _)) if !self.interrupt.is_cancelled() => {
                let secs = limit.as_secs_f64();
                let message = format!("the {secs} s that it may take are over{doing}");
                Problem::undecided("time-limit", message).remedy(
                    "give it more time (`check --timeout`), or make the model smaller, for example by its constants",
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
    pub fn none_begun(&self, texts: &[Text], request: &CheckRequest) -> Vec<PropertyReport> {
        let all = texts.iter().flat_map(Text::all);
        let named = all.enumerate();
        let named = named.map(|(place, (name, text))| (place + 1, name, text));
        named
            .filter(|(place, name, _)| is_selected(request, *place, name.as_deref()))
            .map(|named| self.not_begun(named, request.method))
            .collect()
    }
}

/// Whether a property was asked for.
fn is_selected(request: &CheckRequest, place: usize, name: Option<&str>) -> bool {
    let mut wanted = request.selected.iter().flat_map(|names| names.split(','));
    let is_wanted =
        |wanted: &str| name == Some(wanted.trim()) || place.to_string() == wanted.trim();
    request.selected.is_empty() || wanted.any(is_wanted)
}
