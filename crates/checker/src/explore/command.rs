//! Commands, compiled for one number domain.
//!
//! A probability is computed exactly and rounded once, whatever the domain: by [`Quotient`] arithmetic where that
//! is enough, else by that of any size, whose result is remembered for the values of the variables that occur.
//! Assignments of constants and increments become masks and summands of the packed state.

use prism_lang::ast::BinaryOp;
use prism_lang::resolved::{Command, Update};
use prism_lang::{Arithmetic, EvalError, EvalErrorKind, Expr, Number, Rational, VarIndex};
use rustc_hash::FxHashMap;

use super::code::{Code, Compiler};
use super::quotient::Quotient;
use crate::state_space::Field;

/// A probability and by how much it may be off.
#[derive(Clone, Debug)]
pub(super) struct Rounded<N> {
    pub(super) value: N,
    /// How many roundings it went through (0: it is exact); `None`: it is irrational, and its error unknown.
    pub(super) roundings: Option<u32>,
}

/// Why a number cannot be used.
pub(super) enum BadNumber {
    NoValue(EvalError),
    /// Negative, infinite or not a number where that is not allowed.
    OutOfBounds(f64),
    Underflow,
}

/// How a command changes the state.
#[derive(Clone)]
pub(super) struct CompiledCommand<'m, N> {
    pub(super) source: &'m Command,
    pub(super) updates: Vec<CompiledUpdate<'m, N>>,
    /// Whether the probabilities need not be summed up: they are known to sum to 1, or are rates.
    pub(super) sum_known: bool,
    /// Whether all probabilities are the same in every state.
    pub(super) is_constant: bool,
    /// The probability, if there is one update and it happens for sure or at a constant rate.
    pub(super) simple: Option<Rounded<N>>,
}

/// One outcome of a command.
#[derive(Clone)]
pub(super) struct CompiledUpdate<'m, N> {
    pub(super) probability: Probability<'m, N>,
    pub(super) masks: Vec<Mask>,
    pub(super) increments: Vec<Increment<'m>>,
    pub(super) computed: Vec<Computed<'m>>,
}

/// `word = (word & keep | set) + add`
#[derive(Clone, Copy, Debug)]
pub(super) struct Mask {
    pub(super) word: usize,
    pub(super) keep: u64,
    pub(super) set: u64,
    pub(super) add: u64,
}

/// What must hold for an increment (which is in a mask): the variable is in `low..=high`.
#[derive(Clone)]
pub(super) struct Increment<'m> {
    pub(super) variable: VarIndex,
    pub(super) field: Field,
    pub(super) low: i64,
    pub(super) high: i64,
    pub(super) source: &'m Expr,
}

/// An assignment of any expression; its bits are cleared by a mask.
#[derive(Clone)]
pub(super) struct Computed<'m> {
    pub(super) variable: VarIndex,
    pub(super) field: Field,
    pub(super) code: Code,
    pub(super) source: &'m Expr,
    /// Whether every value is known to be in range.
    pub(super) fits: bool,
}

/// The probability of an update, or another number that may depend on the state.
#[derive(Clone)]
pub(super) enum Probability<'m, N> {
    Constant(Rounded<N>),
    Dependent {
        expr: &'m Expr,
        fast: Option<Quotient>,
        fields: Vec<Field>,
        known: FxHashMap<Vec<i64>, Rounded<N>>,
    },
}

impl<'m, N: Arithmetic> CompiledCommand<'m, N> {
    /// Compiles a command; with `sums`, its probabilities must sum to 1.
    pub(super) fn new(source: &'m Command, sums: bool, compiler: Compiler<'_>) -> Self {
        let updates = source
            .updates
            .iter()
            .map(|u| CompiledUpdate::new(u, compiler));
        let mut updates: Vec<CompiledUpdate<'m, N>> = updates.collect();
        let is_constant =
            (updates.iter()).all(|u| matches!(u.probability, Probability::Constant(_)));
        // Outcomes that never happen.
        let never =
            |p: &Probability<'_, N>| matches!(p, Probability::Constant(c) if c.value.is_zero());
        updates.retain(|u| !never(&u.probability));
        let simple = match &updates[..] {
            [only] => match &only.probability {
                Probability::Constant(p) if !sums || p.value == N::one() => Some(p.clone()),
                _ => None,
            },
            _ => None,
        };
        Self {
            updates,
            source,
            sum_known: !sums,
            is_constant,
            simple,
        }
    }
}

