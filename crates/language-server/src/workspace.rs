//! The texts at hand: what the editor has open, saved or not, before what the folders hold.

use crate::kind::{self, Kind};
use crate::model::ModelView;
use crate::properties::PropertiesView;
use crate::study_view::StudyView;
use crate::text::Text;
use diagnostic::{Problem, Source};
use ls_types::Uri;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::str::FromStr;
use study::{Study, Texts};

/// What is wrong with a study's questions to its models.
#[derive(Clone, Debug, Default)]
pub struct Mistakes {
    /// What has to be corrected.
    pub problems: Vec<Problem>,
    /// What has a meaning that is perhaps not meant.
    pub warnings: Vec<Problem>,
}

/// What is known above this crate, and brought by whoever runs the server.
pub trait Engine {
    /// What is wrong with a study's questions to its models; if these are all of its models, what none of them expresses, too.
    fn mistakes(&self, study: &Study, models: Vec<Source>, are_all: bool) -> Mistakes;

    /// The JSON Schemas of a study's files, by the names of their kinds.
    fn schemas(&self) -> Vec<(&'static str, serde_json::Value)>;

    /// What a diagnostic's code means.
    fn explanation(&self, code: &str) -> Option<String>;
}

/// An engine that knows nothing: models and properties are judged as they are alone.
#[derive(Clone, Copy, Debug, Default)]
pub struct Alone;

impl Engine for Alone {
    fn mistakes(&self, _: &Study, _: Vec<Source>, _: bool) -> Mistakes {
        Mistakes::default()
    }

    fn schemas(&self) -> Vec<(&'static str, serde_json::Value)> {
        Vec::new()
    }

    fn explanation(&self, _: &str) -> Option<String> {
        None
    }
}

/// A text that the editor has open.
#[derive(Clone, Debug)]
pub struct Document {
    /// What the editor calls it.
    pub uri: Uri,
    /// Its version, as the editor counts.
    pub version: i32,
    /// The name of its language in the editor.
    pub language: String,
    /// The text.
    pub text: Rc<Text>,
}

/// All texts, with what was made of them.
pub struct Workspace {
    open: BTreeMap<PathBuf, Document>,
    pub(crate) engine: Box<dyn Engine>,
    pub(crate) schemas: BTreeMap<&'static str, serde_json::Value>,
    models: RefCell<BTreeMap<PathBuf, Rc<ModelView>>>,
    properties: RefCell<BTreeMap<PathBuf, Rc<PropertiesView>>>,
    studies: RefCell<BTreeMap<PathBuf, Rc<StudyView>>>,
}

/// How many files of a folder are looked at for models and properties that belong together.
const MOST_SIBLINGS: usize = 2_000;

impl Workspace {
    /// No text is open.
    #[must_use]
    pub fn new(engine: Box<dyn Engine>) -> Self {
        Self {
            open: BTreeMap::new(),
            schemas: engine.schemas().into_iter().collect(),
            engine,
            models: RefCell::default(),
            properties: RefCell::default(),
            studies: RefCell::default(),
        }
    }

    /// The path of what an editor names. What is no file has its name as a path, at which nothing is.
    #[must_use]
    pub fn path(uri: &Uri) -> PathBuf {
        let is_file = uri.as_str().starts_with("file:");
        let path = uri.to_file_path().filter(|_| is_file);
        path.map_or_else(|| PathBuf::from(uri.as_str()), |path| path.into_owned())
    }

    /// What the editor calls a file.
    #[must_use]
    pub fn uri(&self, path: &Path) -> Option<Uri> {
        match self.open.get(path) {
            Some(document) => Some(document.uri.clone()),
            None if path.is_absolute() => Uri::from_file_path(path),
            None => Uri::from_str(path.to_str()?).ok(),
        }
    }

    /// The document of this path, if it is open.
    #[must_use]
    pub fn document(&self, path: &Path) -> Option<&Document> {
        self.open.get(path)
    }

    /// All open documents.
    pub fn documents(&self) -> impl Iterator<Item = (&PathBuf, &Document)> {
        self.open.iter()
    }

    /// Takes over an open document, or another version of it.
    pub fn set(&mut self, path: PathBuf, document: Document) {
        self.open.insert(path, document);
        self.forget_studies();
    }

    /// Opens a text at an absolute path, or changes it there; by its name it is a model, properties or a study's file.
    pub fn open(&mut self, path: &Path, text: impl Into<String>) {
        let version = self.open.get(path).map_or(1, |it| it.version + 1);
        let Some(uri) = self.uri(path) else { return };
        let document = Document {
            uri,
            version,
            language: String::new(),
            text: Rc::new(Text::new(text.into())),
        };
        self.set(path.to_owned(), document);
    }

