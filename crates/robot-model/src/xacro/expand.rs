//! The walk over a template that makes XML of it.

use super::eval::{Evaluated, MOST, Surroundings, evaluate};
use super::parse::parse;
use super::scopes::{At, Entry, Macro, Scopes};
use super::text::{Part, parameters, parts};
use super::value::{Value, literal, number, whole};
use super::{Arguments, yaml};
use crate::diagnostics::{Place, Problem};
use crate::reader::{Reader, joined};
use crate::xml::{self, Attribute, Element};
use std::rc::Rc;
use std::sync::Arc;

/// Elements, macros and files inside one another; robots have some thirty.
const MAX_DEPTH: usize = 120;

/// Elements that a template may become.
const MAX_ELEMENTS: usize = 500_000;

/// Values that are computed, and texts that are joined, by their size.
const MAX_WORK: usize = 20_000_000;

/// Properties that are evaluated for one another.
const MAX_LAZY: usize = 60;

/// Words that are no names, since expressions could not have them.
const KEYWORDS: [&str; 12] = [
    "and", "or", "not", "in", "is", "if", "else", "for", "lambda", "None", "True", "False",
];

type Expanded<T> = Result<T, Problem>;

/// The XML that a template stands for, with values of its arguments; and the names of those that it declares.
pub(crate) fn expand(
    reader: &mut Reader<'_, '_>,
    root: Element,
    arguments: Arguments,
) -> Result<(Element, Vec<String>), Problem> {
    let (scopes, at) = Scopes::new();
    let mut expander = Expander {
        reader,
        scopes,
        arguments,
        declared: Vec::new(),
        files: vec![Arc::clone(&root.place.file)],
        calls: Vec::new(),
        depth: 0,
        lazy: 0,
        elements: 0,
        work: 0,
    };
    let mut root = root;
    expander.element(&mut root, at)?;
    Ok((root, expander.declared))
}

struct Expander<'e, 'r, 's> {
    reader: &'e mut Reader<'r, 's>,
    scopes: Scopes,
    /// The values of `xacro:arg`.
    arguments: Arguments,
    /// The names of those that the template declares, in their order.
    declared: Vec<String>,
    /// The files that are being read, the innermost last.
    files: Vec<Arc<str>>,
    /// The macros that are being expanded, with where they are called.
    calls: Vec<(String, Place)>,
    depth: usize,
    lazy: usize,
    elements: usize,
    work: usize,
}

/// An evaluation in a scope.
struct Within<'w, 'e, 'r, 's> {
    expander: &'w mut Expander<'e, 'r, 's>,
    symbols: usize,
}

impl Surroundings for Within<'_, '_, '_, '_> {
    fn property(&mut self, name: &str) -> Result<Option<Value>, String> {
        self.expander.property(self.symbols, name)
    }

    fn member(&mut self, scope: usize, name: &str) -> Result<Option<Value>, String> {
        self.expander.property(scope, name)
    }

    fn argument(&mut self, name: &str) -> Result<Value, String> {
        self.expander.argument(name).map(Value::text)
    }

    fn yaml(&mut self, file: &str) -> Evaluated {
        let address = self.expander.address(file);
        let text = self.expander.reader.text_at(&address)?;
        self.spend(text.len())?;
        let mut numbers = |text: &str| {
            let value = evaluate(&parse(text)?, self)?;
            value
                .number()
                .ok_or_else(|| format!("`{text}` is not a number"))
        };
        yaml::parse(&text, &mut numbers).map_err(|reason| format!("{address}: {reason}"))
    }

    fn spend(&mut self, work: usize) -> Result<(), String> {
        self.expander.spend(work)
    }
}

