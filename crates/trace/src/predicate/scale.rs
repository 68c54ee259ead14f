//! In which unit and frame the numbers of an expression are, and how several come to be in one.
//!
//! # Definition
//! A signal has the unit of its field; a field may also have none (undeclared) or one that is not
//! known here, as `counts` (opaque). A number has the unit that is written behind it, or none
//! (bare). A product or quotient has the product or quotient of the units.
//!
//! What is added, compared or put into one `min`, `max`, `norm` must have one dimension and is
//! brought to one unit: to that of the signals if they agree, otherwise to the coherent SI unit.
//! So a text in which all signals have the same unit and numbers have none is computed on the
//! stored values without any rounding by conversion, and a number with a unit is rounded once
//! (see [`crate::units`]). A bare number is taken in the unit of the signals; where those differ,
//! it is refused, unless it is 0. An undeclared unit is taken to be that of its surroundings, but
//! never to be that of a written number.
//!
//! Frames: components in different frames must not meet in these places either. Of a `norm`, a
//! product or a quotient no frame remains; a field without a frame goes with every frame.

use super::eval::Amount;
use super::lint::PredicateLintKind;
use super::{FrameMismatch, PredicateErrorKind};
use crate::channel::Field;
use crate::units::{Conversion, Dimension, QuantityValue, Unit};

/// The unit of an amount, as far as it is known.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Scale {
    /// A number without a unit.
    Bare,
    /// A signal, named here, whose unit is not declared; or what was computed from it.
    Undeclared(String),
    /// A unit that is only known to be equal to itself.
    Opaque(String),
    /// A known unit.
    Unit(Unit),
    /// The coherent unit to which signals of these different units were brought.
    Mixed(Unit, Vec<String>),
}

/// A frame and a signal that is expressed in it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Framed {
    pub(super) frame: String,
    pub(super) signal: String,
}

/// An amount with all that is known of it.
#[derive(Debug, Clone)]
pub(super) struct Operand {
    pub(super) amount: Amount,
    pub(super) scale: Scale,
    pub(super) frame: Option<Framed>,
    /// Whether no signal is read.
    pub(super) constant: bool,
    /// The number as it was written, if it is one, and whether a minus stands before it.
    pub(super) written: Option<(QuantityValue, bool)>,
}

/// Amounts brought to one unit and frame.
pub(super) struct Unified {
    pub(super) amounts: Vec<Amount>,
    pub(super) scale: Scale,
    pub(super) frame: Option<Framed>,
    pub(super) constant: bool,
    /// What should be looked at, each with the position of the operand.
    pub(super) lints: Vec<(usize, PredicateLintKind)>,
}

/// What does not fit, with the positions of the two operands.
pub(super) type Misfit = (PredicateErrorKind, usize, usize);

impl Scale {
    pub(super) fn of_field(field: &Field, signal: &str) -> Self {
        let text = field.unit.trim();
        if text.is_empty() {
            return Scale::Undeclared(signal.to_owned());
        }
        match text.parse::<Unit>() {
            Ok(unit) => Scale::Unit(unit),
            Err(_) => Scale::Opaque(text.to_owned()),
        }
    }

    pub(super) fn unit(&self) -> Option<&Unit> {
        match self {
            Scale::Unit(unit) | Scale::Mixed(unit, _) => Some(unit),
            _ => None,
        }
    }

    pub(super) fn describe(&self) -> String {
        match self {
            Scale::Bare => "a number without a unit".to_owned(),
            Scale::Undeclared(signal) => format!("{signal}, whose unit is not declared,"),
            Scale::Opaque(text) => format!("an amount in {text}"),
            Scale::Unit(unit) | Scale::Mixed(unit, _) => describe(unit),
        }
    }

