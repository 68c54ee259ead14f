//! Words to a formula, by recursive descent with one function for each level of precedence.

use std::collections::HashMap;
use std::fmt;
use std::ops::Range;

use super::ast::{AtomId, Bound, Formula, Interval, TimeUnit};
use super::lexer::{Kind, Operator, Token, WORDS, lex};
use super::settings::TimeModel;

/// The deepest nesting of a formula, so that walking it cannot exhaust a thread's stack.
pub const MAX_DEPTH: usize = 100;

/// The text of an atom and where it stands first.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct AtomText {
    /// The text as it was written.
    pub text: String,
    /// Its place, in bytes of the formula's text.
    pub span: Range<usize>,
}

/// A formula read from text, with the texts of its atoms.
#[derive(Debug, Clone, PartialEq)]
pub struct Parsed {
    /// The formula.
    pub formula: Formula,
    /// Its atoms, each once: [`AtomId`] is a position in this list.
    pub atoms: Vec<AtomText>,
}

impl fmt::Display for Parsed {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.formula.display(&self.atoms).fmt(out)
    }
}

/// Why a text is not a formula.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FormulaError {
    /// The text that was read.
    pub text: String,
    /// The place of the mistake, in bytes.
    pub span: Range<usize>,
    /// What is wrong.
    pub message: String,
    /// What to do about it.
    pub remedy: String,
}

impl FormulaError {
    pub(super) fn new(text: &str, span: Range<usize>, message: String, remedy: String) -> Self {
        FormulaError {
            text: text.to_owned(),
            span,
            message,
            remedy,
        }
    }
}

impl fmt::Display for FormulaError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let column = self
            .text
            .get(..self.span.start)
            .map_or(0, |before| before.chars().count())
            + 1;
        write!(
            out,
            "in the formula \"{}\", column {column}: {}; {}",
            self.text, self.message, self.remedy
        )
    }
}

impl std::error::Error for FormulaError {}

/// Reads a formula. `parameters` gives the value in seconds of a name in an interval, as in
/// `eventually[0, release_time] released`, or `None` if it has none.
///
/// # Errors
/// [`FormulaError`] with the place in the text.
pub fn parse(text: &str, parameters: &dyn Fn(&str) -> Option<f64>) -> Result<Parsed, FormulaError> {
    let mut parser = Parser {
        text,
        tokens: lex(text)?,
        next: 0,
        depth: 0,
        parameters,
        atoms: Vec::new(),
        known: HashMap::new(),
    };
    let formula = parser.equivalence()?;
    match parser.kind() {
        Kind::End => Ok(Parsed {
            formula,
            atoms: parser.atoms,
        }),
        Kind::Close | Kind::CloseSquare => Err(parser.error(
            format!("this \"{}\" closes nothing", parser.peek().text),
            "remove it, or open a bracket before it",
        )),
        _ => Err(parser.error(
            format!("{} cannot follow here", parser.found()),
            "put an operator such as \"and\", \"=>\" or \"until\" before it",
        )),
    }
}

struct Parser<'t> {
    text: &'t str,
    tokens: Vec<Token<'t>>,
    next: usize,
    depth: usize,
    parameters: &'t dyn Fn(&str) -> Option<f64>,
    atoms: Vec<AtomText>,
    /// The number of each atom, by its words with one space between them.
    known: HashMap<String, usize>,
}

type Parse = Result<Formula, FormulaError>;

