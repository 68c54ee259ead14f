//! Modules, commands and updates.

use super::expression::Context;
use super::model::PARTS;
use super::{Parse, Parser, Reported};
use crate::ast::{Assignment, BinaryOp, Command, Expr, ExprKind, Module, ModuleBody, Name, Update};
use crate::diagnostic::Diagnostic;
use crate::diagnostic::Span;
use crate::lexer::TokenKind;

impl Parser<'_> {
    /// Reads a module; mistakes inside are recovered inside.
    pub(super) fn module(&mut self) -> Parse<Module> {
        let start = self.advance();
        let name = self.expect_new_name("the name of a module")?;
        let body = if self.is_symbol("=") {
            self.renamed_module()?
        } else {
            self.written_module(&name)?
        };
        let span = start.span.to(self.previous_span());
        Ok(Module { name, body, span })
    }

    fn renamed_module(&mut self) -> Parse<ModuleBody> {
        self.expect("=")?;
        let base = self.expect_name("the name of the module to copy")?;
        self.expect("[")?;
        let mut renames = Vec::new();
        loop {
            let old = self.expect_name_or_function("a name to replace")?;
            self.expect("=")?;
            renames.push((old, self.expect_name_or_function("a new name")?));
            if !self.accept(",") {
                break;
            }
        }
        self.expect("]")?;
        self.expect_keyword("endmodule")?;
        Ok(ModuleBody::Renamed { base, renames })
    }

    fn written_module(&mut self, name: &Name) -> Parse<ModuleBody> {
        let (mut variables, mut commands, mut invariant) = (Vec::new(), Vec::new(), None);
        while !self.accept_keyword("endmodule") {
            if self.starts_part() {
                self.unclosed(name, "module", "endmodule");
                break;
            }
            let item = if self.is_symbol("[") {
                self.command().map(|c| commands.push(c))
            } else if self.accept_keyword("invariant") {
                self.invariant().map(|i| invariant = Some(i))
            } else if self.is_symbol_ahead(1, ":") {
                self.variable().map(|v| variables.push(v))
            } else {
                Err(self.expected(
                    "a variable (`x : [0..1];`), a command (`[] guard -> ...;`) or `endmodule`",
                ))
            };
            if item.is_err() {
                self.recover_in_module();
            }
        }
        Ok(ModuleBody::Written {
            variables,
            invariant,
            commands,
        })
    }

    fn invariant(&mut self) -> Parse<Expr> {
        let invariant = self.expression(Context::Model)?;
        self.expect_keyword("endinvariant")?;
        Ok(invariant)
    }

    /// Whether something starts here that cannot be inside a module (`init` can: in a declaration).
    pub(super) fn starts_part(&self) -> bool {
        let token = self.peek();
        self.at_end() || (token.kind == TokenKind::Keyword && PARTS.contains(&token.text))
    }

    fn recover_in_module(&mut self) {
        let stops: Vec<&str> = PARTS
            .iter()
            .copied()
            .filter(|p| *p != "init")
            .chain(["endmodule"])
            .collect();
        self.recover(&stops);
    }

    pub(super) fn unclosed(&mut self, name: &Name, what: &str, closing: &str) {
        let message = format!("{what} `{}` is not closed.", name.text);
        let error = Diagnostic::error("unclosed", name.span, message);
        let found = self.peek().span;
        self.report(
            error
                .related(found, "it should be closed before this")
                .remedy(format!("Write `{closing}` behind its last line.")),
        );
    }

    /// Reads `[act] guard -> updates;`.
    fn command(&mut self) -> Parse<Command> {
        let start = self.expect("[")?;
        let action = if self.is_symbol("]") {
            None
        } else {
            Some(self.expect_name("the name of an action")?)
        };
        self.expect("]")?;
        let guard = self.expression(Context::Model)?;
        self.expect("->")?;
        let updates = self.updates()?;
        let span = start.to(self.expect(";")?);
        Ok(Command {
            action,
            guard,
            updates,
            span,
        })
    }

    fn updates(&mut self) -> Parse<Vec<Update>> {
        let mut updates = Vec::new();
        loop {
            let start = self.peek().span;
            let probability = if self.starts_assignments() {
                None
            } else {
                Some(self.probability_of_update()?)
            };
            let certain = probability.is_none();
            let assignments = self.assignments()?;
            let span = start.to(self.previous_span());
            updates.push(Update {
                probability,
                assignments,
                span,
            });
            if certain && updates.len() > 1 {
                self.missing_probability(span);
            }
            if !self.is_symbol("+") {
                return Ok(updates);
            }
            if certain && updates.len() == 1 {
                self.missing_probability(span);
            }
            self.advance();
        }
    }

    fn missing_probability(&mut self, span: Span) {
        let message = "each of several updates needs a probability, and this one has none.";
        let error = Diagnostic::error("missing-probability", span, message);
        self.report(error.remedy("Write `p : (x'=...)`, with probabilities that sum to 1."));
    }

    fn starts_assignments(&self) -> bool {
        (self.is_symbol("(") && self.peek_ahead(1).kind == TokenKind::Primed)
            || (self.is_keyword("true") && !self.is_symbol_ahead(1, ":"))
            || self.peek().kind == TokenKind::Primed
    }

    fn probability_of_update(&mut self) -> Parse<Expr> {
        if self.is_symbol("[") {
            return self.probability_interval();
        }
        let probability = self.expression(Context::Model)?;
        if self.is_symbol(":") {
            self.advance();
            return Ok(probability);
        }
        if let Some(target) = assigned_without_prime(&probability) {
            let message = format!("the variable `{target}` needs a prime to be assigned.");
            let error = Diagnostic::error("missing-prime", probability.span, message);
            self.report(error.remedy(format!("Write `({target}'=...)`.")));
            return Err(Reported);
        }
        let message = format!(
            "expected `:` and an update behind this probability, found {}.",
            super::describe(&self.peek())
        );
        let error = Diagnostic::error("syntax", probability.span, message);
        self.report(error.remedy(
            "Write updates as `0.5 : (x'=1)`, assignments in parentheses and with a prime.",
        ));
        Err(Reported)
    }

    /// Reads `[0.1,0.2] :`.
    fn probability_interval(&mut self) -> Parse<Expr> {
        let start = self.expect("[")?;
        let low = self.nested(|p| p.expression(Context::Model))?;
        self.expect(",")?;
        let high = self.nested(|p| p.expression(Context::Model))?;
        let span = start.to(self.expect("]")?);
        self.expect(":")?;
        let kind = ExprKind::Interval(Box::new(low), Box::new(high));
        Ok(Expr { kind, span })
    }

    fn assignments(&mut self) -> Parse<Vec<Assignment>> {
        if self.accept_keyword("true") {
            return Ok(Vec::new());
        }
        let mut assignments = vec![self.assignment()?];
        while self.accept("&") {
            assignments.push(self.assignment()?);
        }
        Ok(assignments)
    }

    /// Reads `(x'=x+1)`.
    fn assignment(&mut self) -> Parse<Assignment> {
        let token = self.peek();
        if token.kind == TokenKind::Primed {
            let message = format!(
                "the assignment to `{}` must stand in parentheses.",
                token.text
            );
            let error = Diagnostic::error("syntax", token.span, message);
            self.report(error.remedy(format!("Write `({}'=...)`.", token.text)));
            return Err(Reported);
        }
        let start = self.expect("(")?;
        let target = self.peek();
        if target.kind == TokenKind::Name && self.is_symbol_ahead(1, "=") {
            let message = format!(
                "the variable `{}` needs a prime to be assigned.",
                target.text
            );
            let error = Diagnostic::error("missing-prime", target.span, message);
            self.report(error.remedy(format!("Write `({}'=...)`.", target.text)));
        } else if target.kind != TokenKind::Primed {
            return Err(self.expected("a variable with a prime, such as `x'`"));
        }
        let variable = super::name_of(&self.advance());
        self.expect("=")?;
        let value = self.expression(Context::Model)?;
        let span = start.to(self.expect(")")?);
        Ok(Assignment {
            variable,
            value,
            span,
        })
    }
}

/// The variable of `x=1`, which stands where `(x'=1)` was meant.
fn assigned_without_prime(expr: &Expr) -> Option<&str> {
    let ExprKind::Binary(BinaryOp::Equal, target, _) = &expr.kind else {
        return None;
    };
    match &target.kind {
        ExprKind::Name(name) => Some(name),
        _ => None,
    }
}
