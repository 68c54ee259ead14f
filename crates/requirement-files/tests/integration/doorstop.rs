//! Folders of Doorstop.

use crate::support::{file, item};
use diagnostic::Problem;
use requirement_files::{Change, Columns, Document, Field, File, Format};

const SETTINGS: &str = "settings:\n  digits: 3\n  prefix: REQ\n  sep: ''\n";
const ONE: &str = "active: true\nderived: false\nheader: |\n  Stop\nlevel: 1.1\nlinks:\n- SYS001: aBc=\n- SYS002: null\nnormative: true\n\
    rationale: 'It''s near'\nref: ''\nreviewed: xyz=\ntext: |\n  The arm shall stop.\n\n  At once.\n";

fn read(files: &[(&str, &str)]) -> Result<Document, Problem> {
    let mut all = vec![file(".doorstop.yml", SETTINGS)];
    all.extend(files.iter().map(|(name, text)| file(name, text)));
    Document::read(Format::Doorstop, &all, &Columns::default())
}

fn text(files: &[File], name: &str) -> String {
    let found = files.iter().find(|it| it.name == name).expect(name);
    String::from_utf8(found.bytes.clone()).expect("UTF-8")
}

#[test]
fn items_are_read_and_changed_in_place() {
    let heading = ONE.replace("normative: true", "normative: false");
    let document = read(&[
        ("REQ001.yml", ONE),
        ("REQ002.yml", &heading),
        ("notes.md", "x"),
    ])
    .expect("a folder");
    assert_eq!(document.items.len(), 1);
    let own = document.items[0].item.clone();
    assert_eq!(own.text, "The arm shall stop.\n\nAt once.");
    assert_eq!(
        (own.rationale.as_str(), own.parents.len()),
        ("It's near", 2)
    );
    assert_eq!(
        document.fields,
        [Field::Text, Field::Rationale, Field::Parents]
    );
    assert_eq!(document.notes.len(), 2, "{:?}", document.notes);

    let mut new = own;
    new.text = "# One: 'line'".into();
    new.parents = vec!["SYS001".into(), "SYS003".into()];
    let files = document
        .with(&[
            Change::Set(new, vec![Field::Text, Field::Parents]),
            Change::Add(item("REQ003", " odd\tstart ", &["REQ001"])),
        ])
        .expect("written");
    let expected = ONE
        .replace(
            "|\n  The arm shall stop.\n\n  At once.\n",
            "|\n  # One: 'line'\n",
        )
        .replace("- SYS002: null\n", "- SYS003\n");
    assert_eq!(text(&files, "REQ001.yml"), expected);
    let added = text(&files, "REQ003.yml");
    assert!(
        added.contains("links:\n- REQ001\n") && added.contains("text: \" odd\\u0009start \"\n"),
        "{added}"
    );
    assert_eq!(files.len(), 2);
}

#[test]
fn items_in_markdown_keep_their_header() {
    let markdown = "---\nactive: true\nlevel: 1.0\nlinks: []\nnormative: true\n---\n\n# Stop\n\nThe arm\nshall stop.\n";
    let document = read(&[("REQ001.md", markdown)]).expect("a folder");
    let mut own = document.items[0].item.clone();
    assert_eq!(own.text, "The arm\nshall stop.");
    own.text = "Other".into();
    own.parents = vec!["SYS001".into()];
    let files = document
        .with(&[Change::Set(own, vec![Field::Text, Field::Parents])])
        .expect("written");
    let expected = markdown
        .replace("The arm\nshall stop.", "Other")
        .replace("links: []", "links:\n- SYS001");
    assert_eq!(text(&files, "REQ001.md"), expected);
}

#[test]
fn ids_that_do_not_fit_and_bad_yaml_are_refused() {
    let document = read(&[("REQ001.yml", ONE)]).expect("a folder");
    for id in ["R1", "REQ", "REQ1x", "REQ../1"] {
        let problem = document
            .with(&[Change::Add(item(id, "x", &[]))])
            .expect_err(id);
        assert_eq!(problem.code, "cannot-write-requirement");
    }
    let problem = read(&[
        ("REQ001.yml", "text: [1\n"),
        ("REQ002.yml", "a: &x 1\nb: *x\n"),
    ])
    .expect_err("bad");
    let lines: Vec<_> = problem
        .clone()
        .into_each()
        .iter()
        .map(|it| it.place().expect("placed").name.clone())
        .collect();
    assert_eq!(lines, ["REQ001.yml", "REQ002.yml"], "{problem}");
    assert!(Document::read(Format::Doorstop, &[], &Columns::default()).is_err());
    let empty = Document::empty(Format::Doorstop, "d", "T", "ARM-007").expect("a folder");
    let files = empty
        .with(&[Change::Add(item("ARM-007", "x", &[]))])
        .expect("written");
    assert_eq!(
        text(&files, ".doorstop.yml"),
        "settings:\n  digits: 3\n  prefix: 'ARM'\n  sep: '-'\n"
    );
}
