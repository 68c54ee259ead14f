//! Temporal logic over signals: formulas as text, their meaning on a trace, and monitors that judge
//! a trace sample by sample.
//!
//! Metric temporal logic with past and future (R. Koymans, "Specifying real-time properties with
//! metric temporal logic", Real-Time Systems 2(4), 1990) over atoms that have a truth value and,
//! if they compare numbers, a robustness (signal temporal logic: O. Maler and D. Nickovic,
//! "Monitoring temporal properties of continuous signals", FORMATS 2004; A. Donzé and O. Maler,
//! "Robust satisfaction of temporal logic over real-valued signals", FORMATS 2010). What each
//! operator means, and what is said at the end of a trace, is defined in [`semantics`].
//!
//! # Language
//! | form | meaning |
//! |---|---|
//! | `always p`, `globally`, `G`; `always[0, 2 s] p` | at all times from now on; of the next 2 s |
//! | `eventually[0, 500 ms] p`, `F` | at some time |
//! | `p until[0, 50 samples] q`, `U` | q in time, and p at all times before |
//! | `p weak_until q`, `W` | the same, but q need not come |
//! | `p release q`, `R` | q at all times up to and including the first p, or for ever |
//! | `once[0, 2 s] p`, `O`; `historically p`, `H`; `p since q`, `S` | the same for the past |
//! | `next p`, `X`; `previous p`, `Y` | at the next sample, the one before (discrete time only) |
//! | `rise(p)`, `fall(p)` | p becomes true, false |
//! | `not`, `!`; `and`, `&`, `&&`; `or`, `\|`, `\|\|`; `=>`, `->`, `implies`; `<=>`, `<->`, `iff` | logic |
//! | anything between | an atom, as it is written: `grasped`, `/robot.hand_speed < 250 mm/s`, `(/a.x - /b.x) * 2 < 3` |
//!
//! Operators with one operand bind most closely, then `until` and its like, `and`, `or`, `=>`, `<=>`.
//! `until`, `=>` and `<=>` group to the right. Comparisons bind more closely than all of them, so
//! `not a < b` is `not (a < b)`.
//!
//! Intervals are closed. A bound is a number with a unit (`ns`, `us`, `ms`, `s`, `min`, `h`,
//! `samples`), the name of a parameter (in seconds), or, at the upper end, `inf`. A bound without a
//! unit takes that of the other end, so `[1, 2 ms]` begins at 1 ms; if neither has one, it counts
//! samples in discrete time and seconds in dense time.
//!
//! ```
//! use temporal::formula::{Formula, parse};
//! let parsed = parse("always (grasped => eventually[0, release_time] /gripper.width > 8 cm)",
//!     &|name| (name == "release_time").then_some(2.0))?;
//! assert_eq!(parsed.atoms[1].text, "/gripper.width > 8 cm");
//! assert_eq!(parsed.formula.to_string(), "always (p0 => (eventually[0 s, 2 s] p1))");
//!
//! let error = parse("always (near and", &|_| None).unwrap_err();
//! assert_eq!(error.message, "a statement is missing before the end");
//! # Ok::<(), temporal::formula::FormulaError>(())
//! ```
//!
//! # Judging
//! A [`FormulaMonitor`] takes a trace sample by sample, in memory that the windows of the formula
//! bound, and gives in one pass ([`FormulaReport`]):
//!
//! | what | how |
//! |---|---|
//! | the verdict | at the first sample; what is said of times that were not seen is the [`Ending`] |
//! | when it was determined | [`FormulaReport::decided_at_secs`], online [`Progress::verdict`] |
//! | the robustness | bounds, which are equal if all is known ([`RobustnessBounds`]) |
//! | how often the requirement was put to the test | [`FormulaReport::triggered`]: how often the [`Formula::trigger`], or another formula given in the [`Settings`], became true |
//! | why it is violated | [`Explanation`]: the atoms and times that by themselves force it |
//!
//! Of a trace from which samples are missing ([`FormulaJudge::lose`]) a verdict is given only if it is
//! that of every trace in which they are put in. An instant can have several samples
//! ([`FormulaJudge::step_instant`]); which samples a formula has is defined in
//! [`semantics::signals`].
//!
//! Time is discrete or dense ([`TimeModel`]). In discrete time only samples count, so a formula
//! may hold because nobody looked; in dense time signals keep their values between samples, or go in
//! straight lines ([`Interpolation`]). Each has its engine ([`discrete`], [`dense`]), and both are
//! tested against the definition on all small formulas. Properties of the model checker become
//! formulas by [`ltl::from_ltl`], staged monitors by
//! [`MonitorSpec::to_formula`](crate::monitor::MonitorSpec::to_formula).
//!
//! The crate's first page shows it at work.

mod ast;
pub mod dense;
pub mod discrete;
mod early_end;
mod explain;
mod lexer;
mod losses;
pub mod ltl;
mod monitor;
mod parser;
mod positive;
mod print;
mod report;
pub mod semantics;
mod settings;

pub use ast::{AtomId, Bound, Formula, Interval, MAX_BOUND, TimeUnit, Window};
pub use early_end::Horizon;
pub use monitor::{BothValues, FormulaJudge, FormulaMonitor};
pub use parser::{AtomText, FormulaError, MAX_DEPTH, Parsed, parse};
pub use print::FormulaText;
pub use report::{Explanation, FormulaReport, Progress, Responsible, RobustnessBounds, StepError};
pub use settings::{CompileError, Ending, Interpolation, Settings, TimeModel};

pub use crate::monitor::Verdict;
