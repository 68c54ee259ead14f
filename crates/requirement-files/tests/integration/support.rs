//! Documents from texts.

use diagnostic::Problem;
use requirement_files::{Change, Columns, Document, Field, File, Format, Item};

/// A file of this name and text.
pub fn file(name: &str, text: &str) -> File {
    File {
        name: name.into(),
        bytes: text.into(),
    }
}

/// Reads one text.
pub fn read(format: Format, text: &str) -> Result<Document, Problem> {
    Document::read(format, &[file("x", text)], &Columns::default())
}

/// The text after changes of a document of one file.
pub fn changed(document: &Document, changes: &[Change]) -> String {
    let files = document.with(changes).expect("written");
    assert_eq!(files.len(), 1);
    String::from_utf8(files[0].bytes.clone()).expect("UTF-8")
}

/// Each item of a document with another text, one after the other: nothing else of the item changes, and no other item.
pub fn every_text_can_be_changed(document: &Document) {
    for at in 0..document.items.len() {
        let mut item = document.items[at].item.clone();
        item.text = "Changed & \"kept\" <here>;\nin two lines.".into();
        let files = document
            .with(&[Change::Set(item.clone(), vec![Field::Text])])
            .expect("written");
        assert!(!files.is_empty());
        let again = Document::read(document.format, &files, document.columns());
        // Of a folder only the changed file is given.
        if let Ok(again) = again {
            for (other, before) in document.items.iter().enumerate() {
                let wanted = if other == at { &item } else { &before.item };
                assert_eq!(again.item(&wanted.id).map(|it| &it.item), Some(wanted));
            }
        }
    }
}

/// An item with these texts.
pub fn item(id: &str, text: &str, parents: &[&str]) -> Item {
    Item {
        id: id.into(),
        text: text.into(),
        rationale: "Why, \"quoted\"".into(),
        status: "draft".into(),
        parents: parents.iter().map(|it| (*it).to_owned()).collect(),
    }
}
