//! The file that says how to explore: `exploration.toml` beside the study's
//! other files.
//!
//! ```toml
//! evidence = "E2"             # the ledger's entry whose bench is run
//! model = "E1"                # the one whose formal model is held against it
//! physics = "fast"            # what is searched in; "full" is the other
//! task_over = "arrived"       # what is found only afterwards is listed apart
//!
//! [budget]
//! episodes = 300
//! batch = 20                  # how many run before feedback
//! stop = { more = 100, news = 1.0 }
//!
//! [abstraction]
//! shortest_secs = 0.2         # what holds shorter is passed over
//! steps = 2                   # so many of the model's changes may show at once
//! [[abstraction.proposition]]
//! name = "in_hand"
//! model = "!handEmpty"        # instead of the vocabulary's meaning
//! trace = "object_in_hand"
//!
//! [[trigger]]                 # where the vocabulary has no meaning for the model
//! when = "sensing_says_ready"
//! model = "robotState=GPLOk"
//! ```

use super::bench::OpenBench;
use super::faults::FaultData;
use crate::technique::simulation::SearchPhysics;
use campaign::{Agent, Cross, Design, Grammar, Method, PathMapping, StepRule};
use diagnostic::{Problem, Problems, Source, did_you_mean};
use rig::{check_keys, check_units};
use schemars::JsonSchema;
use serde::Deserialize;
use std::path::{Path, PathBuf};
use stimulus::{Constraint, Parameter, Space};
use study::Study;

/// How to explore.
#[derive(Debug)]
pub struct Plan {
    /// The file's path relative to the study.
    pub file: String,
    /// The file, for diagnostics.
    pub source: Source,
    /// Its content.
    pub data: Data,
    /// What varies.
    pub space: Space,
    /// Which steps of the model are which actions of a test.
    pub mapping: PathMapping,
}

/// The content of the file.
#[derive(Debug, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Data {
    /// The ledger's entry whose bench is run.
    pub evidence: String,
    /// The ledger's entry whose formal model the episodes are held against.
    pub model: Option<String>,
    /// When the task is over: a word of the vocabulary, or a predicate over signals, that first holds then. What is found only
    /// afterwards is listed apart. If absent, and recordings are held against a model, it is over where the model stays for ever.
    pub task_over: Option<String>,
    /// The physics that is searched in: the fast one where the bench has one, if absent. What is found is shown by the
    /// full one before it counts. The search for disagreement, which gives figures, is of the full one.
    physics: Option<SearchPhysics>,
    /// When to stop.
    #[serde(default)]
    pub budget: Budget,
    /// Where tests come from; every source that the file has data for, if
    /// not named.
    pub sources: Option<Vec<SourceKind>>,
    /// How parameters are chosen.
    #[serde(default = "all_designs")]
    pub designs: Vec<Design>,
    /// How recordings are held against the model.
    pub abstraction: Option<AbstractionData>,
    /// Model states to which tests are to lead.
    #[serde(default)]
    pub goal: Vec<Goal>,
    /// What words of the study mean to this model, where the vocabulary does
    /// not say or says something else.
    #[serde(default)]
    trigger: Vec<TriggerData>,
    /// Values that are injected beside the faults that the bench declares.
    #[serde(default)]
    pub fault: Vec<FaultData>,
    /// Which steps of the model are which actions of a test.
    #[serde(default)]
    step: Vec<StepRule>,
    /// Random tests.
    pub grammar: Option<Grammar>,
    /// Agents that use the system.
    #[serde(default)]
    pub agent: Vec<Agent>,
    /// What is varied, with its distribution.
    #[serde(default)]
    parameter: Vec<Parameter>,
    /// Which combinations are allowed.
    #[serde(default)]
    constraint: Vec<Constraint>,
    /// What situations differ in.
    #[serde(default)]
    pub situation: Vec<SituationData>,
    /// Which of them are crossed.
    #[serde(default)]
    pub cross: Vec<Cross>,
    /// Searches for violations.
    #[serde(default)]
    pub search: Vec<SearchData>,
    /// Code coverage of the controller in the format of lcov: files relative
    /// to the study; a `*` in a file's name stands for anything.
    #[serde(default)]
    pub lcov: Vec<PathBuf>,
    /// The search for contexts in which model and bench differ.
    pub disagreement: Option<DisagreementData>,
}

/// When to stop.
#[derive(Clone, Copy, Debug, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Budget {
    /// Episodes, at most.
    pub episodes: u64,
    /// How many run before what they showed feeds back.
    pub batch: u64,
    /// Stop once so many more episodes would show at most so much new.
    pub stop: Option<StopRule>,
    /// End episodes once all that they are run for is decided.
    pub early_end: bool,
}

