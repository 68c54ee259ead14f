//! FRET's sentences as sentences of ours.
//!
//! # Definition
//! `[scope] [condition] COMPONENT shall [with probability ...] [timing] satisfy RESPONSE`, word by word to the same parts of a
//! [`Sentence`], so that it means here what it means in FRET:
//!
//! * `after N` asks FRET for the response at the point behind the N-th, so it becomes `after N+1`;
//! * `when ..., when ...` are joined by `and`; `if a then b` is `a => b`; implications are in parentheses, since FRET reads
//!   `a => b => c` from the left;
//! * what is neither a name nor a comparison without parentheses (`preBool(...)`, `f(x) > 1`) becomes a name, whose definition
//!   is given beside the sentence.
//!
//! # Source
//! FRET's grammar of requirements (`Requirement.g4`, version 3) and its manual.
//!
//! # Not translated, with the reason
//! `finally` and `at the last timepoint`, `at the ... occurrence of`, free texts.

use super::expression::{Expr, Reader, Token, tokens};
use requirement_lang::expression::{Atom, Expression};
use requirement_lang::sentence::{
    Amount, Comparison, Condition, ConditionKind, Duration, Probability, Scope, ScopeKind,
    Sentence, Stage, Timing,
};
use requirement_lang::{Context, Span, parse};

/// FRET's sentence as one of ours.
#[derive(Clone, Debug)]
pub struct Translation {
    /// The sentence.
    pub sentence: Sentence,
    /// Its text.
    pub text: String,
    /// Names in it that stand for expressions of FRET: name, expression.
    pub definitions: Vec<(String, String)>,
    /// What is to be known about it, each in one sentence.
    pub notes: Vec<String>,
    /// How many seconds FRET's time point is taken for; `None` if its durations have no unit.
    pub step_secs: Option<f64>,
}

/// Translates a sentence.
///
/// # Errors
/// Why it is not one of FRET's sentences, or has no counterpart, in a few words.
///
/// ```
/// let read = requirement_files::fret::translated(
///     "When in hdg mode Autopilot shall within 3 ticks satisfy if a then b <= 2.0",
/// )?;
/// assert_eq!(
///     read.text,
///     "While hdg, the Autopilot shall within 3 steps satisfy a => b <= 2.0"
/// );
/// # Ok::<(), String>(())
/// ```
pub fn translated(text: &str) -> Result<Translation, String> {
    let tokens = tokens(text)?;
    let tokens = match tokens.split_last() {
        Some((last, rest)) if last.text == "." => rest,
        _ => &tokens[..],
    };
    let mut work = Work {
        reader: Reader::new(tokens, false),
        text,
        definitions: Vec::new(),
        notes: Vec::new(),
        step_secs: None,
    };
    let sentence = work.sentence()?;
    let shown = sentence.to_string();
    // The text is what is kept, so it has to mean what was read.
    let again = parse(&shown, &Context::default());
    if let Some(error) = again.diagnostics.iter().find(|it| it.is_error()) {
        return Err(format!("as a sentence of ours, {shown}: {}", error.message));
    }
    if again.tree.to_string() != shown {
        return Err(format!("it has no counterpart that reads back: {shown}"));
    }
    Ok(Translation {
        sentence: again.tree,
        text: shown,
        definitions: work.definitions,
        notes: work.notes,
        step_secs: work.step_secs,
    })
}

struct Work<'t> {
    reader: Reader<'t>,
    text: &'t str,
    definitions: Vec<(String, String)>,
    notes: Vec<String>,
    step_secs: Option<f64>,
}

impl<'t> Work<'t> {
    fn peek_is(&self, word: &str) -> bool {
        self.ahead(0).is_some_and(|token| token.is(word))
    }

