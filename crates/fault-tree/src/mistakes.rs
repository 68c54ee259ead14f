//! The mistakes of one text: collected as they are met, placed at the end.
//!
//! To find line and column of a place takes a walk over the text. Only those that are shown are placed, so a text of a
//! hundred thousand mistakes costs fifty walks.

use std::ops::Range;

use diagnostic::{MOST_SHOWN, Problem, Source, did_you_mean};

/// Names among which a similar one is looked for.
const MOST_COMPARED: usize = 20_000;

/// A mistake before it is placed.
#[derive(Debug)]
struct Mistake {
    code: &'static str,
    span: Range<usize>,
    message: String,
    remedy: Remedy,
    related: Option<(Range<usize>, &'static str)>,
}

#[derive(Debug)]
enum Remedy {
    Text(String),
    /// The name that is not known; a similar one is looked for once the mistake is shown.
    SimilarTo(String),
}

/// The mistakes of one text.
#[derive(Debug)]
pub(crate) struct Mistakes<'a> {
    source: &'a Source,
    found: Vec<Mistake>,
}

impl<'a> Mistakes<'a> {
    pub fn new(source: &'a Source) -> Self {
        Self {
            source,
            found: Vec::new(),
        }
    }

    pub fn is_empty(&self) -> bool {
        self.found.is_empty()
    }

    /// What cannot be read.
    pub fn add(
        &mut self,
        span: Range<usize>,
        message: impl Into<String>,
        remedy: impl Into<String>,
    ) {
        self.push("bad-fault-tree", span, message.into(), remedy.into());
    }

    /// What is well-formed, and not part of what is computed here.
    pub fn refuse(
        &mut self,
        span: Range<usize>,
        message: impl Into<String>,
        remedy: impl Into<String>,
    ) {
        self.push(
            "unsupported-fault-tree",
            span,
            message.into(),
            remedy.into(),
        );
    }

    fn push(&mut self, code: &'static str, span: Range<usize>, message: String, remedy: String) {
        self.found.push(Mistake {
            code,
            span,
            message,
            remedy: Remedy::Text(remedy),
            related: None,
        });
    }

    /// A second place that matters for the last mistake.
    pub fn relate(&mut self, span: Range<usize>, note: &'static str) {
        if let Some(last) = self.found.last_mut() {
            last.related = Some((span, note));
        }
    }

    /// A name that nothing defines.
    pub fn undefined(&mut self, span: Range<usize>, name: &str) {
        self.found.push(Mistake {
            code: "bad-fault-tree",
            span,
            message: format!("`{name}` is not defined"),
            remedy: Remedy::SimilarTo(name.to_owned()),
            related: None,
        });
    }

    /// The mistakes in the order of their places, as one problem; `None` if there are none. `known` are the defined names.
    pub fn into_problem(self, known: &[&str]) -> Option<Problem> {
        let (shown, not_shown) = self.into_problems(known);
        Problem::all(shown).map(|problem| problem.and_more(not_shown))
    }

    /// Those that are shown, and how many are not.
    pub fn into_problems(mut self, known: &[&str]) -> (Vec<Problem>, usize) {
        self.found.sort_by_key(|it| it.span.start);
        let not_shown = self.found.len().saturating_sub(MOST_SHOWN);
        self.found.truncate(MOST_SHOWN);
        let source = self.source;
        let shown = self.found.into_iter().map(|it| it.placed(source, known));
        (shown.collect(), not_shown)
    }
}

impl Mistake {
    fn placed(self, source: &Source, known: &[&str]) -> Problem {
        let remedy = match self.remedy {
            Remedy::Text(text) => text,
            Remedy::SimilarTo(name) => {
                let known = if known.len() <= MOST_COMPARED {
                    known
                } else {
                    &[]
                };
                let similar = did_you_mean(&name, known.iter().copied());
                similar.map_or("define it, or correct its name".to_owned(), |it| {
                    format!("did you mean `{it}`?")
                })
            }
        };
        let related = self.related.into_iter();
        let related = related.map(|(span, note)| (span, note.to_owned()));
        Problem::new(self.code, self.message)
            .at_places(source, self.span, related.collect())
            .remedy(remedy)
    }
}
