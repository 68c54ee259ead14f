//! The PRISM language: text to typed models and properties, with spans.
//!
//! Reading takes two steps. *Parsing* ([`parse_model`], [`parse_properties`]) turns text into a syntax tree
//! ([`ast`]) and never fails: it returns all mistakes, each with its place and a remedy. *Resolving*
//! ([`resolve()`], [`resolve_properties`]) binds names, checks types, evaluates constants, and returns a
//! [`resolved::Model`] or [`NamedProperty`]s, over which nothing is left to look up. Syntax trees print back
//! to text; [`edit`] changes a text and leaves the rest of it as it is written.
//!
//! ```
//! use prism_lang::{Constants, Property, parse_model, parse_properties, resolve, resolve_properties};
//!
//! let text = "
//!     dtmc
//!     const double p;
//!     module coin
//!       side : [0..2] init 0;
//!       [] side=0 -> p:(side'=1) + 1-p:(side'=2);
//!     endmodule
//!     label \"heads\" = side=1;
//! ";
//! let given = Constants::parse("p=0.3")?;
//! let model = resolve(&parse_model(text).into_result()?, &given)?;
//! let update = &model.modules[0].commands[0].updates[1];
//! assert_eq!(update.probability.eval_number::<f64>(&[0])?, 0.7);
//!
//! let file = parse_properties("P>=0.25 [ F<=1 \"heads\" ]").into_result()?;
//! let properties = resolve_properties(&file, &model, &given)?;
//! assert!(matches!(properties[0].property, Property::Probability { bound: Some(_), .. }));
//!
//! // Mistakes come with a place and a remedy.
//! let mistake = &parse_model("dtmc modul m endmodule").diagnostics[0];
//! assert_eq!(mistake.span.of("dtmc modul m endmodule"), "modul");
//! assert_eq!(mistake.remedy.as_deref(), Some("Did you mean `module`?"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
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