impl Expander<'_, '_, '_> {
    fn spend(&mut self, work: usize) -> Result<(), String> {
        self.work = self.work.saturating_add(work);
        match self.work <= MAX_WORK {
            true => Ok(()),
            false => Err("it takes too much work to expand".to_owned()),
        }
    }

    fn problem(&self, place: &Place, message: impl Into<String>, remedy: &str) -> Problem {
        let mut message = message.into();
        // The innermost call says where it comes from; the others follow from it.
        if let Some((name, at)) = self.calls.last() {
            message = format!("{message} (in macro `{name}`, called at {at})");
        }
        Problem {
            place: place.clone(),
            message,
            remedy: remedy.to_owned(),
        }
    }

    /// The value of a property, from a scope outwards; a text is evaluated when it is first asked for.
    fn property(&mut self, symbols: usize, name: &str) -> Result<Option<Value>, String> {
        let Some(scope) = self.scopes.scope_of(symbols, name) else {
            return Ok(None);
        };
        let Some(entry) = self.scopes.symbols[scope].entries.get_mut(name) else {
            return Ok(None);
        };
        let (text, place) = match entry {
            Entry::Value(value) => return Ok(Some(value.clone())),
            Entry::Block(_) => {
                return Err(format!(
                    "`{name}` is a block: insert it with xacro:insert_block"
                ));
            }
            Entry::Evaluating => return Err(format!("property `{name}` is defined by itself")),
            Entry::Lazy(text, place) => (Rc::clone(text), place.clone()),
        };
        *entry = Entry::Evaluating;
        self.lazy += 1;
        if self.lazy > MAX_LAZY {
            return Err(format!(
                "more than {MAX_LAZY} properties are defined by one another"
            ));
        }
        let value = self.evaluated(&text, scope);
        let value = value.map_err(|reason| format!("{reason} (property `{name}` of {place})"))?;
        self.lazy -= 1;
        let value = as_literal(value);
        let entries = &mut self.scopes.symbols[scope].entries;
        entries.insert(name.to_owned(), Entry::Value(value.clone()));
        Ok(Some(value))
    }

    fn argument(&self, name: &str) -> Result<&str, String> {
        let found = self.arguments.get(name);
        found.map(String::as_str).ok_or_else(|| {
            format!("there is no argument `{name}`: declare it with xacro:arg before")
        })
    }

    /// What a text with expressions and substitutions in it is; one by itself keeps its type.
    fn evaluated(&mut self, text: &str, symbols: usize) -> Evaluated {
        if !text.contains('$') {
            return Ok(Value::text(text));
        }
        let parts = parts(text)?;
        let mut values = Vec::new();
        for part in &parts {
            let value = match part {
                Part::Plain(plain) => Value::text(plain),
                Part::Expression(inner) => {
                    let inner = self.evaluated(inner, symbols)?.to_string();
                    self.expression(&inner, symbols)?
                }
                Part::Substitution(inner) => {
                    let inner = self.evaluated(inner, symbols)?.to_string();
                    Value::text(self.substitution(&inner)?)
                }
            };
            self.spend(value.size(MOST))?;
            values.push(value);
        }
        if let [_] = values[..] {
            return values.pop().ok_or_else(String::new);
        }
        let mut whole = String::new();
        for value in values {
            whole.push_str(&value.to_string());
            if whole.len() > MOST {
                return Err(format!("a text becomes longer than {MOST} characters"));
            }
        }
        // A package's folder is an address here, which is of no file system.
        Ok(Value::text(
            whole.replace("file://package://", "package://"),
        ))
    }

    fn expression(&mut self, text: &str, symbols: usize) -> Evaluated {
        let found = parse(text).and_then(|expr| {
            let mut within = Within {
                expander: self,
                symbols,
            };
            evaluate(&expr, &mut within)
        });
        found.map_err(|reason| match reason.contains("in `${") {
            true => reason,
            false => format!("{reason} in `${{{text}}}`"),
        })
    }

    /// What `$(...)` stands for.
    fn substitution(&mut self, text: &str) -> Result<String, String> {
        let text = text.trim();
        let (command, rest) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
        let rest = rest.trim();
        match (command, rest.split_whitespace().count()) {
            ("arg", 1) => self.argument(rest).map(str::to_owned),
            ("find", 1) => Ok(format!("package://{rest}")),
            ("dirname", 0) => Ok(self.folder()),
            ("cwd", 0) => Ok(".".to_owned()),
            ("optenv", 1..) => {
                let default = rest.split_once(char::is_whitespace);
                Ok(default.map_or_else(String::new, |(_, default)| default.trim().to_owned()))
            }
            ("env", 1) => Err(format!(
                "$(env {rest}) is refused: no environment is read, so that a file means the same everywhere"
            )),
            ("eval", 1..) => self.of_arguments(rest),
            _ => Err(format!("`$({text})` is not known")),
        }
    }

    /// What `$(eval ...)` gives: an expression over the arguments.
    fn of_arguments(&mut self, text: &str) -> Result<String, String> {
        let outermost = self.scopes.symbols.len();
        let entries = self.arguments.iter().map(|(name, value)| {
            let value = match (value.contains('.'), value.to_lowercase().as_str()) {
                (_, "true") => Value::Bool(true),
                (_, "false") => Value::Bool(false),
                (true, _) => number(value).map_or_else(|| Value::text(value), Value::Float),
                (false, _) => whole(value).map_or_else(|| Value::text(value), Value::Int),
            };
            (name.clone(), Entry::Value(value))
        });
        self.scopes.symbols.push(super::scopes::Scope {
            entries: entries.collect(),
            ..super::scopes::Scope::default()
        });
        let value = self.expression(text, outermost);
        self.scopes.symbols.truncate(outermost);
        value.map(|it| it.to_string())
    }

    fn file(&self) -> Arc<str> {
        self.files.last().cloned().unwrap_or_else(|| Arc::from(""))
    }

    fn folder(&self) -> String {
        let file = self.file();
        file.rsplit_once('/')
            .map_or(".", |(folder, _)| folder)
            .to_owned()
    }

    fn address(&self, named: &str) -> String {
        let named = named.strip_prefix("file://").unwrap_or(named);
        joined(&self.file(), named)
    }

    /// A text at a place.
    fn at(&mut self, text: &str, place: &Place, at: At) -> Expanded<Value> {
        self.evaluated(text, at.symbols)
            .map_err(|reason| self.problem(place, reason, "correct the template there"))
    }

    fn text_at(&mut self, text: &str, place: &Place, at: At) -> Expanded<String> {
        self.at(text, place, at).map(|it| it.to_string())
    }

    /// Evaluates an element, and what is in it.
    fn element(&mut self, element: &mut Element, at: At) -> Expanded<()> {
        self.depth += 1;
        if self.depth > MAX_DEPTH {
            let message = format!("elements and macros are nested more than {MAX_DEPTH} deep");
            return Err(self.problem(
                &element.place,
                message,
                "look for a macro that calls itself",
            ));
        }
        self.elements += 1;
        if self.elements > MAX_ELEMENTS {
            let message = format!("it becomes more than {MAX_ELEMENTS} elements");
            return Err(self.problem(
                &element.place,
                message,
                "look for macros that call one another",
            ));
        }
        element
            .attributes
            .retain(|it| !it.name.starts_with("xacro:") && it.name != "xmlns:xacro");
        for place in 0..element.attributes.len() {
            let attribute = &element.attributes[place];
            if attribute.value.contains('$') {
                let (text, at_place) = (attribute.value.clone(), attribute.place.clone());
                element.attributes[place].value = self.text_at(&text, &at_place, at)?;
            }
        }
        if element.text.contains('$') {
            element.text = self
                .text_at(&element.text, &element.place.clone(), at)?
                .trim()
                .to_owned();
        }
        for child in std::mem::take(&mut element.children) {
            self.child(element, child, at)?;
        }
        self.depth -= 1;
        Ok(())
    }

    /// Puts what a child stands for into its parent.
    fn child(&mut self, parent: &mut Element, mut child: Element, at: At) -> Expanded<()> {
        let Some(word) = child.name.strip_prefix("xacro:").map(str::to_owned) else {
            self.element(&mut child, at)?;
            parent.children.push(child);
            return Ok(());
        };
        match word.as_str() {
            "property" => self.define(&child, at),
            "macro" => self.define_macro(child, at),
            "arg" => self.declare(&child, at),
            "include" => self.include(parent, &child, at),
            "insert_block" => self.insert(parent, &child, at),
            "if" => self.only_if(parent, child, true, at),
            "unless" => self.only_if(parent, child, false, at),
            "element" => {
                let name = self.required(&child, "xacro:name")?.clone();
                child.name = self.text_at(&name.value, &name.place, at)?;
                child.attributes.retain(|it| it.name != "xacro:name");
                if child.name.is_empty() || child.name == "xacro:element" {
                    return Err(self.problem(&name.place, "an element needs a name", "give one"));
                }
                self.child(parent, child, at)
            }
            "attribute" => self.set_attribute(parent, &child, at),
            "call" => {
                let name = self.required(&child, "macro")?.clone();
                let called = self.text_at(&name.value, &name.place, at)?;
                child.attributes.retain(|it| it.name != "macro");
                self.call(parent, child, &called, at)
            }
            _ => self.call(parent, child, &word, at),
        }
    }

    /// `xacro:arg`: the first value counts.
    fn declare(&mut self, element: &Element, at: At) -> Expanded<()> {
        let name = self.required(element, "name")?.value.clone();
        let default = self.required(element, "default")?.clone();
        if !self.declared.contains(&name) {
            self.declared.push(name.clone());
        }
        if !self.arguments.contains_key(&name) {
            let value = self.text_at(&default.value, &default.place, at)?;
            self.arguments.insert(name, value);
        }
        Ok(())
    }

    /// What is in an element, if its condition is what is wanted.
    fn only_if(
        &mut self,
        parent: &mut Element,
        mut element: Element,
        wanted: bool,
        at: At,
    ) -> Expanded<()> {
        let value = self.required(&element, "value")?.clone();
        let found = self.at(&value.value, &value.place, at)?;
        let holds = truth(&found).ok_or_else(|| {
            let message = format!(
                "the condition is {}, which is neither true nor false",
                found.repr()
            );
            self.problem(&value.place, message, "give true, false or a number")
        })?;
        if holds == wanted {
            element.attributes.clear();
            self.element(&mut element, at)?;
            adopt(parent, element);
        }
        Ok(())
    }

    fn set_attribute(&mut self, parent: &mut Element, element: &Element, at: At) -> Expanded<()> {
        let name = self.required(element, "name")?.clone();
        let value = self.required(element, "value")?.clone();
        let attribute = Attribute {
            name: self.text_at(&name.value, &name.place, at)?,
            value: self.text_at(&value.value, &value.place, at)?,
            place: element.place.clone(),
        };
        parent.attributes.retain(|it| it.name != attribute.name);
        parent.attributes.push(attribute);
        Ok(())
    }

    fn required<'n>(&self, element: &'n Element, name: &str) -> Expanded<&'n Attribute> {
        element.attribute(name).ok_or_else(|| {
            let message = format!("<{}> has no `{name}`", element.name);
            self.problem(&element.place, message, "add the attribute")
        })
    }

    fn define(&mut self, element: &Element, at: At) -> Expanded<()> {
        let name = self.required(element, "name")?.clone();
        let plain = self.text_at(&name.value, &name.place, at)?;
        if !is_name(&plain) {
            let message = format!("`{plain}` cannot be the name of a property");
            return Err(self.problem(
                &name.place,
                message,
                "use letters, digits and `_`, and no word of expressions",
            ));
        }
        let [value, default] = ["value", "default"].map(|key| element.attribute(key));
        let is_removed = match element.attribute("remove") {
            Some(remove) => self.flag(remove, at)?,
            None => false,
        };
        if usize::from(value.is_some()) + usize::from(default.is_some()) + usize::from(is_removed)
            > 1
        {
            let message =
                format!("property `{plain}` has more than one of `value`, `default` and `remove`");
            return Err(self.problem(&element.place, message, "keep one"));
        }
        if is_removed && self.scopes.scope_of(at.symbols, &plain).is_some() {
            self.scopes.remove(at.symbols, &plain);
            return Ok(());
        }
        if default.is_some() && self.scopes.scope_of(at.symbols, &plain).is_some() {
            return Ok(());
        }
        let lazy = match element.attribute("lazy_eval") {
            Some(lazy) => self.flag(lazy, at)?,
            None => true,
        };
        let (target, lazy) = match element.get("scope") {
            Some("global") => (self.scopes.top(at.symbols), false),
            Some("parent") => match self.scopes.caller(at.symbols) {
                Some(caller) => (caller, false),
                // Nobody is there to have it.
                None => return Ok(()),
            },
            _ => (at.symbols, lazy),
        };
        let Some(text) = value.or(default).cloned() else {
            let block = Entry::Block(Rc::new(element.clone()));
            self.scopes.symbols[target]
                .entries
                .insert(format!("**{plain}"), block);
            return Ok(());
        };
        let entry = match lazy {
            true => entry_of(&text),
            false => Entry::Value(as_literal(self.at(&text.value, &text.place, at)?)),
        };
        self.scopes.symbols[target].entries.insert(plain, entry);
        Ok(())
    }

    fn flag(&mut self, attribute: &Attribute, at: At) -> Expanded<bool> {
        let value = self.at(&attribute.value, &attribute.place, at)?;
        truth(&value).ok_or_else(|| {
            let message = format!("`{}` is {}", attribute.name, value.repr());
            self.problem(&attribute.place, message, "give true or false")
        })
    }

    fn define_macro(&mut self, element: Element, at: At) -> Expanded<()> {
        let name = self.required(&element, "name")?.clone();
        let plain = name
            .value
            .strip_prefix("xacro:")
            .unwrap_or(&name.value)
            .to_owned();
        if plain == "call" || plain.contains('.') || plain.is_empty() {
            let message = format!("`{plain}` cannot be the name of a macro");
            return Err(self.problem(
                &name.place,
                message,
                "use a name without `.` that is not `call`",
            ));
        }
        let parameters = parameters(element.get("params").unwrap_or(""));
        let body = Element {
            attributes: Vec::new(),
            ..element
        };
        self.scopes.define(at, &plain, Macro { parameters, body });
        Ok(())
    }

    fn insert(&mut self, parent: &mut Element, element: &Element, at: At) -> Expanded<()> {
        let name = self.required(element, "name")?;
        for (stars, is_content) in [("**", true), ("*", false)] {
            let key = format!("{stars}{}", name.value);
            let scope = self.scopes.scope_of(at.symbols, &key);
            let entry = scope.and_then(|scope| self.scopes.symbols[scope].entries.get(&key));
            if let Some(Entry::Block(block)) = entry {
                let mut block = (**block).clone();
                if is_content {
                    // Only what is in it is inserted, so that its own attributes say nothing.
                    block.attributes.clear();
                }
                self.element(&mut block, at)?;
                match is_content {
                    true => adopt(parent, block),
                    false => parent.children.push(block),
                }
                return Ok(());
            }
        }
        let message = format!("there is no block `{}`", name.value);
        Err(self.problem(
            &name.place,
            message,
            "name a parameter with `*`, or a property without a value",
        ))
    }

    fn include(&mut self, parent: &mut Element, element: &Element, at: At) -> Expanded<()> {
        let file = self.required(element, "filename")?.clone();
        let named = self.text_at(&file.value, &file.place, at)?;
        let at = match element.attribute("ns").cloned() {
            Some(name) => {
                let name = self.text_at(&name.value, &name.place, at)?;
                self.scopes.namespace(&name, at)
            }
            None => at,
        };
        let is_optional = element
            .attribute("optional")
            .is_some_and(|it| truth(&literal(&it.value)) == Some(true));
        if named.contains(['*', '?', '[']) {
            let message = format!("`{named}` is a pattern of file names");
            return Err(self.problem(&file.place, message, "include each file by its name"));
        }
        let address = self.address(&named);
        let text = match self.reader.text_at(&address) {
            Ok(text) => text,
            Err(_) if is_optional => return Ok(()),
            Err(reason) => {
                let message = format!("{address} cannot be had: {reason}");
                let remedy = "correct the name, or keep the package's folder, named as the package, above or beside this file";
                return Err(self.problem(&file.place, message, remedy));
            }
        };
        let mut root = xml::read(&address, &text)?;
        self.files.push(Arc::from(address.as_str()));
        self.element(&mut root, at)?;
        self.files.pop();
        adopt(parent, root);
        Ok(())
    }

    fn call(
        &mut self,
        parent: &mut Element,
        mut node: Element,
        name: &str,
        at: At,
    ) -> Expanded<()> {
        let Some((of, standing)) = self.scopes.called(at, name) else {
            let message = format!("there is no macro `{name}`");
            let remedy = "define it with <xacro:macro> before, or include the file that does";
            return Err(self.problem(&node.place, message, remedy));
        };
        let mut given: Vec<(String, Value)> = Vec::new();
        for attribute in std::mem::take(&mut node.attributes) {
            if attribute.name.starts_with("xmlns") {
                continue;
            }
            let is_known = of.parameters.iter().any(|it| it.name == attribute.name);
            if !is_known {
                let message = format!("macro `{name}` has no parameter `{}`", attribute.name);
                return Err(self.problem(
                    &attribute.place,
                    message,
                    "leave it out, or correct its name",
                ));
            }
            let value = self.at(&attribute.value, &attribute.place, at)?;
            given.push((attribute.name, as_literal(value)));
        }
        // What stands in the call is the caller's.
        self.element(&mut node, at)?;
        let mut blocks = std::mem::take(&mut node.children).into_iter();
        let inner = self.scopes.inside(standing);
        for (name, value) in given {
            let entries = &mut self.scopes.symbols[inner.symbols].entries;
            entries.insert(name, Entry::Value(value));
        }
        self.calls.push((name.to_owned(), node.place.clone()));
        self.parameters(&of, &mut blocks, (&node.place, at), inner)?;
        if let Some(block) = blocks.next() {
            let message = format!(
                "macro `{name}` takes no more blocks, and <{}> is one",
                block.name
            );
            return Err(self.problem(
                &block.place,
                message,
                "leave it out, or add a parameter with `*`",
            ));
        }
        let mut body = of.body.clone();
        self.element(&mut body, inner)?;
        self.calls.pop();
        self.scopes.leave(inner);
        adopt(parent, body);
        Ok(())
    }

    /// Gives blocks to a macro's parameters, and to those that were not given a value what they have otherwise.
    fn parameters(
        &mut self,
        of: &Macro,
        blocks: &mut std::vec::IntoIter<Element>,
        (place, caller): (&Place, At),
        inner: At,
    ) -> Expanded<()> {
        for parameter in of.parameters.iter().filter(|it| it.name.starts_with('*')) {
            let Some(block) = blocks.next() else {
                let message = format!(
                    "the block `{}` is missing",
                    parameter.name.trim_start_matches('*')
                );
                return Err(self.problem(place, message, "give it as an element inside the call"));
            };
            let entries = &mut self.scopes.symbols[inner.symbols].entries;
            entries.insert(parameter.name.clone(), Entry::Block(Rc::new(block)));
        }
        for parameter in of.parameters.iter().filter(|it| !it.name.starts_with('*')) {
            let name = &parameter.name;
            if self.scopes.symbols[inner.symbols]
                .entries
                .contains_key(name)
            {
                continue;
            }
            let forwarded = match parameter.forwards {
                true => self
                    .property(caller.symbols, name)
                    .map_err(|reason| self.problem(place, reason, "correct the property"))?,
                false => None,
            };
            let value = match (forwarded, &parameter.default) {
                (Some(value), _) => value,
                (None, Some(default)) => self.at(default, place, caller)?,
                (None, None) => {
                    let message = format!("the parameter `{name}` has no value");
                    return Err(self.problem(
                        place,
                        message,
                        "give it in the call, or a default to the macro",
                    ));
                }
            };
            let entry = Entry::Value(as_literal(value));
            let entries = &mut self.scopes.symbols[inner.symbols].entries;
            entries.insert(name.clone(), entry);
        }
        Ok(())
    }
}

