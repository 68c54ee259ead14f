//! ReqIF, as XML and in archives.

use crate::support::{changed, every_text_can_be_changed, file, item, read};
use requirement_files::{Change, Columns, Document, Field, Format, Item};

/// A file in the manner of a tool that prefixes names, has attributes of its own, an enumeration, and an extension.
const FILE: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<r:REQ-IF xmlns:r="http://www.omg.org/spec/ReqIF/20110401/reqif.xsd" xmlns:h="http://www.w3.org/1999/xhtml">
  <r:CORE-CONTENT><r:REQ-IF-CONTENT>
    <r:DATATYPES>
      <r:DATATYPE-DEFINITION-ENUMERATION IDENTIFIER="_e" LONG-NAME="State"><r:SPECIFIED-VALUES>
        <r:ENUM-VALUE IDENTIFIER="_e1" LONG-NAME="open"/><r:ENUM-VALUE IDENTIFIER="_e2" LONG-NAME="approved"/>
      </r:SPECIFIED-VALUES></r:DATATYPE-DEFINITION-ENUMERATION>
    </r:DATATYPES>
    <r:SPEC-TYPES>
      <r:SPEC-OBJECT-TYPE IDENTIFIER="_t" LONG-NAME="Req"><r:SPEC-ATTRIBUTES>
        <r:ATTRIBUTE-DEFINITION-STRING IDENTIFIER="_i" LONG-NAME="ReqIF.ForeignID"/>
        <r:ATTRIBUTE-DEFINITION-XHTML IDENTIFIER="_x" LONG-NAME="ReqIF.Text"/>
        <r:ATTRIBUTE-DEFINITION-STRING IDENTIFIER="_w" LONG-NAME="Rationale"/>
        <r:ATTRIBUTE-DEFINITION-ENUMERATION IDENTIFIER="_s" LONG-NAME="Status"><r:TYPE>
          <r:DATATYPE-DEFINITION-ENUMERATION-REF>_e</r:DATATYPE-DEFINITION-ENUMERATION-REF></r:TYPE>
        </r:ATTRIBUTE-DEFINITION-ENUMERATION>
      </r:SPEC-ATTRIBUTES></r:SPEC-OBJECT-TYPE>
      <r:SPEC-RELATION-TYPE IDENTIFIER="_rt" LONG-NAME="derives"/>
    </r:SPEC-TYPES>
    <r:SPEC-OBJECTS>
      <r:SPEC-OBJECT IDENTIFIER="_o2"><r:TYPE><r:SPEC-OBJECT-TYPE-REF>_t</r:SPEC-OBJECT-TYPE-REF></r:TYPE><r:VALUES>
        <r:ATTRIBUTE-VALUE-STRING THE-VALUE="R2"><r:DEFINITION><r:ATTRIBUTE-DEFINITION-STRING-REF>_i</r:ATTRIBUTE-DEFINITION-STRING-REF></r:DEFINITION></r:ATTRIBUTE-VALUE-STRING>
        <r:ATTRIBUTE-VALUE-XHTML><r:DEFINITION><r:ATTRIBUTE-DEFINITION-XHTML-REF>_x</r:ATTRIBUTE-DEFINITION-XHTML-REF></r:DEFINITION>
          <r:THE-VALUE><h:div>The <h:b>arm</h:b><h:p>stops.</h:p></h:div></r:THE-VALUE></r:ATTRIBUTE-VALUE-XHTML>
        <r:ATTRIBUTE-VALUE-ENUMERATION><r:DEFINITION><r:ATTRIBUTE-DEFINITION-ENUMERATION-REF>_s</r:ATTRIBUTE-DEFINITION-ENUMERATION-REF></r:DEFINITION>
          <r:VALUES><r:ENUM-VALUE-REF>_e1</r:ENUM-VALUE-REF></r:VALUES></r:ATTRIBUTE-VALUE-ENUMERATION>
      </r:VALUES></r:SPEC-OBJECT>
      <r:SPEC-OBJECT IDENTIFIER="_o1"><r:TYPE><r:SPEC-OBJECT-TYPE-REF>_t</r:SPEC-OBJECT-TYPE-REF></r:TYPE><r:VALUES>
        <r:ATTRIBUTE-VALUE-STRING THE-VALUE="R1"><r:DEFINITION><r:ATTRIBUTE-DEFINITION-STRING-REF>_i</r:ATTRIBUTE-DEFINITION-STRING-REF></r:DEFINITION></r:ATTRIBUTE-VALUE-STRING>
        <r:ATTRIBUTE-VALUE-XHTML><r:DEFINITION><r:ATTRIBUTE-DEFINITION-XHTML-REF>_x</r:ATTRIBUTE-DEFINITION-XHTML-REF></r:DEFINITION>
          <r:THE-VALUE><h:div>First</h:div></r:THE-VALUE></r:ATTRIBUTE-VALUE-XHTML>
      </r:VALUES></r:SPEC-OBJECT>
      <r:SPEC-OBJECT IDENTIFIER="_heading"><r:TYPE><r:SPEC-OBJECT-TYPE-REF>_t</r:SPEC-OBJECT-TYPE-REF></r:TYPE></r:SPEC-OBJECT>
    </r:SPEC-OBJECTS>
    <r:SPEC-RELATIONS>
      <r:SPEC-RELATION IDENTIFIER="_l"><r:TYPE><r:SPEC-RELATION-TYPE-REF>_rt</r:SPEC-RELATION-TYPE-REF></r:TYPE>
        <r:SOURCE><r:SPEC-OBJECT-REF>_o2</r:SPEC-OBJECT-REF></r:SOURCE><r:TARGET><r:SPEC-OBJECT-REF>_o1</r:SPEC-OBJECT-REF></r:TARGET></r:SPEC-RELATION>
    </r:SPEC-RELATIONS>
    <r:SPECIFICATIONS><r:SPECIFICATION IDENTIFIER="_sp" LONG-NAME="All"><r:CHILDREN>
      <r:SPEC-HIERARCHY IDENTIFIER="_h1"><r:OBJECT><r:SPEC-OBJECT-REF>_o1</r:SPEC-OBJECT-REF></r:OBJECT></r:SPEC-HIERARCHY>
      <r:SPEC-HIERARCHY IDENTIFIER="_h2"><r:OBJECT><r:SPEC-OBJECT-REF>_o2</r:SPEC-OBJECT-REF></r:OBJECT></r:SPEC-HIERARCHY>
    </r:CHILDREN></r:SPECIFICATION></r:SPECIFICATIONS>
  </r:REQ-IF-CONTENT></r:CORE-CONTENT>
  <r:TOOL-EXTENSIONS><mine xmlns="urn:x">kept <!-- too --></mine></r:TOOL-EXTENSIONS>