    fn ahead(&self, by: usize) -> Option<&'t Token> {
        self.reader.ahead(by)
    }

    fn take(&mut self, word: &str) -> bool {
        let found = self.peek_is(word);
        self.reader.next += usize::from(found);
        found
    }

    fn take_all(&mut self, words: &[&str]) -> bool {
        let mut all = words.iter().enumerate();
        let found = all.all(|(by, word)| self.ahead(by).is_some_and(|token| token.is(word)));
        if found {
            self.reader.next += words.len();
        }
        found
    }

    fn sentence(&mut self) -> Result<Sentence, String> {
        let scope = self.scope()?;
        let condition = self.condition()?;
        let before = match self.peek_is("shall") {
            true => None,
            false => Some(self.component()?),
        };
        if !self.take("shall") {
            return Err(match self.ahead(0) {
                Some(token) => format!("`shall` is expected before `{}`", token.text),
                None => "it has no `shall`".into(),
            });
        }
        let component = match before {
            Some(component) => component,
            None => self.component()?,
        };
        let probability = self.probability()?;
        let timing = self.timing()?;
        if !self.take("satisfy") {
            return Err(match self.ahead(0) {
                Some(token) => format!("`satisfy` is expected before `{}`", token.text),
                None => "it has no `satisfy`".into(),
            });
        }
        let response = self.expression()?;
        if let Some(token) = self.ahead(0) {
            return Err(format!("`{}` does not continue the response", token.text));
        }
        let span = Span::default();
        Ok(Sentence {
            scope,
            condition,
            component,
            probability,
            stages: vec![Stage {
                timing,
                response,
                span,
            }],
        })
    }

    fn component(&mut self) -> Result<String, String> {
        self.take(",");
        self.take("the");
        match self.ahead(0) {
            Some(token) if token.is_word => {
                self.reader.next += 1;
                Ok(token.text.clone())
            }
            Some(token) => Err(format!("a component is expected before `{}`", token.text)),
            None => Err("it has no component".into()),
        }
    }

    fn scope(&mut self) -> Result<Scope, String> {
        let forms: [(&[&str], ScopeKind); 20] = [
            (&["only", "during"], ScopeKind::OnlyIn),
            (&["only", "when", "in"], ScopeKind::OnlyIn),
            (&["only", "if", "in"], ScopeKind::OnlyIn),
            (&["only", "in"], ScopeKind::OnlyIn),
            (&["only", "while"], ScopeKind::OnlyIn),
            (&["only", "after"], ScopeKind::OnlyAfter),
            (&["only", "before"], ScopeKind::OnlyBefore),
            (&["except", "during"], ScopeKind::NotIn),
            (&["except", "when", "in"], ScopeKind::NotIn),
            (&["except", "if", "in"], ScopeKind::NotIn),
            (&["except", "in"], ScopeKind::NotIn),
            (&["except", "while"], ScopeKind::NotIn),
            (&["when", "not", "in"], ScopeKind::NotIn),
            (&["if", "not", "in"], ScopeKind::NotIn),
            (&["unless", "in"], ScopeKind::NotIn),
            (&["when", "in"], ScopeKind::In),
            (&["if", "in"], ScopeKind::In),
            (&["in"], ScopeKind::In),
            (&["during"], ScopeKind::In),
            (&["while"], ScopeKind::In),
        ];
        let pair: [(&[&str], ScopeKind); 2] = [
            (&["after"], ScopeKind::After),
            (&["before"], ScopeKind::Before),
        ];
        let found = forms
            .iter()
            .chain(&pair)
            .find(|(words, _)| self.take_all(words));
        let span = Span::default();
        let Some((_, kind)) = found else {
            return Ok(Scope {
                kind: ScopeKind::Global,
                mode: Expression::True,
                span,
            });
        };
        self.take("mode");
        let mode = self.expression()?;
        self.take("mode");
        self.take(",");
        let kind = *kind;
        Ok(Scope { kind, mode, span })
    }

    fn condition(&mut self) -> Result<Option<Condition>, String> {
        self.take("and");
        let mut found: Option<Condition> = None;
        loop {
            let before = self.reader.next;
            self.take(",");
            let or = self.take("or");
            if !or {
                self.take("and");
            }
            let Some(kind) = self.qualifier() else {
                self.reader.next = before;
                self.take(",");
                return Ok(found);
            };
            let mut expression = self.expression()?;
            if self.take("is") {
                match (self.take("true"), self.take("false")) {
                    (true, _) => {}
                    (false, true) => expression = expression.negation(),
                    _ => return Err("`true` or `false` is expected behind `is`".into()),
                }
            }
            found = Some(match found {
                None => Condition {
                    kind,
                    expression,
                    span: Span::default(),
                },
                Some(first) => {
                    let second = match kind {
                        ConditionKind::Unless => expression.negation(),
                        _ => expression,
                    };
                    let both = vec![first.triggering(), second];
                    Condition {
                        kind: match first.kind {
                            ConditionKind::Whenever => ConditionKind::Whenever,
                            _ => ConditionKind::Upon,
                        },
                        expression: match or {
                            true => Expression::Or(both),
                            false => Expression::And(both),
                        },
                        span: Span::default(),
                    }
                }
            });
        }
    }

    fn qualifier(&mut self) -> Option<ConditionKind> {
        let kinds = [
            ("upon", ConditionKind::Upon),
            ("whenever", ConditionKind::Whenever),
            ("when", ConditionKind::Upon),
            ("where", ConditionKind::Upon),
            ("if", ConditionKind::Upon),
            ("unless", ConditionKind::Unless),
        ];
        let found = kinds.into_iter().find(|(word, _)| self.peek_is(word));
        found.map(|(_, kind)| {
            self.reader.next += 1;
            kind
        })
    }

    fn probability(&mut self) -> Result<Option<Probability>, String> {
        self.take(",");
        if !self.take("with") {
            return Ok(None);
        }
        if !self.take("probability") {
            return Err("`probability` is expected behind `with`".into());
        }
        let comparisons = [
            (">=", Comparison::AtLeast),
            ("<=", Comparison::AtMost),
            (">", Comparison::MoreThan),
            ("<", Comparison::LessThan),
        ];
        let sign = comparisons.into_iter().find(|(sign, _)| self.take(sign));
        let (_, comparison) =
            sign.ok_or("the probability is not compared by `<`, `<=`, `>` or `>=`")?;
        let number = self.ahead(0).map(|token| token.text.clone());
        self.reader.next += 1;
        let number = number.ok_or("a number is expected behind the comparison")?;
        let value = number.parse::<f64>().ok();
        let value = value.filter(|value| (0.0..=1.0).contains(value));
        self.take(",");
        Ok(Some(Probability {
            comparison,
            value: value.ok_or_else(|| format!("`{number}` is not a probability"))?,
            decimal: number,
            span: Span::default(),
        }))
    }

    fn timing(&mut self) -> Result<Timing, String> {
        self.take(",");
        let simple = [
            ("immediately", Timing::Immediately),
            ("initially", Timing::Immediately),
            ("eventually", Timing::Eventually),
            ("always", Timing::Always),
            ("never", Timing::Never),
        ];
        let found = simple.into_iter().find(|(word, _)| self.take(word));
        let timing = match found {
            Some((_, timing)) => timing,
            None if self.take("within") => Timing::Within(self.duration(0)?),
            None if self.take("for") => Timing::For(self.duration(0)?),
            None if self.take("after") => Timing::After(self.duration(1)?),
            None if self.take("until") => Timing::Until(self.expression()?),
            None if self.take("before") => Timing::Before(self.expression()?),
            None if self.take_all(&["at", "the", "next", "timepoint"]) => Timing::Next,
            None if self.take_all(&["at", "the", "first", "timepoint"])
                || self.take_all(&["at", "the", "same", "timepoint"]) =>
            {
                Timing::Immediately
            }
            None if self.peek_is("finally") || self.take_all(&["at", "the", "last"]) => {
                return Err("a response at the last point of the scope has no counterpart".into());
            }
            None => Timing::Eventually,
        };
        self.take(",");
        Ok(timing)
    }

    /// A duration, longer by so many time points than it says.
    fn duration(&mut self, longer: u32) -> Result<Duration, String> {
        let number = self.ahead(0).map_or("", |token| token.text.as_str());
        let count = number.parse::<u32>().ok();
        let count =
            count.ok_or_else(|| format!("`{number}` is not a whole number of time units"))?;
        let unit = self
            .ahead(1)
            .map_or(String::new(), |token| token.text.to_ascii_lowercase());
        let units: [(&str, &str, f64); 6] = [
            ("tick", "", 0.0),
            ("microsec", "us", 1e-6),
            ("millisec", "ms", 1e-3),
            ("sec", "s", 1.0),
            ("minute", "min", 60.0),
            ("hour", "h", 3600.0),
        ];
        let known = units.iter().find(|(word, ..)| unit.starts_with(word));
        let Some((_, short, secs)) = known else {
            return Err(format!("`{unit}` is not a unit of time"));
        };
        self.reader.next += 2;
        let longest = count.checked_add(longer).ok_or("a duration is too long")?;
        if longer > 0 {
            self.notes.push(format!(
                "FRET's `after {count}` asks for the response one time point later, so it becomes `after {longest}`."
            ));
        }
        if short.is_empty() {
            return Ok(Duration::steps(longest));
        }
        self.step_secs = Some(*secs);
        self.notes.push(format!(
            "FRET counts {count} time points; the sentence says {longest} {short}, which is the same if a time point is 1 {short}."
        ));
        Ok(Duration {
            text: format!("{longest} {short}"),
            amount: Amount::Secs(f64::from(longest) * secs),
            span: Span::default(),
        })
    }

    fn expression(&mut self) -> Result<Expression, String> {
        let read = self.reader.expression()?;
        self.boolean(&read)
    }

    /// A boolean expression as one of ours.
    fn boolean(&mut self, read: &Expr) -> Result<Expression, String> {
        let mut pair = |left: &Expr, right: &Expr| -> Result<[Expression; 2], String> {
            Ok([self.boolean(left)?, self.boolean(right)?])
        };
        Ok(match read {
            Expr::True => Expression::True,
            Expr::False => Expression::False,
            Expr::Not(inner) => self.boolean(inner)?.negation(),
            Expr::And(left, right) => Expression::And(flat(pair(left, right)?, true)),
            Expr::Or(left, right) => Expression::Or(flat(pair(left, right)?, false)),
            Expr::Implies(left, right) => {
                let [left, right] = pair(left, right)?;
                Expression::Implies(Box::new(left), Box::new(right))
            }
            Expr::Iff(left, right) => {
                let [left, right] = pair(left, right)?;
                Expression::Iff(Box::new(left), Box::new(right))
            }
            Expr::Xor(left, right) => {
                let [left, right] = pair(left, right)?;
                Expression::Iff(Box::new(left), Box::new(right)).negation()
            }
            Expr::Number(number) => return Err(format!("`{number}` is neither true nor false")),
            atom => self.atom(atom),
        })
    }

    /// A name or a comparison as it is, all else by a name of its own.
    fn atom(&mut self, atom: &Expr) -> Expression {
        let text = match plain(atom) {
            Some(text) => text,
            None => self.named(atom),
        };
        let span = Span::default();
        Expression::Atom(Atom { text, span })
    }

    fn named(&mut self, atom: &Expr) -> String {
        let definition = atom.to_string();
        let known = self.definitions.iter().find(|(_, it)| *it == definition);
        if let Some((name, _)) = known {
            return name.clone();
        }
        let wanted = match atom {
            Expr::Point(_) => "first_time_point".to_owned(),
            _ => name_of(&definition),
        };
        let is_taken = |name: &str| {
            self.definitions.iter().any(|(known, _)| known == name) || self.text.contains(name)
        };
        let mut name = wanted.clone();
        let mut count = 2;
        while is_taken(&name) {
            name = format!("{wanted}_{count}");
            count += 1;
        }
        self.definitions.push((name.clone(), definition));
        name
    }
}

