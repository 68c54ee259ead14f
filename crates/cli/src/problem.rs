//! What the user can mend: one message with its place and a remedy.
//!
//! Every error that leaves a command is a [`Problem`]. It is handled once, in
//! `main`, which prints it and chooses the exit code.

use annotate_snippets::{AnnotationKind, Group, Level, Renderer, Snippet};
use std::fmt;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// A text with the name under which the user knows it.
#[derive(Clone, Debug)]
pub struct Source {
    /// The path as the user would type it, or for example `<property>`.
    pub name: String,
    /// The content.
    pub text: String,
}

impl Source {
    /// Reads a file as text.
    pub fn read(path: &Path) -> Result<Self, Problem> {
        let name = path.display().to_string();
        match std::fs::read(path) {
            Ok(bytes) => match String::from_utf8(bytes) {
                Ok(text) => Ok(Self { name, text }),
                Err(error) => Err(Problem::new(
                    "not-text",
                    format!(
                        "{name} is not UTF-8 text (first bad byte at offset {})",
                        error.utf8_error().valid_up_to()
                    ),
                )
                .remedy("save the file as UTF-8, or check that it is the file you mean")),
            },
            Err(error) => Err(Problem::cannot_read(path, &error)),
        }
    }
}

/// A place in a source.
#[derive(Clone, Debug)]
pub struct Place {
    source: Source,
    span: Range<usize>,
    related: Vec<(Range<usize>, String)>,
}

/// What went wrong, where, and what to do about it.
#[derive(Clone, Debug)]
pub struct Problem {
    /// Names the kind of problem; `corroborate explain CODE` says more.
    pub code: &'static str,
    message: String,
    place: Option<Box<Place>>,
    remedy: Option<String>,
    /// Further problems of the same input.
    others: Vec<Problem>,
    kind: Kind,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Input,
    DataLost,
    Undecided,
    Interrupted,
}

impl Problem {
    /// A problem with the input or the call: exit code 2.
    pub fn new(code: &'static str, message: impl Into<String>) -> Self {
        Self {
            code,
            message: message.into(),
            place: None,
            remedy: None,
            others: Vec::new(),
            kind: Kind::Input,
        }
    }

    /// The user interrupted the work: exit code 130.
    pub fn interrupted() -> Self {
        Self {
            kind: Kind::Interrupted,
            ..Self::new("interrupted", "interrupted")
        }
    }

    /// The same, with how far the work came.
    pub fn interrupted_while(doing: &str) -> Self {
        Self {
            message: format!("interrupted while {doing}"),
            ..Self::interrupted()
        }
    }

    /// Whether the user interrupted the work.
    pub fn is_interruption(&self) -> bool {
        self.kind == Kind::Interrupted
    }

    /// What is wrong, without its place.
    pub fn message(&self) -> &str {
        &self.message
    }

    /// What is wrong, in one line, with its place.
    pub fn line(&self) -> String {
        let line = self.warning_line();
        line.strip_prefix("warning: ")
            .map_or(line.clone(), str::to_owned)
    }

    /// An interruption of work whose finished parts are kept.
    pub fn resumable(self) -> Self {
        if self.kind == Kind::Interrupted {
            self.remedy("run the same command again to go on where it stopped")
        } else {
            self
        }
    }

    /// Work was done but a result could not be kept: exit code 3.
    pub fn data_lost(code: &'static str, message: impl Into<String>) -> Self {
        Self {
            kind: Kind::DataLost,
            ..Self::new(code, message)
        }
    }

    /// The work could not be done with what may be used for it: exit code 3.
    pub fn undecided(code: &'static str, message: impl Into<String>) -> Self {
        Self {
            kind: Kind::Undecided,
            ..Self::new(code, message)
        }
    }

    /// A file that cannot be read.
    pub fn cannot_read(path: &Path, error: &std::io::Error) -> Self {
        let remedy = match error.kind() {
            std::io::ErrorKind::NotFound => "check the name and the folder",
            std::io::ErrorKind::PermissionDenied => "check the permissions of the file",
            std::io::ErrorKind::IsADirectory => "name a file in it",
            _ => "check the disk",
        };
        Self::new(
            "cannot-read",
            format!("{} cannot be read: {error}", path.display()),
        )
        .remedy(remedy)
    }