</r:REQ-IF>
"#;

fn one() -> (Document, Item, Item) {
    let document = read(Format::ReqIf, FILE).expect("a file");
    let (first, second) = (
        document.items[0].item.clone(),
        document.items[1].item.clone(),
    );
    (document, first, second)
}

#[test]
fn objects_are_read_in_the_order_of_the_hierarchy() {
    let (document, first, second) = one();
    assert_eq!((first.id.as_str(), first.text.as_str()), ("R1", "First"));
    assert_eq!(second.text, "The arm\nstops.");
    assert_eq!(
        (second.status.as_str(), &second.parents[..]),
        ("open", &["R1".to_owned()][..])
    );
    assert_eq!(
        document.fields,
        [Field::Text, Field::Rationale, Field::Status, Field::Parents]
    );
    assert_eq!(
        document.notes,
        ["Kept in the file: 1 object without a text (headings and the like)."]
    );
    every_text_can_be_changed(&document);
}

#[test]
fn what_is_not_changed_stays_byte_for_byte() {
    let (document, mut first, mut second) = one();
    second.status = "approved".into();
    let text = changed(
        &document,
        &[Change::Set(second.clone(), vec![Field::Status])],
    );
    let expected = FILE.replace(
        "<r:VALUES><r:ENUM-VALUE-REF>_e1</r:ENUM-VALUE-REF></r:VALUES>",
        "<r:VALUES><r:ENUM-VALUE-REF>_e2</r:ENUM-VALUE-REF></r:VALUES>",
    );
    assert_eq!(text, expected);
    // A value, a relation and objects that were not there.
    first.rationale = "a < b\n& c".into();
    first.parents = vec!["R3".into()];
    second.parents = Vec::new();
    let changes = [
        Change::Set(first, vec![Field::Rationale, Field::Parents]),
        Change::Set(second, vec![Field::Parents]),
        Change::Add(Item {
            status: "open".into(),
            ..item("R3", "Third", &[])
        }),
        Change::Add(Item {
            status: "approved".into(),
            ..item("R4", "Fourth", &["R3", "R1"])
        }),
    ];
    let text = changed(&document, &changes);
    let lines: Vec<&str> = FILE.lines().collect();
    let kept = text.lines().filter(|line| lines.contains(line)).count();
    assert!(kept >= lines.len() - 4, "{kept} of {}\n{text}", lines.len());
    assert!(text.contains("kept <!-- too -->"));
    let again = read(Format::ReqIf, &text).expect("a file");
    let ids: Vec<&str> = again.items.iter().map(|it| it.item.id.as_str()).collect();
    assert_eq!(ids, ["R1", "R2", "R3", "R4"]);
    assert_eq!(again.items[3].item.parents, ["R3", "R1"]);
}

#[test]
fn what_has_no_place_in_the_file_is_refused() {
    let (document, _, mut second) = one();
    second.status = "rejected".into();
    let problem = document
        .with(&[Change::Set(second.clone(), vec![Field::Status])])
        .expect_err("no value");
    assert!(problem.message().contains("open, approved"), "{problem}");
    second.parents = vec!["R9".into()];
    let problem = document
        .with(&[Change::Set(second, vec![Field::Parents])])
        .expect_err("no parent");
    assert!(problem.message().contains("`R9`"), "{problem}");
}

