//! Rational functions as text, in the syntax of PRISM's expressions.

use std::fmt;

use num_bigint::BigInt;
use num_traits::{One, Signed};

use super::function::RationalFunction;
use super::monomial::{MOST_PARAMETERS, Monomial};
use super::polynomial::Polynomial;

impl RationalFunction {
    /// The function over parameters of these names, as `numerator` or `(numerator)/(denominator)`, expanded.
    ///
    /// ```
    /// use checker::parametric::RationalFunction;
    /// use prism_lang::Arithmetic;
    /// let p = RationalFunction::parameter(0).unwrap();
    /// let odds = p.div(&RationalFunction::one().sub(&p)).unwrap();
    /// assert_eq!(odds.text(&["p"]), "(-p)/(p-1)");
    /// assert_eq!(odds.derivative(0).text(&["p"]), "(1)/(p^2-2*p+1)");
    /// ```
    pub fn text(&self, names: &[&str]) -> String {
        let Some((up, down)) = self.quotient() else {
            return "too large".to_owned();
        };
        let (up, down) = (written(&up, names), written(&down, names));
        match down.as_str() {
            "1" => up,
            _ if self.as_constant().is_some() => format!("{up}/{down}"),
            _ => format!("({up})/({down})"),
        }
    }
}

/// Without names: `p0`, `p1`, ...
impl fmt::Display for RationalFunction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text(&[]))
    }
}

/// A polynomial, its terms in descending order.
pub(super) fn written(polynomial: &Polynomial, names: &[&str]) -> String {
    let mut text = String::new();
    for (monomial, value) in &polynomial.terms {
        if value.is_negative() {
            text.push('-');
        } else if !text.is_empty() {
            text.push('+');
        }
        text.push_str(&term(*monomial, &value.abs(), names));
    }
    if text.is_empty() {
        text.push('0');
    }
    text
}

fn term(monomial: Monomial, value: &BigInt, names: &[&str]) -> String {
    let mut parts = Vec::new();
    if monomial == Monomial::ONE || !value.is_one() {
        parts.push(value.to_string());
    }
    for parameter in 0..MOST_PARAMETERS {
        let name = match names.get(parameter) {
            Some(name) => (*name).to_owned(),
            None => format!("p{parameter}"),
        };
        match monomial.exponent(parameter) {
            0 => {}
            1 => parts.push(name),
            exponent => parts.push(format!("{name}^{exponent}")),
        }
    }
    parts.join("*")
}
