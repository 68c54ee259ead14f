//! Predicates and quantities over signals, in text: `/robot.state = 'release' & /robot.hand_speed <
//! 250 mm/s`. The language is defined at [`Predicate`].

mod bind;
mod bound;
mod comparison;
mod dimensions;
mod error;
mod eval;
mod functions;
mod lexer;
mod lint;
mod measure;
mod parser;
mod responsible;
mod scale;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

pub use bound::{BoundPredicate, BoundQuantity};
pub use comparison::{Comparison, ComparisonOperator, Constant, Threshold, ThresholdOrigin};
pub use error::{FrameMismatch, PredicateError, PredicateErrorKind};
pub use lint::{PredicateLint, PredicateLintKind};
pub use measure::{AxisBox, Measure, axis_boxes};
pub(crate) use parser::{Node, NodeKind, is_name, parse};

use crate::parameters::Parameters;

/// The parsed entries of a vocabulary, by name.
pub(crate) type Definitions = BTreeMap<String, Expression>;

/// A parsed text.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Expression {
    pub(crate) text: String,
    pub(crate) root: Node,
}

/// A statement about signals that is true or false, or unknown, at each time.
///
/// ```
/// use trace::{Cursor, Field, Predicate, Trace};
/// let mut trace = Trace::new();
/// let robot = trace.add_channel("/robot", vec![
///     Field::enumeration("state", ["sense", "release"]),
///     Field::number("hand_speed", "m/s"),
/// ])?;
/// trace.channels[robot].push(1.0, &[1.0, 0.2])?;
///
/// let slow = Predicate::parse("/robot.state = 'release' => /robot.hand_speed < 250 mm/s")?;
/// let slow = slow.bind(&trace)?; // looks the signals up and checks types and units, once
/// let mut cursor = Cursor::new(&trace);
/// assert_eq!(slow.eval(&cursor), None);
/// cursor.seek(1.0);
/// assert_eq!(slow.eval(&cursor), Some(true));
/// let margin = slow.robustness(&cursor).expect("all is known"); // in m/s
/// assert!((margin - 0.05).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Language
/// | form | meaning |
/// |---|---|
/// | `0.25`, `1e-3` | number |
/// | `250 mm/s`, `10 cm`, `40 deg`, `50 %` | number with a unit (see [`crate::units`]) |
/// | `true`, `false` | truth value |
/// | `'release'`, `"release"` | name of a value of an enumeration |
/// | `/robot.hand_speed` | signal: topic, dot, field; in backquotes if it has odd letters |
/// | `grasped` | another entry of the [`Vocabulary`](crate::Vocabulary), or a parameter of it |
/// | `-a`, `a * b`, `a / b`, `a + b`, `a - b` | arithmetic |
/// | `abs(a)`, `min(a, ...)`, `max(a, ...)`, `norm(a, ...)` | absolute value, least, greatest, Euclidean norm |
/// | `distance(/a, /b)` | `norm(/a.x - /b.x, /a.y - /b.y, /a.z - /b.z)`, where `/a.x` and so on are signals |
/// | `angle_difference(a, b)` | `a - b`, less whole turns, above minus half a turn and up to half a turn |
/// | `angle_between(a, b)` | its absolute value: the angle between two headings |
/// | `=` or `==`, `!=`, `<`, `<=`, `>`, `>=` | comparison |
/// | `!a` or `not a` | negation; weaker than comparison, so `!a = b` is `!(a = b)` |
/// | `a & b`, `&&`, `and` | conjunction |
/// | `a \| b`, `\|\|`, `or` | disjunction |
/// | `a => b` | implication, to the right |
///
/// Precedence falls down the table. Comparisons do not chain. Numbers are double precision and `=`
/// compares them exactly. A predicate sees the values of one moment: rates of change have to be
/// signals of their own, and "within two seconds" belongs to temporal logic.
///
/// # Missing values
/// A signal has no value before its first row and where its row holds NaN. A number computed from
/// a missing one, or by a division by zero, is missing; a comparison with a missing one is unknown;
/// and the connectives are those of Kleene's strong logic (S. C. Kleene, "Introduction to
/// Metamathematics", 1952, section 64): an unknown that cannot change the result does not matter.
///
/// # Units and frames
/// A signal has the unit and the frame of its [`Field`](crate::Field). What is added, compared or
/// put into one `min`, `max` or `norm` must have one dimension and one frame, or binding is
/// refused. Signals of one unit are computed with as they are stored; a written number is brought
/// to their unit and rounded once, so `250 mm/s` is `0.25` beside a signal in m/s. Signals of
/// different units are brought to the coherent SI unit.
///
/// A number without a unit is taken in that of the signals (and refused where they have several);
/// a signal without a unit, in that of its surroundings, but not beside a written unit. Both are
/// among the [`BoundPredicate::lints`]. A unit that is not known, as `counts`, goes together with
/// itself and with numbers without a unit. A signal without a frame goes with every frame.
///
/// # Robustness
/// How far the values are from changing the truth, positive where true, negative where false:
///
/// | form | robustness r |
/// |---|---|
/// | `a < b`, `a <= b` | b - a |
/// | `a > b`, `a >= b` | a - b |
/// | `a = b` of numbers | -abs(a - b) |
/// | `a != b` of numbers | abs(a - b) |
/// | truth values, names of enumerations | infinity if true, -infinity if false |
/// | `!a` | -r(a) |
/// | `a & b` | min(r(a), r(b)) |
/// | `a \| b` | max(r(a), r(b)) |
/// | `a => b` | max(-r(a), r(b)) |
/// | `a = b` of truth values | max(min(r(a), r(b)), min(-r(a), -r(b))), and negated for `!=` |
///
/// A difference is expressed in the coherent SI unit of its dimension (m, m/s, N, rad); without a
/// known unit, in that of the signals. Within `&` and `|` differences of different dimensions are
/// compared as plain numbers. Where the truth is known the robustness is, and it is >= 0 where that
/// is true and <= 0 where it is false; 0 is compatible with both, as `<` and `<=` have one
/// robustness. An unknown operand that does not matter to the truth is left out; were it known, the
/// robustness would have the same sign and at least the same size.
///
/// Source: A. Donzé and O. Maler, "Robust satisfaction of temporal logic over real-valued signals",
/// FORMATS 2010, section 3.1, extended to equality, truth values and unknown values.
#[derive(Debug, Clone, PartialEq)]
pub struct Predicate(Source);

