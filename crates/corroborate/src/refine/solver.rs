//! What a model would answer if it had another text.

use crate::technique::model_checking::Compiled;
use diagnostic::{Problem, Source};
use host::Cancel;
use refinement::Values;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use study::Study;

/// Solves texts of one study's models, each once.
pub struct Solver<'a> {
    study: &'a Study,
    interrupt: &'a Cancel,
    known: RefCell<BTreeMap<String, Values>>,
    /// Whether the first text of each model, the one that is there, has states in which nothing can happen.
    deadlocked: RefCell<BTreeMap<PathBuf, bool>>,
    failed: RefCell<Option<Problem>>,
}

impl<'a> Solver<'a> {
    /// Asks the study's questions, until the user wants to stop.
    pub fn new(study: &'a Study, interrupt: &'a Cancel) -> Self {
        Self {
            study,
            interrupt,
            known: RefCell::default(),
            deadlocked: RefCell::default(),
            failed: RefCell::default(),
        }
    }

    /// Parses, checks and solves a model's text.
    ///
    /// # Errors
    /// What the text says wrong; `cannot-refine` if it comes to a state in which nothing can happen and the model's first text
    /// does not: such a change is a mistake, whatever it makes agree.
    pub fn values(&self, path: &Path, text: &str) -> Result<Values, Problem> {
        if let Some(known) = self.known.borrow().get(text) {
            return Ok(known.clone());
        }
        let source = Source {
            name: path.display().to_string(),
            text: text.to_owned(),
        };
        let compiled = Compiled::of_source(self.study, source)?;
        let (values, deadlocks) =
            compiled.values_and_deadlocks(&[], &|| self.interrupt.is_cancelled())?;
        let is_deadlocked = deadlocks > 0;
        let mut known_of = self.deadlocked.borrow_mut();
        let was = *known_of.entry(path.to_owned()).or_insert(is_deadlocked);
        if is_deadlocked && !was {
            let name = path.display();
            return Err(Problem::new(
                "cannot-refine",
                format!("{name} would come to a state in which nothing can happen"),
            ));
        }
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
