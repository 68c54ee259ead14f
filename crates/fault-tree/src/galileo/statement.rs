//! Statements, from words to definitions. A statement with a mistake ends at its `;`, and the next one is read.

use std::ops::Range;

use num_rational::BigRational;
use num_traits::One;

use super::lexer::{Placed, Token};
use crate::data::EventData;
use crate::decimal::decimal;
use crate::draft::{Argument, Body, Draft};
use crate::mistakes::Mistakes;
use crate::reading::Settings;
use crate::tree::Connective;

/// Gates whose result depends on the order of failures, or that make events dependent, and why each is refused.
const DYNAMIC: [(&str, &str); 14] = [
    ("pand", "it depends on the order of failures"),
    ("por", "it depends on the order of failures"),
    ("seq", "it forbids orders of failures"),
    ("mutex", "it makes events exclude each other"),
    ("fdep", "it makes one event cause others"),
    ("pdep", "it makes one event cause others"),
    (
        "rdep",
        "it changes the rate of an event when another occurs",
    ),
    ("inspect", "it repairs events at certain times"),
    ("wsp", "a spare fails at another rate while it is not used"),
    ("csp", "a spare fails at another rate while it is not used"),
    (
        "hsp",
        "a spare is claimed by one gate, in the order of failures",
    ),
    (
        "spare",
        "a spare fails at another rate while it is not used",
    ),
    ("pand-inc", "it depends on the order of failures"),
    ("por-inc", "it depends on the order of failures"),
];

pub(super) struct Statements<'a, 'm> {
    pub settings: &'a Settings,
    pub draft: &'a mut Draft,
    pub mistakes: &'a mut Mistakes<'m>,
    pub warnings: &'a mut Mistakes<'m>,
}

