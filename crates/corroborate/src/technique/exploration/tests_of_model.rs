//! Abstract tests from a formal model's paths.

use super::abstraction::Abstraction;
use super::formal::{Formal, Meaning};
use super::plan::{Plan, SourceKind};
use super::triggers::triggers;
use campaign::PathStep;
use checker::paths::{Path, PathSteps, most_probable_path, transition_cover};
use diagnostic::Problem;
use host::Cancel;
use prism_lang::resolved::{self, VariableKind};
use std::collections::BTreeMap;
use stimulus::{AbstractTest, Setting};
use study::Study;

/// A path of a tour is not gone on with beyond so many transitions.
const LONGEST_TOUR: usize = 500;

/// A test made from a path.
#[derive(Clone, Debug)]
pub struct ModelTest {
    /// What led to it.
    pub kind: SourceKind,
    /// The goals that it is to reach, in words.
    pub goals: Vec<String>,
    /// The test.
    pub test: AbstractTest,
    /// How many transitions the path has.
    pub transitions: usize,
    /// The path's probability.
    pub probability: f64,
    /// Steps that are no actions of a test: the system's own, or time.
    pub unmapped: usize,
}

/// Tests from the model, and the goals that gave none, with the reason.
#[derive(Debug, Default)]
pub struct ModelTests {
    /// The tests, no two with the same content.
    pub tests: Vec<ModelTest>,
    /// Goals without a test.
    pub without: Vec<(String, String)>,
    /// Transition coverage: classes, paths, transitions of all paths.
    pub cover: Option<(usize, usize, usize)>,
}

/// Makes tests for those sources of the plan that need the model.
pub fn tests_of_model(
    study: &Study,
    plan: &Plan,
    formal: &Formal,
    abstraction: Option<&Abstraction>,
    kinds: &[SourceKind],
    interrupt: &Cancel,
) -> Result<ModelTests, Problem> {
    let mut maker = Maker {
        plan,
        formal,
        made: ModelTests::default(),
    };
    if kinds.contains(&SourceKind::Goals) {
        for goal in &plan.data.goal {
            maker.goal(SourceKind::Goals, &goal.name, &goal.model)?;
        }
    }
    if kinds.contains(&SourceKind::Triggers) {
        for trigger in triggers(study, plan) {
            match &trigger.model {
                Ok(text) => maker.goal(SourceKind::Triggers, &trigger.name(), text)?,
                Err(reason) => maker.none(trigger.name(), reason.clone()),
            }
        }
    }
    if let Some(abstraction) = abstraction.filter(|_| kinds.contains(&SourceKind::Transitions)) {
        maker.cover(abstraction, interrupt)?;
    }
    Ok(maker.made)
}

struct Maker<'a> {
    plan: &'a Plan,
    formal: &'a Formal,
    made: ModelTests,
}

impl Maker<'_> {
    fn none(&mut self, goal: String, reason: String) {
        self.made.without.push((goal, reason));
    }

    /// The most probable path to where an expression holds.
    fn goal(&mut self, kind: SourceKind, name: &str, text: &str) -> Result<(), Problem> {
        let flags = match self.formal.meaning(text)? {
            Meaning::Holds(flags) => flags,
            Meaning::Unknown(reason) => {
                self.none(name.into(), reason);
                return Ok(());
            }
        };
        match most_probable_path(&self.formal.space, &flags) {
            Some(path) => self.add(kind, name, &path),
            None => {
                self.none(name.into(), "the model never reaches it".into());
                Ok(())
            }
        }
    }

    /// Paths that take every abstract transition, and in each abstract state
    /// every change of the model that is an action of a test.
    fn cover(&mut self, abstraction: &Abstraction, interrupt: &Cancel) -> Result<(), Problem> {
        let space = &self.formal.space;
        let watched = self.watched();
        let class = |from: usize, to: usize| {
            let (a, b) = (abstraction.class_of[from], abstraction.class_of[to]);
            if a != b {
                return Some((a, b, usize::MAX));
            }
            let change = watched.iter().position(|(variable, value)| {
                space.value(to, *variable) == *value && space.value(from, *variable) != *value
            });
            change.map(|rule| (a, b, rule))
        };
        let cover = transition_cover(space, class, LONGEST_TOUR, &|| interrupt.is_cancelled());
        if interrupt.is_cancelled() {
            return Err(Problem::interrupted());
        }
        self.made.cover = Some((cover.classes, cover.paths.len(), cover.length));
        for (number, path) in cover.paths.iter().enumerate() {
            let name = format!("tour {} of the model's transitions", number + 1);
            self.add(SourceKind::Transitions, &name, path)?;
        }
        Ok(())
    }

    /// Changes of variables that rules of the mapping name.
    fn watched(&self) -> Vec<(usize, i64)> {
        let changes = self.plan.mapping.rules.iter().flat_map(|r| &r.changes);
        let watched = changes.filter_map(|(name, value)| {
            let variable = self.formal.model.variable(name)?;
            let value = match value {
                Setting::Bool(value) => i64::from(*value),
                other => other.as_integer()?,
            };
            Some((variable, value))
        });
        watched.collect()
    }

    fn add(&mut self, kind: SourceKind, goal: &str, path: &Path<f64>) -> Result<(), Problem> {
        let steps = PathSteps::new(&self.formal.model, &self.formal.space, path)
            .map_err(|error| Problem::new("cannot-explore", error.to_string()))?;
        let model = &self.formal.model;
        let steps: Vec<PathStep> = steps.steps.iter().map(|s| path_step(model, s)).collect();
        let made = self.plan.mapping.test(goal, &steps);
        if made.test.actions.is_empty() {
            let reason = match steps.is_empty() {
                true => "the model begins there, so every test reaches it",
                false => "no step of its path is an action of a test",
            };
            self.none(goal.into(), reason.into());
            return Ok(());
        }
        let mut known = self.made.tests.iter_mut();
        match known.find(|known| known.test.actions == made.test.actions) {
            Some(same) => same.goals.push(goal.into()),
            None => self.made.tests.push(ModelTest {
                kind,
                goals: vec![goal.into()],
                test: made.test,
                transitions: steps.len(),
                probability: path.probability,
                unmapped: made.unmapped.len(),
            }),
        }
        Ok(())
    }
}

/// A step in the words of the mapping, by its most probable cause.
pub fn path_step(model: &resolved::Model, step: &checker::paths::Step) -> PathStep {
    let changes = step.changes.iter().map(|change| {
        let variable = model.variable(&change.variable);
        let kind = variable.map(|v| model.variables[v].kind);
        let value = match kind {
            Some(VariableKind::Bool) => Setting::Bool(change.to != 0),
            _ => Setting::Number(change.to as f64),
        };
        (change.variable.clone(), value)
    });
    let changes: BTreeMap<String, Setting> = changes.collect();
    match step.causes.first() {
        Some(cause) => PathStep {
            modules: cause.modules.clone(),
            action: cause.action.clone(),
            changes,
        },
        None => PathStep {
            changes,
            ..PathStep::default()
        },
    }
}
