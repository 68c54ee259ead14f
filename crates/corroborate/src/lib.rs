#![doc = include_str!("../README.md")]
//!
//! | to | there is |
//! |---|---|
//! | make a study that runs as it is | [`new_study()`]; from a template, a robot's description or a recording: [`init()`] |
//! | open one and look into it, every mistake placed | [`Study::load`] |
//! | check all of it, and see what is stale and why | [`plan()`] |
//! | produce what is stale, compare, conclude; resume | [`run()`] |
//! | follow that as it goes | [`Host::events`], a closure that takes each [`Event`](host::Event) |
//! | cancel it | [`Host::cancel`]: call [`Cancel::cancel`](host::Cancel::cancel) from any thread |
//! | read verdicts | [`StudyResult::conclusions`](evidence::StudyResult::conclusions); their sum, as of all reports, as [`Ended::outcome`] |
//! | read the result of an earlier run | [`results::read_current_result`] |
//! | compare pieces of evidence | [`compare()`]; two results [`diff()`] |
//! | find which asset is to blame for what disagrees | [`diagnose()`]; one path of a model [`sampled_path`](diagnose::sampled_path) |
//! | check that every figure follows from its evidence | [`verify()`] |
//! | write its assurance case, with statements that others sign | [`assure()`] |
//! | make one signed archive of all that, and check one | [`pack()`], [`verify_pack()`] |
//! | see each requirement in all its forms, and where they drifted apart | [`requirements()`]; ready ones [`requirements::library`] |
//! | keep requirements the same in FRET, ReqIF, StrictDoc, Doorstop and CSV | [`import_requirements()`], [`export_requirements()`] |
//! | check properties of one model | [`check()`] |
//! | judge recordings, by a study's monitors or by formulas | [`monitor()`] |
//! | look for what nobody has thought of; stop and go on | [`explore()`] |
//! | map where formal model and simulation differ | [`map_disagreement`](explore::map_disagreement) |
//! | make a finding small, and keep it as a regression | [`shrink()`] |
//! | run an episode again, and look at it; run all regressions again | [`replay()`], [`check_regressions`](replay::check_regressions) |
//! | simulate episodes, and record and judge them | [`simulate::simulate()`] |
//! | run a study's episodes on several machines | [`shard()`], then [`merge()`] |
//! | fit a simulator to what was counted | [`calibrate()`] |
//! | estimate how rare an event is | [`rare()`] |
//! | run the same episodes in two physics engines | [`engines()`] |
//! | allow a study to run the programs that it names | [`consent::allow`]; for one call [`Host::trust`] |
//! | see what is missing around the program | [`doctor`](doctor::doctor()) |
//! | repeat a flaky test until its rate is decided | [`decide()`] |
//! | try variants of its assets, side by side | [`what_if()`] |
//! | be offered patches of its assets, and take them | [`refine()`] |
//! | look into a recording or a robot's description | [`inspect()`] |
//! | judge a running system, over DDS (ROS 2) or Foxglove | [`watch::watch()`] |
//!
//! Nothing is global: studies run side by side in one process, each with a host of its own, with the same results as one
//! after another. Every function takes a request as plain data, which its `new` fills with defaults, and gives a report that
//! serializes by the schema of its name in `schemas/`. What is simulated in physics needs [`Host::physics_library`];
//! programs of a study are given [`Host::python_path`] and work below [`Host::scratch`]. No function reads the environment, or
//! sets anything of the process.
//! `examples/first_study.rs` shows a study from its folder to verdicts, `examples/explore_and_replay.rs` one that is explored.

pub mod assure;
pub mod calibrate;
mod compare;
pub mod corroboration;
pub mod decide;
pub mod diagnose;
pub mod diff;
pub mod doctor;
pub mod engines;
pub mod explore;
pub mod init;
pub mod inspect;
pub mod kept;
pub mod outcome;
pub mod pack;
mod plan;
mod published;
pub mod rare;
pub mod refine;
pub mod replay;
pub mod requirements;
pub mod results;
pub mod rigs;
pub mod ros2_table;
mod run;
pub mod schemas;
pub mod shard;
pub mod shrink;
pub mod simulate;
pub mod technique;
mod test_bench;
pub mod verify;
pub mod watch;
pub mod what_if;

pub use diagnostic;
pub use evidence;
pub use host;
pub use judging;
pub use query;
pub use rig::consent;
pub use study;

pub use diagnostic::Problem;
pub use evidence::StudyResult;
pub use host::{Events, Host};
pub use study::Study;

pub use assure::{AssureReport, AssureRequest, Drawing, NamedTexts, assure};
pub use calibrate::{CalibrateRequest, calibrate};
pub use compare::{CompareReport, CompareRequest, compare};
pub use decide::{DecideReport, DecideRequest, decide};
pub use diagnose::{DiagnoseRequest, diagnose};
pub use diff::{DiffReport, DiffRequest, diff};
pub use engines::{EnginesReport, EnginesRequest, engines};
pub use explore::{ExploreRequest, explore};
pub use init::{InitReport, InitRequest, InitSource, Template, init, new_study};
pub use inspect::{InspectRequest, inspect};
pub use judging::{MonitorReport, MonitorRequest, monitor};
pub use outcome::{Ended, Outcome};
pub use pack::{PackRequest, pack, verify_pack};
pub use plan::{Freshness, PlannedEvidence, RunPlan, plan};
pub use query::{CheckReport, CheckRequest, check};
pub use rare::{RareReport, RareRequest, rare};
pub use refine::{RefineRequest, Refined, refine};
pub use replay::{ReplayReport, ReplayRequest, replay};
pub use requirements::exchange::{
    ExchangeReport, ExchangeRequest, export_requirements, import_requirements,
};
pub use requirements::{RequirementsReport, RequirementsRequest, requirements};
pub use run::{EvidenceReport, RunReport, RunRequest, run, run_with_page};
pub use shard::{MergeReport, MergeRequest, ShardReport, ShardRequest, merge, shard};
pub use shrink::{ShrinkReport, ShrinkRequest, shrink};
pub use technique::Techniques;
pub use verify::{Audit, Checked, Fault, VerifyReport, VerifyRequest, verify};
pub use what_if::{WhatIfRequest, what_if};

/// Which build of the engine this is: the same for the same sources of what computes results, however they were built.
pub fn build() -> host::BuildId {
    host::BuildId::new(env!("CORROBORATE_BUILD"))
}
