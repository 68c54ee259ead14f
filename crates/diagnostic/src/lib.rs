#![doc = include_str!("../README.md")]

mod cancel;
mod counted;
mod excerpt;
mod names;
mod printable;
mod problems;

pub use cancel::Cancel;
pub use counted::counted;
pub use excerpt::Excerpt;
pub use names::did_you_mean;
pub use printable::{printable, printable_json, printable_line};
pub use problems::Problems;

use std::fmt;
use std::ops::Range;
use std::path::Path;

/// A text with the name under which the user knows it.
#[derive(Clone, Debug)]
pub struct Source {
    /// The path as the user would type it, or for example `<property>`.
    pub name: String,
    /// The content.
    pub text: String,
}

/// How many problems of one input are shown.
pub const MOST_SHOWN: usize = 50;
/// How many characters of a message are shown: what it quotes may be of any length.
const MOST_CHARACTERS: usize = 1_000;

impl Source {
    /// A text under a name.
    pub fn new(name: impl Into<String>, text: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            text: text.into(),
        }
    }
}

/// A text whose middle is left out if it is too long to be shown.
pub fn shortened(text: &str) -> std::borrow::Cow<'_, str> {
    // As long in bytes as in characters, at least.
    if text.len() <= MOST_CHARACTERS {
        return text.into();
    }
    let count = text.chars().count();
    if count <= MOST_CHARACTERS {
        return text.into();
    }
    let (head, tail) = (3 * MOST_CHARACTERS / 4, MOST_CHARACTERS / 4);
    let start: String = text.chars().take(head).collect();
    let end: String = text.chars().skip(count - tail).collect();
    format!(
        "{start} [{} characters left out] {end}",
        count - head - tail
    )
    .into()
}

/// A place in a source: no more of its text than is shown, so that many mistakes in a large file stay small.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    /// The path as the user would type it, or for example `<property>`.
    pub name: String,
    /// The line, counted from one.
    pub line: usize,
    /// The column in characters, counted from one.
    pub column: usize,
    /// The lines that are shown; `None` where the line is too long for it.
    pub excerpt: Option<Excerpt>,
}

/// Line and column of a byte of a text, in characters, counted from one.
///
/// ```
/// assert_eq!(diagnostic::line_and_column("dtmc\nmodule", 5), (2, 1));
/// ```
pub fn line_and_column(text: &str, offset: usize) -> (usize, usize) {
    let bytes = &text.as_bytes()[..offset.min(text.len())];
    let line_start = bytes.iter().rposition(|&b| b == b'\n').map_or(0, |p| p + 1);
    let line = bytes.iter().filter(|&&b| b == b'\n').count() + 1;
    let is_first_byte = |b: &&u8| (**b & 0xC0) != 0x80;
    let column = bytes[line_start..].iter().filter(is_first_byte).count() + 1;
    (line, column)
}

/// What went wrong, where, and what to do about it.
#[derive(Clone, Debug, PartialEq)]
pub struct Problem {
    /// Names the kind of problem; `corroborate explain CODE` says more.
    pub code: &'static str,
    message: String,
    place: Option<Box<Place>>,
    /// The file that it is about as a whole, which the message names, too.
    file: Option<Box<str>>,
    remedy: Option<Box<str>>,
    /// Further problems of the same input.
    others: Vec<Problem>,
    /// How many more there are, which are not shown.
    not_shown: usize,
    kind: Kind,
}

/// Of which kind a problem is: faces choose exit codes by it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// The input or the call is wrong.
    Input,
    /// Work was done, but a result could not be kept.
    DataLost,
    /// The work could not be done with what may be used for it.
    Undecided,
    /// The user asked to stop.
    Interrupted,
}

impl Problem {
    /// A problem with the input or the call: exit code 2.
    pub fn new(code: &'static str, message: impl Into<String>) -> Self {
        Self {
            code,
            message: shortened(&message.into()).into_owned(),
            place: None,
            file: None,
            remedy: None,
            others: Vec::new(),
            not_shown: 0,
            kind: Kind::Input,
        }
    }