/// Operands of the same connective in one list, as our texts are read.
fn flat(pair: [Expression; 2], is_and: bool) -> Vec<Expression> {
    let [left, right] = pair;
    let mut all = match left {
        Expression::And(all) if is_and => all,
        Expression::Or(all) if !is_and => all,
        other => vec![other],
    };
    match right {
        Expression::And(more) if is_and => all.extend(more),
        Expression::Or(more) if !is_and => all.extend(more),
        other => all.push(other),
    }
    all
}

/// A name, or a comparison without parentheses, as our sentences have it.
fn plain(atom: &Expr) -> Option<String> {
    let is_name = |name: &str| {
        name.starts_with(|letter: char| letter.is_alphabetic() || letter == '_')
            && name
                .chars()
                .all(|letter| letter.is_alphanumeric() || letter == '_')
    };
    match atom {
        Expr::Name(name) if is_name(name) => Some(name.clone()),
        Expr::Operation(sign, left, right) if is_comparison(sign) => {
            Some(format!("{} {sign} {}", operand(left)?, operand(right)?))
        }
        _ => None,
    }
}

fn is_comparison(sign: &str) -> bool {
    matches!(sign, "=" | "!=" | "<" | "<=" | ">" | ">=")
}

/// A number or name, with its sign.
fn operand(side: &Expr) -> Option<String> {
    match side {
        Expr::Name(name) if name.chars().all(|it| it.is_alphanumeric() || it == '_') => {
            Some(name.clone())
        }
        Expr::Number(number) => Some(number.clone()),
        Expr::Minus(inner) => match **inner {
            Expr::Number(_) | Expr::Name(_) => Some(format!("-{}", operand(inner)?)),
            _ => None,
        },
        _ => None,
    }
}

/// A name made of an expression.
fn name_of(definition: &str) -> String {
    const LONGEST: usize = 40;
    let mut name = String::new();
    let words = [
        ("<=", " le "),
        (">=", " ge "),
        ("!=", " ne "),
        ("<", " lt "),
        (">", " gt "),
        ("=", " eq "),
        ("!", " not "),
    ];
    let mut text = definition.to_owned();
    for (sign, word) in words {
        text = text.replace(sign, word);
    }
    for letter in text.chars() {
        match letter.is_ascii_alphanumeric() {
            true => name.push(letter.to_ascii_lowercase()),
            false if name.is_empty() || name.ends_with('_') => {}
            false => name.push('_'),
        }
        if name.len() >= LONGEST {
            break;
        }
    }
    let name = name.trim_end_matches('_');
    match name.starts_with(|first: char| first.is_ascii_alphabetic()) {
        true => name.to_owned(),
        false => format!("it_{name}"),
    }
}
