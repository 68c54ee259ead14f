//! `corroborate language-server`: an editor is answered.

use super::Done;
use crate::args::LanguageServer;
use corroborate::Outcome;
use corroborate::technique::model_checking::{Compiled, Unexpressed};
use diagnostic::{Problem, Source};
use language_server::{Ended, Engine, Mistakes};
use serde_json::Value;
use std::io::{BufReader, BufWriter, stdin, stdout};
use study::Study;

/// What the engine knows above texts.
struct Knowledge;

impl Engine for Knowledge {
    fn mistakes(&self, study: &Study, models: Vec<Source>, are_all: bool) -> Mistakes {
        let (mut compiled, mut problems) = (Vec::new(), Vec::new());
        for model in models {
            match Compiled::of_source(study, model) {
                Ok(model) => compiled.push(model),
                Err(problem) => problems.extend(problem.into_each()),
            }
        }
        // Without one of the models, what it expresses is not known.
        if !are_all || !problems.is_empty() {
            return Mistakes {
                problems,
                warnings: Vec::new(),
            };
        }
        let found = Unexpressed::by(study, &compiled);
        Mistakes {
            problems: found.mistakes,
            warnings: found.warnings,
        }
    }

    fn schemas(&self) -> Vec<(&'static str, Value)> {
        let files = corroborate::schemas::files().into_iter();
        files.map(|it| (it.name, it.schema.into())).collect()
    }

    fn explanation(&self, code: &str) -> Option<String> {
        crate::explain::text(code)
    }
}

/// Answers an editor until it has enough.
pub fn language_server(_: &LanguageServer) -> Result<Done, Problem> {
    let input = BufReader::new(stdin());
    let output = BufWriter::new(stdout());
    let ended = language_server::serve(input, output, Box::new(Knowledge)).map_err(|error| {
        let message = format!("the editor's messages cannot be read: {error}");
        Problem::new("editor-lost", message)
            .remedy("let an editor start it: it speaks the Language Server Protocol, not to people")
    })?;
    match ended {
        Ended::AsAsked => Ok(Done {
            output: String::new(),
            outcome: Outcome::Holds,
        }),
        Ended::Abruptly => Err(Problem::new(
            "editor-lost",
            "the editor's messages ended without `shutdown`",
        )
        .remedy("restart the editor if it is still there")),
    }
}
