//! What a model file may hold besides modules: `system ... endsystem` and observables.

use super::{Expr, Name};
use crate::diagnostic::Span;

/// `system ... endsystem`: how the modules are composed.
#[derive(Clone, Debug, PartialEq)]
pub struct System {
    /// Its name, if it has one; others can refer to it by that name.
    pub name: Option<Name>,
    /// The composition.
    pub body: SystemExpr,
    /// The whole construct.
    pub span: Span,
}

/// A composition of modules and its place.
#[derive(Clone, Debug, PartialEq)]
pub struct SystemExpr {
    /// What it is.
    pub kind: SystemKind,
    /// Its place.
    pub span: Span,
}

/// The kinds of compositions.
#[derive(Clone, Debug, PartialEq)]
pub enum SystemKind {
    /// A module.
    Module(Name),
    /// `"name"`: another `system ... endsystem`.
    Reference(Name),
    /// `a || b || c`: synchronised on every action that operands share.
    Full(Vec<SystemExpr>),
    /// `a ||| b`: not synchronised.
    Interleaved(Vec<SystemExpr>),
    /// `a |[x,y]| b`: synchronised on the actions in brackets.
    On(Box<SystemExpr>, Vec<Name>, Box<SystemExpr>),
    /// `a / {x,y}`: the actions in braces become unnamed.
    Hide(Box<SystemExpr>, Vec<Name>),
    /// `a {x<-y}`: the old names and the new ones.
    Rename(Box<SystemExpr>, Vec<(Name, Name)>),
    /// What could not be understood; a diagnostic says why.
    Error,
}

/// What can be observed of a partially observable model.
#[derive(Clone, Debug, PartialEq)]
pub enum Observables {
    /// `observables x, y endobservables`
    Variables {
        /// The variables.
        names: Vec<Name>,
        /// The whole construct.
        span: Span,
    },
    /// `observable "o" = x>0;`
    Defined {
        /// Its name, without quotes.
        name: Name,
        /// Its definition.
        body: Expr,
        /// The whole declaration.
        span: Span,
    },
}
