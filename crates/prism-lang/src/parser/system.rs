//! `system ... endsystem`, and what can be observed of partially observable models.

use super::expression::Context;
use super::{Parse, Parser, Reported, name_of};
use crate::ast::{Name, Observables, System, SystemExpr, SystemKind};
use crate::diagnostic::{Diagnostic, Span};
use crate::lexer::TokenKind;

impl Parser<'_> {
    /// Reads `system ... endsystem`.
    pub(super) fn system(&mut self) -> Parse<System> {
        let start = self.advance().span;
        // A name in quotes is a reference, unless a composition follows it.
        let ahead = self.peek_ahead(1);
        let is_name = self.peek().kind == TokenKind::Quoted
            && (matches!(ahead.kind, TokenKind::Quoted | TokenKind::Name) || ahead.text == "(");
        let name = is_name.then(|| name_of(&self.advance()));
        let body = match self.composition() {
            Ok(body) if self.accept_keyword("endsystem") => body,
            outcome => {
                if outcome.is_ok() {
                    self.expected("an operator of composition or `endsystem`");
                }
                self.skip_past("endsystem");
                let span = start.to(self.previous_span());
                SystemExpr {
                    kind: SystemKind::Error,
                    span,
                }
            }
        };
        let span = start.to(self.previous_span());
        Ok(System { name, body, span })
    }

    /// Whether `count` bars follow (and no more).
    fn bars(&self, count: usize) -> bool {
        (0..count).all(|i| self.is_symbol_ahead(i, "|")) && !self.is_symbol_ahead(count, "|")
    }

    /// Reads `a ||| b ||| c || d`: what stands behind the first `||` belongs to the operand before it.
    fn composition(&mut self) -> Parse<SystemExpr> {
        let start = self.peek().span;
        let mut operands = vec![self.synchronised_pair()?];
        while self.bars(3) {
            for _ in 0..3 {
                self.advance();
            }
            operands.push(self.synchronised_pair()?);
        }
        let is_interleaved = operands.len() > 1;
        let first = match operands.pop() {
            Some(last) if is_interleaved => last,
            other => return self.full(other, start),
        };
        let last_start = first.span;
        operands.push(self.full(Some(first), last_start)?);
        Ok(self.joined(operands, SystemKind::Interleaved, start))
    }

    /// Reads `|| b || c` behind the first operand.
    fn full(&mut self, first: Option<SystemExpr>, start: Span) -> Parse<SystemExpr> {
        let mut operands: Vec<SystemExpr> = first.into_iter().collect();
        while self.bars(2) {
            self.advance();
            self.advance();
            operands.push(self.synchronised_pair()?);
        }
        if self.bars(3) {
            let message = "`||` and `|||` need parentheses here.";
            let error = Diagnostic::error("needs-parentheses", self.peek().span, message);
            self.report(error.remedy("Write `(a || b) ||| c` or `a || (b ||| c)`."));
            return Err(Reported);
        }
        Ok(self.joined(operands, SystemKind::Full, start))
    }

    fn joined(
        &mut self,
        mut operands: Vec<SystemExpr>,
        kind: fn(Vec<SystemExpr>) -> SystemKind,
        start: Span,
    ) -> SystemExpr {
        let span = start.to(self.previous_span());
        match operands.pop() {
            Some(only) if operands.is_empty() => only,
            Some(last) => {
                operands.push(last);
                SystemExpr {
                    kind: kind(operands),
                    span,
                }
            }
            None => SystemExpr {
                kind: SystemKind::Error,
                span,
            },
        }
    }

    /// Reads `a |[x,y]| b`.
    fn synchronised_pair(&mut self) -> Parse<SystemExpr> {
        let start = self.peek().span;
        let left = self.hidden_or_renamed()?;
        if !(self.is_symbol("|") && self.is_symbol_ahead(1, "[")) {
            return Ok(left);
        }
        self.advance();
        self.advance();
        let actions = self.names("the name of an action")?;
        self.expect("]")?;
        self.expect("|")?;
        let right = self.hidden_or_renamed()?;
        let span = start.to(self.previous_span());
        let kind = SystemKind::On(Box::new(left), actions, Box::new(right));
        Ok(SystemExpr { kind, span })
    }

    /// Reads `a / {x,y}` and `a {x<-y}`, also one behind the other.
    fn hidden_or_renamed(&mut self) -> Parse<SystemExpr> {
        let start = self.peek().span;
        let mut system = self.system_atom()?;
        let mut operators = 0;
        loop {
            let kind = if self.accept("/") {
                self.expect("{")?;
                SystemKind::Hide(Box::new(system), self.names("the name of an action")?)
            } else if self.accept("{") {
                SystemKind::Rename(Box::new(system), self.action_renames()?)
            } else {
                return Ok(system);
            };
            let span = start.to(self.expect("}")?);
            system = SystemExpr { kind, span };
            operators += 1;
            if operators > super::MAX_DEPTH {
                let message = "too many operators stand behind one another here.";
                let error = Diagnostic::error("too-deep", span, message);
                self.report(error.remedy("Join the names in one pair of braces."));
                return Err(Reported);
            }
        }
    }

    fn action_renames(&mut self) -> Parse<Vec<(Name, Name)>> {
        let mut renames = Vec::new();
        loop {
            let old = self.expect_name("the name of an action")?;
            self.expect("<")?;
            self.expect("-")?;
            renames.push((old, self.expect_name("the new name of an action")?));
            if !self.accept(",") {
                return Ok(renames);
            }
        }
    }

    fn names(&mut self, what: &str) -> Parse<Vec<Name>> {
        let mut names = vec![self.expect_name(what)?];
        while self.accept(",") {
            names.push(self.expect_name(what)?);
        }
        Ok(names)
    }

    fn system_atom(&mut self) -> Parse<SystemExpr> {
        let token = self.peek();
        if self.accept("(") {
            let inside = self.nested(Self::composition)?;
            self.expect(")")?;
            return Ok(inside);
        }
        let kind = match token.kind {
            TokenKind::Quoted => SystemKind::Reference(name_of(&self.advance())),
            _ => SystemKind::Module(self.expect_name("the name of a module")?),
        };
        Ok(SystemExpr {
            kind,
            span: token.span,
        })
    }

    /// Reads `observables x, y endobservables`.
    pub(super) fn observable_variables(&mut self) -> Parse<Observables> {
        let start = self.advance().span;
        let names = self.names("the name of a variable")?;
        let span = start.to(self.expect_keyword("endobservables")?);
        Ok(Observables::Variables { names, span })
    }

    /// Reads `observable "o" = x>0;`.
    pub(super) fn observable(&mut self) -> Parse<Observables> {
        let start = self.advance().span;
        if self.peek().kind != TokenKind::Quoted {
            return Err(self.expected("the name of an observable in double quotes"));
        }
        let name = name_of(&self.advance());
        self.expect("=")?;
        let body = self.expression(Context::Model)?;
        let span = start.to(self.expect(";")?);
        Ok(Observables::Defined { name, body, span })
    }
}
