//! CSV and StrictDoc.

use crate::support::{changed, every_text_can_be_changed, file, item, read};
use requirement_files::{Change, Columns, Document, Field, File, Format, Item};

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

#[test]
fn a_value_that_the_grammar_does_not_let_a_field_have_is_refused() {
    let grammar = "[DOCUMENT]\nTITLE: A\n\n[GRAMMAR]\nELEMENTS:\n- TAG: TEXT\n  FIELDS:\n  - TITLE: STATUS\n    TYPE: SingleChoice(x)\n\
        - TAG: REQUIREMENT\n  FIELDS:\n  - TITLE: UID\n    TYPE: String\n    REQUIRED: True\n  - TITLE: STATUS\n    \
        TYPE: SingleChoice(Draft, Approved)\n    REQUIRED: False\n  - TITLE: STATEMENT\n    TYPE: String\n    REQUIRED: True\n  \
        - TITLE: RATIONALE\n    TYPE: MultipleChoice(Safety, Law)\n    REQUIRED: False\n\n\
        [REQUIREMENT]\nUID: A\nSTATUS: Draft\nSTATEMENT: x\n";
    let document = read(Format::StrictDoc, grammar).expect("a document");
    let with = |status: &str, rationale: &str| Item {
        status: status.into(),
        rationale: rationale.into(),
        ..document.items[0].item.clone()
    };
    let fields = || vec![Field::Status, Field::Rationale];
    for (status, rationale) in [("Approved", "Law, Safety"), ("", "Safety"), ("Draft", "")] {
        let item = with(status, rationale);
        changed(&document, &[Change::Set(item.clone(), fields())]);
        let added = Item {
            id: "B".into(),
            ..item
        };
        changed(&document, &[Change::Add(added)]);
    }
    for (status, rationale, said) in [
        (
            "approved",
            "",
            [
                "its status is `approved`",
                "STATUS be one of Draft, Approved only",
            ],
        ),
        ("Draft, Approved", "", ["`Draft, Approved`", "STATUS"]),
        (
            "Draft",
            "Law, Cost",
            [
                "its rationale is `Cost`",
                "RATIONALE be one of Safety, Law only",
            ],
        ),
    ] {
        let item = with(status, rationale);
        let added = Item {
            id: "B".into(),
            ..item.clone()
        };
        for (change, id) in [
            (Change::Set(item, fields()), "`A`"),
            (Change::Add(added), "`B`"),
        ] {
            let problem = document.with(&[change]).expect_err("no choice");
            assert_eq!(problem.code, "cannot-write-requirement");
            for said in said.iter().chain([&id]) {
                assert!(problem.message().contains(said), "{said}: {problem}");
            }
        }
    }
}

/// A table is written with what separates its columns, and a new one with what its name says.
#[test]
fn a_table_of_tabs_stays_one() {
    let named = |name: &str, text: &str| {
        let file = File {
            name: name.into(),
            bytes: text.as_bytes().to_vec(),
        };
        Document::read(Format::Csv, &[file], &Columns::default()).expect("a table")
    };
    let add = || [Change::Add(item("R2", "One, two", &["R1"]))];
    for (name, text, row) in [
        ("r.tsv", "id\ttext\tparents\n", "R2\tOne, two\tR1\n"),
        ("R.TSV", "id\ttext\tNote, of, many\n", "R2\tOne, two\t\n"),
        ("r.csv", "id\ttext\tparents\n", "R2\tOne, two\tR1\n"),
        ("r.csv", "id,text,parents\n", "R2,\"One, two\",R1\n"),
        // What has no tab is as it is, whatever its name.
        ("r.tsv", "id;text;parents\n", "R2;One, two;R1\n"),
    ] {
        assert_eq!(
            changed(&named(name, text), &add()),
            format!("{text}{row}"),
            "{name}"
        );
    }
    for (name, separator) in [("new.tsv", "\t"), ("new.TSV", "\t"), ("new.csv", ",")] {
        let empty = Document::empty(Format::Csv, name, "T", "").expect("a table");
        let text = changed(&empty, &add());
        let columns = ["id", "text", "rationale", "status", "parents"].join(separator);
        assert!(
            text.starts_with(&format!("{columns}\nR2{separator}")),
            "{name}: {text}"
        );
        assert_eq!(named(name, &text).items[0].item.text, "One, two");
    }
}
