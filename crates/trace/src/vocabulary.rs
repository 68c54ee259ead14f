//! Names for predicates and quantities, so that requirements can speak of `grasped` and `near`.

use std::collections::BTreeSet;
use std::sync::Arc;

use crate::parameters::Parameters;
use crate::predicate::{
    Definitions, Expression, Node, NodeKind, Predicate, PredicateError, PredicateErrorKind,
    Quantity, Source, is_name, parse,
};
use crate::suggest::nearest;

/// Named definitions, which may refer to each other but not in a circle.
///
/// ```
/// use trace::Vocabulary;
/// let vocabulary = Vocabulary::new([
///     ("hand_distance", "distance(/truth.human_hand, /truth.robot_hand)"),
///     ("near", "hand_distance < 0.1"),
/// ]).map_err(|errors| errors[0].clone())?;
/// let slow_when_near = vocabulary.predicate("near => /robot.hand_speed < 0.25")?;
/// assert!(slow_when_near.signals().contains("/truth.robot_hand.x"));
///
/// let error = vocabulary.predicate("nera").unwrap_err();
/// assert!(error.to_string().contains("did you mean near?"));
/// # Ok::<(), trace::PredicateError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Vocabulary {
    definitions: Arc<Definitions>,
    parameters: Arc<Parameters>,
}

impl Vocabulary {
    /// Parses all definitions, given as name and text, and checks that what they refer to exists.
    ///
    /// # Errors
    /// Every [`PredicateError`] there is: in the names, in the texts, unknown names and circles.
    pub fn new<N: Into<String>, T: AsRef<str>>(
        entries: impl IntoIterator<Item = (N, T)>,
    ) -> Result<Self, Vec<PredicateError>> {
        Vocabulary::with_parameters(entries, Parameters::default())
    }

    /// As [`Vocabulary::new`], where the texts may also refer to `parameters` by name.
    ///
    /// # Errors
    /// Every [`PredicateError`] there is; a name that is also a parameter's counts as defined
    /// twice.
    pub fn with_parameters<N: Into<String>, T: AsRef<str>>(
        entries: impl IntoIterator<Item = (N, T)>,
        parameters: Parameters,
    ) -> Result<Self, Vec<PredicateError>> {
        let mut definitions = Definitions::new();
        let mut errors = Vec::new();
        for (name, text) in entries {
            let (name, text) = (name.into(), text.as_ref());
            match define(&definitions, &parameters, &name, text) {
                Ok(expression) => {
                    definitions.insert(name, expression);
                }
                Err(error) => errors.push(PredicateError {
                    entry: Some(name),
                    ..error
                }),
            }
        }
        if errors.is_empty() {
            for (name, expression) in &definitions {
                let unknown = unknown_names(expression, &definitions, &parameters).into_iter();
                errors.extend(unknown.map(|error| PredicateError {
                    entry: Some(name.clone()),
                    ..error
                }));
            }
            errors.extend(cycles(&definitions));
        }
        if errors.is_empty() {
            Ok(Vocabulary {
                definitions: Arc::new(definitions),
                parameters: Arc::new(parameters),
            })
        } else {
            Err(errors)
        }
    }

    /// The names, in alphabetical order.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.definitions.keys().map(String::as_str)
    }

    /// The parameters that the texts may refer to.
    #[must_use]
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// The text that defines `name`.
    #[must_use]
    pub fn text(&self, name: &str) -> Option<&str> {
        self.definitions
            .get(name)
            .map(|expression| expression.text.as_str())
    }

    /// A predicate whose names refer to this vocabulary; often just a name.
    ///
    /// # Errors
    /// [`PredicateError`] with the place in `text`.
    pub fn predicate(&self, text: &str) -> Result<Predicate, PredicateError> {
        self.source(text).map(Predicate::new)
    }

    /// A quantity whose names refer to this vocabulary.
    ///
    /// # Errors
    /// [`PredicateError`] with the place in `text`.
    pub fn quantity(&self, text: &str) -> Result<Quantity, PredicateError> {
        self.source(text).map(Quantity::new)
    }

    pub(crate) fn source(&self, text: &str) -> Result<Source, PredicateError> {
        let expression = Expression {
            text: text.to_owned(),
            root: parse(text)?,
        };
        match unknown_names(&expression, &self.definitions, &self.parameters)
            .into_iter()
            .next()
        {
            Some(error) => Err(error),
            None => Ok(Source {
                expression,
                definitions: Arc::clone(&self.definitions),
                parameters: Arc::clone(&self.parameters),
            }),
        }
    }
}

fn define(
    definitions: &Definitions,
    parameters: &Parameters,
    name: &str,
    text: &str,
) -> Result<Expression, PredicateError> {
    let error = |kind| PredicateError {
        text: text.to_owned(),
        entry: None,
        span: 0..0,
        kind,
    };
    if !is_name(name) {
        return Err(error(PredicateErrorKind::BadName {
            name: name.to_owned(),
        }));
    }
    if definitions.contains_key(name) || parameters.get(name).is_some() {
        return Err(error(PredicateErrorKind::DuplicateName {
            name: name.to_owned(),
        }));
    }
    Ok(Expression {
        text: text.to_owned(),
        root: parse(text)?,
    })
}

/// The names that `expression` refers to, with their places.
fn references(expression: &Expression) -> Vec<(&str, &Node)> {
    let mut found = Vec::new();
    let mut waiting = vec![&expression.root];
    while let Some(node) = waiting.pop() {
        if let NodeKind::Name(name) = &node.kind {
            found.push((name.as_str(), node));
        }
        waiting.extend(node.children());
    }
    found.sort_by_key(|(_, node)| node.span.start);
    found
}

fn unknown_names(
    expression: &Expression,
    definitions: &Definitions,
    parameters: &Parameters,
) -> Vec<PredicateError> {
    let unknown = references(expression).into_iter();
    let unknown = unknown
        .filter(|(name, _)| !definitions.contains_key(*name) && parameters.get(name).is_none());
    let known = || {
        definitions
            .keys()
            .map(String::as_str)
            .chain(parameters.names())
    };
    let error = |(name, node): (&str, &Node)| PredicateError {
        text: expression.text.clone(),
        entry: None,
        span: node.span.clone(),
        kind: PredicateErrorKind::UnknownName {
            name: name.to_owned(),
            similar: nearest(name, known()),
        },
    };
    unknown.map(error).collect()
}

/// One error for each circle of references, found by depth-first search without recursion.
fn cycles(definitions: &Definitions) -> Vec<PredicateError> {
    let mut errors = Vec::new();
    let mut done = BTreeSet::new();
    for start in definitions.keys() {
        let mut path: Vec<(&str, Vec<(&str, &Node)>)> = Vec::new();
        let mut entering = Some(start.as_str());
        loop {
            if let Some(name) = entering.take()
                && done.insert(name)
            {
                let below = definitions.get(name).map(references).unwrap_or_default();
                path.push((name, below));
            }
            let Some((name, below)) = path.last_mut() else {
                break;
            };
            let Some((next, node)) = below.pop() else {
                path.pop();
                continue;
            };
            let name: &str = name;
            if let Some(from) = path.iter().position(|(other, _)| *other == next) {
                let around = path[from..].iter().map(|(name, _)| (*name).to_owned());
                let names = around.chain([next.to_owned()]).collect();
                errors.push(PredicateError {
                    text: definitions[name].text.clone(),
                    entry: Some(name.to_owned()),
                    span: node.span.clone(),
                    kind: PredicateErrorKind::Cycle { names },
                });
            } else {
                entering = Some(next);
            }
        }
    }
    errors
}
