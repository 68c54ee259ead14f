//! The vocabulary: each proposition once, with what it means to each
//! technique.

use super::{StudyParameters, Texts};
use crate::placed::toml_place;
use diagnostic::{Problem, Problems, Source, did_you_mean};
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;
use toml::Spanned;

/// One proposition and its bindings.
#[derive(Clone, Debug)]
pub struct Proposition {
    /// What it means, in words.
    pub meaning: String,
    /// An expression over the formal model's variables.
    pub model: Option<Binding>,
    /// A predicate over a trace's signals.
    pub trace: Option<Binding>,
    /// A predicate whose robustness says how far the proposition is from
    /// changing, where `trace` is only true or false. It decides nothing.
    pub graded: Option<Binding>,
    /// A column of the experiments' table that counts it.
    pub column: Option<Binding>,
}

/// A binding's text and its place in the file.
#[derive(Clone, Debug)]
pub struct Binding {
    /// The text.
    pub text: String,
    /// Its place in the vocabulary's source, without the quotes.
    pub span: Range<usize>,
}

/// All propositions, by name.
#[derive(Clone, Debug)]
pub struct Vocabulary {
    /// The file, for diagnostics.
    pub source: Source,
    /// The propositions.
    pub propositions: BTreeMap<String, Proposition>,
    /// Their bindings to traces.
    pub signals: trace::Vocabulary,
}

#[derive(JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
struct PropositionText {
    /// What it means, in words.
    meaning: String,
    /// An expression over the formal model's variables.
    #[schemars(with = "Option<String>")]
    model: Option<Spanned<String>>,
    /// A predicate over signals of recordings, for example `"distance < 10 cm"`.
    #[schemars(with = "Option<String>")]
    trace: Option<Spanned<String>>,
    /// A predicate whose robustness says how far the proposition is from changing, where `trace` is only true or false. It decides nothing.
    #[schemars(with = "Option<String>")]
    graded: Option<Spanned<String>>,
    /// The column of an experiment's table that counts it.
    #[schemars(with = "Option<String>")]
    column: Option<Spanned<String>>,
}

/// The JSON Schema of `vocabulary.toml`.
pub(crate) fn schema() -> schemars::Schema {
    schemars::schema_for!(BTreeMap<String, PropositionText>)
}

impl Vocabulary {
    /// Reads `vocabulary.toml`; its predicates may use the parameters. Mistakes are added to those that were found, and a
    /// predicate that has one is replaced.
    pub fn load(
        folder: &Path,
        texts: &dyn Texts,
        parameters: &StudyParameters,
        found: &mut Problems,
    ) -> Self {
        let path = folder.join("vocabulary.toml");
        let source = found.keep(texts.needed(&path)).unwrap_or_else(|| {
            found.lose_names();
            Source::new(path.display().to_string(), "")
        });
        let texts = crate::toml_text::read_on(&source, found);
        let texts: BTreeMap<String, PropositionText> = texts.unwrap_or_default();
        let propositions: BTreeMap<String, Proposition> = texts
            .into_iter()
            .map(|(name, text)| {
                let proposition = Proposition {
                    meaning: text.meaning,
                    model: text.model.map(binding),
                    trace: text.trace.map(binding),
                    graded: text.graded.map(binding),
                    column: text.column.map(binding),
                };
                (name, proposition)
            })
            .collect();
        let signals = signals(&source, &propositions, parameters, found);
        Self {
            source,
            propositions,
            signals,
        }
    }

    /// An error in a predicate, at its place in the vocabulary's file.
    pub fn predicate_problem(&self, error: &trace::PredicateError) -> Problem {
        predicate_problem(&self.source, &self.propositions, error)
    }

    /// The proposition with this name, or a problem at the place that uses it.
    pub fn proposition(
        &self,
        name: &str,
        user: &Source,
        span: Range<usize>,
    ) -> Result<&Proposition, Problem> {
        self.propositions.get(name).ok_or_else(|| {
            let problem = Problem::new(
                "unknown-proposition",
                format!("the vocabulary has no proposition `{name}`"),
            )
            .at(user, span);
            match did_you_mean(name, self.propositions.keys().map(String::as_str)) {
                Some(similar) => problem.remedy(format!("did you mean `{similar}`?")),
                None => problem.remedy(format!("define [{name}] in {}", self.source.name)),
            }
        })
    }
}

/// What the bindings to traces mean. One that is wrong is told, and is taken as always true.
fn signals(
    source: &Source,
    propositions: &BTreeMap<String, Proposition>,
    parameters: &StudyParameters,
    found: &mut Problems,
) -> trace::Vocabulary {
    let bound = propositions.iter();
    let mut bound: BTreeMap<&str, &str> = bound
        .filter_map(|(name, it)| Some((name.as_str(), it.trace.as_ref()?.text.as_str())))
        .collect();
    // Names that mean nothing are looked for once all texts can be read, so that there may be mistakes behind the first.
    loop {
        let entries = bound.iter().map(|(name, text)| (*name, *text));
        let errors = match trace::Vocabulary::with_parameters(entries, parameters.values.clone()) {
            Ok(signals) => {
                for name in bound.keys() {
                    let checked = signals.predicate(name).and_then(|it| it.check());
                    if let Err(error) = checked {
                        found.add(predicate_problem(source, propositions, &error));
                    }
                }
                return signals;
            }
            Err(errors) => errors,
        };
        let mut is_replaced = false;
        for error in &errors {
            found.add(predicate_problem(source, propositions, error));
            let entry = error.entry.as_deref().and_then(|name| bound.get_mut(name));
            if let Some(text) = entry.filter(|text| **text != ALWAYS) {
                *text = ALWAYS;
                is_replaced = true;
            }
        }
        if !is_replaced {
            return trace::Vocabulary::default();
        }
    }
}

/// A predicate that is true at all times.
const ALWAYS: &str = "true";

fn predicate_problem(
    source: &Source,
    propositions: &BTreeMap<String, Proposition>,
    error: &trace::PredicateError,
) -> Problem {
    let problem = Problem::new("bad-predicate", error.kind.to_string())
        .remedy("correct the predicate in the vocabulary, or judge a recording that has the signals it names");
    let entry = error.entry.as_ref().and_then(|name| propositions.get(name));
    match entry.and_then(|p| p.trace.as_ref()) {
        Some(binding) => {
            let start = binding.span.start + error.span.start;
            problem.at(source, start..binding.span.start + error.span.end)
        }
        None => match &error.entry {
            Some(name) => problem.at(source, toml_place(source, &[name])),
            None => problem,
        },
    }
}

fn binding(text: Spanned<String>) -> Binding {
    let span = text.span();
    Binding {
        text: text.into_inner(),
        span: span.start + 1..span.end.saturating_sub(1).max(span.start + 1),
    }
}