/// A number computed from signals at each time, for example a distance.
///
/// ```
/// use trace::{Cursor, Field, Quantity, Trace};
/// let mut trace = Trace::new();
/// let hand = trace.add_channel("/hand", vec![Field::number("x", "m"), Field::number("y", "m")])?;
/// trace.channels[hand].push(0.0, &[3.0, -4.0])?;
/// let reach = Quantity::parse("norm(/hand.x, /hand.y)")?.bind(&trace)?;
/// let mut cursor = Cursor::new(&trace);
/// cursor.seek(0.0);
/// assert_eq!(reach.eval(&cursor), Some(5.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Quantity(Source);

/// A text and the vocabulary that its names refer to, where each name is known to be defined.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Source {
    pub(crate) expression: Expression,
    pub(crate) definitions: Arc<Definitions>,
    pub(crate) parameters: Arc<Parameters>,
}

impl Source {
    fn parse(text: &str) -> Result<Self, PredicateError> {
        crate::Vocabulary::default().source(text)
    }

    /// The signals that are read, directly or through the vocabulary.
    fn signals(&self) -> BTreeSet<String> {
        let mut signals = BTreeSet::new();
        let mut done = BTreeSet::new();
        let mut waiting = vec![&self.expression.root];
        while let Some(node) = waiting.pop() {
            if let NodeKind::Name(name) = &node.kind
                && done.insert(name)
                && let Some(definition) = self.definitions.get(name)
            {
                waiting.push(&definition.root);
            }
            signals.extend(node.own_signals());
            waiting.extend(node.children());
        }
        signals
    }
}

impl Predicate {
    /// Parses a text without a vocabulary; with one, use
    /// [`Vocabulary::predicate`](crate::Vocabulary::predicate).
    ///
    /// # Errors
    /// [`PredicateError`] with the place in the text.
    pub fn parse(text: &str) -> Result<Self, PredicateError> {
        Source::parse(text).map(Predicate)
    }

    /// Whether some recording can give it a meaning: written units go together, and it is something true or false.
    ///
    /// # Errors
    /// The first mistake, with the place in the text that has it.
    pub fn check(&self) -> Result<(), PredicateError> {
        dimensions::check(&self.0)
    }

    pub(crate) fn new(source: Source) -> Self {
        Predicate(source)
    }

    /// The text as it was written.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.0.expression.text
    }

    /// The signals that are read, as `/topic.field`, directly or through the vocabulary.
    #[must_use]
    pub fn signals(&self) -> BTreeSet<String> {
        self.0.signals()
    }
}

impl Quantity {
    /// Parses a text without a vocabulary; with one, use
    /// [`Vocabulary::quantity`](crate::Vocabulary::quantity).
    ///
    /// # Errors
    /// [`PredicateError`] with the place in the text.
    pub fn parse(text: &str) -> Result<Self, PredicateError> {
        Source::parse(text).map(Quantity)
    }

    pub(crate) fn new(source: Source) -> Self {
        Quantity(source)
    }

    /// The text as it was written.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.0.expression.text
    }

    /// The signals that are read, as `/topic.field`, directly or through the vocabulary.
    #[must_use]
    pub fn signals(&self) -> BTreeSet<String> {
        self.0.signals()
    }
}
