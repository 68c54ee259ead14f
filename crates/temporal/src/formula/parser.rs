//! Words to a formula, by recursive descent with one function for each level of precedence.

mod interval;

use std::collections::HashMap;
use std::fmt;
use std::ops::Range;

use super::ast::{AtomId, Formula, Interval};
use super::lexer::{Kind, Operator, Token, WORDS, lex};

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
        if let Some(sign) = (words.first())
            .filter(|first| first.kind == Kind::Joint && !matches!(first.text, "-" | "+"))
        {
            return Err(FormulaError::new(
                self.text,
                sign.span.clone(),
                format!("something is missing before \"{}\"", sign.text),
                "write the value to compare or compute with; a window is written [0, 2 s]"
                    .to_owned(),
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
