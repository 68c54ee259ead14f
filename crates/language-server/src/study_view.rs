//! A study as far as its files could be read.

use crate::kind::{self, Kind};
use crate::mentions::{self, Known, Mention};
use crate::toml_tree;
use crate::workspace::Workspace;
use diagnostic::{Problem, Problems, Source};
use std::path::{Path, PathBuf};
use study::{Study, Texts, Work};

/// A study, read.
#[derive(Debug)]
pub struct StudyView {
    /// Its folder.
    pub folder: PathBuf,
    /// What could be read; `None` if there is no study.
    pub study: Option<Study>,
    /// All mistakes, as the command line tells them.
    pub problems: Vec<Problem>,
    /// What has a meaning that is perhaps not meant.
    pub warnings: Vec<Problem>,
    /// Its names.
    pub known: Known,
}

impl StudyView {
    /// Reads the study in a folder.
    #[must_use]
    pub fn new(workspace: &Workspace, folder: &Path) -> Self {
        let mut found = Problems::new();
        let study = Study::read_texts(folder, workspace, &mut found);
        let study = found.keep(study);
        let is_whole = found.is_empty();
        let mut view = Self {
            folder: folder.to_owned(),
            warnings: Vec::new(),
            problems: Vec::new(),
            known: Known::default(),
            study,
        };
        view.known = view.names(workspace);
        if let Some(study) = &view.study {
            if is_whole {
                view.warnings = study.forms.warnings(&[]);
            }
            let warnings = view.look_into_models(workspace, study, is_whole, &mut found);
            view.warnings.extend(warnings);
        }
        view.problems = found.into_problem().map_or(Vec::new(), Problem::into_each);
        view
    }

    /// What the models say wrong of the study; gives what is perhaps not meant. What is said of the study's own files may follow from mistakes that were found
    /// there, and is left out then; what is wrong with a model by itself is told where the model is.
    fn look_into_models(
        &self,
        workspace: &Workspace,
        study: &Study,
        is_whole: bool,
        found: &mut Problems,
    ) -> Vec<Problem> {
        let paths = self.models();
        let mut sources = Vec::new();
        for path in &paths {
            let Some(model) = workspace.model(path) else {
                continue;
            };
            if !model.is_read || !model.stand_ins().is_empty() || model.resolved().is_none() {
                continue;
            }
            let name = path.display().to_string();
            sources.push(Source::new(name, model.text.as_str()));
        }
        // What a technique from outside expresses is known to itself alone.
        let are_all = sources.len() == paths.len()
            && !(study.ledger.iter()).any(|entry| matches!(entry.work, Work::Other { .. }));
        let names: Vec<String> = sources.iter().map(|it| it.name.clone()).collect();
        let is_of_model =
            |it: &Problem| it.place().is_some_and(|place| names.contains(&place.name));
        let mistakes = workspace.engine.mistakes(study, sources, are_all);
        if !is_whole {
            return Vec::new();
        }
        for problem in mistakes.problems.into_iter().flat_map(Problem::into_each) {
            if !is_of_model(&problem) {
                found.add(problem);
            }
        }
        mistakes.warnings
    }

    /// The models of the ledger, each once, in its order.
    #[must_use]
    pub fn models(&self) -> Vec<PathBuf> {
        let entries = self.study.iter().flat_map(|study| &study.ledger);
        let mut models = Vec::new();
        for entry in entries {
            if let Some(model) = entry.work.parts().model {
                let path = self.folder.join(model);
                if !models.contains(&path) {
                    models.push(path);
                }
            }
        }
        models
    }

    /// The study's own files.
    pub fn own_files(&self) -> impl Iterator<Item = PathBuf> {
        kind::OF_STUDY.iter().map(|name| self.folder.join(name))
    }

    /// The files whose names are known: the study's own, explorations and variants.
    #[must_use]
    pub fn files(&self, workspace: &Workspace) -> Vec<PathBuf> {
        let variants = self.folder.join("variants");
        let beside = workspace.siblings(&self.folder, Kind::Toml);
        let mut files: Vec<PathBuf> = self.own_files().collect();
        let others = beside
            .into_iter()
            .chain(workspace.siblings(&variants, Kind::Toml));
        files.extend(others.filter(|path| {
            let kind = kind::schema_name(path);
            kind.is_some_and(|it| matches!(it, "exploration.toml" | "variant.toml"))
        }));
        files
    }

    /// Whether the names of a file are known.
    #[must_use]
    pub fn knows(&self, path: &Path) -> bool {
        let folder = path.parent();
        folder == Some(&self.folder) || folder == Some(&self.folder.join("variants"))
    }

    /// All that its own files name.
    #[must_use]
    pub fn mentions(&self, workspace: &Workspace) -> Vec<Mention> {
        let mut all = Vec::new();
        for path in self.files(workspace) {
            if let Some(text) = workspace.read(&path) {
                all.extend(mentions::of_file(self, &path, text.as_str()));
            }
        }
        all
    }

    /// The names that its files declare, read from the texts, so that they are known where something else is wrong.
    fn names(&self, workspace: &Workspace) -> Known {
        let keys = |file: &str| {
            let path = self.folder.join(file);
            let text = workspace
                .exists(&path)
                .then(|| workspace.read(&path))
                .flatten();
            text.map_or(Vec::new(), |text| toml_tree::nodes(text.as_str()))
        };
        let of_top = |file: &str| {
            let nodes = keys(file).into_iter().filter(|it| it.path.len() == 1);
            nodes.map(|it| it.path[0].clone()).collect()
        };
        let ledger = keys("ledger.toml").into_iter();
        let ids = ledger.filter(|it| it.is(&["evidence", "*", "id"]));
        Known {
            propositions: of_top("vocabulary.toml"),
            parameters: of_top("parameters.toml"),
            evidence: ids.filter_map(|it| it.text).collect(),
        }
    }
}