    /// A file that cannot be written.
    pub fn cannot_write(path: &Path, error: &std::io::Error) -> Self {
        Self::new(
            "cannot-write",
            format!("{} cannot be written: {error}", path.display()),
        )
        .remedy(match error.kind() {
            std::io::ErrorKind::StorageFull => "free some disk space and run the command again",
            _ => "choose a folder that can be written, with --out",
        })
    }

    /// Adds the place.
    pub fn at(mut self, source: &Source, span: Range<usize>) -> Self {
        let end = source.text.len();
        let span = span.start.min(end)..span.end.clamp(span.start.min(end), end);
        self.place = Some(Box::new(Place {
            source: source.clone(),
            span,
            related: Vec::new(),
        }));
        self
    }

    /// Names what the problem was met with, for example a recording.
    pub fn about(mut self, name: &str) -> Self {
        self.message = format!("{name}: {}", self.message);
        self
    }

    /// Adds what to do.
    pub fn remedy(mut self, remedy: impl Into<String>) -> Self {
        self.remedy = Some(remedy.into());
        self
    }

    /// Several problems as one; `None` if there are none.
    pub fn all(problems: impl IntoIterator<Item = Self>) -> Option<Self> {
        let mut problems = problems.into_iter();
        let mut first = problems.next()?;
        first.others.extend(problems);
        Some(first)
    }

    /// Diagnostics of the PRISM language as one problem; `None` if none is an
    /// error.
    pub fn from_diagnostics(
        source: &Source,
        diagnostics: &[prism_lang::Diagnostic],
    ) -> Option<Self> {
        let errors = diagnostics
            .iter()
            .filter(|d| d.severity == prism_lang::Severity::Error);
        Self::all(errors.map(|d| Self::from_diagnostic(source, d)))
    }

    fn from_diagnostic(source: &Source, diagnostic: &prism_lang::Diagnostic) -> Self {
        let span = diagnostic.span;
        let mut problem =
            Self::new(diagnostic.code, diagnostic.message.clone()).at(source, span.start..span.end);
        if let Some(place) = &mut problem.place {
            place.related = diagnostic
                .related
                .iter()
                .map(|(span, note)| (span.start..span.end, note.clone()))
                .collect();
        }
        problem.remedy = diagnostic.remedy.clone();
        problem
    }

    /// A TOML file that does not have the expected form.
    pub fn from_toml(source: &Source, error: &toml::de::Error) -> Self {
        let problem = Self::new("bad-study-file", error.message().trim_end().to_owned())
            .remedy("`corroborate init` writes a small study with every kind of entry");
        match error.span() {
            Some(span) => problem.at(source, span),
            None => Self {
                message: format!("{}: {}", source.name, problem.message),
                ..problem
            },
        }
    }

    /// The exit code that this problem ends the program with.
    pub fn exit_code(&self) -> u8 {
        match self.kind {
            Kind::Input => 2,
            Kind::DataLost | Kind::Undecided => 3,
            Kind::Interrupted => 130,
        }
    }

    /// The problem as it is shown to the user.
    pub fn render(&self, colour: bool) -> String {
        let renderer = if colour {
            Renderer::styled()
        } else {
            Renderer::plain()
        };
        let mut text = renderer.render(&self.groups()).to_string();
        for other in &self.others {
            text.push_str("\n\n");
            text.push_str(&renderer.render(&other.groups()).to_string());
        }
        text
    }

    /// The problem as a warning in one line: something that can be worked with,
    /// but perhaps is not meant.
    pub fn warning_line(&self) -> String {
        let place = self.place.as_ref().map(|place| {
            let (text, start) = (&place.source.text, place.span.start);
            let (line, column) = prism_lang::line_and_column(text, start);
            format!("{}:{line}:{column}: ", place.source.name)
        });
        let mut said = format!("warning: {}{}", place.unwrap_or_default(), self.message);
        if let Some(remedy) = &self.remedy {
            said.push(' ');
            said.push_str(remedy);
        }
        said.push_str(&format!(" (`corroborate explain {}`)", self.code));
        said
    }

