//! What a model would answer if it had another text.

use crate::problem::{Problem, Source};
use crate::study::Study;
use crate::talk::Interrupt;
use crate::technique::model_checking::Compiled;
use refinement::Values;
use std::path::Path;

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

    /// The same for texts of the model of this file.
    pub fn at<'p>(&'p self, path: &'p Path) -> Of<'p> {
        Of { solver: self, path }
    }
}

/// Solves texts of one model.
pub struct Of<'p> {
    solver: &'p Solver<'p>,
    path: &'p Path,
}

impl refinement::Solver for Of<'_> {
    fn values(&self, text: &str) -> Result<Values, String> {
        let found = self.solver.values(self.path, text);
        found.map_err(|problem| problem.warning_line())
    }
}
