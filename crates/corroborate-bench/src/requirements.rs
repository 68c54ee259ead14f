//! What is required of a task, each requirement in all its forms.
//!
//! The sentence is the source. The property and the monitor are made from it by `requirement-lang`, unless a
//! fault gives one of them a sentence of its own: then that form means something else.

use crate::study::MARGIN;
use crate::task::STEPS_PER_SEC;
use evidence::{FailureMode, Requirement};
use requirement_lang::compile::monitor::{Monitor, monitor};
use requirement_lang::compile::property::{Model, label_of_name, property};
use requirement_lang::{Context, parse};

/// The identifiers of the requirements.
pub mod id {
    /// The task is done.
    pub const DONE: &str = "done";
    /// It is done in time.
    pub const IN_TIME: &str = "in-time";
    /// It is done if the person is ready.
    pub const READY: &str = "ready";
    /// The hand is slow near the person.
    pub const SLOW: &str = "slow";
}

/// One requirement with its forms, as sentences.
#[derive(Clone, Debug)]
pub struct Forms {
    /// The requirement.
    pub id: &'static str,
    /// What is meant.
    pub sentence: String,
    /// What the property says, if something else.
    pub property: Option<String>,
    /// What the monitor says, if something else.
    pub monitor: Option<String>,
    /// By how much the monitor's clock is faster than time.
    pub clock: f64,
    /// Whether a formal model can speak of it.
    pub is_formal: bool,
}

impl Forms {
    fn new(id: &'static str, sentence: String, is_formal: bool) -> Self {
        Self {
            id,
            sentence,
            property: None,
            monitor: None,
            clock: 1.0,
            is_formal,
        }
    }

    /// Whether all its forms are those of the sentence.
    #[must_use]
    pub fn is_sentence(&self) -> bool {
        self.property.is_none() && self.monitor.is_none() && self.clock == 1.0
    }

    /// The property in the PRISM language.
    ///
    /// # Errors
    /// What is wrong with the sentence.
    pub fn query(&self) -> Result<String, String> {
        let text = self.property.as_ref().unwrap_or(&self.sentence);
        let context = Context::default();
        let sentence = parse(text, &context).into_result();
        let sentence = sentence.map_err(|found| format!("{found:?}"))?;
        let model = Model {
            step_secs: Some(1.0 / f64::from(STEPS_PER_SEC)),
            proposition: &label_of_name,
        };
        let property = property(&sentence, &model).map_err(|error| error.to_string())?;
        Ok(property.query())
    }
}

/// A sentence as a monitor.
///
/// # Errors
/// What is wrong with the sentence.
pub fn monitor_of(text: &str) -> Result<Monitor, String> {
    let sentence = parse(text, &Context::default()).into_result();
    let sentence = sentence.map_err(|found| format!("{found:?}"))?;
    monitor(&sentence).map_err(|error| error.to_string())
}

/// The sentence of "in time", for a limit in steps.
#[must_use]
pub fn in_time(limit_steps: u32) -> String {
    let secs = f64::from(limit_steps) / f64::from(STEPS_PER_SEC);
    format!("The robot shall within {secs} s satisfy done.")
}

/// The requirements of a task.
#[must_use]
pub fn requirements(limit_steps: u32) -> Vec<Forms> {
    vec![
        Forms::new(
            id::DONE,
            "The robot shall eventually satisfy done.".into(),
            true,
        ),
        Forms::new(id::IN_TIME, in_time(limit_steps), true),
        Forms::new(
            id::READY,
            "When ready, the robot shall eventually satisfy done.".into(),
            true,
        ),
        Forms::new(
            id::SLOW,
            "When near, the robot shall immediately satisfy slow.".into(),
            false,
        ),
    ]
}

/// The requirements as a study states them.
#[must_use]
pub fn stated(forms: &[Forms]) -> Vec<Requirement> {
    forms
        .iter()
        .map(|form| Requirement {
            id: form.id.to_owned(),
            text: form.sentence.clone(),
            threshold: None,
            sentence: Some(form.sentence.clone()),
            property: form.property.clone(),
            monitor: form.monitor.clone(),
            margin: MARGIN,
            asks_for: None,
            same_quantity_as: None,
            ..Requirement::default()
        })
        .collect()
}

/// The failure modes as a study states them.
#[must_use]
pub fn failure_modes(modes: &[String]) -> Vec<FailureMode> {
    modes
        .iter()
        .map(|mode| FailureMode {
            id: mode.clone(),
            name: mode.clone(),
            meaning: "Counted against the runs that reach its stage.".into(),
            margin: MARGIN,
        })
        .collect()
}
