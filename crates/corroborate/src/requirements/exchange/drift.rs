//! FRET's sentences as sentences of ours, and whether they mean the same as FRET's formulas.

use requirement_files::fret::{self, Comparison, Formulas, Meaning, Translation};
use requirement_files::{Document, Format, Placed};
use requirement_lang::{Context, Sentence, parse};
use schemars::JsonSchema;
use serde::Serialize;
use study::Study;

/// One of FRET's sentences.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct SentenceShown {
    /// The requirement.
    pub id: String,
    /// As a sentence of ours; none if it cannot be translated.
    pub sentence: Option<String>,
    /// Why it cannot be.
    pub not_translated: Option<String>,
    /// Names in the sentence that stand for expressions of FRET: `name: expression`.
    pub definitions: Vec<String>,
    /// What the vocabulary does not have of its names.
    pub not_in_vocabulary: Vec<String>,
    /// What is to be known about the translation.
    pub notes: Vec<String>,
    /// The translation against FRET's formulas, on runs that go on for ever.
    pub runs: Option<ComparisonShown>,
    /// The same on runs that end: what could still have come in time is excused by FRET, and here by the monitor's ending alone.
    pub ends: Option<ComparisonShown>,
    /// How FRET's probability differs from the sentence's.
    pub probability: Option<String>,
    /// FRET's text as our language reads it as it is, where that means something else.
    pub verbatim: Option<ComparisonShown>,
    /// The sentence that the study has for it.
    pub own: Option<String>,
    /// The study's sentence against FRET's formulas, on runs that go on for ever.
    pub own_runs: Option<ComparisonShown>,
}

/// What a comparison of meanings came to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// No word told them apart.
    Same,
    /// A word tells them apart.
    Differs,
    /// On runs that end, FRET excuses what could still come; no word told them apart in anything else.
    Excuses,
    /// They were not compared.
    NotCompared,
}

/// A comparison of meanings.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct ComparisonShown {
    /// What it came to.
    pub verdict: Verdict,
    /// How many words were tried.
    pub words: usize,
    /// Up to this length, all were.
    pub all_up_to: usize,
    /// A word that tells them apart or is excused, or why they were not compared.
    pub reason: Option<String>,
}

impl ComparisonShown {
    fn new(comparison: &Comparison) -> Self {
        let of = |verdict, reason| Self {
            verdict,
            words: 0,
            all_up_to: 0,
            reason: Some(reason),
        };
        match comparison {
            Comparison::Same { words, all_up_to } => Self {
                verdict: Verdict::Same,
                words: *words,
                all_up_to: *all_up_to,
                reason: None,
            },
            Comparison::Differs(trace) => of(Verdict::Differs, trace.to_string()),
            Comparison::Excuses {
                trace,
                words,
                all_up_to,
            } => Self {
                words: *words,
                all_up_to: *all_up_to,
                ..of(Verdict::Excuses, trace.to_string())
            },
            Comparison::NotCompared(reason) => of(Verdict::NotCompared, reason.clone()),
        }
    }
}

impl SentenceShown {
    /// Whether the sentence may become the requirement's own: its names are known, and it means what FRET's formulas do as
    /// far as they were compared.
    pub(super) fn can_be_taken(&self) -> bool {
        let differs = |it: &Option<ComparisonShown>| {
            it.as_ref().is_some_and(|it| it.verdict == Verdict::Differs)
        };
        self.sentence.is_some()
            && self.definitions.is_empty()
            && self.not_in_vocabulary.is_empty()
            && self.probability.is_none()
            && !differs(&self.runs)
    }
}

/// The sentences of a document of FRET's; none of other formats.
pub(super) fn of_document(study: &Study, document: &Document) -> Vec<SentenceShown> {
    if document.format != Format::Fret {
        return Vec::new();
    }
    document
        .items
        .iter()
        .map(|placed| of_item(study, placed))
        .collect()
}