impl Plan {
    /// The JSON Schema of an exploration's file.
    pub fn schema() -> schemars::Schema {
        schemars::schema_for!(Data)
    }
}

impl Default for Budget {
    fn default() -> Self {
        Self {
            episodes: 200,
            batch: 20,
            stop: None,
            early_end: true,
        }
    }
}

/// When more episodes have stopped paying.
#[derive(Clone, Copy, Debug, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StopRule {
    /// So many more episodes ...
    pub more: u64,
    /// ... would show anything new in at most so many of them, on average.
    pub news: f64,
}

/// Where a test comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, JsonSchema, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SourceKind {
    /// The tests of the bench's own files.
    Own,
    /// The most probable path of the formal model to each goal.
    Goals,
    /// Paths of the model to what each requirement is triggered by.
    Triggers,
    /// Paths that take every abstract transition and every step that is an
    /// action of a test.
    Transitions,
    /// Faults that the bench's data declare, made certain or likely.
    Faults,
    /// Random tests within rules.
    Random,
    /// What agents do.
    Agents,
    /// Changes of tests that showed something new.
    Mutation,
    /// Search for the least robustness of a requirement.
    Search,
}

impl study::Choice for SourceKind {
    const CHOICES: &'static [(Self, &'static str, &'static str)] = &[
        (Self::Own, "own", "The tests of the bench's own files"),
        (
            Self::Goals,
            "goals",
            "The most probable path of the formal model to each goal",
        ),
        (
            Self::Triggers,
            "triggers",
            "Paths of the model to what each requirement is triggered by",
        ),
        (
            Self::Transitions,
            "transitions",
            "Paths that take every abstract transition and every step that is an action of a test",
        ),
        (
            Self::Faults,
            "faults",
            "Faults that the bench's data declare, made certain or likely",
        ),
        (Self::Random, "random", "Random tests within rules"),
        (Self::Agents, "agents", "What agents do"),
        (
            Self::Mutation,
            "mutation",
            "Changes of tests that showed something new",
        ),
        (
            Self::Search,
            "search",
            "Search for the least robustness of a requirement",
        ),
    ];
}

impl SourceKind {
    /// What it is called in results.
    pub fn name(self) -> &'static str {
        match self {
            Self::Own => "own tests",
            Self::Goals => "model: goals",
            Self::Triggers => "model: triggers",
            Self::Transitions => "model: transitions",
            Self::Faults => "fault injection",
            Self::Random => "random tests",
            Self::Agents => "agents",
            Self::Mutation => "mutation",
            Self::Search => "search",
        }
    }
}

/// How recordings are held against the model.
#[derive(Debug, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AbstractionData {
    /// What holds for less than this is passed over, in seconds.
    #[serde(default)]
    pub shortest_secs: f64,
    /// How many of the model's changes a recording may show at once.
    #[serde(default = "one")]
    pub steps: usize,
    /// The propositions that distinguish states.
    pub proposition: Vec<PropositionData>,
}

/// A proposition that distinguishes states.
#[derive(Debug, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PropositionData {
    /// Its name, often one of the vocabulary.
    pub name: String,
    /// What it means to the model; as the vocabulary says, if absent.
    pub model: Option<String>,
    /// What it means to recordings; as the vocabulary says, if absent.
    pub trace: Option<String>,
}

/// What a word of the study means to the model.
#[derive(Debug, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
struct TriggerData {
    /// The word, by which a requirement is triggered.
    #[schemars(with = "String")]
    when: toml::Spanned<String>,
    /// An expression over the model's variables.
    model: String,
}

/// Model states to which a test is to lead.
#[derive(Debug, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Goal {
    /// What it is called.
    pub name: String,
    /// An expression over the model's variables.
    pub model: String,
}

/// What situations differ in: exactly one of proposition, parameter, action.
#[derive(Debug, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SituationData {
    /// Its name.
    pub name: String,
    /// Whether this held, at the first time `when` held, or ever.
    pub proposition: Option<String>,
    /// The proposition that says when.
    pub when: Option<String>,
    /// The parameter whose value it is.
    pub parameter: Option<String>,
    /// Where that is cut into intervals.
    #[serde(default)]
    pub edges: Vec<f64>,
    /// Whether the test has this action, for example `set gaze=false`.
    pub action: Option<campaign::ActionPattern>,
}

/// A search for the least robustness of a requirement.
#[derive(Debug, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SearchData {
    /// The requirement.
    pub requirement: String,
    /// The bench's own test that is run.
    pub test: String,
    /// How it is searched.
    pub method: Method,
    /// What it varies; the file's parameters, if absent. Few that bear on the
    /// requirement are searched faster.
    #[serde(default)]
    parameter: Vec<Parameter>,
}

