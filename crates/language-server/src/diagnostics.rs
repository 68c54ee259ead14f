//! What is wrong with a text, in the words of the command line.

use crate::kind::{self, Kind};
use crate::text::Text;
use crate::workspace::Workspace;
use diagnostic::{Excerpt, MOST_SHOWN, Place, Problem};
use ls_types::{
    CodeDescription, Diagnostic, DiagnosticRelatedInformation, DiagnosticSeverity, Location,
    NumberOrString, Position, Range as LspRange, Uri,
};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// Who says it.
const SOURCE: &str = "corroborate";

/// How diagnostics are told to this editor.
#[derive(Clone, Debug, Default)]
pub struct Telling {
    /// The scheme of the links to what a code means; without one there are no links.
    pub explain_scheme: Option<String>,
}

impl Telling {
    fn diagnostic(
        &self,
        range: LspRange,
        severity: DiagnosticSeverity,
        code: &str,
        message: String,
    ) -> Diagnostic {
        let link = self.explain_scheme.as_ref();
        let link = link.and_then(|scheme| Uri::from_str(&format!("{scheme}:{code}.txt")).ok());
        Diagnostic {
            range,
            severity: Some(severity),
            code: Some(NumberOrString::String(code.to_owned())),
            code_description: link.map(|href| CodeDescription { href }),
            source: Some(SOURCE.into()),
            message,
            ..Diagnostic::default()
        }
    }
}

/// What is wrong with an open file, and with those that are judged with it, by file.
#[must_use]
pub fn of_file(
    workspace: &Workspace,
    path: &Path,
    telling: &Telling,
) -> BTreeMap<PathBuf, Vec<Diagnostic>> {
    let mut all = BTreeMap::new();
    match workspace.kind(path) {
        Kind::Model => {
            let found = workspace.model(path).map_or(Vec::new(), |view| {
                let found: Vec<_> = view.diagnostics().collect();
                in_prism(workspace, path, &view.text, &found, telling)
            });
            all.insert(path.to_owned(), found);
        }
        Kind::Properties => {
            let found = workspace.properties(path).map_or(Vec::new(), |view| {
                let found: Vec<_> = view.diagnostics.iter().collect();
                in_prism(workspace, path, &view.text, &found, telling)
            });
            all.insert(path.to_owned(), found);
        }
        Kind::Toml | Kind::Other => {}
    }
    if workspace.concerns_a_study(path)
        && let Some(folder) = workspace.study_folder(path)
    {
        for (file, found) in of_study(workspace, &folder, telling) {
            all.entry(file).or_insert_with(Vec::new).extend(found);
        }
    }
    all
}

/// What is wrong with a study's own files. Each of them has an entry, so that what was told before is taken back.
fn of_study(
    workspace: &Workspace,
    folder: &Path,
    telling: &Telling,
) -> BTreeMap<PathBuf, Vec<Diagnostic>> {
    let mut all: BTreeMap<PathBuf, Vec<Diagnostic>> = BTreeMap::new();
    let Some(view) = workspace.study(folder) else {
        return all;
    };
    for file in view.own_files() {
        all.insert(file, Vec::new());
    }
    let mistakes = view
        .problems
        .iter()
        .map(|it| (it, DiagnosticSeverity::ERROR));
    let warnings = view
        .warnings
        .iter()
        .map(|it| (it, DiagnosticSeverity::WARNING));
    for (problem, severity) in mistakes.chain(warnings) {
        let (path, found) = of_problem(workspace, folder, problem, severity, telling);
        all.entry(path).or_default().push(found);
    }
    all
}

/// A problem at its place; without one, at the beginning of `study.toml`.
fn of_problem(
    workspace: &Workspace,
    folder: &Path,
    problem: &Problem,
    severity: DiagnosticSeverity,
    telling: &Telling,
) -> (PathBuf, Diagnostic) {
    let message = with_remedy(problem.message(), problem.what_to_do());
    let Some(place) = problem.place() else {
        let begin = LspRange::new(Position::new(0, 0), Position::new(0, 0));
        let found = telling.diagnostic(begin, severity, problem.code, message);
        return (folder.join(kind::OF_STUDY[0]), found);
    };
    let path = PathBuf::from(&place.name);
    let mut found = telling.diagnostic(LspRange::default(), severity, problem.code, message);
    match &place.excerpt {
        Some(excerpt) => {
            found.range = in_excerpt(excerpt, &excerpt.span);
            let uri = workspace.uri(&path);
            let related = excerpt.related.iter();
            let related = related.filter_map(|(span, note)| {
                Some(DiagnosticRelatedInformation {
                    location: Location::new(uri.clone()?, in_excerpt(excerpt, span)),
                    message: note.clone(),
                })
            });
            let related: Vec<_> = related.collect();
            found.related_information = (!related.is_empty()).then_some(related);
        }
        None => found.range = by_column(workspace, &path, place),
    }
    (path, found)
}

fn by_column(workspace: &Workspace, path: &Path, place: &Place) -> LspRange {
    let text = workspace.read(path);
    text.map_or_else(LspRange::default, |text| {
        let at = text.offset_of_column(place.line, place.column);
        text.range(at..at)
    })
}

/// A part of an excerpt, whose first line has a number in the whole text.
fn in_excerpt(excerpt: &Excerpt, span: &std::ops::Range<usize>) -> LspRange {
    let mut range = Text::new(excerpt.text.clone()).range(span.clone());
    let first = u32::try_from(excerpt.first_line.saturating_sub(1)).unwrap_or(0);
    range.start.line = range.start.line.saturating_add(first);
    range.end.line = range.end.line.saturating_add(first);
    range
}

fn in_prism(
    workspace: &Workspace,
    path: &Path,
    text: &Text,
    found: &[&prism_lang::Diagnostic],
    telling: &Telling,
) -> Vec<Diagnostic> {
    let uri = workspace.uri(path);
    let shown = found.iter().take(MOST_SHOWN);
    let mut all: Vec<Diagnostic> = shown
        .map(|it| one_in_prism(uri.as_ref(), text, it, telling))
        .collect();
    if found.len() > MOST_SHOWN
        && let Some(last) = all.last_mut()
    {
        let more = found.len() - MOST_SHOWN;
        let rest =
            format!("\n{more} more mistakes are not shown: correct these {MOST_SHOWN} first");
        last.message.push_str(&rest);
    }
    all
}

fn one_in_prism(
    uri: Option<&Uri>,
    text: &Text,
    it: &prism_lang::Diagnostic,
    telling: &Telling,
) -> Diagnostic {
    let range = |span: prism_lang::Span| text.range(span.start..span.end);
    let severity = match it.severity {
        // A value is given when the model is checked.
        _ if it.code == "undefined-constant" => DiagnosticSeverity::INFORMATION,
        prism_lang::Severity::Error => DiagnosticSeverity::ERROR,
        prism_lang::Severity::Warning => DiagnosticSeverity::WARNING,
    };
    let message = with_remedy(&it.message, it.remedy.as_deref());
    let mut found = telling.diagnostic(range(it.span), severity, it.code, message);
    let related: Vec<_> = (it.related.iter())
        .filter_map(|(span, note)| {
            Some(DiagnosticRelatedInformation {
                location: Location::new(uri?.clone(), range(*span)),
                message: note.clone(),
            })
        })
        .collect();
    found.related_information = (!related.is_empty()).then_some(related);
    found
}

fn with_remedy(message: &str, remedy: Option<&str>) -> String {
    match remedy {
        Some(remedy) => format!("{message}\n{remedy}"),
        None => message.to_owned(),
    }
}
