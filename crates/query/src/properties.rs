//! The properties of a command line and of its file.
//!
//! A property with a syntax error, or one that means nothing over the model, does not keep the others from being checked: it gets an error of
//! its own. If none is left, the mistakes end the command.

use crate::report::{PropertyReport, wrong_report};
use crate::request::{CheckRequest, PropertyInput};
use diagnostic::{Problem, Source};
use host::Host;
use prism_lang::ast::{PropertyFile, UnreadProperty};
use prism_lang::{Constants, Diagnostic, Diagnostics, NamedProperty, resolved};
use study::Method;

/// A property that was asked for.
pub(crate) enum Asked {
    Property(Box<NamedProperty>),
    Wrong(Wrong),
}

/// A property that means nothing over the model.
#[derive(Clone, Debug)]
pub(crate) struct Wrong {
    pub name: Option<String>,
    pub text: String,
    pub message: String,
    pub unsupported: bool,
}

impl Asked {
    pub fn name(&self) -> Option<&str> {
        match self {
            Self::Property(property) => property.name.as_deref(),
            Self::Wrong(wrong) => wrong.name.as_deref(),
        }
    }
}

/// A text of properties.
pub(crate) struct Text {
    pub source: Source,
    pub tree: PropertyFile,
    /// The properties that could not be read, each with its place among all, from 0.
    pub unread: Vec<(usize, Wrong)>,
    /// All of their mistakes.
    pub mistakes: Option<Problem>,
}

impl Text {
    /// Parses a text. Mistakes outside of properties, such as in a label, leave nothing that could be checked.
    pub fn new(source: Source) -> Result<Self, Problem> {
        let parsed = prism_lang::parse_properties(&source.text);
        let (tree, found) = (parsed.tree, parsed.diagnostics);
        let mistakes = study::placed::from_diagnostics(&source, &found);
        if let Some(problem) = &mistakes
            && tree.has_errors_outside(&found)
        {
            return Err(problem.clone());
        }
        let wrong = |property: &UnreadProperty| {
            let first = found.partition_point(|d| d.span.start < property.span.start);
            let own = found[first..].iter().take_while(|d| property.has(d));
            let own: Vec<Diagnostic> = own.cloned().collect();
            let problem = study::placed::from_diagnostics(&source, &own);
            let wrong = Wrong {
                name: property.name.as_ref().map(|name| name.text.clone()),
                text: property.text.clone(),
                message: problem.map_or_else(|| "it cannot be read".to_owned(), |p| p.line()),
                unsupported: own.iter().all(|mistake| mistake.code == "unsupported"),
            };
            (property.index, wrong)
        };
        Ok(Self {
            unread: tree.unread.iter().map(wrong).collect(),
            source,
            tree,
            mistakes,
        })
    }

    /// Name and text of all properties, in their order.
    pub fn all(&self) -> Vec<(Option<String>, String)> {
        let read = self.tree.properties.iter();
        let name = |property: &prism_lang::ast::Property| {
            let name = property.name.as_ref().map(|name| name.text.clone());
            (name, property.text.clone())
        };
        let unread = |wrong: &Wrong| (wrong.name.clone(), wrong.text.clone());
        self.in_order(read.map(name).collect(), unread)
    }

    /// Puts what belongs to unread properties to its place.
    fn in_order<T>(&self, read: Vec<T>, unread: impl Fn(&Wrong) -> T) -> Vec<T> {
        let mut read = read.into_iter();
        let mut all = Vec::new();
        for (index, wrong) in &self.unread {
            let before = index - all.len();
            all.extend(read.by_ref().take(before));
            all.push(unread(wrong));
        }
        all.extend(read);
        all
    }
}

/// Reads the texts of all properties that were asked for.
pub(crate) fn read(request: &CheckRequest, host: &Host) -> Result<Vec<Text>, Problem> {
    let sources = request.properties.iter().map(|input| match input {
        PropertyInput::File(path) => crate::check::read_prism(path, host),
        PropertyInput::Text(text) => Ok(given_property(text)),
    });
    let texts = sources.collect::<Result<Vec<_>, _>>()?;
    let texts = texts.into_iter().map(Text::new);
    let texts: Vec<Text> = texts.collect::<Result<_, Problem>>()?;
    let mistakes = || texts.iter().filter_map(|text| text.mistakes.as_ref());
    if let Some(problem) = mistakes().next()
        && texts.iter().all(|text| text.tree.properties.is_empty())
    {
        return Err(problem.clone());
    }
    for problem in mistakes() {
        host.events.mistake(problem);
    }
    Ok(texts)
}

/// All properties that were asked for, in order.
pub(crate) fn resolved(
    texts: &[Text],
    model: &resolved::Model,
    given: &Constants,
) -> Result<Vec<Asked>, Problem> {
    let mut all = Vec::new();
    for text in texts {
        let read = resolve(&text.source, text.tree.clone(), model, given)?;
        all.extend(text.in_order(read, |wrong| Asked::Wrong(wrong.clone())));
    }
    Ok(all)
}

/// The properties, none of which can be checked.
pub(crate) fn failed(texts: &[Text], method: Method, problem: &Problem) -> Vec<PropertyReport> {
    let all = texts.iter().flat_map(Text::all);
    all.enumerate()
        .map(|(place, (name, text))| {
            let wrong = Wrong {
                name,
                text,
                message: problem.line(),
                unsupported: problem.code == "unsupported",
            };
            wrong_report(place + 1, &wrong, method)
        })
        .collect()
}

/// The properties of a text, those with mistakes set apart.
fn resolve(
    source: &Source,
    mut tree: PropertyFile,
    model: &resolved::Model,
    given: &Constants,
) -> Result<Vec<Asked>, Problem> {
    let mut all: Vec<Option<Asked>> = tree.properties.iter().map(|_| None).collect();
    let mut places: Vec<usize> = (0..all.len()).collect();
    let mut first: Option<Diagnostics> = None;
    loop {
        let found = match prism_lang::resolve_properties(&tree, model, given) {
            Ok(resolved) if resolved.is_empty() && first.is_some() => Vec::new().into(),
            Ok(resolved) => {
                for (place, property) in places.iter().zip(resolved) {
                    all[*place] = Some(Asked::Property(Box::new(property)));
                }
                return Ok(all.into_iter().flatten().collect());
            }
            Err(found) => found,
        };
        let wrong = found.iter().find_map(|mistake| {
            let holds = |p: &prism_lang::ast::Property| {
                p.span.start <= mistake.span.start && mistake.span.end <= p.span.end
            };
            Some((tree.properties.iter().position(holds)?, mistake))
        });
        let Some((position, mistake)) = wrong else {
            // A mistake outside of properties, or nothing that is right.
            let shown = first.unwrap_or(found);
            return Err(
                study::placed::from_diagnostics(source, &shown).unwrap_or_else(|| {
                    Problem::new("cannot-resolve", "a property cannot be resolved")
                }),
            );
        };
        let removed = tree.properties.remove(position);
        all[places.remove(position)] = Some(Asked::Wrong(Wrong {
            name: removed.name.as_ref().map(|name| name.text.clone()),
            text: removed.text,
            message: mistake.to_string(),
            unsupported: mistake.code == "unsupported",
        }));
        first.get_or_insert(found);
    }
}

fn given_property(text: &str) -> Source {
    Source {
        name: "<property>".into(),
        text: text.to_owned(),
    }
}
