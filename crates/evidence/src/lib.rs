#![doc = include_str!("../README.md")]
//!
//! The nouns follow *corroborative verification and validation* (Webster et
//! al. 2020, section 2): a [`Requirement`] is checked by a [`Technique`] on
//! [`Asset`]s (a system model and a requirement model); the result is
//! [`Evidence`], a list of [`Finding`]s with their uncertainty. Pairs of
//! evidence are [`Comparison`]s with one of four [`Outcome`]s, and a
//! disagreement is explained by [`Suspect`]s. [`compare_together`] looks at all pieces on a
//! subject at once, [`undecided`] plans the trials that would decide, and [`combine`] gives the
//! interval that independent pieces support together; [`synthesise`] does all of these. A [`StudyResult`] holds all
//! of it and is what a report shows; everything here serialises, and
//! [`StudyResult::json_schema`] describes the form.

mod asset;
mod compare;
mod completions;
mod conclude;
mod condition;
mod description;
mod diagnose;
mod disagreement;
mod exploration;
mod failure;
mod finding;
mod fit;
mod guarantee;
mod interval;
mod ledger;
mod looks;
mod making;
mod margin;
mod measure;
mod part;
pub mod replay;
mod requirement;
mod resampled;
mod sensitivity;
mod step;
mod synthesis;
mod technique;
mod traceability;
#[cfg(test)]
#[path = "../tests/integration/support/uniform.rs"]
mod uniform;
mod verdict;

pub use asset::{Asset, AssetRole, Tool};
pub use compare::{
    DecisionPlan, FurtherSubjects, Influences, Levels, PlannedTrials, Programme, Relation,
    Spreading, Study, Together, TrialCosts, Undecided, compare, compare_together, programme,
    undecided,
};
pub use conclude::alone::{Alone, alone, shown};
pub use conclude::combined::{Combined, CommonBound, Model, Weights, combine};
pub use conclude::coverage::coverage_gaps;
pub use conclude::threshold::{Deciding, NotPlanned};
pub use conclude::{AS_ALIKE, CERTAINTY, conclude, effective_size};
pub use condition::doubt_triggers;
pub use description::DescriptionGap;
pub use diagnose::{
    CERTAIN, Cell, CellPlace, Clue, Contrast, Counted, Diagnosis, Effort, Exchanged,
    ExchangedColumns, Figure, HALF_STEP, JudgedBy, Matter, MixedUp, Rate, STRONG, SameTraces,
    Suspect, SuspectAsset, SuspectKind, Symptom, TableOf, Traces, VerdictCounts, Witness,
    changed_places, contrasts, exchanged, exchanged_columns, mixed_up, put_right, rank,
    requirement_form, share_assumption, signed_strength, strength, system_model, voices,
};
pub use disagreement::{
    ContextParameter, ContextRange, ContextRegion, DisagreementMap, MapPlace, RegionOutcome,
    RegionShares, SearchEnd,
};
pub use exploration::{
    BrokenEpisode, CauseFound, CauseSetting, Confirmation, Discovery, Distinction, Exploration,
    SignalRelation, SignalTerm, Stopped,
};
pub use failure::{EpisodeFailures, FailureKind};
pub use finding::{
    Completions, ConstantInterval, CredibleInterval, Denominator, EndDistribution, Finding,
    FormDifference, Measure, MethodAnswer, Reading, RobustBounds, SchedulerEnds, Spread, Subject,
    WorstCase,
};
pub use fit::{
    CalibrationReport, DirectionReport, FileReport, HeldOutRunsReport, Identification, Likeness,
    LineageReport, ModeReport, ParameterReport, PredictionReport,
};
pub use guarantee::Guarantee;
pub use interval::Interval;
pub use ledger::{
    AlikeTrials, Calibration, ClusterTests, CommonText, CopyKind, Cost, Evidence, LineageQuestion,
    PublishedFigure, RepeatedRows, SharedSeeds, StudyResult, TakenCorrelation,
};
pub use looks::{Look, LookedAt, Looking, Looks};
pub use margin::{DEFAULT_MARGIN, margin_of};
pub use measure::{Worst, adds_up};
pub use part::is_of_another_part;
pub use requirement::{Direction, FailureMode, Requirement, Threshold};
pub use sensitivity::{ASSUMED_GROUP, CORRELATIONS, bear_clustering};
pub use step::{CarryOver, Step};
pub use synthesis::{Synthesis, synthesise};
pub use technique::{AskedBy, Mark, Rerun, Technique, Traits, WitnessOf};
pub use traceability::{TraceRow, trace};
pub use verdict::{
    ClusterSensitivity, Comparison, Conclusion, CoverageGap, ErrorFamily, ErrorRate, Excluded,
    ExcludedTrials, ExclusionReason, FurtherTrials, Inaccuracy, Outcome, PieceStanding, RunVerdict,
    Standing, TriggerComparison, Verdict,
};
