//! Property files: declarations, labels, and references from one property to another.

use std::collections::{BTreeMap, BTreeSet};

use super::formula::{Formula, Size};
use super::scope::{Renaming, Scope, Symbol};
use super::unreadable;
use crate::ast::{self, ExprKind, Type};
use crate::diagnostic::{Diagnostic, Diagnostics, Span};
use crate::number::Constants;
use crate::property::{NamedProperty, Property, Quantity, StateFormula};
use crate::resolved::{Model, VariableKind};
use crate::suggest::suggest;

/// Gives properties their meaning over a model.
///
/// `given` sets undefined constants of the property file; a name that neither the file nor the model
/// declares is reported, and so is a constant without a value where it is used. Labels and formulas of the file
/// are written out; labels of the model keep their name. A quoted name may also refer to another property of
/// the file, which is written out, too.
///
/// # Errors
/// All mistakes that were found, in the order of their places.
///
/// ```
/// use prism_lang::{Constants, Property, parse_model, parse_properties, resolve, resolve_properties};
/// let model = parse_model("dtmc module m x : [0..1]; [] true -> (x'=1-x); endmodule");
/// let model = resolve(&model.tree, &Constants::new()).unwrap();
/// let file = parse_properties("P=? [ F<=3 x=1 ]");
/// let properties = resolve_properties(&file.tree, &model, &Constants::new()).unwrap();
/// assert!(matches!(properties[0].property, Property::Probability { bound: None, .. }));
/// ```
pub fn resolve_properties(
    properties: &ast::PropertyFile,
    model: &Model,
    given: &Constants,
) -> Result<Vec<NamedProperty>, Diagnostics> {
    let mut resolver = PropertyResolver {
        scope: model_scope(model),
        model,
        labels: BTreeMap::new(),
        named: BTreeMap::new(),
        unread: names_of_unread(properties),
        size: Size::default(),
    };
    resolver.unknown_constants(properties, given);
    resolver.declarations(properties, given);
    resolver.names(&properties.properties);
    let resolved: Vec<Option<NamedProperty>> = properties
        .properties
        .iter()
        .map(|p| resolver.named_property(p))
        .collect();
    let mut diagnostics = resolver.scope.diagnostics;
    if !diagnostics.is_empty() {
        diagnostics.sort_by_key(|d| (d.span.start, d.span.end));
        return Err(diagnostics.into());
    }
    let resolved: Option<Vec<_>> = resolved.into_iter().collect();
    resolved.ok_or_else(|| vec![unreadable()].into())
}

fn names_of_unread(file: &ast::PropertyFile) -> BTreeSet<&str> {
    let names = file.unread.iter().filter_map(|p| p.name.as_ref());
    names.map(|name| name.text.as_str()).collect()
}

/// The names that a model gives to its properties.
fn model_scope<'a>(model: &Model) -> Scope<'a> {
    let mut scope = Scope::new();
    for constant in &model.constants {
        let symbol = Symbol::Constant(constant.value.clone());
        scope.declare(&constant.name, None, symbol);
    }
    for (index, parameter) in model.parameters.iter().enumerate() {
        let symbol = Symbol::Parameter(index, parameter.ty);
        scope.declare(&parameter.name, None, symbol);
    }
    for (name, body) in &model.formulas {
        scope.declare(name, None, Symbol::Formula(body.clone()));
    }
    for (index, variable) in model.variables.iter().enumerate() {
        let ty = match variable.kind {
            VariableKind::Bool => Type::Bool,
            VariableKind::Int { .. } | VariableKind::Unbounded => Type::Int,
        };
        scope.declare(&variable.name, None, Symbol::Variable(index, ty));
    }
    scope
}

/// What is known of a property that has a name.
enum Named {
    /// Not read yet.
    Unread,
    /// Being read: a reference to it is a cycle.
    Active,
    /// What it means, and how large that is; `None` if it is wrong.
    Read(Box<Option<Formula>>, Size),
}

pub(super) struct PropertyResolver<'a> {
    pub(super) scope: Scope<'a>,
    pub(super) model: &'a Model,
    /// Labels of the property file; `None` if one is wrong.
    labels: BTreeMap<&'a str, Option<crate::Expr>>,
    /// Properties by name.
    named: BTreeMap<&'a str, (&'a ast::Property, Named)>,
    /// Names of properties that could not be read.
    unread: BTreeSet<&'a str>,
    /// What has been resolved so far: how deep it is here, and how large it became.
    pub(super) size: Size,
}

impl<'a> PropertyResolver<'a> {
    fn unknown_constants(&mut self, file: &ast::PropertyFile, given: &Constants) {
        let of_model = self.model.constants.iter().map(|c| c.name.as_str());
        let of_file = file.constants.iter().map(|c| c.name.text.as_str());
        let known: Vec<&str> = of_model.chain(of_file).collect();
        for name in given.0.keys().filter(|n| !known.contains(&n.as_str())) {
            let remedy = match suggest(name, known.iter().copied()) {
                Some(near) => format!("Did you mean `{near}`?"),
                None => "Declare it, or do not give it a value.".to_owned(),
            };
            let message = format!("neither the model nor the properties have a constant `{name}`.");
            let error = Diagnostic::error("unknown-constant", Span::default(), message);
            self.scope.report(error.remedy(remedy));
        }
    }

