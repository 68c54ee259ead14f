//! What the scheduler of the worst case does, as a stimulus to try in simulation.
//!
//! # Definition
//! Where a decision process misses a requirement's threshold under some scheduler, the worst scheduler (of the least
//! probability where the requirement asks for at least something, of the greatest where for at most) has a most probable
//! path on which the requirement fails (`checker::scheduler::Scheduler::path`). Its steps are the actions that the scheduler
//! chooses and what they change. Those that `exploration.toml` maps to actions of a bench (`[[step]]` tables) are an
//! abstract test, in the form of a finding, which `replay` runs and judges.
//!
//! # Assumes
//! `exploration.toml` maps actions to what the bench does for them.
//!
//! # Guarantee
//! The path is one of the model. That the bench goes the same way is not said: the test does what the environment does on
//! the path, the system does what it does. A path is a witness; how often the bench shows it is no rate.

use super::{Compiled, MAX_STEPS_SHOWN, Question};
use crate::technique::exploration::{OpenBench, Plan, path_step};
use crate::technique::simulation::Seeds;
use checker::paths::{Path as ModelPath, PathSteps, Step};
use checker::scheduler::ScheduledPath;
use checker::state_space::StateSpace;
use checker::{CheckError, Options};
use diagnostic::Problem;
use evidence::{CERTAINTY, Direction, Finding, Guarantee, Measure, Subject, Threshold, WorstCase};
use host::store::Inputs;
use prism_lang::ast::Optimum;
use std::path::Path;
use stimulus::Stimulus;
use study::{Expected, Finding as FindingFile, FormText, Shows};

/// The file that says which steps of a model are actions of a bench.
const EXPLORATION: &str = "exploration.toml";

/// The folder of the results in a study.
const RESULTS: &str = "results/";