impl<'t> Parser<'t> {
    fn peek(&self) -> &Token<'t> {
        // The last word is End, and it is never passed.
        &self.tokens[self.next]
    }

    fn kind(&self) -> Kind {
        self.peek().kind
    }

    fn advance(&mut self) -> Token<'t> {
        let token = self.tokens[self.next].clone();
        self.next = (self.next + 1).min(self.tokens.len() - 1);
        token
    }

    fn take(&mut self, kind: Kind) -> bool {
        let found = self.kind() == kind;
        if found {
            self.advance();
        }
        found
    }

    fn take_operator(&mut self, operator: Operator) -> bool {
        self.take(Kind::Operator(operator))
    }

    fn found(&self) -> String {
        match self.kind() {
            Kind::End => "the end".to_owned(),
            _ => format!("\"{}\"", self.peek().text),
        }
    }

    fn error(&self, message: String, remedy: &str) -> FormulaError {
        FormulaError::new(
            self.text,
            self.peek().span.clone(),
            message,
            remedy.to_owned(),
        )
    }

    /// Runs `parse` one level deeper.
    fn nested(&mut self, parse: fn(&mut Self) -> Parse) -> Parse {
        if self.depth >= MAX_DEPTH {
            return Err(self.error(
                "the formula is nested too deeply".to_owned(),
                "name parts of it in the vocabulary",
            ));
        }
        self.depth += 1;
        let formula = parse(self);
        self.depth -= 1;
        formula
    }

    fn equivalence(&mut self) -> Parse {
        let left = self.implication()?;
        if !self.take_operator(Operator::Iff) {
            return Ok(left);
        }
        let right = self.nested(Self::equivalence)?;
        Ok(Formula::Iff(Box::new(left), Box::new(right)))
    }

    fn implication(&mut self) -> Parse {
        let left = self.disjunction()?;
        if !self.take_operator(Operator::Implies) {
            return Ok(left);
        }
        let right = self.nested(Self::implication)?;
        Ok(Formula::implies(left, right))
    }

    fn disjunction(&mut self) -> Parse {
        let mut operands = vec![self.conjunction()?];
        while self.take_operator(Operator::Or) {
            operands.push(self.conjunction()?);
        }
        Ok(one_or(operands, Formula::Or))
    }

    fn conjunction(&mut self) -> Parse {
        let mut operands = vec![self.until()?];
        while self.take_operator(Operator::And) {
            operands.push(self.until()?);
        }
        Ok(one_or(operands, Formula::And))
    }

    /// The operators of time with two operands; they bind more closely than `and`, to the right.
    fn until(&mut self) -> Parse {
        let left = self.unary()?;
        let build = match self.kind() {
            Kind::Operator(Operator::Until) => Formula::Until,
            Kind::Operator(Operator::WeakUntil) => Formula::WeakUntil,
            Kind::Operator(Operator::Release) => Formula::Release,
            Kind::Operator(Operator::Since) => Formula::Since,
            _ => return Ok(left),
        };
        self.advance();
        let interval = self.interval()?;
        let right = self.nested(Self::until)?;
        Ok(build(interval, Box::new(left), Box::new(right)))
    }

    fn unary(&mut self) -> Parse {
        let Kind::Operator(operator) = self.kind() else {
            return self.primary();
        };
        let build: fn(Interval, Box<Formula>) -> Formula = match operator {
            Operator::Not => |_, inner| Formula::Not(inner),
            Operator::Next => |_, inner| Formula::Next(inner),
            Operator::Previous => |_, inner| Formula::Previous(inner),
            Operator::Rise => |_, inner| Formula::Rise(inner),
            Operator::Fall => |_, inner| Formula::Fall(inner),
            Operator::Eventually => Formula::Eventually,
            Operator::Always => Formula::Always,
            Operator::Once => Formula::Once,
            Operator::Historically => Formula::Historically,
            _ => return self.primary(),
        };
        self.advance();
        let windowed = matches!(
            operator,
            Operator::Eventually | Operator::Always | Operator::Once | Operator::Historically
        );
        let interval = if windowed {
            self.interval()?
        } else {
            Interval::UNBOUNDED
        };
        Ok(build(interval, Box::new(self.nested(Self::unary)?)))
    }

    fn primary(&mut self) -> Parse {
        match self.kind() {
            Kind::Open if !self.opens_atom() => {
                let open = self.advance();
                let formula = self.nested(Self::equivalence)?;
                if self.take(Kind::Close) {
                    return Ok(formula);
                }
                if self.kind() == Kind::End {
                    return Err(FormulaError::new(
                        self.text,
                        open.span,
                        "this \"(\" is never closed".to_owned(),
                        "add \")\" where its part ends".to_owned(),
                    ));
                }
                Err(self.error(
                    format!("{} cannot follow here", self.found()),
                    "put an operator such as \"and\" before it, or close the bracket with \")\"",
                ))
            }
            Kind::Open | Kind::Word | Kind::Number | Kind::Joint => self.atom(),
            _ => Err(self.error(
                format!("a statement is missing before {}", self.found()),
                "write a name such as \"grasped\", a comparison such as \"/robot.hand_speed < 0.25\", \
                 or a formula in parentheses",
            )),
        }
    }

    /// Whether the parenthesis here belongs to arithmetic: what follows its end goes on with an
    /// operator of arithmetic or a comparison.
    fn opens_atom(&self) -> bool {
        let mut open = 0usize;
        for (index, token) in self.tokens.iter().enumerate().skip(self.next) {
            match token.kind {
                Kind::Open => open += 1,
                Kind::Close => open = open.saturating_sub(1),
                _ => {}
            }
            if open == 0 {
                return self
                    .tokens
                    .get(index + 1)
                    .is_some_and(|after| after.kind == Kind::Joint);
            }
        }
        false
    }

    /// Takes the words up to the next operator of logic or time, or bracket not opened here.
    fn atom(&mut self) -> Parse {
        let first = self.next;
        let mut open: Vec<Range<usize>> = Vec::new();
        loop {
            match self.kind() {
                Kind::Open | Kind::OpenSquare => open.push(self.peek().span.clone()),
                Kind::Close | Kind::CloseSquare if open.pop().is_none() => break,
                Kind::Comma if open.is_empty() => {
                    return Err(self.error(
                        "a comma can only separate the arguments of a function".to_owned(),
                        "use \"and\" to demand both parts",
                    ));
                }
                Kind::End => break,
                Kind::Operator(_) if open.is_empty() => {
                    if self.next > first && self.tokens[self.next - 1].kind == Kind::Joint {
                        return Err(self.operator_as_name());
                    }
                    break;
                }
                _ => {}
            }
            self.advance();
        }
        if let Some(span) = open.pop() {
            return Err(FormulaError::new(
                self.text,
                span,
                "this bracket is never closed".to_owned(),
                "close it where its part ends".to_owned(),
            ));
        }
        self.finish_atom(first)
    }

    fn operator_as_name(&self) -> FormulaError {
        self.error(
            format!(
                "the operator {} stands where a value is needed",
                self.found()
            ),
            "if it is the name of a signal, put it in backquotes",
        )
    }

    /// The atom from word `first` to here.
    fn finish_atom(&mut self, first: usize) -> Parse {
        let words = &self.tokens[first..self.next];
        let span = words.first().map_or(0, |word| word.span.start)
            ..words.last().map_or(0, |word| word.span.end);
        if let Some(last) = words.last().filter(|last| last.kind == Kind::Joint) {
            return Err(FormulaError::new(
                self.text,
                last.span.clone(),
                format!("something is missing behind \"{}\"", last.text),
                "write the value to compare or compute with".to_owned(),
            ));
        }
        if let Some(pair) = (words.windows(2)).find(|pair| is_juxtaposed(pair)) {
            return Err(juxtaposed(self.text, pair));
        }
        let text = &self.text[span.clone()];
        if text == "true" || text == "false" {
            return Ok(if text == "true" {
                Formula::True
            } else {
                Formula::False
            });
        }
        let key = words
            .iter()
            .map(|word| word.text)
            .collect::<Vec<_>>()
            .join(" ");
        let count = self.atoms.len();
        let id = *self.known.entry(key).or_insert(count);
        if id == count {
            self.atoms.push(AtomText {
                text: text.to_owned(),
                span,
            });
        }
        Ok(Formula::Atom(AtomId(id)))
    }

    /// `[low, high]` if it comes next.
    fn interval(&mut self) -> Result<Interval, FormulaError> {
        let start = self.peek().span.start;
        if !self.take(Kind::OpenSquare) {
            return Ok(Interval::UNBOUNDED);
        }
        let low = self.bound()?;
        let remedy = "write it as [0, 2 s], [0.5 s, inf] or [0, 50 samples]";
        let Some(low) = low else {
            return Err(self.error("an interval cannot begin at infinity".to_owned(), remedy));
        };
        if !self.take(Kind::Comma) {
            return Err(self.error(
                format!("{} stands where the interval needs \",\"", self.found()),
                remedy,
            ));
        }
        let high = self.bound()?;
        let closed = self.take(Kind::CloseSquare) || high.is_none() && self.take(Kind::Close);
        if !closed {
            return Err(self.error(
                format!("{} stands where the interval needs \"]\"", self.found()),
                remedy,
            ));
        }
        let span = start..self.tokens[self.next - 1].span.end;
        self.settle(low, high, span)
    }

    /// Gives a bound without a unit that of the other, and checks the ends.
    fn settle(
        &self,
        (mut low, low_scale): (Bound, f64),
        high: Option<(Bound, f64)>,
        span: Range<usize>,
    ) -> Result<Interval, FormulaError> {
        let mut interval = Interval { low, high: None };
        if let Some((mut high, high_scale)) = high {
            match (low.unit, high.unit) {
                (TimeUnit::Unstated, unit) => low = in_unit(low, unit, high_scale),
                (unit, TimeUnit::Unstated) => high = in_unit(high, unit, low_scale),
                _ => {}
            }
            interval = Interval {
                low,
                high: Some(high),
            };
        }
        // Units that are not stated are settled later; here, only what is wrong in any case.
        match interval.window(TimeModel::Discrete) {
            Err(error) => {
                let message = error.to_string();
                let (message, remedy) =
                    message.split_once("; ").unwrap_or((&message, "correct it"));
                Err(FormulaError::new(
                    self.text,
                    span,
                    message.to_owned(),
                    remedy.to_owned(),
                ))
            }
            Ok(_) => Ok(interval),
        }
    }

    /// A bound with the factor of its unit to the unit of time or count; `None` for infinity.
    fn bound(&mut self) -> Result<Option<(Bound, f64)>, FormulaError> {
        let token = self.peek().clone();
        match token.kind {
            Kind::Number => {
                self.advance();
                let Ok(value) = token.text.parse::<f64>() else {
                    return Err(
                        self.error("this number cannot be read".to_owned(), "write it as 0.5")
                    );
                };
                let (unit, scale) = self.unit()?;
                let bound = in_unit(
                    Bound {
                        value,
                        unit: TimeUnit::Unstated,
                    },
                    unit,
                    scale,
                );
                Ok(Some((bound, scale)))
            }
            Kind::Word if matches!(token.text, "inf" | "infinity" | "∞") => {
                self.advance();
                Ok(None)
            }
            Kind::Word => match (self.parameters)(token.text) {
                Some(secs) => {
                    self.advance();
                    Ok(Some((Bound::secs(secs), 1.0)))
                }
                None => Err(self.error(
                    format!("{} is not the name of a duration", self.found()),
                    "declare it as a parameter with a unit of time, or write a number",
                )),
            },
            _ => Err(self.error(
                format!(
                    "{} stands where a bound of the interval is needed",
                    self.found()
                ),
                "write a number with a unit, as in [0, 2 s], a parameter's name or inf",
            )),
        }
    }

    /// A unit if one comes next, and how many seconds or samples it is.
    fn unit(&mut self) -> Result<(TimeUnit, f64), FormulaError> {
        if self.kind() != Kind::Word {
            return Ok((TimeUnit::Unstated, 1.0));
        }
        let found = UNITS.iter().find(|(name, ..)| *name == self.peek().text);
        let Some(&(_, unit, scale)) = found else {
            return Err(self.error(
                format!("{} is not a unit of time", self.found()),
                "use ns, us, ms, s, min, h or samples",
            ));
        };
        self.advance();
        Ok((unit, scale))
    }
}

