//! The PRISM language: text to typed models and properties, with spans.

mod arithmetic;
pub mod ast;
mod diagnostic;
mod eval;
pub mod expr;
mod lexer;
mod number;
mod parser;
mod print;
pub mod property;
mod resolve;
pub mod resolved;
mod suggest;

pub use arithmetic::Arithmetic;
pub use diagnostic::{Diagnostic, Parsed, Severity, Span, line_and_column};
pub use eval::{EvalError, EvalErrorKind};
pub use expr::{Expr, ExprKind, Function, VarIndex};
pub use number::{Constants, ConstantsError, Number, Rational, Value, rational_to_f64};
pub use parser::{parse_model, parse_properties};
pub use property::{Bound, Comparison, NamedProperty, Path, Property, StateFormula, TimeBound};
pub use resolve::{resolve, resolve_properties, resolve_with};
