//! What an exploration gives: the form of `exploration.json`.

use evidence::{Discovery, Exploration};
use schemars::JsonSchema;
use serde::Serialize;
use study::{BenchFiles, Shows};

/// Said with every result of an exploration.
pub const NO_EVIDENCE: &str = "These episodes were chosen to show something new. They are witnesses and coverage; \
    how often they show something does not estimate how often it happens.";

/// What an exploration found and covered.
#[derive(Debug, Serialize, JsonSchema)]
pub struct ExplorationReport {
    /// What was run, and what was found.
    #[serde(flatten)]
    pub found: Exploration<FindingReport>,
    /// The files that were run.
    pub bench: BenchFiles,
    /// Each source with what it brought.
    pub sources: Vec<SourceReport>,
    /// Each search for a violation.
    pub searches: Vec<SearchReport>,
    /// What was covered.
    pub coverage: CoverageReport,
    /// What the model gave.
    pub model_tests: ModelTestsReport,
}

/// What a source of tests brought.
#[derive(Debug, Serialize, JsonSchema)]
pub struct SourceReport {
    /// The source.
    pub source: String,
    /// Episodes.
    pub episodes: u64,
    /// How many of them showed something that no episode had shown before.
    pub with_news: u64,
}

/// A search for the violation of a requirement.
#[derive(Debug, Serialize, JsonSchema)]
pub struct SearchReport {
    /// The requirement.
    pub requirement: String,
    /// How it was searched.
    pub method: String,
    /// Episodes that it asked for.
    pub episodes: u64,
    /// How many of them had a space-time robustness, which guides the search.
    pub with_robustness: u64,
    /// The least of these, as a share of what is allowed; below 0 the
    /// requirement is violated.
    pub least_robustness: Option<f64>,
    /// Its first episode that violated the requirement, counted among its own
    /// from 1.
    pub violated_after: Option<u64>,
    /// How many of its episodes violated it.
    pub violated: u64,
    /// Why the search was as good as blind, and what would help, if it was.
    pub blind: Option<String>,
}

/// Something that was found.
#[derive(Debug, Serialize, JsonSchema)]
pub struct FindingReport {
    /// What it is.
    pub shows: Shows,
    /// Where, how often, and by what.
    #[serde(flatten)]
    pub found: Discovery,
}

/// What was covered.
#[derive(Debug, Serialize, JsonSchema)]
pub struct CoverageReport {
    /// Requirements and failure modes whose precondition was met.
    pub triggers: SetReport,
    /// Cross products of situations.
    pub crosses: Vec<CrossReport>,
    /// The model's abstract states.
    pub states: Option<SetReport>,
    /// The model's abstract transitions.
    pub transitions: Option<SetReport>,
    /// Propositions that the model does not express and that are false there.
    pub not_expressed: Vec<(String, String)>,
    /// Code of the controller.
    pub code: Option<CodeReport>,
    /// Whether more episodes would show more.
    pub saturation: SaturationReport,
}

/// Members of a known set that were seen.
#[derive(Debug, Serialize, JsonSchema)]
pub struct SetReport {
    /// How many were seen.
    pub covered: u64,
    /// How many there are.
    pub total: u64,
    /// Those that were never seen.
    pub missing: Vec<String>,
    /// What was seen that the set does not have.
    pub unknown: Vec<String>,
}

/// A cross product of situations.
#[derive(Debug, Serialize, JsonSchema)]
pub struct CrossReport {
    /// Its name.
    pub name: String,
    /// Cells that were seen.
    pub covered: u64,
    /// Cells that there are.
    pub total: u64,
    /// What was never seen, in the largest blocks, with the number of cells.
    pub holes: Vec<String>,
    /// Cells that were seen although the file says that they cannot be.
    pub seen_though_excluded: Vec<Vec<String>>,
}

/// Code coverage.
#[derive(Debug, Serialize, JsonSchema)]
pub struct CodeReport {
    /// Lines that ran, and all lines.
    pub lines: [u64; 2],
    /// Functions that ran, and all functions.
    pub functions: [u64; 2],
    /// Branches that were taken, and all branches.
    pub branches: [u64; 2],
    /// Lines that never ran, of each file.
    pub never_run: Vec<String>,
}

/// How much is still unseen.
#[derive(Debug, Default, Serialize, JsonSchema)]
pub struct SaturationReport {
    /// Different things that were seen.
    pub seen: u64,
    /// Those that one episode alone showed.
    pub seen_once: u64,
    /// How many more such episodes can show (Chao's estimate, a lower bound in
    /// expectation).
    pub unseen: f64,
    /// Expected number of new things in the next episode (Good and Turing).
    pub news_in_next: f64,
    /// Expected number of new things in 100 more episodes (Chao and others).
    pub news_in_100_more: f64,
    /// With the study's confidence, the chance that the next episode shows
    /// anything new is at most this. It holds as far as episodes are
    /// generated alike.
    pub chance_of_news_at_most: f64,
}

/// Tests that the formal model gave.
#[derive(Debug, Default, Serialize, JsonSchema)]
pub struct ModelTestsReport {
    /// The tests.
    pub tests: Vec<ModelTestReport>,
    /// Goals without a test, with the reason.
    pub without: Vec<(String, String)>,
    /// Paths that together take every class of transitions.
    pub transition_cover: Option<CoverReport>,
}

/// A test that the formal model gave.
#[derive(Debug, Serialize, JsonSchema)]
pub struct ModelTestReport {
    /// The source.
    pub source: String,
    /// Where its path leads; several goals can have the same test.
    pub goals: Vec<String>,
    /// Transitions of the path.
    pub transitions: usize,
    /// The path's probability.
    pub probability: f64,
    /// Its steps that are no action of a test.
    pub unmapped: usize,
    /// The test.
    pub test: String,
}

/// Transition coverage of the model.
#[derive(Debug, Serialize, JsonSchema)]
pub struct CoverReport {
    /// Classes of transitions; all are taken.
    pub classes: usize,
    /// Paths that take them.
    pub paths: usize,
    /// Transitions of all paths together.
    pub transitions: usize,
}