    /// The scale of a product or quotient; `None` if it is out of range.
    pub(super) fn product(&self, other: &Scale, divided: bool) -> Option<Scale> {
        let combine = |left: &Unit, right: &Unit| {
            if divided {
                left.divided_by(right)
            } else {
                left.times(right)
            }
        };
        Some(match (self, other) {
            (Scale::Undeclared(signal), _) | (_, Scale::Undeclared(signal)) => {
                Scale::Undeclared(signal.clone())
            }
            (Scale::Bare, Scale::Bare) => Scale::Bare,
            (Scale::Opaque(left), Scale::Opaque(right)) if divided && left == right => {
                Scale::Unit(Unit::one())
            }
            (Scale::Opaque(_), _) | (_, Scale::Opaque(_)) => opaque_product(self, other, divided),
            _ => {
                let one = Unit::one();
                let left = self.unit().unwrap_or(&one);
                let right = other.unit().unwrap_or(&one);
                let unit = combine(left, right)?;
                match (self, other) {
                    (Scale::Mixed(_, units), _) | (_, Scale::Mixed(_, units)) => {
                        Scale::Mixed(unit, units.clone())
                    }
                    _ => Scale::Unit(unit),
                }
            }
        })
    }
}

/// For example `a speed in mm/s`.
fn describe(unit: &Unit) -> String {
    let dimension = unit.dimension();
    let name = dimension.to_string();
    if dimension == Dimension::NONE {
        return "a plain number".to_owned();
    }
    if name == dimension.si_unit() {
        return format!("an amount in {unit}");
    }
    let article = if name.starts_with(['a', 'e', 'i', 'o', 'u']) {
        "an"
    } else {
        "a"
    };
    format!("{article} {name} in {unit}")
}

fn opaque_product(left: &Scale, right: &Scale, divided: bool) -> Scale {
    let text = |scale: &Scale| match scale {
        Scale::Opaque(text) => text.clone(),
        other => other.unit().map_or("1", Unit::text).to_owned(),
    };
    let (left, right) = (text(left), text(right));
    if right == "1" {
        return Scale::Opaque(left);
    }
    if left == "1" && !divided {
        return Scale::Opaque(right);
    }
    Scale::Opaque(format!(
        "({left}){}({right})",
        if divided { "/" } else { "*" }
    ))
}

impl Operand {
    pub(super) fn constant(value: &QuantityValue) -> Self {
        let scale = match value.unit() {
            Some(unit) => Scale::Unit(unit.clone()),
            None => Scale::Bare,
        };
        Operand {
            amount: Amount::Constant(value.number()),
            scale,
            frame: None,
            constant: true,
            written: Some((value.clone(), false)),
        }
    }

    /// An amount that was computed; a constant one is computed now, once and for all.
    pub(super) fn computed(
        amount: Amount,
        scale: Scale,
        frame: Option<Framed>,
        constant: bool,
    ) -> Self {
        let amount = if constant { amount.folded() } else { amount };
        Operand {
            amount,
            scale,
            frame,
            constant,
            written: None,
        }
    }

    pub(super) fn negated(self) -> Self {
        let written = self.written.map(|(value, negative)| (value, !negative));
        let negated = Operand::computed(
            Amount::Negate(Box::new(self.amount)),
            self.scale,
            self.frame,
            self.constant,
        );
        Operand { written, ..negated }
    }

    /// A constant amount, which is in `unit`, in the coherent SI unit.
    pub(super) fn in_si(&self, unit: &Unit) -> f64 {
        match (&self.written, &self.amount) {
            (Some((value, true)), _) => -value.number_in_si(unit),
            (Some((value, false)), _) => value.number_in_si(unit),
            (None, Amount::Constant(number)) => unit.factor().conversion().apply(*number),
            (None, _) => f64::NAN,
        }
    }

    fn is_zero(&self) -> bool {
        self.amount == Amount::Constant(0.0)
    }

