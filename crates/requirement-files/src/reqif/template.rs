//! A file of ReqIF without requirements.
//!
//! It has one type of objects (`ReqIF.ForeignID`, `ReqIF.Text`, `Rationale`, `Status`), one of relations (`Parent`) and one
//! specification. Nothing here reads a clock: times are those of 1970, as in other reproducible files.

use super::xhtml::escaped;

/// The time that is written where the format asks for one.
pub(super) const TIME: &str = "1970-01-01T00:00:00Z";

/// A file of this title.
pub(crate) fn empty(title: &str) -> String {
    let title = escaped(title);
    let attribute = |kind: &str, id: &str, name: &str, datatype: &str| {
        format!(
            "            <ATTRIBUTE-DEFINITION-{kind} IDENTIFIER=\"{id}\" LAST-CHANGE=\"{TIME}\" LONG-NAME=\"{name}\">\n\
             \x20             <TYPE>\n                <DATATYPE-DEFINITION-{kind}-REF>{datatype}</DATATYPE-DEFINITION-{kind}-REF>\n\
             \x20             </TYPE>\n            </ATTRIBUTE-DEFINITION-{kind}>\n"
        )
    };
    let attributes = [
        attribute("STRING", "_id", "ReqIF.ForeignID", "_string"),
        attribute("XHTML", "_text", "ReqIF.Text", "_xhtml"),
        attribute("STRING", "_rationale", "Rationale", "_string"),
        attribute("STRING", "_status", "Status", "_string"),
    ];
    format!(
        r#"<?xml version="1.0" encoding="UTF-8"?>
<REQ-IF xmlns="http://www.omg.org/spec/ReqIF/20110401/reqif.xsd" xmlns:xhtml="http://www.w3.org/1999/xhtml">
  <THE-HEADER>
    <REQ-IF-HEADER IDENTIFIER="_header">
      <CREATION-TIME>{TIME}</CREATION-TIME>
      <REQ-IF-TOOL-ID>corroborate</REQ-IF-TOOL-ID>
      <REQ-IF-VERSION>1.0</REQ-IF-VERSION>
      <SOURCE-TOOL-ID>corroborate</SOURCE-TOOL-ID>
      <TITLE>{title}</TITLE>
    </REQ-IF-HEADER>
  </THE-HEADER>
  <CORE-CONTENT>
    <REQ-IF-CONTENT>
      <DATATYPES>
        <DATATYPE-DEFINITION-STRING IDENTIFIER="_string" LAST-CHANGE="{TIME}" LONG-NAME="Text" MAX-LENGTH="100000"/>
        <DATATYPE-DEFINITION-XHTML IDENTIFIER="_xhtml" LAST-CHANGE="{TIME}" LONG-NAME="Formatted text"/>
      </DATATYPES>
      <SPEC-TYPES>
        <SPEC-OBJECT-TYPE IDENTIFIER="_requirement" LAST-CHANGE="{TIME}" LONG-NAME="Requirement">
          <SPEC-ATTRIBUTES>
{}          </SPEC-ATTRIBUTES>
        </SPEC-OBJECT-TYPE>
        <SPEC-RELATION-TYPE IDENTIFIER="_parent" LAST-CHANGE="{TIME}" LONG-NAME="Parent"/>
        <SPECIFICATION-TYPE IDENTIFIER="_document" LAST-CHANGE="{TIME}" LONG-NAME="Document"/>
      </SPEC-TYPES>
      <SPEC-OBJECTS>
      </SPEC-OBJECTS>
      <SPEC-RELATIONS>
      </SPEC-RELATIONS>
      <SPECIFICATIONS>
        <SPECIFICATION IDENTIFIER="_specification" LAST-CHANGE="{TIME}" LONG-NAME="{title}">
          <TYPE>
            <SPECIFICATION-TYPE-REF>_document</SPECIFICATION-TYPE-REF>
          </TYPE>
          <CHILDREN>
          </CHILDREN>
        </SPECIFICATION>
      </SPECIFICATIONS>
    </REQ-IF-CONTENT>
  </CORE-CONTENT>
</REQ-IF>
"#,
        attributes.concat()
    )
}
