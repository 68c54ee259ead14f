//! Studies in folders of their own, and hosts that write down what happened.

use corroborate::host::{Event, Events, Host};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use tempfile::TempDir;

/// A study in a folder of its own.
pub struct Copy {
    folder: TempDir,
}

impl Copy {
    /// The study of the template, under a title of its own for its model.
    pub fn of_template(model: &str) -> Self {
        let folder = TempDir::new().expect("a temporary folder");
        let copy = Self { folder };
        corroborate::new_study(&copy.path("")).expect("the folder is empty");
        copy.edit("ledger.toml", "Formal model", model);
        copy
    }

    /// A study of the repository, without what was made of it.
    pub fn of(study: &str) -> Self {
        let from = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("../..")
            .join(study);
        let folder = TempDir::new().expect("a temporary folder");
        copy(&from, folder.path());
        Self { folder }
    }

    /// A cart whose simulator is a command in Python, with so many episodes.
    pub fn of_cart(episodes: u64) -> Self {
        let copy = Self::of("conformance/command");
        copy.edit(
            "ledger.toml",
            "episodes = 40",
            &format!("episodes = {episodes}"),
        );
        copy
    }

    /// A file of the study; the folder itself without a name.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Replaces a text in a file of the study.
    pub fn edit(&self, name: &str, old: &str, new: &str) {
        let text = std::fs::read_to_string(self.path(name)).expect("a text");
        assert!(text.contains(old), "{name} has no `{old}`");
        std::fs::write(self.path(name), text.replacen(old, new, 1)).expect("it is written");
    }

    /// The files of its results, without what tells times and hashes of them.
    pub fn results(&self) -> BTreeMap<PathBuf, Vec<u8>> {
        let results = self.path("results");
        let mut found = BTreeMap::new();
        let mut folders = vec![results.clone()];
        while let Some(folder) = folders.pop() {
            for entry in std::fs::read_dir(folder).expect("a folder").flatten() {
                let path = entry.path();
                match path.is_dir() {
                    true => folders.push(path),
                    false => {
                        let name = path.strip_prefix(&results).expect("it is below");
                        found.insert(name.to_owned(), without_times(&path));
                    }
                }
            }
        }
        found
    }
}

fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).expect("it is made");
    for entry in std::fs::read_dir(from).expect("a folder").flatten() {
        let (from, to) = (entry.path(), to.join(entry.file_name()));
        match from.is_dir() {
            true if entry.file_name() == "results" => {}
            true => copy(&from, &to),
            false => drop(std::fs::copy(from, to).expect("it is copied")),
        }
    }
}

/// The bytes of a file; of JSON without costs, and without the hashes over them.
fn without_times(path: &Path) -> Vec<u8> {
    let bytes = std::fs::read(path).expect("a file");
    if path.extension().is_none_or(|extension| extension != "json") {
        return bytes;
    }
    let mut value: Value = serde_json::from_slice(&bytes).expect("JSON");
    let is_comparison = path.ends_with("comparison.json");
    let whole = value.as_object_mut().expect("an object");
    whole.remove("costs");
    if whole.remove("digest").is_some() {
        let content = whole["content"].as_object_mut().expect("an object");
        content.remove("cost");
        content.remove("costs");
    }
    if is_comparison {
        whole.remove("inputs");
    }
    serde_json::to_vec(&value).expect("JSON")
}

/// A host that writes down all events, and stops at the first one that `stops`.
pub fn host(stops: fn(&Event) -> bool) -> (Host, Arc<Mutex<Vec<Event>>>) {
    let events: Arc<Mutex<Vec<Event>>> = Arc::default();
    let told = events.clone();
    let mut host = Host::silent(corroborate::build());
    // The studies of these tests are the project's own.
    host.trust.is_given = true;
    let cancel = host.cancel.clone();
    host.events = Events::new(move |event| {
        if stops(&event) {
            cancel.cancel();
        }
        told.lock().expect("the events").push(event);
    });
    (host, events)
}

/// The lines that were told.
pub fn notes(events: &Mutex<Vec<Event>>) -> Vec<String> {
    let events = events.lock().expect("the events");
    let notes = events.iter().filter_map(|event| match event {
        Event::Note { text } => Some(text.clone()),
        _ => None,
    });
    notes.collect()
}
