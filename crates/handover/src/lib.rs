#![doc = include_str!("../README.md")]
//!
//! # Use
//!
//! A [`Scenario`] says what is there, [`Parameters`] what tuning may change; both are TOML. An episode needs MuJoCo
//! ([`testbench::Engine`]; `tools/mujoco` fetches the pinned release and prints its path); everything else works without it.
//!
//! `examples/campaign.rs` runs many episodes and prints rates, `examples/episode.rs` prints one
//! topic of one episode as CSV, or its physical model.
//!
//! # Determinism
//!
//! Each purpose (object, pose, human, tracking, planner) draws from a random stream of its own
//! under the episode's seed, every rate is counted in whole time steps, and an episode builds its
//! physics afresh. The same seed gives the same bits in a used world, a fresh one, and on any
//! thread. Across machines the bits may differ: the C library chooses code by processor.
//!
//! # What a trace holds
//!
//! | topic | rate | signals |
//! |---|---|---|
//! | `/robot` | 50 Hz, after each tick | `state`, `decision` (`none`, `release`, `keep`, `time_out`), `crashed`, `ended`, `planning`, `hand_command`, `restricted`, `announcing`, `hand.x` to `.z`, `hand_speed` |
//! | `/sensors` | 10 Hz and at every change | `sensing`, `sensing_done`, `gaze_ok`, `pressure_ok`, `location_ok`, `all_ok`, `finger_displacement`, the reported `object` |
//! | `/tracking` | 20 of 100 Hz | reported `object`, `human_hand`, `human_head` |
//! | `/truth` | 50 Hz | `object`, `object_attitude`, `object_speed`, `in_hand`, `object_contacts_hand`, `hand_contacts`, `grip_force`, `human_hand`, `human_head`, `human_distance`, `pull`, `gaze`, `pressure`, `location`, `human_ready`, `human_holds`, `tracking_glitch` |
//! | `/human` | 50 Hz | `activated`, `ready`, `gaze`, `pressure`, `location` as the abstract test applies them, `gave_up` |
//!
//! `/truth.human_ready` is whether the human really looks, pulls and has the hand there;
//! `/sensors.all_ok` is what the robot believes. A requirement about the human should read the
//! former. `/truth.human_distance` is between the centre of the robot's wrist and the centre of the
//! human's hand or head, whichever is nearer.
//!
//! # Hardware in the loop
//!
//! [`run_episode_with`] joins an episode to an [`Outside`]: it is told of every time step, so that it
//! can hold the episode in step with a clock and pass on what is recorded, and gives readings that
//! replace simulated ones (the human's signals, tracked positions, the sensors' judgements). This
//! crate knows neither clocks nor networks; see `crates/live` for those.
//!
//! # Performance
//!
//! `CAMPAIGN_FAST=both` of `examples/profile.rs` measures full physics, fast physics and the engine alone
//! ([`EngineAlone`]) in turns. Of eight episodes each, on a machine that others used, too, the full physics with its
//! recording ran at 0.87 (tuned) and 0.89 (untuned) of the speed of bare engine steps of the same episodes: 77 and 92
//! times real time on one core, for 88 and 103. The fast physics ran at 2.6 and 1.6 of it, 226 and 168 times real time.
//! `examples/campaign.rs` prints the wall-clock ratio (`CAMPAIGN_FAST=1` for the fast physics).
//!
//! # Two engines
//!
//! The full physics is MuJoCo's or Rapier's ([`Physics`]): the same robot, person, seeds, steps and recording, so that what two
//! engines agree on does not rest on one's approximations. Links, joints, drives, masses, shapes and who touches whom are the
//! same; a test holds the two descriptions against each other. Springs and dampers stand for MuJoCo's soft contacts, stops and dry
//! friction, and give way to slow forces as these do ([`testbench::physics::Softness::spring`]), not to blows. Friction of contacts is
//! hard in Rapier, and MuJoCo's settings of its solver are not used there. Hand and object are read as they were before the last
//! step in both. In either engine an object falls freely, slides on the pedestal with what exceeds its friction, is gripped by forces within
//! their cones that carry its weight, and hangs by its weight on the human's hand (tested against physics by hand).
//!
//! # Fast physics
//!
//! MuJoCo alone has it. [`HandoverBench::in_fast_physics`] (or `fast = true` in the scenario's `[simulation]`) lets less
//! than the full physics stand in for it where less will do. It is approximate and for searching: what is found in it is
//! to be shown by the full physics, which is integrated otherwise and is the reference. Which of the two a bench runs is
//! no setting of a stimulus.
//!
//! * Hand empty and apart from a resting object: only the arm's joints move, each by its servo, with
//!   the arm's inertia, Coriolis and centrifugal torques and its stops. Fingers move with it, with their
//!   dry friction and stops, while they are sent elsewhere, or if they are so heavy for that friction that
//!   they swing (those of the untuned parameters have 0.1 kg m2).
//! * Steady motion, in which every drive of the arm speeds up as it did, or not at all, the fingers'
//!   rest and nobody's force changes: bursts of four steps of the whole model alternate with glides of at
//!   most 40, in which the joints, and the object in the hand, go on at the rates measured, and at the
//!   rates' own change where that is regular. A glide is so long that a change of these rates as great
//!   as was not foreseen since the last one moves nothing by more than a fifth of a micrometre (the hand
//!   by two). With fingers that swing bursts take 0.04 s, until their dry friction has settled, and there are
//!   glides only while they hold the object, none in which one of them comes upon it or squeezes it, none
//!   under a pull and for 0.7 s (the untuned) after it.
//! * The model lists all pairs that can touch, and the object's weight is a force: the same equations.
//!
//! Everything that decides how the fingers meet the object is integrated in full. `tests/integration/fast.rs` bounds
//! how far hand and object are from where the full physics has them.
//!
//! Paired by seed with the full physics, 16 of 2000 tuned handovers (E4) are judged otherwise, 7 of which lose a
//! false negative of the pressure sensor and 9 gain one, and every rate is the same within 0.46 points (90 %
//! interval of the paired difference); of 1000 untuned ones (E2) 3 are, all of which fail instead (p 0.25), and
//! every rate is the same within 0.75 points. In some tuned episodes the object can settle in the hand in two
//! ways, millimetres apart, and the full physics takes the other one, too, once its object is displaced by a
//! micrometre or ten. `tests/fast/verdicts.py` prints the table from two campaigns;
//! `examples/fast_against_full.rs` compares how episodes end and where hand and object are;
//! `examples/profile.rs` says what either costs in each state of the robot.
//!
//! # Where the time goes
//!
//! Of the full physics' time 95 % is spent inside MuJoCo, 4 % in the C library's memory and mathematics routines,
//! under 1 % in this crate. Inside MuJoCo: about a quarter for the Hessian of contacts that slide
//! (elliptic cones), a quarter for the rest of the Newton solver, a tenth for collision, the rest
//! for kinematics and dynamics. A step with nothing in the hand costs 18 microseconds, one that
//! holds the object by six contacts 34.
//!
//! What mattered, measured on a held object:
//!
//! * A solver tolerance of 1e-10 instead of 1e-8: 20 % less time, because a converged step is the
//!   next one's starting point (one Newton iteration instead of four). 1e-4 takes five times as long.
//! * Friction without a torsional part: 10 times less creep and 20 % less time.
//! * An impedance ratio of 300 in place of no-slip iterations, which spoil the warm start.
//! * Shapes that MuJoCo collides in closed form (see below). Sparse algebra, CG and PGS are slower
//!   at this size; pyramidal cones dropped the object in trials.
//!
//! # What is modelled how
//!
//! * Arm: position servos with the published gains; drives follow trapezoidal speed profiles. The
//!   arm's weight is carried by feed-forward. Joints that never move in the scenario are fixed.
//! * Hand: ten finger joints with torque-limited servos and dry friction; segments are capsules.
//! * Object: an upright cylinder, a capsule to the fingers; on the pedestal it stands on four feet.
//! * Human: moved on given paths; acts on the object by a force whose line of action runs at the
//!   height of the robot's grip (the wrist keeps the leg upright), later by a limited spring.
//! * Not modelled: contact of the arm or hand with the pedestal, of the object with the arm, of the
//!   human with the robot; compliance of the arm's links; latency of tracking.

mod model;
mod outside;
mod physics;
mod purpose;
pub mod robot;
pub mod scenario;
mod world;

pub use model::{PhysicalDraws, joint_order, mjcf, standing_pose};
pub use outside::{Outside, OutsideReadings, Reading, SensorsOutside};
pub use physics::Physics;
pub use scenario::{Parameters, Scenario};
pub use world::{
    EngineAlone, Episode, HandoverBench, Outcome, RunningHandover, SavedHandover, Steps, World,
    run_episode, run_episode_with, watch_episode,
};
