//! Words to trees, by recursive descent with one function for each level of precedence.

use std::ops::Range;

use super::error::{PredicateError, PredicateErrorKind};
use super::lexer::{Token, lex};
use crate::suggest::nearest;
use crate::units::QuantityValue;

/// The deepest nesting of a tree, so that walking it cannot exhaust a thread's stack.
pub(crate) const MAX_DEPTH: usize = 256;

/// A part of an expression and its place in the text.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Node {
    pub(crate) kind: NodeKind,
    pub(crate) span: Range<usize>,
    /// Number of nodes on the longest path down from here.
    depth: usize,
}

#[derive(Debug, Clone, PartialEq)]
pub(crate) enum NodeKind {
    Number(Box<QuantityValue>),
    Bool(bool),
    Text(String),
    Signal(String),
    Name(String),
    Not(Box<Node>),
    Negate(Box<Node>),
    Binary(Operator, Box<Node>, Box<Node>),
    Call(Function, Vec<Node>),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Operator {
    Add,
    Subtract,
    Multiply,
    Divide,
    And,
    Or,
    Implies,
    Compare(Comparison),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Comparison {
    Equal,
    NotEqual,
    Less,
    LessEqual,
    Greater,
    GreaterEqual,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Function {
    Abs,
    Min,
    Max,
    Norm,
    Distance,
    AngleDifference,
    AngleBetween,
}

const FUNCTIONS: [(&str, Function, &str); 7] = [
    ("abs", Function::Abs, "abs(a)"),
    ("min", Function::Min, "min(a, b, ...)"),
    ("max", Function::Max, "max(a, b, ...)"),
    ("norm", Function::Norm, "norm(a, b, ...)"),
    (
        "distance",
        Function::Distance,
        "distance(/a, /b), where /a.x, /a.y, /a.z and so on are signals",
    ),
    (
        "angle_difference",
        Function::AngleDifference,
        "angle_difference(a, b)",
    ),
    (
        "angle_between",
        Function::AngleBetween,
        "angle_between(a, b)",
    ),
];

/// Functions that people look for, but that need more than the values of one moment.
const NOT_OF_AN_INSTANT: [&str; 12] = [
    "derivative",
    "diff",
    "rate",
    "integral",
    "previous",
    "prev",
    "next",
    "delay",
    "mean",
    "average",
    "rise",
    "fall",
];

const COMPARISONS: [(&str, Comparison); 6] = [
    ("=", Comparison::Equal),
    ("!=", Comparison::NotEqual),
    ("<", Comparison::Less),
    ("<=", Comparison::LessEqual),
    (">", Comparison::Greater),
    (">=", Comparison::GreaterEqual),
];

impl Node {
    /// The parts directly below.
    pub(crate) fn children(&self) -> Vec<&Node> {
        match &self.kind {
            NodeKind::Not(inner) | NodeKind::Negate(inner) => vec![inner],
            NodeKind::Binary(_, left, right) => vec![left, right],
            NodeKind::Call(Function::Distance, _) => Vec::new(),
            NodeKind::Call(_, arguments) => arguments.iter().collect(),
            _ => Vec::new(),
        }
    }

    /// The signals that this node reads itself, not through its children.
    pub(crate) fn own_signals(&self) -> Vec<String> {
        match &self.kind {
            NodeKind::Signal(name) => vec![name.clone()],
            NodeKind::Call(Function::Distance, arguments) => {
                let prefixes = arguments
                    .iter()
                    .filter_map(|argument| match &argument.kind {
                        NodeKind::Signal(prefix) => Some(prefix),
                        _ => None,
                    });
                prefixes
                    .flat_map(|prefix| ["x", "y", "z"].map(|axis| format!("{prefix}.{axis}")))
                    .collect()
            }
            _ => Vec::new(),
        }
    }
}

/// Parses the whole of `text`.
pub(crate) fn parse(text: &str) -> Result<Node, PredicateError> {
    let error = |(kind, span)| PredicateError {
        text: text.to_owned(),
        entry: None,
        span,
        kind,
    };
    let tokens = lex(text).map_err(error)?;
    let mut parser = Parser {
        tokens,
        next: 0,
        nesting: 0,
    };
    parser.whole().map_err(error)
}

/// Whether `word` can be the name of an entry: letters, digits and underscores, not beginning with
/// a digit, and without a meaning in the language.
pub(crate) fn is_name(word: &str) -> bool {
    let first_fits = word.starts_with(|letter: char| letter.is_alphabetic() || letter == '_');
    let rest_fits = word
        .chars()
        .all(|letter| letter.is_alphanumeric() || letter == '_');
    let reserved = matches!(word, "true" | "false" | "and" | "or" | "not")
        || FUNCTIONS.iter().any(|(name, ..)| *name == word);
    first_fits && rest_fits && !reserved
}

type ParseError = (PredicateErrorKind, Range<usize>);
type Parse = Result<Node, ParseError>;

struct Parser {
    tokens: Vec<(Token, Range<usize>)>,
    next: usize,
    nesting: usize,
}

impl Parser {
    fn whole(&mut self) -> Parse {
        let node = self.implication()?;
        match self.peek() {
            Token::End => Ok(node),
            _ => Err(self.unexpected("an operator or the end")),
        }
    }

    fn peek(&self) -> &Token {
        // The last word is End, and it is never passed.
        &self.tokens[self.next].0
    }

    fn span(&self) -> Range<usize> {
        self.tokens[self.next].1.clone()
    }

    fn advance(&mut self) {
        self.next = (self.next + 1).min(self.tokens.len() - 1);
    }

    /// Takes the operator or bracket `symbol` if it comes next.
    fn take(&mut self, symbol: &str) -> bool {
        let found = matches!(self.peek(), Token::Symbol(next) if *next == symbol);
        if found {
            self.advance();
        }
        found
    }

    fn unexpected(&self, expected: &'static str) -> ParseError {
        let found = match self.peek() {
            Token::Number(number) => format!("the number {number}"),
            Token::Text(text) => format!("'{text}'"),
            Token::Signal(signal) => format!("the signal {signal}"),
            Token::Name(name) => format!("the name {name}"),
            Token::Symbol(symbol) => format!("\"{symbol}\""),
            Token::End => "the end".to_owned(),
        };
        (
            PredicateErrorKind::Unexpected { found, expected },
            self.span(),
        )
    }

    /// Builds a node, unless it would be too deep.
    fn node(&self, kind: NodeKind, span: Range<usize>) -> Parse {
        let mut node = Node {
            kind,
            span,
            depth: 0,
        };
        let below = match &node.kind {
            NodeKind::Call(_, arguments) => arguments.iter().map(|child| child.depth).max(),
            _ => node.children().iter().map(|child| child.depth).max(),
        };
        node.depth = below.unwrap_or(0) + 1;
        if node.depth > MAX_DEPTH {
            return Err((PredicateErrorKind::TooLarge, node.span));
        }
        Ok(node)
    }

    fn binary(&self, operator: Operator, left: Node, right: Node) -> Parse {
        let span = left.span.start..right.span.end;
        self.node(
            NodeKind::Binary(operator, Box::new(left), Box::new(right)),
            span,
        )
    }

    /// Runs `parse` one level deeper.
    fn nested(&mut self, parse: fn(&mut Self) -> Parse) -> Parse {
        if self.nesting >= MAX_DEPTH / 4 {
            return Err((PredicateErrorKind::TooLarge, self.span()));
        }
        self.nesting += 1;
        let node = parse(self);
        self.nesting -= 1;
        node
    }

    fn implication(&mut self) -> Parse {
        let left = self.disjunction()?;
        if !self.take("=>") {
            return Ok(left);
        }
        let right = self.nested(Self::implication)?;
        self.binary(Operator::Implies, left, right)
    }

    fn disjunction(&mut self) -> Parse {
        self.chain(&[("|", Operator::Or)], Self::conjunction)
    }

    fn conjunction(&mut self) -> Parse {
        self.chain(&[("&", Operator::And)], Self::negation)
    }

    fn sum(&mut self) -> Parse {
        self.chain(
            &[("+", Operator::Add), ("-", Operator::Subtract)],
            Self::product,
        )
    }

    fn product(&mut self) -> Parse {
        self.chain(
            &[("*", Operator::Multiply), ("/", Operator::Divide)],
            Self::sign,
        )
    }

    /// Operands joined by operators that group to the left.
    fn chain(&mut self, operators: &[(&str, Operator)], operand: fn(&mut Self) -> Parse) -> Parse {
        let mut left = operand(self)?;
        while let Some(&(_, operator)) = operators.iter().find(|(symbol, _)| self.take(symbol)) {
            let right = operand(self)?;
            left = self.binary(operator, left, right)?;
        }
        Ok(left)
    }

    fn negation(&mut self) -> Parse {
        let start = self.span().start;
        if !self.take("!") {
            return self.comparison();
        }
        let inner = self.nested(Self::negation)?;
        let span = start..inner.span.end;
        self.node(NodeKind::Not(Box::new(inner)), span)
    }

    fn comparison(&mut self) -> Parse {
        let left = self.sum()?;
        let Some(comparison) = self.take_comparison() else {
            return Ok(left);
        };
        let right = self.sum()?;
        let span = self.span();
        if self.take_comparison().is_some() {
            return Err((PredicateErrorKind::ChainedComparison, span));
        }
        self.binary(Operator::Compare(comparison), left, right)
    }

    fn take_comparison(&mut self) -> Option<Comparison> {
        let found = COMPARISONS.iter().find(|(symbol, _)| self.take(symbol));
        found.map(|&(_, comparison)| comparison)
    }

    fn sign(&mut self) -> Parse {
        let start = self.span().start;
        if !self.take("-") {
            return self.primary();
        }
        let inner = self.nested(Self::sign)?;
        let span = start..inner.span.end;
        self.node(NodeKind::Negate(Box::new(inner)), span)
    }

    fn primary(&mut self) -> Parse {
        let span = self.span();
        let kind = match self.peek().clone() {
            Token::Number(number) => NodeKind::Number(number),
            Token::Text(text) => NodeKind::Text(text),
            Token::Signal(signal) => NodeKind::Signal(signal),
            Token::Name(name) => return self.name(name, span),
            Token::Symbol("(") => return self.bracket(),
            _ => return Err(self.unexpected("a number, a signal, a name or a bracket")),
        };
        self.advance();
        self.node(kind, span)
    }

    fn bracket(&mut self) -> Parse {
        let start = self.span().start;
        self.advance();
        let mut node = self.nested(Self::implication)?;
        let end = self.span().end;
        if !self.take(")") {
            return Err(self.unexpected("an operator or \")\""));
        }
        node.span = start..end;
        Ok(node)
    }

    fn name(&mut self, name: String, span: Range<usize>) -> Parse {
        self.advance();
        if !self.take("(") {
            let kind = match name.as_str() {
                "true" => NodeKind::Bool(true),
                "false" => NodeKind::Bool(false),
                _ => NodeKind::Name(name),
            };
            return self.node(kind, span);
        }
        let known = FUNCTIONS.iter().find(|(spelling, ..)| *spelling == name);
        let Some(&(spelling, function, usage)) = known else {
            let similar = nearest(&name, FUNCTIONS.iter().map(|(spelling, ..)| *spelling));
            let kind = if NOT_OF_AN_INSTANT.contains(&name.as_str()) {
                PredicateErrorKind::NotInstantaneous { name }
            } else {
                PredicateErrorKind::UnknownFunction { name, similar }
            };
            return Err((kind, span));
        };
        let arguments = self.arguments()?;
        let span = span.start..self.tokens[self.next - 1].1.end;
        if !accepts(function, &arguments) {
            let kind = PredicateErrorKind::ArgumentCount {
                function: spelling,
                usage,
            };
            return Err((kind, span));
        }
        self.node(NodeKind::Call(function, arguments), span)
    }

    /// The arguments of a call up to its closing bracket.
    fn arguments(&mut self) -> Result<Vec<Node>, ParseError> {
        let mut arguments = Vec::new();
        if self.take(")") {
            return Ok(arguments);
        }
        loop {
            arguments.push(self.nested(Self::implication)?);
            if self.take(")") {
                return Ok(arguments);
            }
            if !self.take(",") {
                return Err(self.unexpected("\",\" or \")\""));
            }
        }
    }
}

fn accepts(function: Function, arguments: &[Node]) -> bool {
    match function {
        Function::Abs => arguments.len() == 1,
        Function::Min | Function::Max | Function::Norm => !arguments.is_empty(),
        Function::AngleDifference | Function::AngleBetween => arguments.len() == 2,
        Function::Distance => {
            arguments.len() == 2
                && arguments
                    .iter()
                    .all(|node| matches!(node.kind, NodeKind::Signal(_)))
        }
    }
}