/// The search for contexts in which model and bench differ.
#[derive(Debug, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DisagreementData {
    /// The requirement whose probability is compared.
    pub requirement: String,
    /// The bench's own test that is run.
    pub test: String,
    /// The ledger's entry whose bench is run, if not that of the file.
    pub evidence: Option<String>,
    /// The ledger's entry whose formal model predicts, if not that of the
    /// file.
    pub model: Option<String>,
    /// Episodes, at most.
    pub episodes: u64,
    /// How many of them lead to the regions; two fifths, if absent.
    pub explore: Option<u64>,
    /// All contexts are cut into at most so many regions.
    #[serde(default = "six")]
    pub regions: usize,
    /// Difference that still counts as agreement; the requirement's margin
    /// if absent.
    pub margin: Option<f64>,
    /// Which constants of the model follow which parameters of the context.
    pub constant: Vec<ConstantData>,
    /// The contexts.
    pub parameter: Vec<Parameter>,
}

/// A constant of the model as a function of a context's parameter.
#[derive(Debug, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ConstantData {
    /// The constant.
    pub name: String,
    /// The parameter.
    pub parameter: String,
    /// The constant is `offset + factor * value`, cut to 0 to 1.
    #[serde(default = "one_f64")]
    pub factor: f64,
    /// See `factor`.
    #[serde(default)]
    pub offset: f64,
}

impl SearchData {
    /// What it varies, if not what the file does.
    pub fn space(&self) -> Option<Space> {
        (!self.parameter.is_empty()).then(|| Space {
            parameters: self.parameter.clone(),
            constraints: Vec::new(),
        })
    }
}

impl DisagreementData {
    /// The contexts.
    pub fn space(&self) -> Space {
        Space {
            parameters: self.parameter.clone(),
            constraints: Vec::new(),
        }
    }
}

fn one() -> usize {
    1
}

fn six() -> usize {
    6
}

fn one_f64() -> f64 {
    1.0
}

fn all_designs() -> Vec<Design> {
    vec![Design::LowDiscrepancy, Design::Boundary, Design::Random]
}

impl Plan {
    /// Reads a file that is named by what a study keeps, and not by the user.
    pub fn of_study(study: &Study, file: &Path) -> Result<Self, Problem> {
        study.reach.check(&study.folder.join(file))?;
        Self::load(&study.folder, file)
    }

    /// Reads the file, whose path is relative to the study's folder.
    pub fn load(folder: &Path, file: &Path) -> Result<Self, Problem> {
        let source = host::files::read_source(&folder.join(file))?;
        let mut data: Data = study::read_toml("bad-exploration", &source)?;
        let space = Space {
            parameters: std::mem::take(&mut data.parameter),
            constraints: std::mem::take(&mut data.constraint),
        };
        let mapping = PathMapping {
            rules: std::mem::take(&mut data.step),
        };
        let plan = Self {
            file: file.display().to_string(),
            source,
            data,
            space,
            mapping,
        };
        plan.check()?;
        Ok(plan)
    }

    /// A problem at the first place of `word` in the file.
    pub fn mistake(&self, word: &str, message: impl Into<String>) -> Problem {
        let problem = Problem::new("bad-exploration", message);
        match self.source.text.find(word) {
            Some(place) if !word.is_empty() => problem.at(&self.source, place..place + word.len()),
            _ => problem.about(&self.source.name),
        }
    }

    fn check(&self) -> Result<(), Problem> {
        let wrong =
            |word: &str, error: &dyn std::fmt::Display| self.mistake(word, error.to_string());
        self.space.check().map_err(|e| wrong("[[parameter]]", &e))?;
        check_units(&self.space, &self.source, "bad-exploration")?;
        for space in self.data.search.iter().filter_map(SearchData::space) {
            space.check().map_err(|e| wrong("[[search]]", &e))?;
            check_units(&space, &self.source, "bad-exploration")?;
        }
        if let Some(disagreement) = &self.data.disagreement {
            check_units(&disagreement.space(), &self.source, "bad-exploration")?;
        }
        self.mapping.check().map_err(|e| wrong("[[step]]", &e))?;
        if let Some(grammar) = &self.data.grammar {
            grammar.check().map_err(|e| wrong("[grammar]", &e))?;
        }
        for agent in &self.data.agent {
            agent.check().map_err(|e| wrong("[[agent]]", &e))?;
        }
        if let Some(abstraction) = &self.data.abstraction {
            let count = abstraction.proposition.len();
            if !(1..=60).contains(&count) {
                return Err(wrong(
                    "[abstraction]",
                    &"an abstraction has 1 to 60 propositions",
                ));
            }
            if !(0.0..1e6).contains(&abstraction.shortest_secs) {
                let message = format!(
                    "`shortest_secs` must be from 0 to less than 1e6 (got {})",
                    abstraction.shortest_secs
                );
                return Err(wrong("shortest_secs", &message));
            }
        }
        if self.data.designs.is_empty() {
            return Err(wrong("designs", &"name at least one design"));
        }
        if self.data.budget.batch == 0 || self.data.budget.episodes == 0 {
            return Err(wrong(
                "[budget]",
                &"a batch and the budget have at least one episode",
            ));
        }
        Ok(())
    }

