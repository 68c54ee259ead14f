//! Values as rational functions of constants that were left open.
//!
//! A model that was resolved with open constants ([`prism_lang::resolve_open`]) is explored once, its probabilities
//! being [`RationalFunction`]s of these. [`solve`] then answers a property by functions that hold at every point at
//! which each transition's function is positive: these [`Conditions`] are part of the answer, with whether they
//! hold on the [`Region`] asked for. A function can be evaluated exactly ([`RationalFunction::at`]), quickly and with
//! bounds ([`Compiled`]), differentiated ([`RationalFunction::derivative`]) and printed.
//!
//! In models with choices, and for bounds such as `P>=0.5`, the region is split until on each part the best choices
//! are the same, or the bound is met or missed, at all points; what is left undecided is part of the answer.
//!
//! ```
//! use checker::explore::explore;
//! use checker::parametric::{ParametricValue, RationalFunction, Region, solve};
//! use checker::Options;
//! use prism_lang::{Constants, parse_model, parse_properties, resolve_open, resolve_properties};
//!
//! let text = "dtmc const double p; const double q; module m s : [0..2];
//!   [] s=0 -> p:(s'=1) + q:(s'=2) + 1-p-q:(s'=0); endmodule";
//! let none = Constants::new();
//! let model = resolve_open(&parse_model(text).tree, &none, &none, &["p", "q"]).unwrap();
//! let asked = parse_properties("P=? [ F s=1 ]").tree;
//! let asked = resolve_properties(&asked, &model, &none).unwrap();
//! let space = explore::<RationalFunction>(&model)?;
//! let region = Region::parse("p=0:0.5,q=0.1:0.4", &model.parameters)?;
//! let answer = solve(&space, &asked[0].property, &region, &Options::default())?;
//! let ParametricValue::Function(function) = &answer.parts[0].values[0] else { unreachable!() };
//! assert_eq!(function.text(&["p", "q"]), "(p)/(p+q)");
//! assert_eq!(function.derivative(1).text(&["p", "q"]), "(-p)/(p^2+2*p*q+q^2)");
//! assert!(answer.conditions.hold());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub(crate) mod amount;
mod check;
mod compiled;
mod conditions;
pub(crate) mod engine;
mod factors;
mod function;
mod gcd;
mod monomial;
pub(crate) mod optimise;
mod parse;
mod points;
mod polynomial;
mod print;
mod region;

pub use check::{ParametricAnswer, ParametricValue, Part, solve};
pub use compiled::Compiled;
pub use conditions::{Condition, Conditions};
pub use function::RationalFunction;
pub use monomial::MOST_PARAMETERS;
pub use parse::RegionError;
pub use points::{ACCURACY, Functions};
pub use region::{Region, Sign};
