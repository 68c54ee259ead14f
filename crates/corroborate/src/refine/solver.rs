//! What a model would answer if it had another text.

use crate::technique::model_checking::Compiled;
use diagnostic::{Problem, Source};
use host::Cancel;
use refinement::Values;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::Path;
use study::Study;

/// Solves texts of one study's models, each once.
pub struct Solver<'a> {
    study: &'a Study,
    interrupt: &'a Cancel,
    known: RefCell<BTreeMap<String, Values>>,
    failed: RefCell<Option<Problem>>,
}

impl<'a> Solver<'a> {
    /// Asks the study's questions, until the user wants to stop.
    pub fn new(study: &'a Study, interrupt: &'a Cancel) -> Self {
        Self {
            study,
            interrupt,
            known: RefCell::default(),
            failed: RefCell::default(),
        }
    }

    /// Parses, checks and solves a model's text.
    pub fn values(&self, path: &Path, text: &str) -> Result<Values, Problem> {
        if let Some(known) = self.known.borrow().get(text) {
            return Ok(known.clone());
        }
        let source = Source {
            name: path.display().to_string(),
            text: text.to_owned(),
        };
        let compiled = Compiled::of_source(self.study, source)?;
        let values = compiled.values_at(&[], &|| self.interrupt.is_cancelled())?;
        let mut known = self.known.borrow_mut();
        known.insert(text.to_owned(), values.clone());
        Ok(values)
    }

    /// The same for texts of the model of this file.
    pub fn at<'p>(&'p self, path: &'p Path) -> Of<'p> {
        Of { solver: self, path }
    }

    /// The problem behind the last text that could not be solved, with its place and remedy.
    pub fn problem(&self, reason: String) -> Problem {
        let failed = self.failed.borrow_mut().take();
        failed.unwrap_or_else(|| Problem::new("cannot-refine", reason))
    }
}

/// Solves texts of one model.
pub struct Of<'p> {
    solver: &'p Solver<'p>,
    path: &'p Path,
}

impl refinement::Solver for Of<'_> {
    fn values(&self, text: &str) -> Result<Values, String> {
        self.solver.values(self.path, text).map_err(|problem| {
            let line = problem.warning_line();
            *self.solver.failed.borrow_mut() = Some(problem);
            line
        })
    }
}