fn of_item(study: &Study, placed: &Placed) -> SentenceShown {
    let step_secs = study.about.model.step_secs();
    let text = &placed.item.text;
    let read = fret::translated(text);
    let translation = read.as_ref().ok();
    let compared = |sentence: &Sentence, formulas: &Formulas| {
        fret::compare(sentence, formulas, translation, step_secs)
    };
    let formulas = placed.formulas.as_ref();
    let meaning: Option<Meaning> = translation
        .zip(formulas)
        .map(|(it, formulas)| compared(&it.sentence, formulas));
    let own = study
        .forms
        .by_id(&placed.item.id)
        .and_then(|form| form.sentence.as_ref());
    let own_runs = own
        .zip(formulas)
        .map(|(own, formulas)| compared(&own.tree, formulas).runs);
    let shown = |comparison: &Comparison| ComparisonShown::new(comparison);
    SentenceShown {
        id: placed.item.id.clone(),
        sentence: translation.map(|it| it.text.clone()),
        not_translated: read.as_ref().err().cloned(),
        definitions: translation.map_or(Vec::new(), |it| {
            let all = it.definitions.iter();
            all.map(|(name, meaning)| format!("{name}: {meaning}"))
                .collect()
        }),
        not_in_vocabulary: translation.map_or(Vec::new(), |it| unknown(study, it)),
        notes: translation.map_or(Vec::new(), |it| it.notes.clone()),
        runs: meaning.as_ref().map(|it| shown(&it.runs)),
        ends: meaning.as_ref().map(|it| shown(&it.ends)),
        probability: meaning.and_then(|it| it.probability),
        verbatim: formulas.and_then(|formulas| verbatim(text, translation, formulas, step_secs)),
        own: own.map(|it| it.text.clone()),
        own_runs: own_runs.as_ref().map(shown),
    }
}

/// Which of the requirements that a document of FRET's has after an export have a sentence in the study that their text does not
/// say: FRET reads the text, and makes its formulas of it. `text` gives the text of a requirement that is written.
pub(super) fn of_texts(
    study: &Study,
    document: &Document,
    sentences: &[SentenceShown],
    text: impl Fn(&str) -> Option<String>,
) -> Vec<String> {
    if document.format != Format::Fret {
        return Vec::new();
    }
    let note = |form: &study::SubjectForm| {
        let id = form.subject.id();
        let own = form.sentence.as_ref()?;
        let written = text(id);
        let known = sentences.iter().find(|it| it.id == id);
        let is_said = known
            .and_then(|it| it.own_runs.as_ref())
            .is_some_and(|it| it.verdict == Verdict::Differs);
        // Of a text that stays, FRET's formulas have told it already.
        if written.is_none() && (is_said || known.is_none()) {
            return None;
        }
        let is_new = written.is_some();
        let text = written.or_else(|| document.item(id).map(|it| it.item.text.clone()))?;
        // What is no sentence of FRET's is a text for people.
        let read = fret::translated(&text).ok()?;
        let why = match fret::compare_with_text(&own.tree, &read, study.about.model.step_secs()) {
            Comparison::Differs(trace) => trace.to_string(),
            Comparison::NotCompared(reason) => reason,
            Comparison::Same { .. } | Comparison::Excuses { .. } => return None,
        };
        let is = if is_new { "is exported with" } else { "has" };
        Some(format!(
            "{id}: the study's sentence `{}` does not say what its text says, of which FRET makes its formulas ({why}): it {is} the text `{}`. Change the text, too, and export it again.",
            own.text,
            diagnostic::shortened(&text)
        ))
    };
    study.forms.subjects.iter().filter_map(note).collect()
}

/// The names of a sentence that the vocabulary does not have.
fn unknown(study: &Study, translation: &Translation) -> Vec<String> {
    let names = translation.sentence.propositions();
    let is_known = |name: &str| study.vocabulary.propositions.contains_key(name);
    let unknown = names.into_iter().filter(|name| !is_known(name));
    unknown.map(str::to_owned).collect()
}

/// FRET's text read as it is by our language, if that can be and means something else than FRET's formulas.
fn verbatim(
    text: &str,
    translation: Option<&Translation>,
    formulas: &Formulas,
    step_secs: Option<f64>,
) -> Option<ComparisonShown> {
    let read = parse(text, &Context::default());
    if read.has_errors() || translation.is_some_and(|it| it.text == read.tree.to_string()) {
        return None;
    }
    let runs = fret::compare(&read.tree, formulas, translation, step_secs).runs;
    let shown = ComparisonShown::new(&runs);
    (shown.verdict == Verdict::Differs).then_some(shown)
}