impl Compiled<'_> {
    /// Adds what the worst scheduler does to each requirement whose threshold it misses.
    pub(super) fn add_worst_cases(
        &self,
        id: &str,
        space: &StateSpace<f64>,
        findings: &mut [Finding],
        cancel: &(dyn Fn() -> bool + Sync),
    ) -> Result<(), Problem> {
        if !self.model.model_type.has_choices() {
            return Ok(());
        }
        for question in &self.questions {
            let of = |finding: &&mut Finding| &finding.subject == question.subject;
            let Some(finding) = findings.iter_mut().find(of) else {
                continue;
            };
            let Some(threshold) = self.threshold(question.subject) else {
                continue;
            };
            let Measure::Probability { answer, .. } = &mut finding.measure else {
                continue;
            };
            let Guarantee::Schedulers { low, high, worst } = &mut answer.guarantee else {
                continue;
            };
            let misses = match threshold.direction {
                Direction::AtLeast => *low < threshold.value - CERTAINTY,
                Direction::AtMost => *high > threshold.value + CERTAINTY,
            };
            if misses {
                let case = self.worst_case(id, question, threshold, space, cancel)?;
                *worst = Some(Box::new(case));
            }
        }
        Ok(())
    }

    fn threshold(&self, subject: &Subject) -> Option<Threshold> {
        let Subject::Requirement(id) = subject else {
            return None;
        };
        let mut requirements = self.study.requirements.iter();
        requirements.find(|it| &it.id == id)?.threshold
    }

    fn worst_case(
        &self,
        id: &str,
        question: &Question<'_>,
        threshold: Threshold,
        space: &StateSpace<f64>,
        cancel: &(dyn Fn() -> bool + Sync),
    ) -> Result<WorstCase, Problem> {
        let (optimum, satisfies) = match threshold.direction {
            Direction::AtLeast => (Optimum::Min, false),
            Direction::AtMost => (Optimum::Max, true),
        };
        let found = self.worst_path(question, optimum, satisfies, space, cancel)?;
        let path = match found {
            Ok(path) => path,
            Err(reason) => {
                return Ok(WorstCase {
                    probability: None,
                    steps: Vec::new(),
                    file: None,
                    test: None,
                    note: format!("no path of the worst scheduler is shown: {reason}"),
                });
            }
        };
        let steps = self.steps(space, &path)?;
        let words = steps.iter().zip(self.actions(space, &path));
        let mut words: Vec<String> = words
            .map(|(step, action)| in_words(step, action.as_deref()))
            .collect();
        if words.len() > MAX_STEPS_SHOWN {
            let more = words.len() - MAX_STEPS_SHOWN;
            words.truncate(MAX_STEPS_SHOWN);
            words.push(format!("and {more} more steps"));
        }
        let case = WorstCase {
            probability: Some(path.probability),
            steps: words,
            file: None,
            test: None,
            note: String::new(),
        };
        let enacted = self.enacted(id, question.subject.id(), (&path, &steps))?;
        Ok(match enacted {
            Ok((file, test)) => WorstCase {
                note: format!("`corroborate replay . {file}` tries it in simulation"),
                file: Some(file),
                test: Some(test),
                ..case
            },
            Err(reason) => WorstCase {
                note: format!("no bench can try it: {reason}"),
                ..case
            },
        })
    }

    /// The path, or why there is none.
    fn worst_path(
        &self,
        question: &Question<'_>,
        optimum: Optimum,
        satisfies: bool,
        space: &StateSpace<f64>,
        cancel: &(dyn Fn() -> bool + Sync),
    ) -> Result<Result<ScheduledPath, String>, Problem> {
        let options = Options {
            cancel: Some(cancel),
            ..Options::default()
        };
        let asked = |text: &FormText| self.property_over(&self.model, text, optimum);
        // Given the trigger where that is asked; else, or where that has no scheduler, over all runs.
        let texts = [question.texts().0, question.property];
        let mut scheduler = Err(CheckError::NoInitialState);
        for text in texts {
            scheduler = checker::scheduler::scheduler(space, &asked(text)?, &options);
            if scheduler.is_ok() {
                break;
            }
        }
        let own = asked(question.property)?;
        let path = scheduler.and_then(|found| found.path(space, &own, satisfies, &options));
        match path {
            Err(CheckError::Cancelled) => Err(Problem::interrupted()),
            Err(error) => Ok(Err(error.to_string())),
            Ok(None) => Ok(Err(
                "its formula must be F, G, U, W or R over states, without a bound where it fails by running out"
                    .to_owned(),
            )),
            Ok(Some(path)) => Ok(Ok(path)),
        }
    }

    /// What happens on the path: of each step the causes with the action that the scheduler takes.
    fn steps(&self, space: &StateSpace<f64>, path: &ScheduledPath) -> Result<Vec<Step>, Problem> {
        let through = ModelPath {
            states: path.states.clone(),
            probability: path.probability,
        };
        let mut steps = PathSteps::new(&self.model, space, &through)
            .map_err(|error| Problem::new("cannot-check", error.to_string()))?
            .steps;
        for (step, action) in steps.iter_mut().zip(self.actions(space, path)) {
            step.causes.retain(|cause| cause.action == action);
        }
        Ok(steps)
    }

    fn actions(&self, space: &StateSpace<f64>, path: &ScheduledPath) -> Vec<Option<String>> {
        let action = |row: &usize| Some(space.actions()[space.action(*row)?].clone());
        path.rows.iter().map(action).collect()
    }

    /// The file of the results and its text, or why the bench knows none of it.
    fn enacted(
        &self,
        id: &str,
        requirement: &str,
        (path, steps): (&ScheduledPath, &[Step]),
    ) -> Result<Result<(String, String), String>, Problem> {
        let study = self.study;
        if !study.folder.join(EXPLORATION).is_file() {
            return Ok(Err(format!(
                "the study has no {EXPLORATION} whose [[step]] tables say which steps of {id} are actions of a test"
            )));
        }
        let plan = match Plan::of_study(study, Path::new(EXPLORATION)) {
            Ok(plan) => plan,
            Err(problem) => return Ok(Err(problem.warning_line())),
        };
        let name = format!("worst case of {id} for requirement {requirement}");
        let of_test: Vec<_> = steps.iter().map(|it| path_step(&self.model, it)).collect();
        let made = plan.mapping.test(&name, &of_test);
        if made.test.actions.is_empty() {
            return Ok(Err(format!(
                "no [[step]] table of {EXPLORATION} knows a step of it ({})",
                unknown(steps).join(", ")
            )));
        }
        if (study.forms.by_id(requirement)).is_none_or(|form| form.monitor.is_none()) {
            return Ok(Err(format!(
                "requirement {requirement} has no monitor that would judge the episode"
            )));
        }
        let evidence = &plan.data.evidence;
        let bench = study.entry(evidence).and_then(OpenBench::files_of);
        let bench = match bench {
            Ok(bench) => bench,
            Err(problem) => return Ok(Err(problem.warning_line())),
        };
        let finding = FindingFile {
            found_by: format!("{name}, on a path with probability {}", path.probability),
            program: env!("CARGO_PKG_VERSION").to_owned(),
            seed: Seeds::new(study.about.seed, evidence).of(1),
            bench,
            shows: Shows::Violated(requirement.to_owned()),
            expected: Expected::Fails,
            recording: None,
            stimulus: Stimulus::of(made.test),
        };
        let text = finding.to_toml(&format!(
            "What the worst scheduler of {id} does on the most probable path on which requirement {requirement} fails.\n\
             {} of its {} steps are not part of a test: the system's own, or time.",
            made.unmapped.len(),
            steps.len()
        ))?;
        Ok(Ok((
            format!("{RESULTS}worst/{id}-{requirement}.toml"),
            text,
        )))
    }

    /// What the worst cases depend on beside the model.
    pub(super) fn inputs_of_worst_cases(&self, inputs: &mut Inputs) {
        if self.model.model_type.has_choices() {
            for question in &self.questions {
                inputs.add_json("threshold", &self.threshold(question.subject));
            }
            let plan = std::fs::read(self.study.folder.join(EXPLORATION)).unwrap_or_default();
            inputs.add("exploration", &plan);
        }
    }
}

