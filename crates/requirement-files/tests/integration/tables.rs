//! CSV and StrictDoc.

use crate::support::{changed, every_text_can_be_changed, file, item, read};
use requirement_files::{Change, Columns, Document, Field, Format};

const TABLE: &str = "Owner;ID;Requirement;Parent;Status\r\n\
                     Ada;R1;\"The arm stops;\r\nat \"\"once\"\".\";;draft\r\n\
                     \r\n\
                     Bob;R2;The hand opens.;R1, R0;final\r\n\
                     ;;a remark;;\r\n";

#[test]
fn a_table_is_read_by_its_header_and_changed_in_place() {
    let document = read(Format::Csv, TABLE).expect("a table");
    let items: Vec<_> = document.items.iter().map(|it| &it.item).collect();
    assert_eq!(items[0].text, "The arm stops;\nat \"once\".");
    assert_eq!(items[1].parents, ["R1", "R0"]);
    assert_eq!(
        document.fields,
        [Field::Text, Field::Status, Field::Parents]
    );
    assert_eq!(document.notes.len(), 2, "{:?}", document.notes);
    every_text_can_be_changed(&document);

    let mut two = items[1].clone();
    two.status = "draft; again".into();
    let new = item("R3", "New\nlines", &["R2"]);
    let text = changed(
        &document,
        &[Change::Set(two, vec![Field::Status]), Change::Add(new)],
    );
    let expected = TABLE.replace(";final\r\n", ";\"draft; again\"\r\n");
    assert_eq!(text, format!("{expected};R3;\"New\r\nlines\";R2;draft\r\n"));
}

#[test]
fn columns_of_other_names_are_declared() {
    let text = "number,what,id\n1,Stop.,x\n2,Go.,y\n";
    let problem = read(Format::Csv, text).expect_err("no text");
    assert!(
        problem.message().contains("no column for the text"),
        "{problem}"
    );
    let columns = Columns {
        id: Some("Number".into()),
        fields: vec![(Field::Text, "what".into())],
    };
    let document = Document::read(Format::Csv, &[file("x.csv", text)], &columns).expect("a table");
    assert_eq!(document.items[1].item.id, "2");
    let wrong = Columns {
        id: Some("Nummer".into()),
        ..columns
    };
    let problem = Document::read(Format::Csv, &[file("x.csv", text)], &wrong).expect_err("wrong");
    assert!(problem.message().contains("`Nummer`"), "{problem}");
}

#[test]
fn mistakes_of_a_table_are_told_together_with_their_lines() {
    let text = "id,text\nA,x,y\nB,\"q\" r\nA2,\"open\n";
    let problem = read(Format::Csv, text).expect_err("three mistakes");
    let mut lines: Vec<_> = problem
        .clone()
        .into_each()
        .iter()
        .map(|it| it.place().expect("placed").line)
        .collect();
    lines.sort_unstable();
    assert_eq!(lines, [2, 3, 4], "{problem}");
    let twice = read(Format::Csv, "id,text\nA,x\nB,y\nA,z\n").expect_err("twice");
    assert_eq!(twice.place().map(|it| it.line), Some(4));
    assert!(read(Format::Csv, "").is_err());
}

const DOCUMENT: &str = "[DOCUMENT]\nTITLE: Arm\nOPTIONS:\n  ENABLE_MID: True\n\n[TEXT]\nSTATEMENT: >>>\nNo id here.\n<<<\n\n\
    [[SECTION]]\nTITLE: Motion\n\n[REQUIREMENT]\nMID: 1f\nUID: ARM-1\nSTATUS: Active\nTITLE: Stop\nSTATEMENT: The arm shall stop.\n\
    RATIONALE: >>>\nPeople are near.\n\nVery near.\n<<<\nCOMMENT: kept\nRELATIONS:\n- TYPE: Parent\n  VALUE: SYS-1\n  ROLE: Refines\n\
    - TYPE: File\n  VALUE: a.c\n\n[[/SECTION]]\n\n[REQUIREMENT]\nUID: ARM-2\nSTATEMENT: >>>\nTwo\nlines\n<<<\n";

#[test]
fn a_document_of_strictdoc_is_read_and_changed_in_place() {
    let document = read(Format::StrictDoc, DOCUMENT).expect("a document");
    let first = &document.items[0].item;
    assert_eq!(
        (first.id.as_str(), first.status.as_str()),
        ("ARM-1", "Active")
    );
    assert_eq!(first.rationale, "People are near.\n\nVery near.");
    assert_eq!(first.parents, ["SYS-1"]);
    assert_eq!(document.items[1].item.text, "Two\nlines");
    assert_eq!(
        document.notes,
        ["Kept in the file: 1 node without a UID (with a UID it is taken over)."]
    );
    every_text_can_be_changed(&document);

    let mut one = first.clone();
    one.text = "The arm shall stop at once.".into();
    one.rationale = String::new();
    let mut two = document.items[1].item.clone();
    two.parents = vec!["ARM-1".into()];
    two.rationale = "Since\nso".into();
    let text = changed(
        &document,
        &[
            Change::Set(one, vec![Field::Text, Field::Rationale]),
            Change::Set(two, vec![Field::Parents, Field::Rationale]),
            Change::Add(item("ARM-3", "Third", &["ARM-2"])),
        ],
    );
    let expected = DOCUMENT
        .replace("The arm shall stop.", "The arm shall stop at once.")
        .replace("RATIONALE: >>>\nPeople are near.\n\nVery near.\n<<<\n", "");
    let expected = format!(
        "{expected}RATIONALE: >>>\nSince\nso\n<<<\nRELATIONS:\n- TYPE: Parent\n  VALUE: ARM-1\n\n[REQUIREMENT]\nUID: ARM-3\n\
         STATUS: draft\nSTATEMENT: Third\nRATIONALE: Why, \"quoted\"\nRELATIONS:\n- TYPE: Parent\n  VALUE: ARM-2\n"
    );
    assert_eq!(text, expected);
}

#[test]
fn what_strictdoc_cannot_hold_is_refused() {
    let document = read(Format::StrictDoc, DOCUMENT).expect("a document");
    let mut one = document.items[0].item.clone();
    one.text = "a\n<<<\nb".into();
    let problem = document
        .with(&[Change::Set(one, vec![Field::Text])])
        .expect_err("would end");
    assert_eq!(problem.code, "cannot-write-requirement");
    let open = DOCUMENT
        .replace("<<<\nCOMMENT", "COMMENT")
        .replace("lines\n<<<", "lines");
    let problem = read(Format::StrictDoc, &open).expect_err("no end");
    assert!(problem.to_string().contains("has no end"), "{problem}");
    assert!(read(Format::StrictDoc, "# Title\n").is_err());
}

#[test]
fn a_grammar_of_its_own_says_which_fields_there_are() {
    let grammar = "[DOCUMENT]\nTITLE: A\n\n[GRAMMAR]\nELEMENTS:\n- TAG: REQUIREMENT\n  FIELDS:\n  - TITLE: UID\n    TYPE: String\n    \
        REQUIRED: True\n  - TITLE: STATEMENT\n    TYPE: String\n    REQUIRED: True\n\n[REQUIREMENT]\nUID: A\nSTATEMENT: x\n";
    let document = read(Format::StrictDoc, grammar).expect("a document");
    assert_eq!(document.fields, [Field::Text, Field::Parents]);
}
