//! Text to [`Sentence`]s. Parsing never fails: it returns what was understood and all mistakes.
//!
//! The word `shall` divides the sentence. Left of it stand the scope, the condition and the
//! component; right of it the probability, and stages joined by `then`, each with its timing and
//! its response. Clauses begin with their keywords and end at a comma, at the next keyword, or
//! where the component (`the ...`) begins. Keywords may be in any case.

mod clauses;
mod duration;
mod expression;
mod probability;
mod stages;

use trace::Parameters;

use crate::diagnostic::{Diagnostic, Parsed, Span};
use crate::expression::is_name;
use crate::lexer::{Kind, Token, tokens};
use crate::sentence::{Amount, Condition, ConditionKind, Scope, ScopeKind, Sentence, Timing};

/// What the names in a sentence may refer to.
#[derive(Clone, Copy, Debug, Default)]
pub struct Context<'c> {
    /// The declared parameters; `None` if there are none.
    pub parameters: Option<&'c Parameters>,
    /// The names of the vocabulary. `None` if they are not known, so that any name is accepted.
    pub vocabulary: Option<&'c [&'c str]>,
}

/// Reads a sentence.
///
/// ```
/// use requirement_lang::{Context, parse};
/// let parsed = parse("When grasped, the robot shal immediately satisfy slow", &Context::default());
/// assert!(parsed.has_errors());
/// let remedy = parsed.diagnostics[0].remedy.as_deref();
/// assert_eq!(remedy, Some("Did you mean `shall` instead of `shal`?"));
/// ```
#[must_use]
pub fn parse(text: &str, context: &Context<'_>) -> Parsed<Sentence> {
    let mut reader = Reader {
        text,
        context,
        diagnostics: Vec::new(),
    };
    let all = tokens(text);
    let tree = match all.get(MAX_WORDS) {
        Some(beyond) => too_long(&mut reader, beyond.span),
        None => whole(&mut reader, &all),
    };
    let mut diagnostics = reader.diagnostics;
    diagnostics.sort_by_key(|diagnostic| (diagnostic.span, !diagnostic.is_error()));
    Parsed { tree, diagnostics }
}

/// The longest sentence in words and signs, so that no tree is too deep to be walked.
const MAX_WORDS: usize = 2000;

fn too_long(reader: &mut Reader<'_>, beyond: Span) -> Sentence {
    reader.error(
        "too-long",
        beyond,
        format!("The sentence has more than {MAX_WORDS} words and signs."),
        "Give parts of it names in the vocabulary, or write several requirements.",
    );
    nothing()
}

fn whole(reader: &mut Reader<'_>, all: &[Token<'_>]) -> Sentence {
    reader.check_parentheses(all);
    match top_level(all, |token| token.is("shall")).first() {
        Some(&shall) => sentence(reader, all, shall),
        None => without_shall(reader, all),
    }
}

fn sentence(reader: &mut Reader<'_>, all: &[Token<'_>], shall: usize) -> Sentence {
    let (mut left, right) = (all[..shall].to_vec(), &all[shall + 1..]);
    // "In at least 95 % of runs, when ..." is no scope.
    let leading = probability::take(reader, &mut left);
    // "Only in M shall the robot ..." has the component behind.
    let (behind, right) = clauses::component_behind(right);
    let clauses = clauses::clauses(reader, &left, all[shall].span, behind.is_none());
    let component = behind.unwrap_or(clauses.component);
    let response = stages::stages(reader, right, all[shall].span, clauses.scope.kind);
    if let (Some(_), Some(second)) = (&leading, &response.probability) {
        probability::refuse_second(reader, second.span);
    }
    let sentence = Sentence {
        scope: clauses.scope,
        condition: clauses.condition,
        component,
        probability: leading.or(response.probability),
        stages: response.stages,
    };
    warn_of_continual_after(reader, &sentence);
    warn_of_exact_instants(reader, &sentence);
    sentence
}

/// A response so many seconds later, and not before, is judged at a sample of just that time.
fn warn_of_exact_instants(reader: &mut Reader<'_>, sentence: &Sentence) {
    for stage in &sentence.stages {
        if let Timing::After(duration) = &stage.timing
            && let Amount::Secs(secs) = duration.amount
            && secs > 0.0
        {
            reader.warning(
                "exact-instant",
                duration.span,
                "This asks for the response at one exact instant: a recording without a sample \
                 just then does not meet it.",
                "Write `within` if a response by then is meant, or `for` with the negation of the \
                 response, or resample recordings at equal steps.",
            );
        }
    }
}