const UNITS: [(&str, TimeUnit, f64); 15] = [
    ("ns", TimeUnit::Seconds, 1e-9),
    ("us", TimeUnit::Seconds, 1e-6),
    ("µs", TimeUnit::Seconds, 1e-6),
    ("ms", TimeUnit::Seconds, 1e-3),
    ("s", TimeUnit::Seconds, 1.0),
    ("sec", TimeUnit::Seconds, 1.0),
    ("secs", TimeUnit::Seconds, 1.0),
    ("second", TimeUnit::Seconds, 1.0),
    ("seconds", TimeUnit::Seconds, 1.0),
    ("min", TimeUnit::Seconds, 60.0),
    ("h", TimeUnit::Seconds, 3600.0),
    ("sample", TimeUnit::Samples, 1.0),
    ("samples", TimeUnit::Samples, 1.0),
    ("step", TimeUnit::Samples, 1.0),
    ("steps", TimeUnit::Samples, 1.0),
];

/// The bound, whose number counts units of `scale`.
fn in_unit(bound: Bound, unit: TimeUnit, scale: f64) -> Bound {
    // Dividing by a power of ten that a double holds exactly gives the double nearest to the
    // decimal that was written, which multiplying by its reciprocal may miss.
    let value = if scale < 1.0 {
        bound.value / (1.0 / scale).round()
    } else {
        bound.value * scale
    };
    Bound { value, unit }
}

fn one_or(mut operands: Vec<Formula>, build: fn(Vec<Formula>) -> Formula) -> Formula {
    if operands.len() == 1 {
        operands.swap_remove(0)
    } else {
        build(operands)
    }
}

/// Whether two words of an atom stand side by side with nothing between them, other than a number
/// and its unit.
fn is_juxtaposed(pair: &[Token<'_>]) -> bool {
    let ends = matches!(pair[0].kind, Kind::Word | Kind::Close | Kind::CloseSquare);
    ends && matches!(pair[1].kind, Kind::Word | Kind::Number) && pair[1].text != "%"
}

fn juxtaposed(text: &str, pair: &[Token<'_>]) -> FormulaError {
    let second = pair[1].text;
    let lower = second.to_lowercase();
    let operator = (WORDS.iter()).find(|(word, _)| word.len() > 1 && *word == lower);
    let remedy = match operator {
        Some((word, _)) => format!("operators are written in small letters: \"{word}\""),
        None => "put an operator such as \"and\", \"=>\" or \"until\" between them".to_owned(),
    };
    FormulaError::new(
        text,
        pair[1].span.clone(),
        format!("\"{second}\" directly follows \"{}\"", pair[0].text),
        remedy,
    )
}