    /// What a library says, whose last clause, behind a semicolon, is what to do about it.
    ///
    /// ```
    /// let problem = diagnostic::Problem::said("bad-recording", "a.csv is empty; record it again");
    /// assert_eq!((problem.message(), problem.what_to_do()), ("a.csv is empty", Some("record it again")));
    /// ```
    pub fn said(code: &'static str, error: impl fmt::Display) -> Self {
        let said = error.to_string();
        match said.rsplit_once("; ") {
            Some((message, remedy)) => Self::new(code, message).remedy(remedy),
            None => Self::new(code, said),
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

    /// Whether it is said where it is.
    pub fn has_place(&self) -> bool {
        self.place.is_some()
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
        .of_file(path)
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
        .of_file(path)
    }

    /// Adds the file that it is about, where no place in it can be named.
    pub fn of_file(mut self, path: &Path) -> Self {
        self.file = Some(path.to_string_lossy().into());
        self
    }

    /// The same with what to do in the words of who is spoken to: a caller of a function has no options of a command line.
    pub fn in_words(mut self, words: &dyn Fn(&str) -> String) -> Self {
        self.remedy = self.remedy.map(|remedy| words(&remedy).into());
        let others = self.others.into_iter();
        self.others = others.map(|other| other.in_words(words)).collect();
        self
    }

    /// Adds the place.
    pub fn at(self, source: &Source, span: Range<usize>) -> Self {
        self.at_places(source, span, Vec::new())
    }

    /// Adds the place, and places that have to do with it.
    pub fn at_places(
        mut self,
        source: &Source,
        span: Range<usize>,
        related: Vec<(Range<usize>, String)>,
    ) -> Self {
        self.place = Some(Box::new(Place::new(source, span, related)));
        self
    }

    /// Names what the problem was met with, for example a recording.
    pub fn about(mut self, name: &str) -> Self {
        self.message = format!("{name}: {}", self.message);
        self
    }

    /// Adds what to do.
    pub fn remedy(mut self, remedy: impl Into<String>) -> Self {
        self.remedy = Some(shortened(&remedy.into()).into());
        self
    }

    /// It and its others, each by itself. What is only counted is left out.
    pub fn into_each(mut self) -> Vec<Self> {
        let others = std::mem::take(&mut self.others);
        self.not_shown = 0;
        std::iter::once(self).chain(others).collect()
    }

    /// Several problems as one; `None` if there are none.
    pub fn all(problems: impl IntoIterator<Item = Self>) -> Option<Self> {
        let mut problems = problems.into_iter();
        let mut first = problems.next()?;
        let own = std::mem::take(&mut first.others);
        for mut problem in own.into_iter().chain(problems) {
            first.not_shown += std::mem::take(&mut problem.not_shown);
            let others = std::mem::take(&mut problem.others);
            for one in std::iter::once(problem).chain(others) {
                match first.others.len() + 1 < MOST_SHOWN {
                    true => first.others.push(one),
                    false => first.not_shown += 1,
                }
            }
        }
        Some(first)
    }

    /// The same with so many further problems that are counted and not shown.
    pub fn and_more(mut self, count: usize) -> Self {
        self.not_shown += count;
        self
    }

    /// Of which kind it is.
    pub fn kind(&self) -> Kind {
        self.kind
    }

    /// Where it is.
    pub fn place(&self) -> Option<&Place> {
        self.place.as_deref()
    }

    /// The file that it is in or about, as far as that is known.
    pub fn file(&self) -> Option<&str> {
        let of_place = self.place().map(|place| place.name.as_str());
        of_place.or(self.file.as_deref())
    }

    /// What to do about it.
    pub fn what_to_do(&self) -> Option<&str> {
        self.remedy.as_deref()
    }

    /// Further problems of the same input.
    pub fn others(&self) -> &[Problem] {
        &self.others
    }

    /// What is said of further problems of the same input that are not shown.
    pub fn rest(&self) -> Option<String> {
        let (count, shown) = (self.not_shown, self.others.len() + 1);
        (count > 0)
            .then(|| format!("{count} more mistakes are not shown: correct these {shown} first"))
    }

    /// The problem as a warning in one line: something that can be worked with,
    /// but perhaps is not meant.
    pub fn warning_line(&self) -> String {
        let place = self.place.as_ref();
        let place = place.map(|at| format!("{}:{}:{}: ", at.name, at.line, at.column));
        let mut said = format!("warning: {}{}", place.unwrap_or_default(), self.message);
        if let Some(remedy) = &self.remedy {
            let is_sentence = said.ends_with(['.', '!', '?', ':', ';']);
            said.push_str(if is_sentence { " " } else { "; " });
            said.push_str(remedy);
        }
        said.push_str(&format!(" (`corroborate explain {}`)", self.code));
        said
    }
}

impl Place {
    fn new(source: &Source, span: Range<usize>, related: Vec<(Range<usize>, String)>) -> Self {
        let span = excerpt::within(&source.text, span);
        let (line, column) = line_and_column(&source.text, span.start);
        Self {
            name: source.name.clone(),
            line,
            column,
            excerpt: Excerpt::new(&source.text, span, related),
        }
    }
}

impl fmt::Display for Problem {
    /// Message, place and remedy as plain text, with further problems below.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.kind {
            Kind::Interrupted => write!(f, "error: {}", self.message)?,
            _ => write!(f, "error[{}]: {}", self.code, self.message)?,
        }
        if let Some(place) = &self.place {
            write!(f, "\n --> {}:{}:{}", place.name, place.line, place.column)?;
        }
        if let Some(remedy) = &self.remedy {
            write!(f, "\n = help: {remedy}")?;
        }
        for other in &self.others {
            write!(f, "\n\n{other}")?;
        }
        match self.rest() {
            Some(rest) => write!(f, "\n\n{rest}"),
            None => Ok(()),
        }
    }
}

