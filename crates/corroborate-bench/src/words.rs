//! The study's vocabulary for its formal models: what each proposition means over a model's variables.

use crate::family::{Family, HANDOVER};
use crate::journey;
use crate::requirements::{Forms, id};
use refinement::Asked;

/// The propositions of a study, as its formal models know them.
#[derive(Clone, Debug)]
pub struct Words {
    /// The states in which a run is done.
    done: &'static str,
    /// Those in which it is at its end.
    finished: &'static str,
    /// Whether the model's steps are the task's.
    has_steps: bool,
    /// What each failure mode means.
    pub asked: Vec<Asked>,
}

impl Words {
    /// The words of a family, for these failure modes.
    #[must_use]
    pub fn new(family: Family, modes: &[String]) -> Self {
        if family == Family::Handover {
            let asked = HANDOVER.iter().map(|it| Asked {
                mode: it.mode.to_owned(),
                occurs: Some(it.occurs.to_owned()),
                after: Some(it.after.to_owned()),
            });
            return Self {
                done: "robotState=handoverSuccessful",
                finished: "robotState=handoverSuccessful | robotState=handoverUnsuccessful | robotState=motionError \
                           | robotState=interactionDone | robotState=timedOut",
                has_steps: false,
                asked: asked.collect(),
            };
        }
        if family == Family::Corridor {
            let asked = journey::MODES.iter().map(|(mode, occurs, after)| Asked {
                mode: (*mode).to_owned(),
                occurs: Some((*occurs).to_owned()),
                after: Some((*after).to_owned()),
            });
            return Self {
                done: journey::DONE,
                finished: journey::DONE,
                has_steps: true,
                asked: asked.collect(),
            };
        }
        let asked = modes.iter().map(|mode| Asked {
            mode: mode.clone(),
            occurs: Some(format!("s=failed_{mode}")),
            after: Some(format!("s=at_{mode}")),
        });
        Self {
            done: "s=done",
            finished: "s>=done",
            has_steps: true,
            asked: asked.collect(),
        }
    }

    /// Whether the model's language has a requirement: time is steps only in the chains.
    #[must_use]
    pub fn expresses(&self, form: &Forms) -> bool {
        form.is_formal && (self.has_steps || form.id == id::DONE)
    }

    /// Labels for the properties of requirements.
    #[must_use]
    pub fn labels(&self) -> String {
        format!(
            "label \"ready\" = true;\nlabel \"done\" = {};\nlabel \"finished\" = {};\n",
            self.done, self.finished
        )
    }

    /// The two questions of a failure mode's rate: how often it occurs, and how often it could.
    #[must_use]
    pub fn questions(&self, mode: &str) -> Option<(String, String)> {
        let asked = self.asked.iter().find(|asked| asked.mode == mode)?;
        let eventually = |what: &Option<String>| Some(format!("P=? [ F ({}) ]", what.as_ref()?));
        Some((eventually(&asked.occurs)?, eventually(&asked.after)?))
    }
}
