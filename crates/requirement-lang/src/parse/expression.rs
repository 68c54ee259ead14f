//! Boolean expressions from tokens, by recursive descent; precedence as in [`crate::expression`].

use super::Reader;
use crate::diagnostic::Span;
use crate::expression::{Atom, Expression, is_name};
use crate::lexer::{Kind, Token};

/// How deeply parentheses may nest, so that no text can exhaust the stack.
const MAX_DEPTH: usize = 64;

/// Words that begin another part of the sentence, so that a phrase with one of them would hide it.
const MISPLACED: [&str; 12] = [
    "when", "whenever", "upon", "if", "unless", "where", "while", "during", "only", "shall",
    "then", "satisfy",
];

/// Reads all of `tokens` as an expression. `after` is where an operand is missed if there is none.
pub(super) fn expression(reader: &mut Reader<'_>, tokens: &[Token<'_>], after: Span) -> Expression {
    let mut parser = Parser {
        reader,
        tokens,
        next: 0,
        after,
        depth: 0,
    };
    let mut read = parser.equivalence();
    if let Some(token) = parser.tokens.get(parser.next) {
        let (span, text) = (token.span, token.text.to_owned());
        parser.reader.error(
            "unexpected",
            span,
            format!("Here `{text}` does not continue the expression."),
            "Join propositions with `and`, `or`, `=>`, and balance the parentheses.",
        );
        read = Expression::Missing;
    }
    read
}

struct Parser<'p, 'r, 't> {
    reader: &'p mut Reader<'r>,
    tokens: &'p [Token<'t>],
    next: usize,
    after: Span,
    depth: usize,
}

impl Parser<'_, '_, '_> {
    fn kind(&self) -> Option<Kind> {
        self.tokens.get(self.next).map(|token| token.kind)
    }

    fn take(&mut self, kind: Kind) -> bool {
        let found = self.kind() == Some(kind);
        self.next += usize::from(found);
        found
    }

    fn equivalence(&mut self) -> Expression {
        let mut left = self.implication();
        loop {
            let differs = self.kind() == Some(Kind::Xor);
            if !differs && self.kind() != Some(Kind::Iff) {
                return left;
            }
            self.next += 1;
            let right = self.implication();
            let same = Expression::Iff(Box::new(left), Box::new(right));
            left = if differs { same.negation() } else { same };
        }
    }

    /// Reads operands first and folds them from the right, so that a chain needs no recursion.
    fn implication(&mut self) -> Expression {
        let mut operands = vec![self.disjunction()];
        while self.take(Kind::Implies) {
            operands.push(self.disjunction());
        }
        let last = operands.pop().unwrap_or(Expression::Missing);
        operands.into_iter().rev().fold(last, |right, left| {
            Expression::Implies(Box::new(left), Box::new(right))
        })
    }

    fn disjunction(&mut self) -> Expression {
        let mut operands = vec![self.conjunction()];
        while self.take(Kind::Or) {
            operands.push(self.conjunction());
        }
        several(operands, Expression::Or)
    }

    fn conjunction(&mut self) -> Expression {
        let mut operands = vec![self.negation()];
        while self.take(Kind::And) {
            operands.push(self.negation());
        }
        several(operands, Expression::And)
    }

    fn negation(&mut self) -> Expression {
        let mut negated = 0;
        while self.take(Kind::Not) {
            negated += 1;
        }
        let inner = self.primary();
        // Two negations cancel out, so that a long row of them is no deep tree.
        match negated % 2 {
            0 => inner,
            _ => inner.negation(),
        }
    }

    fn primary(&mut self) -> Expression {
        if self.kind() == Some(Kind::Open)
            && let Some(close) = closing(self.tokens, self.next)
            && !continues_arithmetic(self.tokens.get(close + 1))
        {
            return self.group(close);
        }
        let first = self.next;
        while let Some(token) = self.tokens.get(self.next) {
            match token.kind {
                Kind::Word => self.next += 1,
                Kind::Open => match closing(self.tokens, self.next) {
                    Some(close) if self.next == first || self.calls(token.span) => {
                        self.next = close + 1;
                    }
                    _ => break,
                },
                _ => break,
            }
        }
        self.atom(first)
    }

    /// Whether a parenthesis at `open`, which follows a word, belongs to that word's atom.
    fn calls(&self, open: Span) -> bool {
        let before = &self.tokens[self.next - 1];
        before.span.end == open.start || before.text.ends_with(is_operator)
    }

    fn group(&mut self, close: usize) -> Expression {
        let span = self.tokens[self.next].span;
        if self.depth == MAX_DEPTH {
            self.reader.error(
                "too-deep",
                span,
                format!("Parentheses nest more than {MAX_DEPTH} deep here."),
                "Give parts of the expression a name in the vocabulary.",
            );
            self.next = close + 1;
            return Expression::Missing;
        }
        let mut inner = Parser {
            reader: &mut *self.reader,
            tokens: &self.tokens[..close],
            next: self.next + 1,
            after: span,
            depth: self.depth + 1,
        };
        let mut read = inner.equivalence();
        if let Some(rest) = inner.tokens.get(inner.next) {
            let rest = rest.span;
            inner.reader.error(
                "unexpected",
                rest,
                "This does not continue the expression in the parentheses.",
                "Join propositions with `and`, `or` or `=>`.",
            );
            read = Expression::Missing;
        }
        self.next = close + 1;
        read
    }

    fn atom(&mut self, first: usize) -> Expression {
        let Some(tokens) = self
            .tokens
            .get(first..self.next)
            .filter(|tokens| !tokens.is_empty())
        else {
            return self.nothing();
        };
        let span = Span::new(tokens[0].span.start, tokens[tokens.len() - 1].span.end);
        let words: Vec<&str> = tokens.iter().map(|token| token.text).collect();
        if let [rest @ .., is, constant] = tokens
            && is.is("is")
            && constant.is_any(&["true", "false"])
            && !rest.is_empty()
        {
            let span = Span::new(rest[0].span.start, rest[rest.len() - 1].span.end);
            let stated = self.named(&words[..words.len() - 2], span);
            return if constant.is("true") {
                stated
            } else {
                stated.negation()
            };
        }
        match words.as_slice() {
            [one] if one.eq_ignore_ascii_case("true") => Expression::True,
            [one] if one.eq_ignore_ascii_case("false") => Expression::False,
            words => self.named(words, span),
        }
    }

    fn named(&mut self, words: &[&str], span: Span) -> Expression {
        let misplaced = |word: &&&str| {
            MISPLACED
                .iter()
                .any(|other| word.eq_ignore_ascii_case(other))
        };
        if let Some(word) = words.iter().find(misplaced) {
            self.reader.error(
                "misplaced",
                span,
                format!("`{word}` stands inside an expression."),
                "Put scope and condition before the component, and begin a stage with `, then`; a name \
                 cannot have this word as a part of its own.",
            );
            return Expression::Missing;
        }
        if words.iter().all(|word| is_name(word)) {
            let text = phrase(words);
            self.reader.check_name(&text, span);
            return Expression::Atom(Atom { text, span });
        }
        let text = single_spaced(span.of(self.reader.text));
        let odd = words.iter().find(|word| !is_name(word)).unwrap_or(&"");
        let operator = text.contains(|letter| is_operator(letter) || letter == '(');
        let stop = text.ends_with('.') || !text.contains(char::is_alphanumeric);
        if stop || (words.len() > 1 && !operator) {
            self.reader.error(
                "phrase",
                span,
                format!(
                    "This is neither a name nor a comparison, since a name cannot contain `{odd}`."
                ),
                "Write a name of the vocabulary, a phrase of plain words, or a comparison such as \
                 `speed < 250 mm/s`.",
            );
            return Expression::Missing;
        }
        Expression::Atom(Atom { text, span })
    }

    fn nothing(&mut self) -> Expression {
        let (span, message) = match self.tokens.get(self.next) {
            Some(token) => (
                token.span,
                format!("A proposition is missing before `{}`.", token.text),
            ),
            None => {
                let end = self
                    .tokens
                    .last()
                    .map_or(self.after.end, |last| last.span.end);
                (
                    Span::new(end, end),
                    "A proposition is missing here.".to_owned(),
                )
            }
        };
        self.reader.error(
            "missing-proposition",
            span,
            message,
            "Write a name of the vocabulary, or a comparison such as `speed < 250 mm/s`.",
        );
        if self.next < self.tokens.len() {
            self.next += 1;
        }
        Expression::Missing
    }
}