impl Statements<'_, '_> {
    pub fn read(&mut self, tokens: &[Placed<'_>]) {
        let mut rest = tokens;
        while !rest.is_empty() {
            let end = rest
                .iter()
                .position(|(token, _)| *token == Token::Semicolon);
            let (statement, after) = rest.split_at(end.unwrap_or(rest.len()));
            if let (None, Some((_, span))) = (end, statement.last()) {
                self.mistakes.add(
                    span.clone(),
                    "this statement does not end",
                    "end it with `;`",
                );
            }
            self.statement(statement);
            rest = after.get(1..).unwrap_or_default();
        }
    }

    fn statement(&mut self, tokens: &[Placed<'_>]) {
        match tokens {
            [] => {}
            [(Token::Word("toplevel"), _), rest @ ..] => self.top(rest, &tokens[0].1),
            [(Token::Word("param"), span), ..] => self.mistakes.refuse(
                span.clone(),
                "`param` declares a number without a value, and a probability needs one",
                "write numbers in place of parameters",
            ),
            [(Token::Quoted(name) | Token::Word(name), span), rest @ ..] => {
                self.definition(name, span, rest)
            }
            [(Token::Equals | Token::Semicolon, span), ..] => {
                self.mistakes.add(
                    span.clone(),
                    "a statement begins with a name",
                    "write `\"name\"` first",
                );
            }
        }
    }

    fn top(&mut self, rest: &[Placed<'_>], span: &Range<usize>) {
        let [(Token::Quoted(name) | Token::Word(name), place)] = rest else {
            return self.mistakes.add(
                span.clone(),
                "`toplevel` has one name",
                "write `toplevel \"name\";`",
            );
        };
        if let Some((_, first)) = &self.draft.top {
            let first = first.clone();
            self.mistakes.add(
                place.clone(),
                "there is a second `toplevel`",
                "keep one of them",
            );
            return self.mistakes.relate(first, "the first is here");
        }
        self.draft.top = Some(((*name).to_owned(), place.clone()));
    }

    fn definition(&mut self, name: &str, span: &Range<usize>, rest: &[Placed<'_>]) {
        let body = match rest {
            [] => {
                self.mistakes.add(
                    span.clone(),
                    format!("`{name}` is neither a gate nor a basic event"),
                    "write a gate (`and`, `or`, `2of3`) with its arguments, or `prob=` or `lambda=`",
                );
                Body::Unknown
            }
            [(Token::Word(_), _), (Token::Equals, _), ..] => self.basic(name, span, rest),
            [(Token::Word(gate), place), arguments @ ..] => self.gate(gate, place, arguments),
            [(_, place), ..] => {
                self.mistakes.add(
                    place.clone(),
                    "the name of a gate or an attribute is expected here",
                    "write for example `and`, `2of3` or `prob=0.1`",
                );
                Body::Unknown
            }
        };
        self.draft.define(Some(name.to_owned()), span.clone(), body);
    }

    fn gate(&mut self, gate: &str, place: &Range<usize>, tokens: &[Placed<'_>]) -> Body {
        let mut arguments = Vec::with_capacity(tokens.len());
        let mut is_wrong = false;
        for (token, span) in tokens {
            match token {
                Token::Quoted(name) | Token::Word(name) => {
                    arguments.push(Argument::Name((*name).to_owned(), span.clone()));
                }
                Token::Equals | Token::Semicolon => {
                    self.mistakes
                        .add(span.clone(), "a gate has names only", "take this away");
                    is_wrong = true;
                }
            }
        }
        match self.connective(gate, place, arguments.len()) {
            Some(connective) if !is_wrong => Body::Gate(connective, arguments),
            _ => Body::Unknown,
        }
    }

    fn connective(&mut self, gate: &str, place: &Range<usize>, count: usize) -> Option<Connective> {
        let lower = gate.to_ascii_lowercase();
        // `pdep=0.3` is split at the sign, so it comes here as an attribute of a basic event.
        if let Some((_, reason)) = DYNAMIC.iter().find(|(name, _)| *name == lower) {
            let message =
                format!("`{gate}` is a dynamic gate: {reason}, and only static trees are read");
            self.mistakes.refuse(
                place.clone(),
                message,
                "analyse this tree with a tool for dynamic fault trees",
            );
            return None;
        }
        let Some(connective) = plain(&lower) else {
            return self.threshold(gate, &lower, place, count);
        };
        if let Err((message, remedy)) = check_count(connective, count) {
            self.mistakes
                .add(place.clone(), format!("`{gate}` {message}"), remedy);
            return None;
        }
        Some(connective)
    }

    /// `2of3`, and `vot2` in Storm's dialect.
    fn threshold(
        &mut self,
        gate: &str,
        lower: &str,
        place: &Range<usize>,
        count: usize,
    ) -> Option<Connective> {
        let Some((k, n)) = least_of(lower, count) else {
            let message = format!("`{gate}` is not a gate or an attribute that is known");
            self.mistakes.add(
                place.clone(),
                message,
                "gates are and, or, not, nand, nor, xor and for example 2of3",
            );
            return None;
        };
        if n != count {
            let message = format!("`{gate}` has {count} arguments, and says that they are {n}");
            self.mistakes.add(
                place.clone(),
                message,
                "correct the number, or the arguments",
            );
            return None;
        }
        if let Err((message, remedy)) = check_count(Connective::AtLeast(k), count) {
            self.mistakes
                .add(place.clone(), format!("`{gate}` {message}"), remedy);
            return None;
        }
        Some(Connective::AtLeast(k))
    }

    fn basic(&mut self, name: &str, span: &Range<usize>, tokens: &[Placed<'_>]) -> Body {
        let (mut probability, mut rate) = (None, None);
        let mut is_wrong = false;
        let mut rest = tokens;
        while !rest.is_empty() {
            let [
                (Token::Word(key), place),
                (Token::Equals, _),
                (Token::Word(value), at),
                after @ ..,
            ] = rest
            else {
                let message = "an attribute `name=number` is expected here";
                self.mistakes
                    .add(rest[0].1.clone(), message, "write for example `prob=0.1`");
                return Body::Unknown;
            };
            rest = after;
            let Some(number) = self.attribute(key, place, value, at) else {
                is_wrong = true;
                continue;
            };
            let kept = match key.to_ascii_lowercase().as_str() {
                "prob" => &mut probability,
                "lambda" | "rate" => &mut rate,
                _ => continue,
            };
            if kept.replace(number).is_some() {
                self.mistakes.add(
                    place.clone(),
                    format!("`{key}` is given twice"),
                    "keep one of them",
                );
                is_wrong = true;
            }
        }
        if is_wrong {
            return Body::Unknown;
        }
        self.data(name, span, probability, rate)
    }

    fn data(
        &mut self,
        name: &str,
        span: &Range<usize>,
        probability: Option<BigRational>,
        rate: Option<BigRational>,
    ) -> Body {
        let mission_time = self.settings.mission_time.clone();
        let (message, remedy) = match (probability, rate, mission_time) {
            (Some(probability), None, _) => {
                return Body::Basic(Some(EventData::Probability(probability)));
            }
            (None, Some(rate), Some(time)) => {
                return Body::Basic(Some(EventData::Rate { rate, time }));
            }
            (None, Some(_), None) => (
                format!("`{name}` has a failure rate, and no mission time is given"),
                "give the mission time",
            ),
            (Some(_), Some(_), _) => (
                format!("`{name}` has a probability and a rate"),
                "keep one of them",
            ),
            (None, None, _) => (
                format!("`{name}` has neither a probability nor a rate"),
                "write `prob=` or `lambda=`",
            ),
        };
        self.mistakes.add(span.clone(), message, remedy);
        Body::Unknown
    }

    /// The number of an attribute that is understood.
    fn attribute(
        &mut self,
        key: &str,
        place: &Range<usize>,
        value: &str,
        at: &Range<usize>,
    ) -> Option<BigRational> {
        let lower = key.to_ascii_lowercase();
        if !matches!(lower.as_str(), "prob" | "lambda" | "rate" | "dorm") {
            self.mistakes.refuse(
                place.clone(),
                format!("`{key}` {}", why_refused(&lower)),
                "use `prob=` or `lambda=` alone",
            );
            return None;
        }
        let number = decimal(value);
        let is_share = matches!(lower.as_str(), "prob" | "dorm");
        let fits = number
            .as_ref()
            .is_some_and(|it| !is_share || *it <= BigRational::one());
        if !fits {
            let expected = if is_share {
                "a number between 0 and 1"
            } else {
                "a number of at least 0"
            };
            self.mistakes.add(
                at.clone(),
                format!("`{key}` must be {expected} (got `{value}`)"),
                "correct the number",
            );
            return None;
        }
        if lower == "dorm" {
            let message = "`dorm` has no effect: only a spare gate makes an event dormant, and a static tree has none";
            self.warnings
                .add(place.clone(), message, "nothing needs to be done");
        }
        number
    }
}

fn why_refused(key: &str) -> &'static str {
    match key {
        "pdep" => {
            "is a dynamic gate: it makes one event cause others, and only static trees are read"
        }
        "repair" | "mu" => "is a repair rate, and only events that stay failed are read",
        "cov" | "res" => {
            "is about imperfect coverage, which fails a system by an event alone and is not read"
        }
        "repl" => "stands for several copies of an event, which have to be written out",
        "shape" | "mean" | "stddev" | "phases" | "interval" | "const" | "eprob" => {
            "belongs to a distribution that is not read"
        }
        _ => "is not an attribute that is known",
    }
}

/// The kind of gate that a word says which names no number.
fn plain(lower: &str) -> Option<Connective> {
    Some(match lower {
        "and" => Connective::And,
        "or" => Connective::Or,
        "not" => Connective::Not,
        "xor" => Connective::Xor,
        "nand" => Connective::Nand,
        "nor" => Connective::Nor,
        _ => return None,
    })
}

/// Of `2of3` it is 2 and 3, and of `vot2` 2 and as many as there are.
fn least_of(lower: &str, count: usize) -> Option<(usize, usize)> {
    match lower.strip_prefix("vot") {
        Some(least) => least.parse().ok().map(|least| (least, count)),
        None => {
            let (least, all) = lower.split_once("of")?;
            Some((least.parse().ok()?, all.parse().ok()?))
        }
    }
}

/// The kind of gate that a word says, if it is one that is read.
pub(super) fn connective_of(word: &str, count: usize) -> Option<Connective> {
    let lower = word.to_ascii_lowercase();
    let of_number = || least_of(&lower, count).map(|(least, _)| Connective::AtLeast(least));
    let found = plain(&lower).or_else(of_number)?;
    check_count(found, count).is_ok().then_some(found)
}

/// Whether a gate can have so many arguments: what is wrong, and what to do about it.
pub(crate) fn check_count(
    connective: Connective,
    count: usize,
) -> Result<(), (String, &'static str)> {
    match connective {
        Connective::Not if count != 1 => Err((
            format!("has one argument, and not {count}"),
            "keep one argument",
        )),
        Connective::Xor if count != 2 => Err((
            format!("has two arguments, and not {count}: tools differ in what it means of more"),
            "write what is meant with gates of two arguments",
        )),
        Connective::AtLeast(0) => Err((
            "would always occur: at least 0".to_owned(),
            "ask for at least 1",
        )),
        Connective::AtLeast(k) if k > count => Err((
            format!("can never occur: {k} of {count}"),
            "correct the numbers",
        )),
        _ if count == 0 => Err(("has no arguments".to_owned(), "name its arguments")),
        _ => Ok(()),
    }
}