impl<'m, N: Arithmetic> CompiledUpdate<'m, N> {
    fn new(source: &'m Update, compiler: Compiler<'_>) -> Self {
        let mut update = Self {
            probability: Probability::new(&source.probability, compiler),
            masks: Vec::new(),
            increments: Vec::new(),
            computed: Vec::new(),
        };
        for (variable, value) in &source.assignments {
            update.assign(*variable, value, compiler);
        }
        update
    }

    fn assign(&mut self, variable: VarIndex, source: &'m Expr, compiler: Compiler<'_>) {
        let field = compiler.layout.field(variable);
        let (low, high) = field.bounds();
        let code = compiler.code(source);
        match code {
            Code::Variable(other) if same(&other, &field) => {}
            Code::Constant(value) if low <= value && value <= high => {
                let mask = self.mask(field.word);
                mask.keep &= !(field.mask << field.shift);
                mask.set |= field.bits(value);
            }
            code => match increment(&code, &field) {
                Some(by) => {
                    let mask = self.mask(field.word);
                    mask.add = mask.add.wrapping_add((by as u64) << field.shift);
                    self.increments.push(Increment {
                        variable,
                        field,
                        low: low.saturating_sub(by.min(0)),
                        high: high.saturating_sub(by.max(0)),
                        source,
                    });
                }
                None => {
                    self.mask(field.word).keep &= !(field.mask << field.shift);
                    let fits = code.range().is_some_and(|r| low <= r.0 && r.1 <= high);
                    self.computed.push(Computed {
                        variable,
                        field,
                        code,
                        source,
                        fits,
                    });
                }
            },
        }
    }

    /// Assigns constants and adds increments.
    #[inline]
    pub(super) fn apply_masks(&self, target: &mut [u64]) {
        for mask in &self.masks {
            let word = &mut target[mask.word];
            *word = (*word & mask.keep | mask.set).wrapping_add(mask.add);
        }
    }

    fn mask(&mut self, word: usize) -> &mut Mask {
        let place = match self.masks.iter().position(|m| m.word == word) {
            Some(place) => place,
            None => {
                self.masks.push(Mask {
                    word,
                    keep: u64::MAX,
                    set: 0,
                    add: 0,
                });
                self.masks.len() - 1
            }
        };
        &mut self.masks[place]
    }
}

fn same(a: &Field, b: &Field) -> bool {
    (a.word, a.shift, a.mask) == (b.word, b.shift, b.mask)
}

/// The summand of `variable + constant`, if that is what the code says of this variable, with a range.
fn increment(code: &Code, field: &Field) -> Option<i64> {
    let Code::Operation(operator, a, b) = code else {
        return None;
    };
    let by = match (operator, &**a, &**b) {
        (BinaryOp::Plus, Code::Variable(v), Code::Constant(by))
        | (BinaryOp::Plus, Code::Constant(by), Code::Variable(v))
            if same(v, field) =>
        {
            *by
        }
        (BinaryOp::Minus, Code::Variable(v), Code::Constant(by)) if same(v, field) => {
            by.checked_neg()?
        }
        _ => return None,
    };
    // Unbounded variables are computed: their sums may overflow.
    let (low, high) = field.bounds();
    let is_small = |x: i64| x.unsigned_abs() < 1 << 62;
    (is_small(low) && is_small(high) && is_small(by)).then_some(by)
}

