//! A model as far as it could be read, with stand-ins for the constants that nobody has given a value yet.
//!
//! A constant that is declared without a value is given one on the command line (`--const`). An editor has none, and says so as
//! a remark, not as a mistake; for the properties to be judged, such constants get values that the model accepts.

use crate::text::Text;
use prism_lang::ast::{self, Type};
use prism_lang::names::{Names, Role, Space};
use prism_lang::{Constants, Diagnostic, Number, Value, resolved};
use std::path::PathBuf;
use std::rc::Rc;

/// The values that constants without one are tried with, one after another.
const WHOLE: [i64; 7] = [1, 2, 3, 4, 5, 10, 0];
/// The same for real numbers.
const REAL: [&str; 7] = ["0.5", "0.1", "0.9", "1", "2", "10", "0"];

/// A model, read.
#[derive(Debug)]
pub struct ModelView {
    /// Where it is.
    pub path: PathBuf,
    /// Its text.
    pub text: Rc<Text>,
    /// What could be read.
    pub tree: ast::Model,
    /// All mistakes and warnings.
    pub diagnostics: Vec<Diagnostic>,
    /// Where it names what.
    pub names: Names,
    /// What it means, if it means something.
    pub resolved: Option<resolved::Model>,
    /// The constants without a value, with what they were tried with.
    pub stand_ins: Vec<(String, Value)>,
    /// Whether it has no errors of its form, so that all its names are known.
    pub is_read: bool,
}

impl ModelView {
    /// Reads a model.
    #[must_use]
    pub fn new(path: PathBuf, text: Rc<Text>) -> Self {
        let parsed = prism_lang::parse_model(text.as_str());
        let names = Names::of_model(&parsed.tree, text.as_str());
        let is_read = !parsed.has_errors();
        let mut view = Self {
            path,
            names,
            is_read,
            tree: parsed.tree,
            diagnostics: parsed.diagnostics,
            resolved: None,
            stand_ins: Vec::new(),
            text,
        };
        if is_read {
            view.resolve();
        }
        view
    }

    fn resolve(&mut self) {
        match prism_lang::resolve(&self.tree, &Constants::new()) {
            Ok(model) => {
                self.diagnostics.extend(model.warnings.iter().cloned());
                self.resolved = Some(model);
            }
            Err(found) => {
                let is_open = |it: &Diagnostic| it.code == "undefined-constant";
                if found.iter().filter(|it| it.is_error()).all(is_open) {
                    self.try_values();
                }
                self.diagnostics.extend(found);
            }
        }
    }

    /// Resolves with the first values of the open constants that the model accepts.
    fn try_values(&mut self) {
        let open = self.tree.constants.iter().filter(|it| it.value.is_none());
        let open: Vec<&ast::Constant> = open.collect();
        for (whole, real) in WHOLE.into_iter().zip(REAL) {
            let mut given = Constants::new();
            let value = |ty: Type| match ty {
                Type::Bool => Some(Value::Bool(true)),
                Type::Int => Some(Value::Int(whole)),
                Type::Double => Number::parse(real).map(Value::Double),
            };
            let values: Vec<(String, Value)> = open
                .iter()
                .filter_map(|it| Some((it.name.text.clone(), value(it.ty)?)))
                .collect();
            for (name, value) in &values {
                given.set(name.clone(), value.clone());
            }
            if let Ok(model) = prism_lang::resolve(&self.tree, &given) {
                self.resolved = Some(model);
                self.stand_ins = values;
                return;
            }
        }
    }

    /// The constant of this name.
    #[must_use]
    pub fn constant(&self, name: &str) -> Option<&ast::Constant> {
        self.tree.constants.iter().find(|it| it.name.text == name)
    }

    /// The formula of this name.
    #[must_use]
    pub fn formula(&self, name: &str) -> Option<&ast::Formula> {
        self.tree.formulas.iter().find(|it| it.name.text == name)
    }

    /// The label of this name.
    #[must_use]
    pub fn label(&self, name: &str) -> Option<&ast::Label> {
        self.tree.labels.iter().find(|it| it.name.text == name)
    }

    /// The variable of this name that is written out, with its module.
    #[must_use]
    pub fn variable(&self, name: &str) -> Option<(&ast::Variable, Option<&ast::Module>)> {
        let globals = self.tree.globals.iter().map(|it| (it, None));
        let locals = self.tree.modules.iter().flat_map(|module| {
            let variables = match &module.body {
                ast::ModuleBody::Written { variables, .. } => variables.as_slice(),
                ast::ModuleBody::Renamed { .. } => &[],
            };
            variables.iter().map(move |it| (it, Some(module)))
        });
        globals.chain(locals).find(|(it, _)| it.name.text == name)
    }

    /// The names of a space that are declared, each once, in the order of the alphabet.
    #[must_use]
    pub fn declared(&self, space: Space) -> Vec<&str> {
        let all = self.names.iter();
        let declared = all.filter(|it| it.space == space && it.role == Role::Definition);
        let mut names: Vec<&str> = declared.map(|it| it.name.as_str()).collect();
        names.sort_unstable();
        names.dedup();
        names
    }
}