impl std::error::Error for Problem {}

#[cfg(test)]
mod tests {
    use super::*;

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
        // Behind what is not a sentence what to do is set apart.
        let warning = Problem::new("text-threshold", "the text states 0.9").remedy("correct it");
        assert_eq!(
            warning.warning_line(),
            "warning: the text states 0.9; correct it (`corroborate explain text-threshold`)"
        );
    }

    #[test]
    fn what_to_do_is_said_in_other_words_of_all_problems() {
        let of = |name: &str| Problem::cannot_read(Path::new(name), &std::io::Error::other("x"));
        let both = Problem::all([of("a"), of("b").remedy("see --out")]).unwrap();
        let found = both.in_words(&|remedy| remedy.replace("--out", "out="));
        assert_eq!(found.others()[0].what_to_do(), Some("see out="));
        assert_eq!(
            (found.file(), found.others()[0].file()),
            (Some("a"), Some("b"))
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
            .to_string();
        assert!(shown.contains("study.toml:2:8"), "{shown}");
        assert!(shown.contains("write a whole number"), "{shown}");
    }

    #[test]
    fn a_place_beyond_the_text_is_no_panic() {
        let source = Source {
            name: "empty".into(),
            text: String::new(),
        };
        let shown = Problem::new("x", "empty").at(&source, 5..9).to_string();
        assert!(shown.contains("empty"));
    }

    #[test]
    fn what_is_shown_is_limited_in_number_and_length() {
        let lines: String = (0..100).map(|line| format!("x{line}\n")).collect();
        let source = Source {
            name: "m".into(),
            text: format!("{lines}{}", "7".repeat(2_000_000)),
        };
        let (start, end) = (lines.len(), source.text.len());
        let problem = Problem::new("x", format!("`{}` is not a number", &source.text[start..]));
        let shown = problem.clone().at(&source, start..end).to_string();
        assert!(shown.contains("m:101:1"), "{shown}");
        assert!(shown.len() < 2_000, "{} bytes", shown.len());
        let late = problem.at(&source, end - 1..end).to_string();
        assert!(late.contains("m:101:2000000"), "{late}");
        assert!(late.len() < 2_000, "{} bytes", late.len());
        let each = |at: usize| Problem::new("x", "wrong").at(&source, at..at + 1);
        let many = Problem::all((0..120).map(each)).expect("some").to_string();
        assert_eq!(many.matches("error[x]").count(), MOST_SHOWN);
        assert!(many.contains("70 more mistakes are not shown"), "{many}");
    }
}