    /// The amount in `unit`, of which it has the dimension.
    fn converted(self, unit: &Unit) -> Result<Amount, PredicateErrorKind> {
        let too_large = || PredicateErrorKind::Unit(crate::units::UnitErrorKind::TooLarge);
        let Some(own) = self.scale.unit() else {
            return Ok(self.amount);
        };
        let conversion = own.conversion_to(unit).ok_or_else(too_large)?;
        if conversion.is_none() {
            return Ok(self.amount);
        }
        if let Some((value, negative)) = &self.written {
            // From the digits, which rounds only once.
            let value = value.value_in(unit).ok_or_else(too_large)?;
            return Ok(Amount::Constant(if *negative { -value } else { value }));
        }
        let amount = Amount::Convert(Box::new(self.amount), conversion);
        Ok(if self.constant {
            amount.folded()
        } else {
            amount
        })
    }
}

/// Brings `operands`, of which there is at least one, to one unit and frame.
pub(super) fn unify(operands: Vec<Operand>) -> Result<Unified, Misfit> {
    let mut lints = Vec::new();
    let frame = common_frame(&operands)?;
    let scale = common_scale(&operands)?;
    let constant = operands.iter().all(|operand| operand.constant);
    let mut amounts = Vec::with_capacity(operands.len());
    for (position, operand) in operands.into_iter().enumerate() {
        if let Some(lint) = lint(&operand, &scale, constant) {
            lints.push((position, lint));
        }
        let amount = match scale.unit() {
            Some(unit) => operand
                .converted(unit)
                .map_err(|kind| (kind, position, position))?,
            None => operand.amount,
        };
        amounts.push(amount);
    }
    Ok(Unified {
        amounts,
        scale,
        frame,
        constant,
        lints,
    })
}

fn common_frame(operands: &[Operand]) -> Result<Option<Framed>, Misfit> {
    let mut common: Option<(usize, &Framed)> = None;
    for (position, operand) in operands.iter().enumerate() {
        match (common, &operand.frame) {
            (Some((first, left)), Some(right)) if left.frame != right.frame => {
                let mismatch = Box::new(FrameMismatch {
                    left: left.signal.clone(),
                    left_frame: left.frame.clone(),
                    right: right.signal.clone(),
                    right_frame: right.frame.clone(),
                });
                return Err((PredicateErrorKind::Frames(mismatch), first, position));
            }
            (None, Some(frame)) => common = Some((position, frame)),
            _ => {}
        }
    }
    Ok(common.map(|(_, frame)| frame.clone()))
}

/// The unit to which all of `operands` are brought.
fn common_scale(operands: &[Operand]) -> Result<Scale, Misfit> {
    let undeclared = operands
        .iter()
        .position(|it| matches!(it.scale, Scale::Undeclared(_)));
    let signals = declared(operands, |operand| !operand.constant)?;
    let numbers = declared(operands, |operand| operand.constant)?;
    let (at, scale) = match (signals, numbers) {
        (Some((left, signals)), Some((right, numbers))) => {
            if !alike(&signals, &numbers) {
                let (left, right) = (left.min(right), left.max(right));
                return Err((misfit(operands, left, right), left, right));
            }
            (left, signals)
        }
        (Some(signals), None) => signals,
        (None, Some((at, numbers))) => match undeclared {
            Some(signal) => return Err((undeclared_unit(operands, signal, &numbers), at, at)),
            None => (at, numbers),
        },
        (None, None) => {
            return Ok(match undeclared {
                Some(signal) => operands[signal].scale.clone(),
                None => Scale::Bare,
            });
        }
    };
    check_bare(operands, &scale, at)?;
    Ok(scale)
}

/// The unit of those of `operands` that have one and for which `wanted` holds, and the first.
fn declared(
    operands: &[Operand],
    wanted: impl Fn(&Operand) -> bool,
) -> Result<Option<(usize, Scale)>, Misfit> {
    let mut common: Option<(usize, Scale)> = None;
    for (position, operand) in operands.iter().enumerate() {
        if !wanted(operand) || matches!(operand.scale, Scale::Bare | Scale::Undeclared(_)) {
            continue;
        }
        common = Some(match common {
            None => (position, operand.scale.clone()),
            Some((first, scale)) if alike(&scale, &operand.scale) => {
                (first, joined(scale, &operand.scale))
            }
            Some((first, _)) => return Err((misfit(operands, first, position), first, position)),
        });
    }
    Ok(common)
}