    fn groups(&self) -> Vec<Group<'_>> {
        let title = Level::ERROR.primary_title(self.message.as_str());
        let title = if self.kind == Kind::Interrupted {
            title
        } else {
            title.id(self.code)
        };
        let mut group = match &self.place {
            Some(place) => title.element(place.snippet()),
            None => Group::with_title(title),
        };
        if let Some(remedy) = &self.remedy {
            group = group.element(Level::HELP.message(remedy.as_str()));
        }
        vec![group]
    }
}

impl Place {
    fn snippet(&self) -> Snippet<'_, annotate_snippets::Annotation<'_>> {
        let related = self.related.iter().map(|(span, note)| {
            AnnotationKind::Context
                .span(span.clone())
                .label(note.as_str())
        });
        Snippet::source(self.source.text.as_str())
            .path(self.source.name.as_str())
            .annotation(AnnotationKind::Primary.span(self.span.clone()))
            .annotations(related)
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.render(false))
    }
}

impl std::error::Error for Problem {}

/// Writes a file whole or not at all: a temporary file beside it is renamed.
pub fn write_whole(path: &Path, content: &[u8]) -> Result<(), Problem> {
    let fail = |error: std::io::Error| Problem::cannot_write(path, &error);
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(fail)?;
    }
    let partial: PathBuf = path.with_extension("partial");
    let written = std::fs::write(&partial, content).and_then(|()| std::fs::rename(&partial, path));
    written.map_err(|error| {
        let _ = std::fs::remove_file(&partial);
        fail(error)
    })
}

/// The name among `known` that is most like `name`, if one is alike enough to
/// be meant.
pub fn did_you_mean<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let limit = name.chars().count().div_ceil(3).max(1);
    known
        .into_iter()
        .map(|candidate| (edit_distance(name, candidate), candidate))
        .filter(|(distance, _)| *distance <= limit)
        .min()
        .map(|(_, candidate)| candidate)
}

fn edit_distance(left: &str, right: &str) -> usize {
    let right: Vec<char> = right.chars().collect();
    let mut row: Vec<usize> = (0..=right.len()).collect();
    for (i, a) in left.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, b) in right.iter().enumerate() {
            let substituted = diagonal + usize::from(a != *b);
            diagonal = row[j + 1];
            row[j + 1] = substituted.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[right.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_similar_name_is_proposed_and_a_different_one_is_not() {
        let known = ["handed_over", "grip_failed", "sensing"];
        assert_eq!(did_you_mean("handed_ovr", known), Some("handed_over"));
        assert_eq!(did_you_mean("planner", known), None);
    }

    #[test]
    fn a_warning_is_one_line_with_its_place() {
        let source = Source {
            name: "requirements.toml".into(),
            text: "id = 1\nshall = x\n".into(),
        };
        let warning = Problem::new("exact-instant", "This asks for one instant.")
            .at(&source, 15..16)
            .remedy("Write `within`.");
        assert_eq!(
            warning.warning_line(),
            "warning: requirements.toml:2:9: This asks for one instant. Write `within`. \
             (`corroborate explain exact-instant`)"
        );
    }

    #[test]
    fn a_problem_shows_file_line_and_remedy() {
        let source = Source {
            name: "study.toml".into(),
            text: "title = 1\nseed = x\n".into(),
        };
        let shown = Problem::new("bad-study-file", "the seed is not a number")
            .at(&source, 17..18)
            .remedy("write a whole number")
            .render(false);
        assert!(shown.contains("study.toml:2:8"), "{shown}");
        assert!(shown.contains("write a whole number"), "{shown}");
    }

    #[test]
    fn a_place_beyond_the_text_is_no_panic() {
        let source = Source {
            name: "empty".into(),
            text: String::new(),
        };
        let shown = Problem::new("x", "empty").at(&source, 5..9).render(false);
        assert!(shown.contains("empty"));
    }
}