/// The tests of worst cases: each file, relative to the results folder, with its text.
pub fn tests(findings: &[Finding]) -> impl Iterator<Item = (&str, &str)> {
    worst_cases(findings).filter_map(|(_, case)| {
        let file = case.file.as_deref()?.strip_prefix(RESULTS)?;
        Some((file, case.test.as_deref()?))
    })
}

/// The worst cases among findings, with their subjects.
fn worst_cases(findings: &[Finding]) -> impl Iterator<Item = (&Subject, &WorstCase)> {
    findings.iter().filter_map(|finding| {
        let Measure::Probability { answer, .. } = &finding.measure else {
            return None;
        };
        let Guarantee::Schedulers { worst, .. } = &answer.guarantee else {
            return None;
        };
        Some((&finding.subject, worst.as_deref()?))
    })
}

/// One line for each worst case.
pub fn in_lines(id: &str, findings: &[Finding]) -> Vec<String> {
    let line = |(subject, case): (&Subject, &WorstCase)| {
        let steps = match case.steps.is_empty() {
            true => String::new(),
            false => format!("{}; ", case.steps.join("; ")),
        };
        format!(
            "{id:<13} worst scheduler for {}: {steps}{}",
            subject.id(),
            case.note
        )
    };
    worst_cases(findings).map(line).collect()
}

/// `[action] name: 0 -> 1`.
fn in_words(step: &Step, action: Option<&str>) -> String {
    let changes = step.changes.iter();
    let changes: Vec<String> = changes
        .map(|change| format!("{}: {} -> {}", change.variable, change.from, change.to))
        .collect();
    let changes = match changes.is_empty() {
        true => "nothing changes".to_owned(),
        false => changes.join(", "),
    };
    match action.filter(|action| !action.is_empty()) {
        Some(action) => format!("[{action}] {changes}"),
        None => changes,
    }
}

/// The actions and changes that a mapping would have to name, each once.
fn unknown(steps: &[Step]) -> Vec<String> {
    let mut found: Vec<String> = Vec::new();
    for step in steps {
        let action = step.causes.first().and_then(|cause| cause.action.clone());
        let words = action.unwrap_or_else(|| in_words(step, None));
        if !found.contains(&words) {
            found.push(words);
        }
    }
    found.truncate(8);
    found
}
