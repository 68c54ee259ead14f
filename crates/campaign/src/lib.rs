//! Which stimuli to run next, and what the outcomes so far say.
//!
//! A campaign knows nothing of robots: it gives stimuli and seeds, and is told numbers, labels and
//! yes or no. So every algorithm works on every bench. All are deterministic from a seed; what has
//! a state is plain data that can be written down and resumed.
//!
//! | you want | use |
//! |---|---|
//! | points of a parameter space, spread evenly, by chance, or at its limits | [`Sampler`] |
//! | the stimulus that comes nearest to a violation | [`Searcher`]: cross-entropy, CMA-ES, Bayesian optimisation |
//! | contexts in which a formal model and a simulator disagree | [`DisagreementSearch`], [`Confirmation`] |
//! | abstract tests | [`Grammar`], [`Agent`], [`PathMapping`] |
//! | what was covered, what is missing, and whether more episodes pay | [`Coverage`], [`SetCoverage`], [`Lcov`], [`Saturation`] |
//! | the smallest stimulus that still shows it | [`shrink()`] |
//! | the probability of what hardly ever happens | [`splitting`] |
//! | simulator parameters that fit counts | [`calibration`] |
//! | when to stop | [`stopping`] |
//!
//! Episodes that a search or a boundary design chose are witnesses. Rates counted over them are
//! biased, and say nothing about use: only random and low-discrepancy designs follow the declared
//! distributions.
//!
//! # From a space to the smallest violation
//!
//! ```
//! use campaign::{Method, Search, Searcher, ShrinkOptions, shrink};
//! use stimulus::{AbstractTest, Action, Point, Setting, Space, Stimulus};
//!
//! // A mobile robot brakes at 1.2 m/s^2 once it has seen a person, which takes it 0.3 s.
//! let space = Space::from_toml(r#"
//!     [[parameter]]
//!     name = "speed"
//!     sets = ["robot.speed_m_s"]
//!     uniform = [0.2, 1.5]
//!     nominal = 0.5
//!
//!     [[parameter]]
//!     name = "distance"
//!     sets = ["person.distance_m"]
//!     uniform = [0.6, 4.0]
//!     nominal = 2.0
//!     "#)?;
//! // Stands for a bench: the distance that is left, the robustness of "never touch a person".
//! let distance_left = |point: &Point| {
//!     let [speed, distance] = point.0[..] else { return f64::NAN };
//!     distance - 0.3 * speed - speed * speed / (2.0 * 1.2)
//! };
//!
//! let mut search = Searcher::new(Method::Bayesian, space.clone(), 1)?;
//! while search.best().is_none_or(|best| best.value >= 0.0) {
//!     let points = search.ask(1);
//!     let told: Vec<_> = points.into_iter().map(|p| (p.clone(), distance_left(&p))).collect();
//!     search.tell(&told);
//! }
//! let found = search.best().ok_or("nothing was told")?;
//! assert!(found.index < 40);
//!
//! // The stimulus of that point, with a test that holds more than it takes.
//! let test = AbstractTest::new("a person appears", vec![
//!     Action::send("start"), Action::set("music", true), Action::send("person appears"),
//! ]);
//! let stimulus = space.stimulus(&test, &found.point)?;
//! let options = ShrinkOptions::within(space.clone(), 200)?;
//! let smallest = shrink(&stimulus, &options, &mut |s: &Stimulus| {
//!     let point = space.point_of(&s.settings);
//!     s.test.to_string().contains("person appears") && point.is_some_and(|p| distance_left(&p) < 0.0)
//! })?;
//! assert_eq!(smallest.stimulus.test.to_string(), "send person appears");
//! let is_round = |value: &Setting| value.to_string().len() <= 3;
//! assert!(smallest.stimulus.settings.values().all(is_round) && smallest.is_minimal);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Towards what is missing
//!
//! ```
//! use campaign::{Coverage, CoverageModel, Design, Sampler};
//! use stimulus::{Point, Space};
//!
//! let space = Space::from_toml(
//!     "[[parameter]]\nname = \"speed\"\nsets = [\"speed\"]\ntriangular = [0.0, 0.2, 2.0]")?;
//! let model = CoverageModel::from_toml(
//!     "[[variable]]\nname = \"speed\"\nedges = [0, 0.5, 1, 1.5, 2]\nunit = \"m/s\"\n\
//!      [[cross]]\nname = \"speeds\"\nof = [\"speed\"]")?;
//! let speed = model.variables[0].clone();
//! let situation = |point: &Point| [("speed".to_owned(), speed.label_of(point.0[0]).unwrap_or_default())].into();
//! let mut coverage = Coverage::new(model);
//! let mut sampler = Sampler::new(space, Design::LowDiscrepancy, 1);
//! for point in sampler.ask(4)? {
//!     coverage.record(&[situation(&point)])?;
//! }
//! // Whatever is still missing is asked for: points that lie in the largest hole.
//! while let Some(hole) = coverage.holes("speeds", 1)?.first() {
//!     let points = sampler.ask_where(1, &|point| hole.holds(&situation(point)))?;
//!     coverage.record(&[situation(&points[0])])?;
//! }
//! assert_eq!(coverage.share("speeds")?.rate(), Some(1.0));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod calibration;
pub mod coverage;
pub mod design;
mod error;
pub mod generate;
mod random;
pub mod search;
pub mod shrink;
pub mod splitting;
pub mod stopping;

pub use coverage::{
    Coverage, CoverageModel, Cross, FileCoverage, Hole, Lcov, NewBin, Saturation, SetCoverage,
    Share, Situation, Variable, Visits,
};
pub use design::{Design, Sampler, centred_discrepancy};
pub use error::CampaignError;
pub use generate::{
    ActionPattern, Agent, Alternative, Cover, FromPath, Grammar, Known, PathMapping, PathStep,
    Plan, Rule, StepRule, Values, smallest_cover,
};
pub use random::Random;
pub use search::{
    Agreement, Bayesian, CmaEs, Confirmation, CrossEntropy, DisagreementOptions,
    DisagreementSearch, Evaluated, Finding, FormalPrediction, GaussianProcess, MapCell, Method,
    Prediction, Question, RandomSearch, Region, Search, Searcher,
};
pub use shrink::{NotShown, ShrinkOptions, Shrunk, Size, shrink};
pub use stopping::{Stop, Stopping, StoppingRule};