impl<'m, N: Arithmetic> Probability<'m, N> {
    pub(super) fn new(expr: &'m Expr, compiler: Compiler<'_>) -> Self {
        let variables = expr.variables();
        if variables.is_empty()
            && let Ok(value) = probability(expr, &[])
        {
            return Self::Constant(value);
        }
        // A constant without a value is reported where it is needed.
        Self::Dependent {
            expr,
            fast: compiler.quotient(expr),
            fields: variables
                .iter()
                .map(|v| compiler.layout.field(*v))
                .collect(),
            known: FxHashMap::default(),
        }
    }

    /// The number in a state; `slowly` gets it from the expression where the fast form gives up.
    #[inline]
    pub(super) fn value(
        &mut self,
        state: &[u64],
        compiler: Compiler<'_>,
        slowly: fn(&Expr, &[i64]) -> Result<Rounded<N>, BadNumber>,
    ) -> Result<Rounded<N>, BadNumber> {
        let (expr, fields, known) = match self {
            Self::Constant(value) => return Ok(value.clone()),
            Self::Dependent {
                expr,
                fast,
                fields,
                known,
            } => {
                let small = fast.as_ref().and_then(|f| f.value(state));
                // What is negative is judged slowly.
                if let Some(number) = small.filter(|s| !s.is_negative()).and_then(|s| s.number()) {
                    return Ok(number);
                }
                (expr, fields, known)
            }
        };
        let key: Vec<i64> = fields.iter().map(|f| f.value(state)).collect();
        if let Some(value) = known.get(&key) {
            return Ok(value.clone());
        }
        let value = slowly(expr, &compiler.values(state))?;
        known.insert(key, value.clone());
        Ok(value)
    }
}

/// A probability or rate, computed exactly (as far as it is rational) and brought into the domain.
pub(super) fn probability<N: Arithmetic>(
    expr: &Expr,
    state: &[i64],
) -> Result<Rounded<N>, BadNumber> {
    if expr.has_parameters() {
        return function(expr, state);
    }
    let number: Number = expr.eval_number(state).map_err(BadNumber::NoValue)?;
    if !number.is_non_negative() {
        return Err(BadNumber::OutOfBounds(number.to_f64()));
    }
    if !N::EXACT && !Arithmetic::is_zero(&number) && number.to_f64() < f64::MIN_POSITIVE {
        return Err(BadNumber::Underflow);
    }
    rounded(expr, &number)
}

/// A reward: as a probability, but it may be negative, and is 0 where it is too small for a double.
pub(super) fn reward<N: Arithmetic>(expr: &Expr, state: &[i64]) -> Result<Rounded<N>, BadNumber> {
    if expr.has_parameters() {
        return function(expr, state);
    }
    let number: Number = expr.eval_number(state).map_err(BadNumber::NoValue)?;
    if !number.to_f64().is_finite() {
        return Err(BadNumber::OutOfBounds(number.to_f64()));
    }
    let mut reward: Rounded<N> = rounded(expr, &number)?;
    if !N::EXACT && !Arithmetic::is_zero(&number) && number.to_f64().abs() < f64::MIN_POSITIVE {
        reward.roundings = None;
    }
    Ok(reward)
}

/// What depends on constants that were left open, in a domain that has these as numbers.
fn function<N: Arithmetic>(expr: &Expr, state: &[i64]) -> Result<Rounded<N>, BadNumber> {
    let value: N = expr.eval_number(state).map_err(BadNumber::NoValue)?;
    let known = value.to_f64();
    if !value.is_non_negative() {
        return Err(BadNumber::OutOfBounds(known));
    }
    Ok(Rounded {
        value,
        roundings: Some(0),
    })
}

fn rounded<N: Arithmetic>(expr: &Expr, number: &Number) -> Result<Rounded<N>, BadNumber> {
    let value = N::from_literal(number).ok_or({
        BadNumber::NoValue(EvalError {
            kind: EvalErrorKind::NotRational,
            span: expr.span,
        })
    })?;
    let roundings = if N::EXACT {
        Some(0)
    } else {
        let stored = Rational::from_float(value.to_f64());
        number
            .exact()
            .map(|exact| u32::from(stored.as_ref() != Some(exact)))
    };
    Ok(Rounded { value, roundings })
}
