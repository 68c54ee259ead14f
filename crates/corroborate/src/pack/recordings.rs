//! Recordings on which the evidence rests: named by path, size and SHA-256, and put into the pack only if that was asked for.

use super::parts::{Gathering, below, files_of};
use ::pack::{Content, Part, Recording, Role};
use diagnostic::{Cancel, Problem};
use host::Host;
use std::collections::BTreeMap;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use study::Study;

/// Ends of names that recordings have, whatever folder they lie in.
const FORMATS: [&str; 6] = ["mcap", "bag", "db3", "ulg", "jsonl", "ndjson"];

/// Whether a file has the name of a recording.
pub(super) fn has_format(name: &str) -> bool {
    let end = name.rsplit_once('.').map(|(_, end)| end.to_lowercase());
    end.is_some_and(|end| FORMATS.contains(&end.as_str()))
}

/// Whether a file of the study is a recording: by its name, or since it lies where an entry's recordings do.
pub(super) fn is_recording(study: &Study, path: &str) -> bool {
    let mut folders = study
        .ledger
        .iter()
        .filter_map(|entry| entry.work.recordings());
    has_format(path) || folders.any(|folder| Path::new(path).starts_with(folder))
}

/// Recordings, and those of them that are parts.
pub(super) struct Recorded {
    pub list: Vec<Recording>,
    pub parts: Vec<Part>,
}

/// All recordings of the evidence and of the results.
pub(super) fn of(from: &Gathering<'_>) -> Result<Recorded, Problem> {
    let mut recorded = Recorded {
        list: Vec::new(),
        parts: Vec::new(),
    };
    for (path, full) in paths(from)? {
        from.host.go_on()?;
        let content = content(&full, from.host)?;
        let mut recording = Recording {
            path: path.clone(),
            bytes: content.size,
            sha256: content.sha256.clone(),
            part: None,
        };
        if from.request.with_recordings {
            let name = format!("study/{path}");
            let part = Part::new(&name, Role::Recording, "a recording", content);
            recording.part = Some(part.name.clone());
            recorded.parts.push(part);
        }
        recorded.list.push(recording);
    }
    Ok(recorded)
}

/// Their paths relative to the study, each with the file that it names.
fn paths(from: &Gathering<'_>) -> Result<BTreeMap<String, PathBuf>, Problem> {
    let assets = from.result.evidence.iter().flat_map(|it| &it.assets);
    let named = assets.filter(|it| is_recording(from.study, &it.path));
    let mut paths: BTreeMap<String, PathBuf> = named
        .map(|it| (it.path.clone(), from.study.folder.join(&it.path)))
        .collect();
    for path in files_of(from)? {
        let name = below(from.results, &path);
        if has_format(&name) {
            paths.insert(format!("results/{name}"), path);
        }
    }
    Ok(paths)
}

/// The content of a file, which is not held in memory.
pub(super) fn content(path: &Path, host: &Host) -> Result<Content, Problem> {
    let (path, cancel) = (path.to_owned(), host.cancel.clone());
    Content::streamed(Box::new(move || {
        let cannot = |error: std::io::Error| Problem::cannot_read(&path, &error);
        let known = std::fs::metadata(&path).map_err(cannot)?;
        if !known.is_file() {
            return Err(cannot(std::io::ErrorKind::InvalidInput.into()));
        }
        let file = host::files::open_file(&path)?;
        Ok(Box::new(UntilCancelled {
            file,
            path: path.clone(),
            cancel: cancel.clone(),
        }))
    }))
}

/// A file that is read until somebody asks to stop.
struct UntilCancelled {
    file: std::fs::File,
    path: PathBuf,
    cancel: Arc<Cancel>,
}

impl Read for UntilCancelled {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        match self.cancel.is_cancelled() {
            true => Err(std::io::Error::other("interrupted")),
            false => self.file.read(buffer).map_err(|error| {
                std::io::Error::new(error.kind(), format!("{}: {error}", self.path.display()))
            }),
        }
    }
}