/// Several words are the name with underscores between them; an article at the beginning is left out.
fn phrase(words: &[&str]) -> String {
    let article = ["the", "a", "an"]
        .iter()
        .any(|article| words[0].eq_ignore_ascii_case(article));
    words[usize::from(article && words.len() > 1)..].join("_")
}

fn several(mut operands: Vec<Expression>, join: fn(Vec<Expression>) -> Expression) -> Expression {
    match operands.len() {
        1 => operands.pop().unwrap_or(Expression::Missing),
        _ => join(operands),
    }
}

/// Where the parenthesis opened at `open` is closed.
fn closing(tokens: &[Token<'_>], open: usize) -> Option<usize> {
    let mut depth = 0_usize;
    for (index, token) in tokens.iter().enumerate().skip(open) {
        match token.kind {
            Kind::Open => depth += 1,
            Kind::Close if depth == 1 => return Some(index),
            Kind::Close => depth = depth.saturating_sub(1),
            _ => {}
        }
    }
    None
}

/// Whether a parenthesis before this token was part of a number.
fn continues_arithmetic(token: Option<&Token<'_>>) -> bool {
    token.is_some_and(|token| token.kind == Kind::Word && token.text.starts_with(is_operator))
}

fn is_operator(letter: char) -> bool {
    "<>=+-*/!".contains(letter)
}

/// The text with each run of white space as one space; texts in quotes are left alone.
fn single_spaced(text: &str) -> String {
    let mut spaced = String::with_capacity(text.len());
    let mut quote: Option<char> = None;
    for letter in text.chars() {
        match quote {
            Some(open) if letter == open => quote = None,
            None if matches!(letter, '\'' | '"' | '`') => quote = Some(letter),
            _ => {}
        }
        if quote.is_some() || !letter.is_whitespace() {
            spaced.push(letter);
        } else if !spaced.ends_with(' ') {
            spaced.push(' ');
        }
    }
    spaced
}