/// Whether the two have one dimension.
fn alike(left: &Scale, right: &Scale) -> bool {
    match (left.unit(), right.unit()) {
        (Some(left), Some(right)) => left.dimension() == right.dimension(),
        _ => left == right,
    }
}

/// The scale to which two scales of one dimension are brought.
fn joined(left: Scale, right: &Scale) -> Scale {
    let (Some(first), Some(second)) = (left.unit(), right.unit()) else {
        return left;
    };
    let units_of = |scale: &Scale, unit: &Unit| match scale {
        Scale::Mixed(_, units) => units.clone(),
        _ => vec![unit.text().to_owned()],
    };
    let mixed = matches!(left, Scale::Mixed(..)) || matches!(right, Scale::Mixed(..));
    if first.same_as(second) && !mixed {
        return left;
    }
    let mut units = units_of(&left, first);
    units.extend(units_of(right, second));
    units.dedup();
    Scale::Mixed(Unit::coherent(first.dimension()), units)
}

fn misfit(operands: &[Operand], left: usize, right: usize) -> PredicateErrorKind {
    PredicateErrorKind::Dimensions {
        left: operands[left].scale.describe(),
        right: operands[right].scale.describe(),
    }
}

fn undeclared_unit(operands: &[Operand], signal: usize, numbers: &Scale) -> PredicateErrorKind {
    let signal = match &operands[signal].scale {
        Scale::Undeclared(signal) => signal.clone(),
        other => other.describe(),
    };
    let unit = numbers.unit().map_or("1", Unit::text).to_owned();
    PredicateErrorKind::UndeclaredUnit { signal, unit }
}

/// Bare numbers need one unit, and that of signals: `5 cm + 1` has none for the 1.
fn check_bare(operands: &[Operand], scale: &Scale, at: usize) -> Result<(), Misfit> {
    let constant = operands.iter().all(|operand| operand.constant);
    let units = match scale {
        Scale::Mixed(_, units) => units.clone(),
        Scale::Unit(unit) if constant && unit.dimension() != Dimension::NONE => Vec::new(),
        _ => return Ok(()),
    };
    for (position, operand) in operands.iter().enumerate() {
        let lacks = match operand.scale {
            Scale::Bare => !operand.is_zero(),
            Scale::Undeclared(_) => !units.is_empty(),
            _ => false,
        };
        if lacks {
            let (left, right) = (position.min(at), position.max(at));
            let kind = if units.is_empty() {
                misfit(operands, left, right)
            } else {
                let units = units.clone();
                return Err((
                    PredicateErrorKind::AmbiguousNumber { units },
                    position,
                    position,
                ));
            };
            return Err((kind, left, right));
        }
    }
    Ok(())
}

/// What should be looked at when `operand` is taken in `scale`.
fn lint(operand: &Operand, scale: &Scale, constant: bool) -> Option<PredicateLintKind> {
    let unit = match scale {
        Scale::Unit(unit) | Scale::Mixed(unit, _) => unit.text(),
        Scale::Opaque(text) => text,
        Scale::Bare | Scale::Undeclared(_) => return None,
    };
    match &operand.scale {
        Scale::Bare if constant || operand.is_zero() || unit == "1" => None,
        Scale::Bare => Some(PredicateLintKind::BareNumber {
            unit: unit.to_owned(),
        }),
        Scale::Undeclared(signal) => Some(PredicateLintKind::UndeclaredUnit {
            signal: signal.clone(),
            unit: unit.to_owned(),
        }),
        _ => None,
    }
}

/// How differences in `scale` become robustness.
pub(super) fn to_si(scale: &Scale) -> Conversion {
    scale
        .unit()
        .map_or(Conversion::NONE, |unit| unit.factor().conversion())
}
