//! How tightly operators bind, shared by the parser and the printer.

use crate::ast::{BinaryOp, Comparison, TemporalOp};

/// Levels of the expression grammar, loosest first.
pub(crate) mod level {
    /// `a U b`, `a W b`, `a R b`; operands are of the next level.
    pub(crate) const TEMPORAL_BINARY: u8 = 0;
    /// `X a`, `F a`, `G a`.
    pub(crate) const TEMPORAL_UNARY: u8 = 1;
    /// `c ? a : b`.
    pub(crate) const IF_THEN_ELSE: u8 = 2;
    /// `=>`, to the right.
    pub(crate) const IMPLIES: u8 = 3;
    /// `<=>`.
    pub(crate) const IFF: u8 = 4;
    /// `|`.
    pub(crate) const OR: u8 = 5;
    /// `&`.
    pub(crate) const AND: u8 = 6;
    /// `!`.
    pub(crate) const NOT: u8 = 7;
    /// `=`, `!=`.
    pub(crate) const EQUALITY: u8 = 8;
    /// `<`, `<=`, `>`, `>=`.
    pub(crate) const RELATION: u8 = 9;
    /// `+`, `-`.
    pub(crate) const SUM: u8 = 10;
    /// `*`, `/`.
    pub(crate) const PRODUCT: u8 = 11;
    /// `^`, to the right.
    pub(crate) const POWER: u8 = 12;
    /// `-a`.
    pub(crate) const MINUS: u8 = 13;
    /// Literals, names, calls, parentheses, `P`.
    pub(crate) const BASIC: u8 = 14;
}

/// The level of a binary operator.
pub(crate) fn level_of(operator: BinaryOp) -> u8 {
    match operator {
        BinaryOp::Implies => level::IMPLIES,
        BinaryOp::Iff => level::IFF,
        BinaryOp::Or => level::OR,
        BinaryOp::And => level::AND,
        BinaryOp::Equal | BinaryOp::NotEqual => level::EQUALITY,
        BinaryOp::Less | BinaryOp::LessEqual | BinaryOp::Greater | BinaryOp::GreaterEqual => {
            level::RELATION
        }
        BinaryOp::Plus | BinaryOp::Minus => level::SUM,
        BinaryOp::Times | BinaryOp::Divide => level::PRODUCT,
        BinaryOp::Power => level::POWER,
    }
}

/// The levels that the left and the right operand must at least have.
pub(crate) fn operand_levels(operator: BinaryOp) -> (u8, u8) {
    match level_of(operator) {
        // To the right: `a => b => c` is `a => (b => c)`.
        own @ (level::IMPLIES | level::POWER) => (own + 1, own),
        own => (own, own + 1),
    }
}

/// All binary operators.
const BINARY: [BinaryOp; 15] = [
    BinaryOp::Implies,
    BinaryOp::Iff,
    BinaryOp::Or,
    BinaryOp::And,
    BinaryOp::Equal,
    BinaryOp::NotEqual,
    BinaryOp::Less,
    BinaryOp::LessEqual,
    BinaryOp::Greater,
    BinaryOp::GreaterEqual,
    BinaryOp::Plus,
    BinaryOp::Minus,
    BinaryOp::Times,
    BinaryOp::Divide,
    BinaryOp::Power,
];

/// The binary operator of this symbol.
pub(crate) fn binary_of(symbol: &str) -> Option<BinaryOp> {
    BINARY.into_iter().find(|op| op.symbol() == symbol)
}

/// The comparison of this symbol.
pub(crate) fn comparison_of(symbol: &str) -> Option<Comparison> {
    [
        Comparison::Less,
        Comparison::LessEqual,
        Comparison::Greater,
        Comparison::GreaterEqual,
    ]
    .into_iter()
    .find(|c| c.symbol() == symbol)
}

/// The temporal operator before its operand that has this letter.
pub(crate) fn temporal_prefix(letter: &str) -> Option<TemporalOp> {
    [TemporalOp::Next, TemporalOp::Finally, TemporalOp::Globally]
        .into_iter()
        .find(|op| op.symbol() == letter)
}

/// The temporal operator between its operands that has this letter.
pub(crate) fn temporal_infix(letter: &str) -> Option<TemporalOp> {
    [
        TemporalOp::Until,
        TemporalOp::WeakUntil,
        TemporalOp::Release,
    ]
    .into_iter()
    .find(|op| op.symbol() == letter)
}
