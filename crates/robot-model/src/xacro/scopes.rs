//! Properties and macros by name, in scopes inside one another.

use super::text::Parameter;
use super::value::Value;
use crate::diagnostics::Place;
use crate::xml::Element;
use std::collections::BTreeMap;
use std::rc::Rc;

/// What a property is.
#[derive(Debug, Clone)]
pub(super) enum Entry {
    Value(Value),
    /// A text that is evaluated when it is first asked for, in the scope that has it.
    Lazy(Rc<str>, Place),
    /// It is being evaluated: whoever asks for it now goes in a circle.
    Evaluating,
    /// Elements.
    Block(Rc<Element>),
}

/// Properties.
#[derive(Debug, Default)]
pub(super) struct Scope {
    pub parent: Option<usize>,
    pub entries: BTreeMap<String, Entry>,
    /// Whether it is that of an `xacro:include` with `ns`.
    pub is_namespace: bool,
}

/// A macro.
#[derive(Debug)]
pub(super) struct Macro {
    pub parameters: Vec<Parameter>,
    pub body: Element,
}

/// Macros.
#[derive(Debug, Default)]
pub(super) struct MacroScope {
    pub parent: Option<usize>,
    pub macros: BTreeMap<String, Rc<Macro>>,
    /// Those of namespaces: macros and properties.
    pub namespaces: BTreeMap<String, At>,
}

/// Where names are looked up, by the places of scopes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct At {
    pub symbols: usize,
    pub macros: usize,
}

/// All scopes.
#[derive(Debug)]
pub(super) struct Scopes {
    pub symbols: Vec<Scope>,
    macros: Vec<MacroScope>,
}

impl Scopes {
    /// The outermost scope alone.
    pub fn new() -> (Self, At) {
        let scopes = Self {
            symbols: vec![Scope::default()],
            macros: vec![MacroScope::default()],
        };
        let outermost = At {
            symbols: 0,
            macros: 0,
        };
        (scopes, outermost)
    }

    /// A scope inside another, as of a macro that is called.
    pub fn inside(&mut self, at: At) -> At {
        self.symbols.push(Scope {
            parent: Some(at.symbols),
            ..Scope::default()
        });
        self.macros.push(MacroScope {
            parent: Some(at.macros),
            ..MacroScope::default()
        });
        self.last()
    }

    /// A namespace inside another scope, whose macros see no others.
    pub fn namespace(&mut self, name: &str, at: At) -> At {
        self.symbols.push(Scope {
            parent: Some(at.symbols),
            is_namespace: true,
            ..Scope::default()
        });
        self.macros.push(MacroScope::default());
        let inner = self.last();
        let entry = Entry::Value(Value::Namespace(inner.symbols));
        self.symbols[at.symbols]
            .entries
            .insert(name.to_owned(), entry);
        self.macros[at.macros]
            .namespaces
            .insert(name.to_owned(), inner);
        inner
    }

    fn last(&self) -> At {
        At {
            symbols: self.symbols.len() - 1,
            macros: self.macros.len() - 1,
        }
    }

    /// Forgets the scopes from one on, which nothing refers to any more.
    pub fn leave(&mut self, at: At) {
        // Namespaces that were made inside may be referred to by nothing outside either.
        self.symbols.truncate(at.symbols);
        self.macros.truncate(at.macros);
    }

    /// The scope that has a name, from one outwards.
    pub fn scope_of(&self, symbols: usize, name: &str) -> Option<usize> {
        let mut next = Some(symbols);
        while let Some(scope) = next {
            // A namespace may have gone with the macro that included it.
            let known = self.symbols.get(scope)?;
            if known.entries.contains_key(name) {
                return Some(scope);
            }
            next = known.parent;
        }
        None
    }

    /// The outermost scope of one.
    pub fn top(&self, symbols: usize) -> usize {
        let mut scope = symbols;
        while let Some(parent) = self.symbols[scope].parent {
            scope = parent;
        }
        scope
    }

    /// The scope of whoever called the macro whose scope this is.
    pub fn caller(&self, symbols: usize) -> Option<usize> {
        let mut scope = self.symbols[symbols].parent?;
        if !self.symbols[symbols].is_namespace {
            while self.symbols[scope].is_namespace {
                scope = self.symbols[scope].parent?;
            }
        }
        Some(scope)
    }

    /// Takes a name from a scope and all around it.
    pub fn remove(&mut self, symbols: usize, name: &str) {
        while let Some(scope) = self.scope_of(symbols, name) {
            self.symbols[scope].entries.remove(name);
        }
    }

    pub fn define(&mut self, at: At, name: &str, of: Macro) {
        self.macros[at.macros]
            .macros
            .insert(name.to_owned(), Rc::new(of));
    }

    /// A macro by its name, with the scope in which it stands.
    pub fn called(&self, at: At, name: &str) -> Option<(Rc<Macro>, At)> {
        if let Some(found) = self.macro_of(at.macros, name) {
            return Some((found, at));
        }
        let mut parts: Vec<&str> = name.split('.').collect();
        let last = parts.pop()?;
        if parts.is_empty() {
            return None;
        }
        let mut inner = at;
        for part in parts {
            inner = self.namespace_of(inner.macros, part)?;
        }
        Some((self.macro_of(inner.macros, last)?, inner))
    }

    fn macro_of(&self, macros: usize, name: &str) -> Option<Rc<Macro>> {
        let mut next = Some(macros);
        while let Some(scope) = next {
            if let Some(found) = self.macros[scope].macros.get(name) {
                return Some(Rc::clone(found));
            }
            next = self.macros[scope].parent;
        }
        None
    }

    fn namespace_of(&self, macros: usize, name: &str) -> Option<At> {
        let mut next = Some(macros);
        while let Some(scope) = next {
            if let Some(found) = self.macros[scope].namespaces.get(name) {
                return Some(*found);
            }
            next = self.macros[scope].parent;
        }
        None
    }
}
