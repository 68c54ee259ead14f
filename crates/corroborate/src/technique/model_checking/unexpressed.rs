//! Meanings of the vocabulary that no model of a study has.

use super::Compiled;
use crate::technique::Propositions;
use diagnostic::Problem;
use evidence::Subject;
use study::{Study, quoted_names};

/// What no model of a study expresses. A name that no model knows is a mistake, not an abstraction; but a failure mode may name a
/// value that no model has yet, since that is what a model that does not know it lacks.
#[derive(Debug, Default)]
pub struct Unexpressed {
    /// What has to be corrected.
    pub mistakes: Vec<Problem>,
    /// What may be a model's lack.
    pub warnings: Vec<Problem>,
}

impl Unexpressed {
    /// What none of all models of a study expresses.
    pub fn by(study: &Study, models: &[Compiled<'_>]) -> Self {
        let models: Vec<Propositions<'_>> = models.iter().map(Compiled::propositions).collect();
        Self::of(study, &models)
    }

    /// The same, by what each model expresses.
    pub(crate) fn of(study: &Study, models: &[Propositions<'_>]) -> Self {
        let mut found = Self::default();
        for (name, proposition) in &study.vocabulary.propositions {
            let (Some(binding), Some(first)) = (&proposition.model, models.first()) else {
                continue;
            };
            if models.iter().any(|m| m.expressed.contains(name.as_str())) {
                continue;
            }
            let reason = first.not_expressed.get(name.as_str());
            let reason = reason.map_or("it cannot be evaluated", String::as_str);
            let at = |message: String| {
                Problem::new("unknown-name", message)
                    .at(&study.vocabulary.source, binding.span.clone())
            };
            match is_a_failure(study, name) {
                true => found.warnings.push(
                    at(format!("no model of the study knows `{name}`: {reason}.")).remedy(
                        "Correct the name; if the model lacks it, `corroborate refine` may offer it.",
                    ),
                ),
                false => found.mistakes.push(
                    at(format!("no model of the study expresses `{name}`: {reason}"))
                        .remedy("correct the name, or remove the `model` binding"),
                ),
            }
        }
        found
    }
}

/// Whether a proposition is all that some failure mode's occurrence asks for.
fn is_a_failure(study: &Study, proposition: &str) -> bool {
    let modes = study.forms.subjects.iter();
    let mut modes = modes.filter(|form| matches!(form.subject, Subject::FailureMode(_)));
    modes.any(|form| {
        let names = form.property.as_ref().map(|p| quoted_names(&p.text));
        matches!(names.as_deref(), Some([(only, _)]) if only == proposition)
    })
}