/// What is in an element becomes a part of another.
fn adopt(parent: &mut Element, mut from: Element) {
    parent.children.append(&mut from.children);
    if !from.text.is_empty() {
        parent.text = format!("{} {}", parent.text, from.text).trim().to_owned();
    }
}

/// A text that was evaluated is a number or truth value where it reads as one.
fn as_literal(value: Value) -> Value {
    match value {
        Value::Text(text) => literal(&text),
        other => other,
    }
}

/// A property's text; what reads as a number is one at once.
fn entry_of(text: &Attribute) -> Entry {
    match literal(&text.value) {
        Value::Text(plain) => Entry::Lazy(plain, text.place.clone()),
        value => Entry::Value(value),
    }
}

/// Whether a condition holds; `None` if it is none.
fn truth(value: &Value) -> Option<bool> {
    match value {
        Value::Text(text) => match &**text {
            "true" | "True" => Some(true),
            "false" | "False" => Some(false),
            other => whole(other).map(|it| it != 0),
        },
        other => Some(other.truth()),
    }
}

fn is_name(name: &str) -> bool {
    let mut characters = name.chars();
    let begins = characters
        .next()
        .is_some_and(|it| it.is_alphabetic() || it == '_');
    begins
        && characters.all(|it| it.is_alphanumeric() || it == '_')
        && !name.starts_with("__")
        && !KEYWORDS.contains(&name)
}
