//! Definitions of types for recordings that do not have them: those of releases before Iron.
//!
//! Known are the types of the common interface packages whose fields are the same in all releases
//! from Dashing to Humble (`types.txt`, one line for each type). Where a type differs between these
//! releases it is absent, because a guess would decode other numbers than were recorded. All others
//! are had from folders with `.msg` files that the user names; these go before the known ones.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use crate::schema::{Dialect, Schema, parse_msg};

const KNOWN: &str = include_str!("types.txt");

/// Where a workspace keeps them, a `.msg` file is not deeper than this.
const MAX_FOLDER_DEPTH: usize = 8;

/// Definitions by name (`package/Type`).
#[derive(Debug, Default)]
pub(crate) struct Definitions {
    texts: BTreeMap<String, String>,
}

impl Definitions {
    /// The known types, and those in the `.msg` files below `folders`.
    ///
    /// # Errors
    /// The folder or file that cannot be read, and why.
    pub(crate) fn with_folders(folders: &[PathBuf]) -> Result<Self, (PathBuf, std::io::Error)> {
        let known = KNOWN.lines().filter_map(|line| line.split_once(':'));
        let texts = known.map(|(name, fields)| (name.to_owned(), fields.replace(';', "\n")));
        let mut definitions = Definitions {
            texts: texts.collect(),
        };
        for folder in folders {
            definitions.add_folder(folder, 0)?;
        }
        Ok(definitions)
    }

    fn add_folder(&mut self, folder: &Path, depth: usize) -> Result<(), (PathBuf, std::io::Error)> {
        let at = |path: &Path| {
            let path = path.to_owned();
            move |error| (path, error)
        };
        let mut paths = Vec::new();
        for entry in fs::read_dir(folder).map_err(at(folder))? {
            paths.push(entry.map_err(at(folder))?.path());
        }
        paths.sort();
        for path in paths {
            if path.is_dir() {
                if depth < MAX_FOLDER_DEPTH {
                    self.add_folder(&path, depth + 1)?;
                }
            } else if let Some(name) = type_of_file(&path) {
                let text = fs::read_to_string(&path).map_err(at(&path))?;
                self.texts.insert(name, text);
            }
        }
        Ok(())
    }

    /// The schema of the type `name` (`package/msg/Type`).
    pub(crate) fn schema(&self, name: &str) -> Schema {
        match self
            .joined(name)
            .map(|text| parse_msg(name, &text, Dialect::Ros2))
        {
            Ok(Ok(message_type)) => Schema::Struct(message_type),
            Ok(Err(error)) => Schema::Unknown {
                reason: error.to_string(),
            },
            Err(missing) => Schema::Unknown {
                reason: format!(
                    "the recording does not define the type {missing}, and it is not known here; \
                     name the folder with its .msg file as a message path"
                ),
            },
        }
    }

    /// The definition of a type and of all that it consists of, as recordings join them.
    /// The error is the name of a type that is not known.
    pub(crate) fn joined(&self, name: &str) -> Result<String, String> {
        let name = name.replacen("/msg/", "/", 1);
        let mut joined = self.texts.get(&name).ok_or_else(|| name.clone())?.clone();
        let (mut pending, mut done) = (parts(&joined, &name), vec![name]);
        while let Some(part) = pending.pop() {
            if done.contains(&part) {
                continue;
            }
            let text = self.texts.get(&part).ok_or_else(|| part.clone())?;
            joined.push_str(&format!("\n{}\nMSG: {part}\n{text}", "=".repeat(80)));
            pending.extend(parts(text, &part));
            done.push(part);
        }
        Ok(joined)
    }
}

/// `package/Type` for the file `package/msg/Type.msg`.
fn type_of_file(path: &Path) -> Option<String> {
    if path.extension()? != "msg" {
        return None;
    }
    let folder = path.parent()?;
    let package = if folder.file_name()? == "msg" {
        folder.parent()?
    } else {
        folder
    };
    let package = package.file_name()?.to_str()?;
    Some(format!("{package}/{}", path.file_stem()?.to_str()?))
}

/// The types of the fields in `text`, the definition of `owner`, that are no primitive ones.
fn parts(text: &str, owner: &str) -> Vec<String> {
    let package = owner.split('/').next().unwrap_or_default();
    let words = text.lines().filter_map(|line| {
        let word = line.split('#').next()?.split_whitespace().next()?;
        word.split(['[', '<']).next()
    });
    let names = words.filter(|word| {
        word.contains('/') || word.starts_with(|first: char| first.is_ascii_uppercase())
    });
    names
        .map(|word| match word {
            "Header" => "std_msgs/Header".to_owned(),
            word if word.contains('/') => word.replacen("/msg/", "/", 1),
            word => format!("{package}/{word}"),
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_known_type_can_be_used() {
        let definitions = Definitions::with_folders(&[]).unwrap();
        assert_eq!(definitions.texts.len(), KNOWN.lines().count());
        for name in definitions.texts.keys() {
            let schema = definitions.schema(&name.replacen('/', "/msg/", 1));
            assert!(matches!(schema, Schema::Struct(_)), "{name}: {schema:?}");
        }
    }

    #[test]
    fn definitions_of_the_user_go_first_and_what_lacks_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let own = folder.path().join("src/own_msgs/msg");
        fs::create_dir_all(&own).unwrap();
        fs::write(
            own.join("Part.msg"),
            "int32 LIMIT=3\nfloat64 x # metres\nfloat64[<=3] y\n",
        )
        .unwrap();
        fs::write(own.join("Whole.msg"), "Part[] parts\nHeader header\n").unwrap();
        fs::write(own.join("Broken.msg"), "other_msgs/Thing thing\n").unwrap();
        let definitions = Definitions::with_folders(&[folder.path().to_owned()]).unwrap();
        let Schema::Struct(whole) = definitions.schema("own_msgs/msg/Whole") else {
            panic!("its parts are there")
        };
        assert_eq!(whole.fields.len(), 2);
        let Schema::Unknown { reason } = definitions.schema("own_msgs/msg/Broken") else {
            panic!("a part lacks")
        };
        assert!(
            reason.contains("other_msgs/Thing") && reason.contains("message path"),
            "{reason}"
        );
        let error = Definitions::with_folders(&[folder.path().join("absent")]).unwrap_err();
        assert!(error.0.ends_with("absent"));
    }
}
