//! Which programs a study names: every list `command` in a text of its that is TOML, whatever the file is called.

use super::Content;
use diagnostic::Problem;
use std::ops::Range;
use std::path::{Path, PathBuf};
use toml::de::{DeTable, DeValue};

/// Texts that name programs are shorter.
const MOST_BYTES: u64 = 4 << 20;
/// The key that names a program.
const KEY: &str = "command";

/// A program that a study names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NamedProgram {
    /// Its words.
    pub words: Vec<String>,
    /// Files that are said to belong to it.
    pub files: Vec<String>,
    /// Whose it is: an entry of the ledger, a controller.
    pub of: String,
    /// The file that names it, by its path in the study.
    pub file: String,
    /// The line there.
    pub line: usize,
    /// Where its words stand there.
    pub(super) place: Range<usize>,
    /// The folder in which its relative paths begin: the study's for the ledger, else that of the file.
    pub(super) folder: PathBuf,
}

/// The programs that the files of a content name, in the order of files and lines.
///
/// # Errors
/// `cannot-read`.
pub fn programs(folder: &Path, content: &Content) -> Result<Vec<NamedProgram>, Problem> {
    let mut found = Vec::new();
    for name in content.files.keys() {
        let path = folder.join(name);
        let is_short =
            std::fs::metadata(&path).is_ok_and(|it| it.is_file() && it.len() <= MOST_BYTES);
        if !is_short {
            continue;
        }
        let bytes = host::files::read_file(&path, MOST_BYTES)?;
        let Ok(text) = String::from_utf8(bytes) else {
            continue;
        };
        found.extend(in_text(&text).into_iter().map(|mut program| {
            program.file.clone_from(name);
            program.folder = path.parent().unwrap_or(folder).to_owned();
            program
        }));
    }
    Ok(found)
}

/// Those of a text.
pub(super) fn in_text(text: &str) -> Vec<NamedProgram> {
    if !text.contains(KEY) {
        return Vec::new();
    }
    let Ok(table) = DeTable::parse(text) else {
        return Vec::new();
    };
    let mut found = Vec::new();
    collect(table.get_ref(), text, &mut found);
    found.sort_by_key(|program| program.line);
    found
}

fn collect(table: &DeTable<'_>, text: &str, found: &mut Vec<NamedProgram>) {
    if let Some((words, span)) = table
        .get(KEY)
        .and_then(|it| Some((texts(it.get_ref())?, it.span())))
    {
        found.push(named(table, words, text, &span));
    }
    for value in table.values() {
        below(value.get_ref(), text, found);
    }
}

fn below(value: &DeValue<'_>, text: &str, found: &mut Vec<NamedProgram>) {
    match value {
        DeValue::Table(inner) => collect(inner, text, found),
        DeValue::Array(all) => all.iter().for_each(|it| below(it.get_ref(), text, found)),
        _ => {}
    }
}

fn named(table: &DeTable<'_>, words: Vec<String>, text: &str, span: &Range<usize>) -> NamedProgram {
    let list = |key: &str| table.get(key).and_then(|it| texts(it.get_ref()));
    let word = |key: &str| match table.get(key).map(|it| it.get_ref()) {
        Some(DeValue::String(word)) => Some(word.to_string()),
        _ => None,
    };
    let files = ["files", "assets"]
        .iter()
        .filter_map(|key| list(key))
        .flatten();
    let (line, _) = diagnostic::line_and_column(text, span.start);
    NamedProgram {
        words,
        files: files.collect(),
        of: word("id").or_else(|| word("name")).unwrap_or_default(),
        file: String::new(),
        line,
        place: span.clone(),
        folder: PathBuf::new(),
    }
}

/// The texts of a list that has at least one and nothing else.
fn texts(value: &DeValue<'_>) -> Option<Vec<String>> {
    let DeValue::Array(all) = value else {
        return None;
    };
    let text = |value: &DeValue<'_>| match value {
        DeValue::String(text) => Some(text.to_string()),
        _ => None,
    };
    let found: Option<Vec<String>> = all.iter().map(|it| text(it.get_ref())).collect();
    found.filter(|words| !words.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_list_of_words_is_found_with_its_line_and_whose_it_is() {
        let text = "[[evidence]]\nid = \"E1\"\ncommand = [\"sh\", \"a.sh\"]\nassets = [\"b.sh\"]\n\n[[controller]]\nname = \"pilot\"\nros2 = { }\ncommand = []\n[deep]\nof = [{ x = { name = \"n\", command = [\"c\"] } }]\n";
        let found = in_text(text);
        let told: Vec<(&str, usize, usize)> = found
            .iter()
            .map(|it| (it.of.as_str(), it.line, it.words.len()))
            .collect();
        assert_eq!(told, [("E1", 3, 2), ("n", 11, 1)]);
        assert_eq!(found[0].files, ["b.sh"]);
        assert!(in_text("print('command')").is_empty());
    }
}
