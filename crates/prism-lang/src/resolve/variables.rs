//! Variables: their names, ranges and initial values.

use super::Resolver;
use super::modules::Instance;
use super::scope::{Renaming, Scope, Symbol};
use crate::ast::{self, Type};
use crate::diagnostic::Diagnostic;
use crate::number::Value;
use crate::resolved::{Variable, VariableKind};

impl<'a> Resolver<'a> {
    /// Declares all variables before any expression is read, globals first.
    pub(super) fn declare_variables(
        &mut self,
        globals: &'a [ast::Variable],
        instances: &[Instance<'a>],
    ) {
        for variable in globals {
            self.declare_variable(&variable.name.text, variable, None);
        }
        for (owner, instance) in instances.iter().enumerate() {
            for variable in instance.variables {
                let name = instance.renaming.apply(&variable.name.text);
                self.declare_variable(name, variable, Some((owner, instance.name)));
            }
        }
    }

    fn declare_variable(
        &mut self,
        name: &str,
        variable: &ast::Variable,
        owner: Option<(usize, &str)>,
    ) {
        let ty = match variable.range {
            ast::VariableRange::Bool => Type::Bool,
            ast::VariableRange::Clock => Type::Double,
            _ => Type::Int,
        };
        let symbol = Symbol::Variable(self.variables.len(), ty);
        self.scope.declare(name, Some(variable.name.span), symbol);
        self.owners.push(owner.map(|(index, _)| index));
        // Range and initial value follow once all names are known.
        self.variables.push(Variable {
            name: name.to_owned(),
            module: owner.map(|(_, module)| module.to_owned()),
            kind: VariableKind::Unbounded,
            init: 0,
            span: variable.span,
        });
    }

    /// Computes ranges and initial values, in the order of declaration.
    pub(super) fn ranges(
        &mut self,
        globals: &'a [ast::Variable],
        instances: &[Instance<'a>],
    ) -> Option<Vec<i64>> {
        let none = Renaming::default();
        let local = instances
            .iter()
            .flat_map(|i| i.variables.iter().map(move |v| (v, &i.renaming)));
        let all: Vec<_> = globals.iter().map(|v| (v, &none)).chain(local).collect();
        let mut values = Vec::with_capacity(all.len());
        for (index, (variable, renaming)) in all.into_iter().enumerate() {
            let kind = self.range(variable, renaming);
            let init = kind.and_then(|kind| self.initial_value(variable, renaming, kind));
            if let (Some(kind), Some(init)) = (kind, init) {
                self.variables[index].kind = kind;
                self.variables[index].init = init;
            }
            values.push(init);
        }
        values.into_iter().collect()
    }

    fn range(
        &mut self,
        variable: &'a ast::Variable,
        renaming: &Renaming<'a>,
    ) -> Option<VariableKind> {
        let name = &variable.name.text;
        let (low, high) = match &variable.range {
            ast::VariableRange::Bool => return Some(VariableKind::Bool),
            ast::VariableRange::Int { low, high } => (low, high),
            ast::VariableRange::Unbounded => return Some(VariableKind::Unbounded),
            // The model is refused for it, but its other mistakes are reported.
            ast::VariableRange::Clock => {
                self.check_clock(variable);
                return Some(VariableKind::Unbounded);
            }
        };
        let what = format!("the range of `{name}`");
        let bound = |scope: &mut Scope<'a>, e| scope.constant_value(e, renaming, Type::Int, &what);
        let (low_value, high_value) = (bound(&mut self.scope, low), bound(&mut self.scope, high));
        let (Some(Value::Int(low_value)), Some(Value::Int(high_value))) = (low_value, high_value)
        else {
            return None;
        };
        if low_value > high_value {
            let message = format!(
                "the range of `{name}` is empty: {low_value} is greater than {high_value}."
            );
            let error = Diagnostic::error("empty-range", low.span.to(high.span), message);
            self.scope
                .report(error.remedy("Write the smaller bound first."));
            return None;
        }
        Some(VariableKind::Int {
            low: low_value,
            high: high_value,
        })
    }

    fn initial_value(
        &mut self,
        variable: &'a ast::Variable,
        renaming: &Renaming<'a>,
        kind: VariableKind,
    ) -> Option<i64> {
        let (low, high) = kind.bounds();
        let Some(init) = &variable.init else {
            return Some(if kind == VariableKind::Unbounded {
                0
            } else {
                low
            });
        };
        let name = &variable.name.text;
        if self.has_init {
            let message = format!(
                "`{name}` has an initial value, but the model also has `init ... endinit`."
            );
            let error = Diagnostic::error("two-inits", init.span, message);
            self.scope.report(error.remedy("Keep one of them."));
            return None;
        }
        let ty = match kind {
            VariableKind::Bool => Type::Bool,
            VariableKind::Int { .. } | VariableKind::Unbounded => Type::Int,
        };
        let what = format!("the initial value of `{name}`");
        let value = match self.scope.constant_value(init, renaming, ty, &what)? {
            Value::Bool(value) => i64::from(value),
            Value::Int(value) => value,
            Value::Double(_) => return None,
        };
        if value < low || value > high {
            let message =
                format!("the initial value {value} of `{name}` is not in its range {low}..{high}.");
            let error = Diagnostic::error("init-out-of-range", init.span, message);
            self.scope
                .report(error.remedy("Start within the range, or widen it."));
            return None;
        }
        Some(value)
    }
}