    /// Checks that what this file gives a meaning to is a word of the study.
    ///
    /// # Errors
    /// Each word that is not, at its place.
    pub fn check_triggers(&self, study: &Study) -> Result<(), Problem> {
        let known = || study.vocabulary.propositions.keys().map(String::as_str);
        let mut found = Problems::new();
        for trigger in &self.data.trigger {
            let word = trigger.when.get_ref().as_str();
            if known().any(|it| it == word) {
                continue;
            }
            let message = format!("the vocabulary has no proposition `{word}`");
            let problem =
                Problem::new("unknown-proposition", message).at(&self.source, trigger.when.span());
            found.add(match did_you_mean(word, known()) {
                Some(similar) => problem.remedy(format!("did you mean `{similar}`?")),
                None => problem
                    .remedy("name what a requirement is triggered by, as vocabulary.toml has it"),
            });
        }
        found.or(())
    }

    /// What a word means to the model: as this file says, or else the study's
    /// vocabulary.
    pub fn meaning_in_model(&self, study: &Study, word: &str) -> Option<String> {
        let own = self.data.trigger.iter().find(|t| t.when.get_ref() == word);
        let mut propositions = self.data.abstraction.iter().flat_map(|a| &a.proposition);
        let abstracted = || propositions.find(|p| p.name == word)?.model.clone();
        let word = study.vocabulary.propositions.get(word);
        own.map(|trigger| trigger.model.clone())
            .or_else(abstracted)
            .or_else(|| Some(word?.model.as_ref()?.text.clone()))
    }

    /// Fails where a parameter sets what the bench does not have.
    pub fn fits(&self, bench: &OpenBench, disagreement: bool) -> Result<(), Problem> {
        let Some(test) = bench.own_tests().first() else {
            return Ok(());
        };
        let refused = |stimulus: &stimulus::Stimulus| bench.refuses(stimulus);
        let fits =
            |space: &Space| check_keys(space, test, &self.source, "bad-exploration", &refused);
        match &self.data.disagreement {
            Some(data) if disagreement => return fits(&data.space()),
            _ => fits(&self.space)?,
        }
        let mut of_searches = self.data.search.iter().filter_map(SearchData::space);
        of_searches.try_for_each(|space| fits(&space))
    }

    /// The bench to search in, if it is another than `bench` itself, which is that of the full physics.
    pub fn searching(&self, bench: &OpenBench) -> Result<Option<OpenBench>, Problem> {
        SearchPhysics::choose(self.data.physics, || bench.in_fast_physics()).map_err(|message| {
            self.mistake("physics", message)
                .remedy("leave `physics` out")
        })
    }

    /// The ledger's entry whose bench is run, of the search for disagreement
    /// or else of the exploration.
    pub fn evidence(&self, disagreement: bool) -> &str {
        let other = self.data.disagreement.as_ref().filter(|_| disagreement);
        other
            .and_then(|data| data.evidence.as_ref())
            .unwrap_or(&self.data.evidence)
    }

    /// The sources that the file has data for, or those that it names.
    pub fn sources(&self) -> Vec<SourceKind> {
        if let Some(named) = &self.data.sources {
            return named.clone();
        }
        let model = self.data.model.is_some() && !self.mapping.rules.is_empty();
        let grammar = self.data.grammar.is_some();
        let there = [
            (SourceKind::Own, true),
            (SourceKind::Goals, model && !self.data.goal.is_empty()),
            (SourceKind::Triggers, model),
            (
                SourceKind::Transitions,
                model && self.data.abstraction.is_some(),
            ),
            (SourceKind::Faults, true),
            (SourceKind::Random, grammar),
            (SourceKind::Agents, !self.data.agent.is_empty()),
            (SourceKind::Mutation, grammar),
            (SourceKind::Search, !self.data.search.is_empty()),
        ];
        let there = there.into_iter().filter(|(_, is_there)| *is_there);
        there.map(|(kind, _)| kind).collect()
    }
}
