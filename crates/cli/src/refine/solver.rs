//! What a model would answer if it had another text.

use crate::problem::{Problem, Source};
use crate::study::Study;
use crate::talk::Interrupt;
use crate::technique::model_checking::Compiled;
use evidence::Subject;
use std::collections::BTreeMap;
use std::path::Path;

/// The answers to a study's questions; `None` where the model cannot be asked.
pub type Values = BTreeMap<Subject, Option<f64>>;

/// Solves texts of one model.
pub struct Solver<'a> {
    /// The study whose questions are asked.
    pub study: &'a Study,
    /// Whether the user wants to stop.
    pub interrupt: &'a Interrupt,
}

impl Solver<'_> {
    /// Parses, checks and solves a model's text.
    pub fn values(&self, path: &Path, text: &str) -> Result<Values, Problem> {
        let source = Source {
            name: path.display().to_string(),
            text: text.to_owned(),
        };
        let compiled = Compiled::of_source(self.study, source)?;
        compiled.values_at(&[], &|| self.interrupt.is_set())
    }
}
