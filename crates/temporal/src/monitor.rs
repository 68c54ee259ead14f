//! Staged assertion monitors: a precondition, then postconditions in order, judged over one trace.
//!
//! # Definition
//! A word is a sequence of samples (t_0, v_0), ..., (t_n, v_n) with t_0 < ... < t_n; v_i gives
//! each proposition the value true, false or *unknown* (not recorded). A monitor has a trigger
//! proposition `when` and stages s_1 ... s_m. At each sample where it triggers, an *instance*
//! begins there with stage s_1. A stage is entered at a sample i and is left at a sample j >= i;
//! the next stage is entered at that same j. The instance passes when s_m is left.
//!
//! * `assert p`: left at j = i if p is true at i. It fails if p is false at i.
//! * `wait_for p within d`: left at the first j >= i with p true and t_j <= t_i + d. It fails at
//!   the first sample that shows there is none, at or after t_i + d. Without `within`, d is infinite.
//! * `hold p until q within d`: left at the first j >= i with q true and t_j <= t_i + d, where p
//!   is not asked. It fails at a sample before where p is false, or by the deadline as above.
//!
//! `when` triggers where it *becomes true* (it is true and its last known value, if any, was
//! false; thus also at the first sample), or, with `trigger = "each_sample"`, wherever it is true.
//! An instance that is under way is first advanced at a sample, and only then may a new one begin;
//! while one is under way triggers are counted as `overlapping` and begin nothing.
//!
//! # Unknown values
//! Unknown is neither true nor false: it never triggers, never satisfies an `assert` or `hold`,
//! and never fails one. Events are taken as *observed*: waiting goes on past unknown samples.
//! * p unknown where it is asserted or held: the instance goes on, but instead of passing it ends
//!   inconclusive. (A later failure stands: it fails whatever p was.)
//! * q unknown during `hold`, or p unknown during `wait_for`: the stage may have been over without
//!   being seen to be. What would have failed in that stage from then on is inconclusive.
//!
//! # Deviations and guarantees
//! The form of the monitors follows Webster et al., "A corroborative approach to verification and
//! validation of human-robot teams", Int. J. Robotics Research 39(1), 2020, section on assertion
//! monitors: an `if` for the precondition, then `while !q assert p`, `wait_for` and `assert`. There,
//! time-outs ran on the wall clock; here, time is the clock of the trace alone. Deadlines are
//! compared with a tolerance of 1 ns, the resolution of recorded times, or of four units in the
//! last place of the sample's time where that is coarser.
//! Every count of the report follows from the word alone; a step costs O(m) and allocates nothing
//! except at the first failure. Twenty monitors over 1,200 samples take about 0.3 ms.
//!
//! The robustness, how far a monitor is from another verdict, is computed apart, by a
//! [`RobustnessMonitor`]. Where propositions are only true or false that is infinite; a search is
//! guided by [`SpaceTimeJudge`] instead, which also measures time.
//!
//! ```
//! use temporal::monitor::{Monitor, MonitorSpec, Stage, Verdict};
//! let spec = MonitorSpec::new("grasped", vec![
//!     Stage::Hold { proposition: "in_hand".into(), until: "sensed".into(), within_secs: None },
//!     Stage::WaitFor { proposition: "released".into(), within_secs: Some(5.0) },
//! ]);
//! let monitor = Monitor::compile(&spec)?;
//! assert_eq!(monitor.propositions(), ["grasped", "in_hand", "sensed", "released"]);
//!
//! let mut judge = monitor.start();
//! //                    grasped, in_hand, sensed, released
//! let word = [(0.0, [true,  true,  false, false]),
//!             (1.0, [true,  true,  true,  false]),
//!             (4.0, [true,  false, true,  true])];
//! for (time_secs, values) in word {
//!     judge.step(time_secs, &|proposition| Some(values[proposition]))?;
//! }
//! let report = judge.finish(true);
//! assert_eq!((report.triggered, report.passed), (1, 1));
//! assert_eq!(report.verdict, Verdict::Satisfied);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod formula;
mod machine;
mod report;
mod robustness;
mod space_time;
mod spec;

pub use formula::StagedFormula;
pub use machine::{Judge, Monitor, PropId};
pub use report::{Failure, FailureReason, MonitorReport, StepError, Verdict};
pub use robustness::{
    MAX_UNBOUNDED_STAGES, RobustnessJudge, RobustnessMonitor, StagedRobustness, TooManyUnbounded,
};
pub use space_time::{Graded, SpaceTimeJudge};
pub use spec::{AtEnd, MonitorSpec, Repeat, SpecError, Stage, Trigger};
