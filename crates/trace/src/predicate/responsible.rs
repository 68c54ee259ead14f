//! Which signals make a predicate true or false at a moment.
//!
//! # Definition
//! R(p) is a set of signals of which the values alone give p its truth, whatever the others are:
//!
//! | form | R |
//! |---|---|
//! | comparison, truth value, name | the signals in it |
//! | `!a` | R(a) |
//! | `a & b` if true, `a \| b` if false, `a = b` of truth values | R(a) and R(b) |
//! | `a & b` if false, `a \| b` if true | R of each side that is so by itself |
//!
//! Where both sides decide, both are named, since a person wants to know of both; so R is not
//! always the smallest such set. It is empty where the truth is unknown.
//! Cost: O(nodes * depth), since each side of a connective is evaluated on the way down.

use super::eval::{Amount, Truth};
use crate::signal::{SignalIndex, SignalValues};

/// R of `truth`, in the order of the text, each signal once.
pub(super) fn responsible<V: SignalValues + ?Sized>(truth: &Truth, values: &V) -> Vec<SignalIndex> {
    let mut found = Vec::new();
    if truth.eval(values).is_some() {
        collect(truth, values, &mut found);
    }
    found
}

/// Adds R of `truth`, which is known.
fn collect<V: SignalValues + ?Sized>(truth: &Truth, values: &V, found: &mut Vec<SignalIndex>) {
    match truth {
        Truth::Not(inner) => collect(inner, values, found),
        Truth::And(left, right) => decisive([left, right], false, values, found),
        Truth::Or(left, right) => decisive([left, right], true, values, found),
        Truth::Same(left, right) => {
            collect(left, values, found);
            collect(right, values, found);
        }
        Truth::Constant(_) | Truth::Signal(_) | Truth::Compare(_) | Truth::SameName(..) => {
            signals_of_truth(truth, found);
        }
    }
}

/// Adds R of those of `sides` that have the truth `deciding`, or of both if none has.
fn decisive<V: SignalValues + ?Sized>(
    sides: [&Truth; 2],
    deciding: bool,
    values: &V,
    found: &mut Vec<SignalIndex>,
) {
    let decides = sides.map(|side| side.eval(values) == Some(deciding));
    let none = decides == [false, false];
    for (side, decides) in sides.into_iter().zip(decides) {
        if decides || none {
            collect(side, values, found);
        }
    }
}

/// Adds all signals that `truth` reads.
pub(super) fn signals_of_truth(truth: &Truth, found: &mut Vec<SignalIndex>) {
    match truth {
        Truth::Constant(_) => {}
        Truth::Signal(signal) => add(*signal, found),
        Truth::Not(inner) => signals_of_truth(inner, found),
        Truth::And(left, right) | Truth::Or(left, right) | Truth::Same(left, right) => {
            signals_of_truth(left, found);
            signals_of_truth(right, found);
        }
        Truth::Compare(compared) => {
            signals_of_amount(&compared.left, found);
            signals_of_amount(&compared.right, found);
        }
        Truth::SameName(left, right) => {
            signals_of_amount(left, found);
            signals_of_amount(right, found);
        }
    }
}

/// Adds all signals that `amount` reads.
pub(super) fn signals_of_amount(amount: &Amount, found: &mut Vec<SignalIndex>) {
    match amount {
        Amount::Constant(_) => {}
        Amount::Signal(signal) => add(*signal, found),
        Amount::Negate(inner) | Amount::Abs(inner) | Amount::Convert(inner, _) => {
            signals_of_amount(inner, found);
        }
        Amount::Arithmetic(_, left, right) | Amount::AngleDifference { left, right, .. } => {
            signals_of_amount(left, found);
            signals_of_amount(right, found);
        }
        Amount::Min(list) | Amount::Max(list) | Amount::Norm(list) => {
            for amount in list {
                signals_of_amount(amount, found);
            }
        }
    }
}

fn add(signal: SignalIndex, found: &mut Vec<SignalIndex>) {
    if !found.contains(&signal) {
        found.push(signal);
    }
}