    /// Forgets a document: from now on, what is saved counts.
    pub fn close(&mut self, path: &Path) {
        self.open.remove(path);
        self.forget_studies();
    }

    /// What was made of several files is made anew when it is next asked for.
    pub fn forget_studies(&self) {
        self.studies.borrow_mut().clear();
        self.properties.borrow_mut().clear();
    }

    /// Of what kind a file is.
    #[must_use]
    pub fn kind(&self, path: &Path) -> Kind {
        let language = self.open.get(path).map(|it| it.language.as_str());
        Kind::of(path, language)
    }

    /// The text of a file, open or saved.
    #[must_use]
    pub fn read(&self, path: &Path) -> Option<Rc<Text>> {
        if let Some(document) = self.open.get(path) {
            return Some(document.text.clone());
        }
        let source = match self.kind(path) {
            Kind::Model | Kind::Properties => host::files::read_prism(path).ok()?.0,
            Kind::Toml | Kind::Other => host::files::read_source(path).ok()?,
        };
        Some(Rc::new(Text::new(source.text)))
    }

    /// A model, read.
    #[must_use]
    pub fn model(&self, path: &Path) -> Option<Rc<ModelView>> {
        let text = self.read(path)?;
        let known = self.models.borrow().get(path).cloned();
        if let Some(known) = known.filter(|it| it.text == text) {
            return Some(known);
        }
        let view = Rc::new(ModelView::new(path.to_owned(), text));
        let mut models = self.models.borrow_mut();
        models.insert(path.to_owned(), view.clone());
        Some(view)
    }

    /// A properties file, read with the model that it belongs to.
    #[must_use]
    pub fn properties(&self, path: &Path) -> Option<Rc<PropertiesView>> {
        if let Some(known) = self.properties.borrow().get(path) {
            return Some(known.clone());
        }
        let view = Rc::new(PropertiesView::new(self, path)?);
        let mut properties = self.properties.borrow_mut();
        properties.insert(path.to_owned(), view.clone());
        Some(view)
    }

    /// The folder of the study that a file belongs to: the nearest one above it that has a `study.toml`.
    #[must_use]
    pub fn study_folder(&self, path: &Path) -> Option<PathBuf> {
        let folders = path.ancestors().skip(1);
        let mut folders = folders.filter(|it| !it.as_os_str().is_empty());
        let is_study = |folder: &&Path| Texts::exists(self, &folder.join("study.toml"));
        folders.find(is_study).map(Path::to_owned)
    }

    /// The study that a file belongs to.
    #[must_use]
    pub fn study_of(&self, path: &Path) -> Option<Rc<StudyView>> {
        self.study(&self.study_folder(path)?)
    }

    /// The study in a folder.
    #[must_use]
    pub fn study(&self, folder: &Path) -> Option<Rc<StudyView>> {
        if let Some(known) = self.studies.borrow().get(folder) {
            return Some(known.clone());
        }
        let view = Rc::new(StudyView::new(self, folder));
        let mut studies = self.studies.borrow_mut();
        studies.insert(folder.to_owned(), view.clone());
        Some(view)
    }

    /// The files of a folder that are of a kind, saved or open, in the order of their names.
    #[must_use]
    pub fn siblings(&self, folder: &Path, kind: Kind) -> Vec<PathBuf> {
        let saved = std::fs::read_dir(folder).into_iter().flatten().flatten();
        let saved = saved.take(MOST_SIBLINGS).map(|entry| entry.path());
        let open = self.open.keys().filter(|it| it.parent() == Some(folder));
        let mut found: Vec<PathBuf> = saved
            .chain(open.cloned())
            .filter(|path| self.kind(path) == kind)
            .collect();
        found.sort();
        found.dedup();
        found
    }

    /// Whether a change of this file may change what is said of others.
    #[must_use]
    pub fn concerns_a_study(&self, path: &Path) -> bool {
        let name = path.file_name().and_then(|it| it.to_str()).unwrap_or("");
        kind::OF_STUDY.contains(&name) || self.kind(path) == Kind::Model
    }
}

impl Texts for Workspace {
    fn exists(&self, path: &Path) -> bool {
        self.open.contains_key(path) || path.exists()
    }

    fn text(&self, path: &Path) -> Result<Source, Problem> {
        match self.open.get(path) {
            Some(document) => Ok(Source {
                name: path.display().to_string(),
                text: document.text.as_str().to_owned(),
            }),
            None => host::files::read_source(path),
        }
    }
}
