//! A model as far as it could be read, with stand-ins for the constants that nobody has given a value yet.
//!
//! A constant that is declared without a value is given one on the command line (`--const`). An editor has none, and says so as
//! a remark, not as a mistake; for the properties to be judged, such constants get values that the model accepts.

use crate::text::Text;
use prism_lang::ast::{self, Type};
use prism_lang::names::{Names, Role, Space};
use prism_lang::{Constants, Diagnostic, Number, Value, resolved};
use std::cell::OnceCell;
use std::path::PathBuf;
use std::rc::Rc;

/// The values that constants without one are tried with, one after another.
const WHOLE: [i64; 7] = [1, 2, 3, 4, 5, 10, 0];
/// The same for real numbers.
const REAL: [&str; 7] = ["0.5", "0.1", "0.9", "1", "2", "10", "0"];

/// A model, read. What it means is found out when it is first asked for: names are completed without it.
#[derive(Debug)]
pub struct ModelView {
    /// Where it is.
    pub path: PathBuf,
    /// Its text.
    pub text: Rc<Text>,
    /// What could be read.
    pub tree: ast::Model,
    /// Where it names what.
    pub names: Names,
    /// Whether it has no errors of its form, so that all its names are known.
    pub is_read: bool,
    /// The mistakes of its form.
    of_form: Vec<Diagnostic>,
    meaning: OnceCell<Meaning>,
}

/// What a model means, if it means something.
#[derive(Debug, Default)]
struct Meaning {
    resolved: Option<resolved::Model>,
    diagnostics: Vec<Diagnostic>,
    stand_ins: Vec<(String, Value)>,
}

impl ModelView {
    /// Reads a model.
    #[must_use]
    pub fn new(path: PathBuf, text: Rc<Text>) -> Self {
        let parsed = prism_lang::parse_model(text.as_str());
        let names = Names::of_model(&parsed.tree, text.as_str());
        Self {
            path,
            names,
            is_read: !parsed.has_errors(),
            tree: parsed.tree,
            of_form: parsed.diagnostics,
            text,
            meaning: OnceCell::new(),
        }
    }

    fn meaning(&self) -> &Meaning {
        self.meaning.get_or_init(|| match self.is_read {
            true => self.resolve(),
            false => Meaning::default(),
        })
    }

    /// All mistakes and warnings.
    pub fn diagnostics(&self) -> impl Iterator<Item = &Diagnostic> {
        self.of_form.iter().chain(&self.meaning().diagnostics)
    }

    /// What it means, if it means something.
    #[must_use]
    pub fn resolved(&self) -> Option<&resolved::Model> {
        self.meaning().resolved.as_ref()
    }

    /// The same if it is known already: for what can be said without.
    #[must_use]
    pub fn resolved_already(&self) -> Option<&resolved::Model> {
        self.meaning.get()?.resolved.as_ref()
    }

    /// The constants without a value, with what they were tried with.
    #[must_use]
    pub fn stand_ins(&self) -> &[(String, Value)] {
        &self.meaning().stand_ins
    }

    fn resolve(&self) -> Meaning {
        match prism_lang::resolve(&self.tree, &Constants::new()) {
            Ok(model) => Meaning {
                diagnostics: model.warnings.clone(),
                resolved: Some(model),
                stand_ins: Vec::new(),
            },
            Err(found) => {
                let is_open = |it: &Diagnostic| it.code == "undefined-constant";
                let all_open = found.iter().filter(|it| it.is_error()).all(is_open);
                let tried = all_open.then(|| self.with_values()).flatten();
                let (resolved, stand_ins) = tried.unzip();
                Meaning {
                    resolved,
                    diagnostics: found.into_iter().collect(),
                    stand_ins: stand_ins.unwrap_or_default(),
                }
            }
        }
    }

    /// Resolves with the first values of the open constants that the model accepts.
    fn with_values(&self) -> Option<(resolved::Model, Vec<(String, Value)>)> {
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
                return Some((model, values));
            }
        }
        None
    }

    /// The value of a constant, also where something else is wrong with the model.
    #[must_use]
    pub fn value(&self, name: &str) -> Option<Value> {
        if let Some(model) = self.resolved() {
            return model.constant(name).cloned();
        }
        let (needed, _) = self.needed_by(name);
        let constants = self.tree.constants.iter();
        let constants = constants.filter(|it| needed.contains(&it.name.text));
        let alone = ast::Model {
            model_type: Some((ast::ModelType::Dtmc, prism_lang::Span::default())),
            constants: constants.cloned().collect(),
            ..ast::Model::default()
        };
        let model = prism_lang::resolve(&alone, &Constants::new()).ok()?;
        model.constant(name).cloned()
    }

    /// The constants that a constant's value depends on, itself among them, and whether one of them has none.
    #[must_use]
    pub fn needed_by(&self, name: &str) -> (Vec<String>, bool) {
        let (mut needed, mut is_open) = (vec![name.to_owned()], false);
        let mut next = 0;
        while let Some(constant) = needed.get(next).map(|name| self.constant(name)) {
            next += 1;
            let value = constant.map(|it| it.value.as_ref());
            is_open |= value == Some(None);
            let Some(Some(value)) = value else { continue };
            let within = |span: prism_lang::Span| {
                value.span.start <= span.start && span.end <= value.span.end
            };
            for it in self.names.iter().filter(|it| within(it.span)) {
                if !needed.contains(&it.name) {
                    needed.push(it.name.clone());
                }
            }
        }
        (needed, is_open)
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
