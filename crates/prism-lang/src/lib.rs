#![doc = include_str!("../README.md")]
//!
//! # What is supported
//!
//! All of PRISM's grammar is read and printed: every model type, `system ... endsystem`, clocks, invariants,
//! observables, intervals of probabilities; `P`, `R`, `S`, `A`, `E`, optima, bounds, filters in both forms,
//! `multi`, `<<...>>`, references between properties.
//!
//! Models of the types `dtmc`, `ctmc`, `mdp` and (without a keyword) lts get a meaning
//! ([`resolved::Model`]): local and global variables, unbounded integers, renamed copies (of copies, too),
//! compositions with hiding and renaming, several initial states, reward structures, constants that stay open
//! ([`resolve_open`]) or run over ranges ([`Experiment`]). Properties over them get a meaning
//! ([`Property`]), too. Timed, partially observable and interval models are refused with one diagnostic that
//! says what is missing; their other mistakes are reported beside it. The preprocessor (`#...#`) is not read.
//!
//! Printing a tree gives text that parses to the same tree, but comments are not in the tree; [`format_model`] and
//! [`format_properties`] lay a text out anew and keep them.
//!
//! # Where it deviates from PRISM
//!
//! Real numbers are exact as long as they are rational: `1-0.95` is one twentieth, and `3*0.1=0.3` holds.
//! Integers have 64 bits. A command's probabilities must sum to 1 to within 1e-12: PRISM rescales sums that
//! are off by up to 1e-5, which [`resolve_rounded`] does where it is asked for. See [`resolve()`] and [`Expr::eval_bool`].

mod arithmetic;
pub mod ast;
mod diagnostic;
pub mod edit;
mod eval;
mod experiment;
pub mod expr;
mod format;
mod gcd;
mod lexer;
pub mod names;
mod number;
mod parser;
mod print;
pub mod property;
mod rational;
mod resolve;
pub mod resolved;
mod suggest;

pub use arithmetic::Arithmetic;
pub use diagnostic::{Diagnostic, Diagnostics, Parsed, Severity, Span, line_and_column};
pub use eval::{EvalError, EvalErrorKind};
pub use experiment::Experiment;
pub use expr::{Expr, ExprKind, Function, VarIndex};
pub use format::{format_model, format_properties};
pub use number::{Constants, ConstantsError, Number, Rational, Value, rational_to_f64};
pub use parser::{parse_model, parse_properties};
pub use property::{Bound, Comparison, NamedProperty, Path, Property, StateFormula, TimeBound};
pub use resolve::{resolve, resolve_open, resolve_properties, resolve_rounded, resolve_with};