/// A response that comes exactly so long after each instant of an interval, and not before, cannot
/// be: before it comes for the last instant, it has come for the first.
fn warn_of_continual_after(reader: &mut Reader<'_>, sentence: &Sentence) {
    let continual = |condition: &Condition| condition.kind == ConditionKind::Whenever;
    if let Some(stage) = sentence.stages.first()
        && let Timing::After(duration) = &stage.timing
        && sentence.condition.as_ref().is_some_and(continual)
    {
        reader.warning(
            "continual-after",
            duration.span,
            "With `whenever`, this asks for a response so long after every instant at which the \
             condition holds, and for none before.",
            "Use `when` to count from where the condition becomes true.",
        );
    }
}

fn without_shall(reader: &mut Reader<'_>, all: &[Token<'_>]) -> Sentence {
    let meant = |token: &&Token<'_>| {
        let misspelt = trace::nearest(&token.text.to_lowercase(), ["shall"]).is_some();
        misspelt || token.is_any(&["should", "must", "will"])
    };
    let near = all.iter().find(meant);
    let (span, remedy) = match near {
        Some(token) => (
            token.span,
            format!("Did you mean `shall` instead of `{}`?", token.text),
        ),
        None => (
            Span::new(0, reader.text.len()),
            "Write it as: [scope,] [condition,] the COMPONENT shall [timing] satisfy RESPONSE."
                .to_owned(),
        ),
    };
    reader.error(
        "no-shall",
        span,
        "A requirement needs the word `shall`.",
        remedy,
    );
    nothing()
}

/// The tree of a text in which nothing could be understood.
fn nothing() -> Sentence {
    Sentence {
        scope: no_scope(),
        condition: None,
        component: String::new(),
        probability: None,
        stages: Vec::new(),
    }
}

fn no_scope() -> Scope {
    Scope {
        kind: ScopeKind::Global,
        mode: crate::expression::Expression::True,
        span: Span::default(),
    }
}

/// What the parts of the parser share.
struct Reader<'r> {
    text: &'r str,
    context: &'r Context<'r>,
    diagnostics: Vec<Diagnostic>,
}

impl Reader<'_> {
    fn error(
        &mut self,
        code: &'static str,
        span: Span,
        message: impl Into<String>,
        remedy: impl Into<String>,
    ) {
        self.diagnostics
            .push(Diagnostic::error(code, span, message, remedy));
    }

    fn warning(
        &mut self,
        code: &'static str,
        span: Span,
        message: impl Into<String>,
        remedy: impl Into<String>,
    ) {
        self.diagnostics
            .push(Diagnostic::warning(code, span, message, remedy));
    }

    fn check_parentheses(&mut self, all: &[Token<'_>]) {
        let mut open = Vec::new();
        let mut unmatched = Vec::new();
        for token in all {
            match token.kind {
                Kind::Open => open.push(token.span),
                Kind::Close if open.pop().is_none() => unmatched.push(token.span),
                _ => {}
            }
        }
        for span in open.into_iter().chain(unmatched) {
            self.error(
                "parentheses",
                span,
                "This parenthesis has no partner.",
                "Add the missing one, or remove this one.",
            );
        }
    }

    /// Complains if `name` is a plain name that the vocabulary does not have.
    fn check_name(&mut self, name: &str, span: Span) {
        let Some(known) = self.context.vocabulary else {
            return;
        };
        if !is_name(name) || known.contains(&name) {
            return;
        }
        let remedy = match trace::nearest(name, known.iter().copied()) {
            Some(similar) => format!("Did you mean `{similar}`?"),
            None => "Add it to the vocabulary, or use a name that is there.".to_owned(),
        };
        self.error(
            "unknown-name",
            span,
            format!("The vocabulary has no proposition `{name}`."),
            remedy,
        );
    }
}

/// The positions outside parentheses of the words that `wanted` accepts.
fn top_level(tokens: &[Token<'_>], wanted: impl Fn(&Token<'_>) -> bool) -> Vec<usize> {
    let mut depth = 0_usize;
    let mut found = Vec::new();
    for (index, token) in tokens.iter().enumerate() {
        match token.kind {
            Kind::Open => depth += 1,
            Kind::Close => depth = depth.saturating_sub(1),
            _ if depth == 0 && wanted(token) => found.push(index),
            _ => {}
        }
    }
    found
}

/// The tokens without commas at their ends.
fn trimmed<'a, 't>(mut tokens: &'a [Token<'t>]) -> &'a [Token<'t>] {
    while let [first, rest @ ..] = tokens
        && first.kind == Kind::Comma
    {
        tokens = rest;
    }
    while let [rest @ .., last] = tokens
        && last.kind == Kind::Comma
    {
        tokens = rest;
    }
    tokens
}

/// The place of `tokens`, or just behind `before` if there are none.
fn place(tokens: &[Token<'_>], before: Span) -> Span {
    match (tokens.first(), tokens.last()) {
        (Some(first), Some(last)) => Span::new(first.span.start, last.span.end),
        _ => Span::new(before.end, before.end),
    }
}
