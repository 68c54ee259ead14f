#![doc = include_str!("../README.md")]
//!
//! A sentence in the manner of NASA's FRET (D. Giannakopoulou, T. Pressburger, A. Mavridou and J.
//! Schumann, "Automated formalization of structured natural language requirements", Information and
//! Software Technology 137, 2021) says where a requirement applies, what triggers it, who has to
//! meet it, with which probability, when, and what:
//!
//! ```text
//! [scope,] [condition,] the COMPONENT shall [probability] [timing] satisfy RESPONSE
//!                                     [, then [timing] satisfy RESPONSE] ...
//! ```
//!
//! | part | forms |
//! |---|---|
//! | scope | `in M`, `while M`, `during M`; `when not in M`; `before M`; `after M`; `only in M`, `only before M`, `only after M`; without, the whole run |
//! | condition | `when C` (also `upon`, `if`, `where`): where C becomes true; `whenever C`: wherever C is true; `unless C`: where C becomes false; without, the beginning of each interval of the scope |
//! | probability | `with probability at least 0.95` (`at most`, `more than`, `less than`, `>=` ...), `in at least 95 % of runs`: that a run meets the whole requirement |
//! | timing | `immediately`, `at the next step`, `eventually`, `always`, `never`, `within D`, `for D`, `after D`, `until Q`, `before Q`; it may also follow the response |
//! | response | a boolean expression with `and`, `or`, `not`, `=>`, `<=>`, parentheses; a phrase of several words is a name (`human is ready` is `human_is_ready`) |
//! | duration | `2 s`, `500 ms`, `5 steps`, or the name of a declared [parameter](trace::Parameters) |
//!
//! What a sentence means is defined, and executed, in [`semantics`]; there it is also said where it
//! deviates from FRET. From one sentence come
//!
//! * the [property](compile::property) for the model checker, in the PRISM language,
//! * the [monitor](compile::monitor) for traces, a formula of metric temporal logic,
//! * the [staged monitor](compile::staged), which counts, where stages can express it,
//! * the [test goals](compile::goal) for a generator, in the model and in simulation,
//! * the [coverage bins](compile::coverage) for a campaign of tests.
//!
//! What a form cannot express is refused with the reason, never changed silently. [`library`] has
//! ready sentences for collaborative robots.

pub mod compile;
mod diagnostic;
mod explain;
pub mod expression;
mod lexer;
pub mod library;
mod parse;
mod print;
pub mod semantics;
pub mod sentence;
mod usage;

pub use diagnostic::{Diagnostic, Parsed, Severity, Span};
pub use explain::{Explanation, explain};
pub use parse::{Context, parse};
pub use sentence::Sentence;
pub use usage::ParameterUse;