    fn declarations(&mut self, file: &'a ast::PropertyFile, given: &Constants) {
        self.scope
            .declare_constants(&file.constants, given, &Constants::new(), &[]);
        for formula in &file.formulas {
            let symbol = Symbol::FormulaDefinition(formula);
            self.scope
                .declare(&formula.name.text, Some(formula.name.span), symbol);
        }
        for constant in file.constants.iter().filter(|c| c.value.is_some()) {
            self.scope.constant(constant);
        }
        for formula in &file.formulas {
            self.scope.formula(formula);
        }
        for label in &file.labels {
            let name = label.name.text.as_str();
            if self.is_label(name) {
                let message = format!("there is already a label \"{name}\".");
                let error = Diagnostic::error("duplicate-name", label.name.span, message);
                self.scope.report(error.remedy("Choose another name."));
                continue;
            }
            let what = format!("label \"{name}\"");
            let body = self
                .scope
                .typed(&label.body, &Renaming::default(), Type::Bool, &what);
            self.labels.insert(name, body);
        }
    }

    fn is_label(&self, name: &str) -> bool {
        self.labels.contains_key(name)
            || self.model.label(name).is_some()
            || matches!(name, "init" | "deadlock")
    }

    /// Notes the names of all properties: a reference may come before its property.
    fn names(&mut self, properties: &'a [ast::Property]) {
        for property in properties {
            let Some(name) = &property.name else { continue };
            let message = if self.is_label(&name.text) {
                format!("there is already a label \"{}\".", name.text)
            } else if self.named.contains_key(name.text.as_str()) {
                format!("there are two properties with the name \"{}\".", name.text)
            } else {
                self.named.insert(&name.text, (property, Named::Unread));
                continue;
            };
            let error = Diagnostic::error("duplicate-name", name.span, message);
            self.scope.report(error.remedy("Choose another name."));
        }
    }

    fn named_property(&mut self, property: &'a ast::Property) -> Option<NamedProperty> {
        let name = property.name.as_ref().map_or("", |n| n.text.as_str());
        let meaning = match self.named.get(name) {
            Some((known, _)) if std::ptr::eq(*known, property) => {
                self.named_formula(name, property.span)
            }
            // Without a name, or the second one of a name.
            _ => self.formula(&property.formula),
        };
        Some(NamedProperty {
            name: property.name.as_ref().map(|n| n.text.clone()),
            text: property.text.clone(),
            span: property.span,
            property: as_property(meaning?)?,
        })
    }

    /// The meaning of a property that is known by name, read when it is first needed.
    fn named_formula(&mut self, name: &'a str, span: Span) -> Option<Formula> {
        let (property, state) = self.named.get(name)?;
        let property = *property;
        match state {
            Named::Read(formula, size) => {
                let (formula, size) = (formula.clone(), *size);
                self.size.add(size);
                self.is_small(span).then_some(*formula)?
            }
            Named::Active => {
                let message = format!("property \"{name}\" is defined by itself.");
                let error = Diagnostic::error("cyclic-definition", span, message);
                self.scope
                    .report(error.remedy("Write the formula in place of one of the references."));
                None
            }
            Named::Unread => {
                self.named.insert(name, (property, Named::Active));
                let outside = self.size.start();
                let meaning = self.formula(&property.formula);
                let inside = self.size.finish(outside);
                let read = Named::Read(Box::new(meaning.clone()), inside);
                self.named.insert(name, (property, read));
                meaning
            }
        }
    }

    /// A label, or a reference to a property.
    pub(super) fn label(&mut self, name: &'a str, span: Span) -> Option<Formula> {
        if self.named.contains_key(name) {
            return self.named_formula(name, span);
        }
        if let Some(body) = self.labels.get(name) {
            return body.clone().map(|b| Formula::State(StateFormula::Expr(b)));
        }
        if self.is_label(name) {
            return Some(Formula::State(StateFormula::Label(name.to_owned())));
        }
        if self.unread.contains(name) {
            let message = format!("property \"{name}\" could not be read.");
            let error = Diagnostic::error("unreadable", span, message);
            self.scope
                .report(error.remedy("Correct what is reported there."));
            return None;
        }
        let of_model = self.model.labels.iter().map(|(n, _)| n.as_str());
        let known = of_model
            .chain(self.labels.keys().copied())
            .chain(self.named.keys().copied())
            .chain(["init", "deadlock"]);
        let remedy = match suggest(name, known) {
            Some(near) => format!("Did you mean \"{near}\"?"),
            None => format!("Define it with `label \"{name}\" = ...;`."),
        };
        let message = format!("there is no label \"{name}\".");
        self.scope
            .report(Diagnostic::error("unknown-label", span, message).remedy(remedy));
        None
    }

    /// Whether a quoted name stands for a property.
    pub(super) fn is_property(&self, expr: &ast::Expr) -> bool {
        matches!(&expr.kind, ExprKind::Label(name) if self.named.contains_key(name.as_str()))
    }
}

fn as_property(formula: Formula) -> Option<Property> {
    Some(match formula {
        Formula::State(StateFormula::Probability { bound, path }) => Property::Probability {
            bound: Some(bound),
            path: *path,
        },
        Formula::State(state) => Property::State(state),
        Formula::Number(Quantity::Probability {
            optimum: None,
            path,
        }) => Property::Probability {
            bound: None,
            path: *path,
        },
        Formula::Number(number) => Property::Number(number),
        Formula::Range(filter) => Property::Range(filter),
        Formula::Objectives(objectives) => Property::Objectives(objectives),
        // The parser has reported the temporal operator outside of `P`.
        Formula::Path(_) => return None,
    })
}
