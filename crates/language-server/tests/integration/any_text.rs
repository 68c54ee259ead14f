//! Any text and any place: answers, never a panic.

use crate::support::{files_below, root};
use language_server::diagnostics::{self, Telling};
use language_server::{Alone, Text, Workspace, completion, cursor, format, hover, rename, symbols};
use ls_types::{Position, Range, TextDocumentContentChangeEvent};
use proptest::prelude::*;
use std::path::{Path, PathBuf};

/// Asks everything of a place of a document.
fn ask(workspace: &Workspace, path: &Path, offset: usize) {
    let _ = hover::at(workspace, path, offset);
    for it in cursor::at(workspace, path, offset) {
        let _ = cursor::places(workspace, &it.thing, path);
    }
    let _ = completion::at(workspace, path, offset);
    let _ = rename::rename(workspace, path, offset, "fresh_0");
}

fn ask_of_all(workspace: &Workspace, path: &Path) {
    let _ = diagnostics::of_file(workspace, path, &Telling::default());
    let _ = symbols::of_file(workspace, path);
    let _ = format::edits(workspace, path);
}

/// A study's folder with texts in it that are not saved.
fn paths() -> [PathBuf; 7] {
    let folder = Path::new("/nowhere/study");
    [
        "m.prism",
        "m.props",
        "study.toml",
        "vocabulary.toml",
        "requirements.toml",
        "ledger.toml",
        "exploration.toml",
    ]
    .map(|it| folder.join(it))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn any_characters_at_any_place(
        text in "[ -~\n\ré𝄞\"'\\\\]{0,120}",
        which in 0..7_usize,
        line in 0..6_u32,
        character in 0..40_u32,
    ) {
        let mut workspace = Workspace::new(Box::new(Alone));
        let path = &paths()[which];
        workspace.open(path, &text);
        let lines = Text::new(text);
        ask(&workspace, path, lines.offset(Position::new(line, character)));
        ask_of_all(&workspace, path);
    }

    #[test]
    fn changes_at_any_place_give_what_an_editor_has(
        text in "[ab\n\ré𝄞]{0,40}",
        new in "[cd\n\ré𝄞]{0,10}",
        from in (0..6_u32, 0..12_u32),
        to in (0..6_u32, 0..12_u32),
    ) {
        let mut changed = Text::new(text.clone());
        let position = |(line, character)| Position::new(line, character);
        let range = Range::new(position(from), position(to));
        let lines = Text::new(text.clone());
        let (a, b) = (lines.offset(range.start), lines.offset(range.end));
        changed.change(TextDocumentContentChangeEvent { range: Some(range), range_length: None, text: new.clone() });
        let expected = format!("{}{new}{}", &text[..a.min(b)], &text[a.max(b)..]);
        prop_assert_eq!(changed.as_str(), expected.as_str());
        prop_assert_eq!(changed, Text::new(expected));
    }
}

/// Texts of the project, cut and joined at places that are always the same.
#[test]
fn texts_of_the_project_cut_anywhere() {
    let mut dice = 0x9E37_79B9_u64;
    let mut below = |limit: usize| {
        dice ^= dice << 13;
        dice ^= dice >> 7;
        dice ^= dice << 17;
        (dice % limit.max(1) as u64) as usize
    };
    let study = root().join("case-studies/corridor");
    let files = files_below(&study).into_iter().filter(|it| {
        let ending = it.extension().and_then(|it| it.to_str());
        matches!(ending, Some("toml" | "prism" | "props"))
    });
    for file in files {
        let Ok(text) = std::fs::read_to_string(&file) else {
            continue;
        };
        let mut workspace = Workspace::new(Box::new(Alone));
        for _ in 0..3 {
            let boundary = |mut at: usize| {
                while !text.is_char_boundary(at) {
                    at -= 1;
                }
                at
            };
            let (a, b) = (boundary(below(text.len())), boundary(below(text.len())));
            let cut = format!("{}{}", &text[..a.min(b)], &text[a.max(b)..]);
            workspace.open(&file, &cut);
            let mut at = below(cut.len());
            while !cut.is_char_boundary(at) {
                at -= 1;
            }
            ask(&workspace, &file, at);
            ask_of_all(&workspace, &file);
        }
    }
}

#[test]
fn offsets_within_characters_and_beyond_the_end_are_no_panic() {
    let mut workspace = Workspace::new(Box::new(Alone));
    for path in &paths() {
        workspace.open(path, "é𝄞");
        for offset in 0..12 {
            ask(&workspace, path, offset);
        }
        ask_of_all(&workspace, path);
    }
}
