//! Requirements in structured English, each written once and compiled to every technique.
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
//!
//! ```
//! use requirement_lang::compile::property::{Model, label_of_name, property};
//! use requirement_lang::compile::monitor::monitor;
//! use requirement_lang::{Context, parse};
//!
//! // Parameters are declared once, with units, for sentences and predicates alike.
//! let parameters = trace::Parameters::new([("release_time", "2 s")]).map_err(|errors| errors[0].clone())?;
//! let context = Context { parameters: Some(&parameters), ..Context::default() };
//!
//! let text = "When release_decided, the robot shall with probability at least 0.95 \
//!             within release_time satisfy hand_open.";
//! let sentence = parse(text, &context).into_result().map_err(|mistakes| mistakes[0].clone())?;
//!
//! let for_traces = monitor(&sentence)?;
//! assert_eq!(
//!     for_traces.to_string(),
//!     "always ((rise release_decided) => (eventually[0 s, 2 s] hand_open))"
//! );
//!
//! // The model's steps are 100 ms long.
//! let model = Model { step_secs: Some(0.1), proposition: &label_of_name };
//! assert_eq!(
//!     property(&sentence, &model)?.requirement(),
//!     "P>=0.95 [ (\"release_decided\" => (F<=20 \"hand_open\")) & \
//!      (G ((!\"release_decided\") => (X (\"release_decided\" => (F<=20 \"hand_open\"))))) ]"
//! );
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

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