#[test]
fn entities_and_other_files_are_refused() {
    let bomb = "<!DOCTYPE x [<!ENTITY a \"aaaa\"><!ENTITY b \"&a;&a;\">]>\n<REQ-IF>&b;</REQ-IF>";
    for (text, what) in [
        (bomb, "DTD"),
        ("<REQ-IF><A></REQ-IF>", "well-formed"),
        ("<svg/>", "`svg`"),
        ("", "well-formed"),
    ] {
        let problem = read(Format::ReqIf, text).expect_err(what);
        assert!(problem.to_string().contains(what), "{problem}");
        assert!(problem.has_place());
    }
    let other = FILE.replace("ReqIF.Text", "What");
    let problem = read(Format::ReqIf, &other).expect_err("no text");
    assert!(
        problem
            .message()
            .contains("Rationale, ReqIF.ForeignID, Status, What"),
        "{problem}"
    );
    let columns = Columns {
        id: None,
        fields: vec![(Field::Text, "What".into())],
    };
    let document = Document::read(Format::ReqIf, &[file("x", &other)], &columns).expect("declared");
    assert_eq!(document.items.len(), 2);
}

#[test]
fn ids_that_are_not_unique_are_not_taken() {
    let text = FILE.replace("THE-VALUE=\"R2\"", "THE-VALUE=\"R1\"");
    let document = read(Format::ReqIf, &text).expect("a file");
    let ids: Vec<&str> = document
        .items
        .iter()
        .map(|it| it.item.id.as_str())
        .collect();
    assert_eq!(ids, ["_o1", "_o2"]);
    assert_eq!(document.items[1].item.parents, ["_o1"]);
}

#[test]
fn an_archive_keeps_its_other_files() {
    let empty =
        Document::empty(Format::ReqIfArchive, "a.reqifz", "T & \"U\"", "").expect("an archive");
    let files = empty.with(&[
        Change::Add(item("R1", "One\ntwo", &[])),
        Change::Add(item("R2", "x", &["R1"])),
    ]);
    let files = files.expect("written");
    let document =
        Document::read(Format::ReqIfArchive, &files, &Columns::default()).expect("again");
    assert_eq!(document.items[0].item, item("R1", "One\ntwo", &[]));
    assert_eq!(document.items[1].item.parents, ["R1"]);
    every_text_can_be_changed(&document);
    for cut in [0, 10, files[0].bytes.len() - 5] {
        let bytes = files[0].bytes[..cut].to_vec();
        let cut = requirement_files::File {
            name: "c".into(),
            bytes,
        };
        assert!(Document::read(Format::ReqIfArchive, &[cut], &Columns::default()).is_err());
    }
}

/// Tools refuse or cut what is longer than the type of an attribute allows.
#[test]
fn a_text_that_is_longer_than_its_type_allows_is_refused() {
    let text = FILE
        .replace(
            "<r:DATATYPES>",
            "<r:DATATYPES><r:DATATYPE-DEFINITION-STRING IDENTIFIER=\"_short\" MAX-LENGTH=\"5\"/>",
        )
        .replace(
            "IDENTIFIER=\"_w\" LONG-NAME=\"Rationale\"/>",
            "IDENTIFIER=\"_w\" LONG-NAME=\"Rationale\"><r:TYPE><r:DATATYPE-DEFINITION-STRING-REF>_short\
             </r:DATATYPE-DEFINITION-STRING-REF></r:TYPE></r:ATTRIBUTE-DEFINITION-STRING>",
        );
    let mut text = text;
    for (rationale, fits) in [("\u{e9}\u{e9}\u{e9}\u{e9}\u{e9}", true), ("longer", false)] {
        let document = read(Format::ReqIf, &text).expect("a file");
        let set = Item {
            rationale: rationale.into(),
            ..document.items[0].item.clone()
        };
        let added = Item {
            rationale: rationale.into(),
            status: "open".into(),
            ..item("R3", "Third", &[])
        };
        for (change, id) in [
            (Change::Set(set, vec![Field::Rationale]), "`R1`"),
            (Change::Add(added), "`R3`"),
        ] {
            let written = document.with(&[change]);
            if fits {
                let files = written.expect("it fits");
                // The next one replaces a value that is there.
                if id == "`R1`" {
                    text = String::from_utf8(files[0].bytes.clone()).expect("UTF-8");
                }
                continue;
            }
            let problem = written.expect_err("too long");
            assert_eq!(problem.code, "cannot-write-requirement");
            for said in [
                id,
                "its rationale has 6 characters",
                "`Rationale`",
                "5 at most (MAX-LENGTH)",
            ] {
                assert!(problem.message().contains(said), "{problem}");
            }
        }
    }
}
