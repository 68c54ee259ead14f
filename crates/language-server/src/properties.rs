//! A properties file, and the model that it is judged with.
//!
//! # Definition
//! The model is, of the first of these that name one: the models of the study's ledger, of which one is alone or has the name of
//! the properties file; the model in the same folder that has its name (`grip.props` and `grip.prism`; of several, the first of
//! the alphabet); the only model in the folder. Otherwise there is none, and only the form of the properties is judged.

use crate::kind::Kind;
use crate::model::ModelView;
use crate::text::Text;
use crate::workspace::Workspace;
use prism_lang::ast::PropertyFile;
use prism_lang::names::Names;
use prism_lang::{Constants, Diagnostic, Number, Value};
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// A properties file, read.
#[derive(Debug)]
pub struct PropertiesView {
    /// Where it is.
    pub path: PathBuf,
    /// Its text.
    pub text: Rc<Text>,
    /// What could be read.
    pub tree: PropertyFile,
    /// All mistakes and warnings.
    pub diagnostics: Vec<Diagnostic>,
    /// Where it names what.
    pub names: Names,
    /// The model it was judged with.
    pub model: Option<Rc<ModelView>>,
    /// Which model that is and why, or why there is none.
    pub judged_with: String,
    /// Whether it has no errors of its form, so that all its names are known.
    pub is_read: bool,
}

impl PropertiesView {
    /// Reads a properties file; `None` if there is no such file.
    #[must_use]
    pub fn new(workspace: &Workspace, path: &Path) -> Option<Self> {
        let text = workspace.read(path)?;
        let parsed = prism_lang::parse_properties(text.as_str());
        let names = Names::of_properties(&parsed.tree, text.as_str());
        let (model, mut judged_with) = model_of(workspace, path);
        let model = model.and_then(|it| workspace.model(&it));
        let is_read = !parsed.has_errors();
        let mut diagnostics = parsed.diagnostics;
        match model.as_ref().map(|it| it.resolved()) {
            Some(Some(resolved)) if !parsed.tree.has_errors_outside(&diagnostics) => {
                diagnostics.extend(mistakes(&parsed.tree, resolved));
                diagnostics.sort_by_key(|it| it.span);
            }
            Some(None) => judged_with.push_str("; it has mistakes, so only the form is judged"),
            Some(Some(_)) | None => {}
        }
        Some(Self {
            path: path.to_owned(),
            text,
            tree: parsed.tree,
            diagnostics,
            names,
            model,
            judged_with,
            is_read,
        })
    }
}

/// What properties say wrong of a model, constants without a value aside. Those get one, so that what they are used in is judged.
fn mistakes(file: &PropertyFile, model: &prism_lang::resolved::Model) -> Vec<Diagnostic> {
    let Err(found) = prism_lang::resolve_properties(file, model, &Constants::new()) else {
        return Vec::new();
    };
    let is_open = |it: &&Diagnostic| it.code == "undefined-constant";
    let open: Vec<Diagnostic> = found.iter().filter(is_open).cloned().collect();
    if open.is_empty() {
        return found.into_iter().collect();
    }
    let mut given = Constants::new();
    for constant in file.constants.iter().filter(|it| it.value.is_none()) {
        let value = match constant.ty {
            prism_lang::ast::Type::Bool => Some(Value::Bool(true)),
            prism_lang::ast::Type::Int => Some(Value::Int(1)),
            prism_lang::ast::Type::Double => Number::parse("0.5").map(Value::Double),
        };
        if let Some(value) = value {
            given.set(constant.name.text.clone(), value);
        }
    }
    let with_values = prism_lang::resolve_properties(file, model, &given).err();
    let rest = with_values.into_iter().flatten().filter(|it| !is_open(&it));
    // A name that is declared twice is told twice.
    let mut all = open;
    for it in rest {
        if !all.contains(&it) {
            all.push(it);
        }
    }
    all
}

/// The model that a properties file is judged with, and how that is said.
#[must_use]
pub fn model_of(workspace: &Workspace, path: &Path) -> (Option<PathBuf>, String) {
    let stem = path.file_stem();
    let said = |model: &Path, why: &str| {
        let name = model.file_name().unwrap_or(model.as_os_str());
        format!("judged with {} ({why})", name.to_string_lossy())
    };
    if let Some(study) = workspace.study_of(path) {
        let models = study.models();
        let named = models.iter().find(|it| it.file_stem() == stem);
        if let Some(model) = named {
            let words = said(
                model,
                "the study's ledger names it, and it has this file's name",
            );
            return (Some(model.clone()), words);
        }
        if let [model] = models.as_slice() {
            let words = said(model, "the only model in the study's ledger");
            return (Some(model.clone()), words);
        }
    }
    let Some(folder) = path.parent() else {
        return (None, "judged without a model".into());
    };
    let models = workspace.siblings(folder, Kind::Model);
    if let Some(model) = models.iter().find(|it| it.file_stem() == stem) {
        return (Some(model.clone()), said(model, "it has this file's name"));
    }
    match models.as_slice() {
        [] => (None, "judged without a model: this folder has none".into()),
        [model] => {
            let words = said(model, "the only model in this folder");
            (Some(model.clone()), words)
        }
        several => {
            let words = format!(
                "judged without a model: this folder has {}, and none has this file's name",
                several.len()
            );
            (None, words)
        }
    }
}
