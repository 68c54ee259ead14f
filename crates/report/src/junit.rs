//! Results as JUnit XML, which build servers and tools of requirements read.
//!
//! The form is that of the schema `junit-10` of Jenkins' xUnit plugin but for what pytest adds to a test case, `properties` and `file`,
//! since tools that trace requirements read these: a case is a requirement, and what is known of it stands in its properties. Tools that trace requirements read the property `verifies`.
//! A requirement that is not decided is *skipped* with its reason: it neither passed nor failed.

mod study;

pub use study::of_study;

use std::fmt::Write;

/// A suite of test cases.
#[derive(Clone, Debug, PartialEq)]
pub struct Suite {
    /// Its name.
    pub name: String,
    /// Its cases.
    pub cases: Vec<Case>,
}

/// A test case.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    /// What it is part of.
    pub class: String,
    /// Its name, unique in that.
    pub name: String,
    /// The file that it stands in, if any: of the properties of the case.
    pub file: Option<String>,
    /// How long it took, in seconds, where that is known.
    pub secs: Option<f64>,
    /// Names and values.
    pub properties: Vec<(String, String)>,
    /// How it ended.
    pub end: End,
}

/// How a test case ended.
#[derive(Clone, Debug, PartialEq)]
pub enum End {
    /// It passed.
    Passed,
    /// It failed.
    Failed(Said),
    /// It could not be run.
    Error(Said),
    /// It is not decided.
    Skipped(String),
}

/// What is said of a case that did not pass.
#[derive(Clone, Debug, PartialEq)]
pub struct Said {
    /// Of which kind it is.
    pub kind: String,
    /// In a line.
    pub message: String,
    /// In full.
    pub text: String,
}

/// The suites as XML.
#[must_use]
pub fn xml(suites: &[Suite]) -> String {
    let mut text = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites>\n");
    for suite in suites {
        let count = |is: fn(&End) -> bool| suite.cases.iter().filter(|it| is(&it.end)).count();
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "  <testsuite name=\"{}\" tests=\"{}\" failures=\"{}\" errors=\"{}\" skipped=\"{}\">",
            escaped(&suite.name),
            suite.cases.len(),
            count(|end| matches!(end, End::Failed(_))),
            count(|end| matches!(end, End::Error(_))),
            count(|end| matches!(end, End::Skipped(_)))
        );
        for case in &suite.cases {
            write_case(case, &mut text);
        }
        text.push_str("  </testsuite>\n");
    }
    text + "</testsuites>\n"
}

fn write_case(case: &Case, text: &mut String) {
    let (class, name) = (escaped(&case.class), escaped(&case.name));
    let _ = write!(text, "    <testcase classname=\"{class}\" name=\"{name}\"");
    if let Some(file) = &case.file {
        let _ = write!(text, " file=\"{}\"", escaped(file));
    }
    if let Some(secs) = case.secs {
        let _ = write!(text, " time=\"{secs:.3}\"");
    }
    text.push_str(">\n");
    if !case.properties.is_empty() {
        text.push_str("      <properties>\n");
        for (name, value) in &case.properties {
            let (name, value) = (escaped(name), escaped(value));
            let _ = writeln!(
                text,
                "        <property name=\"{name}\" value=\"{value}\"/>"
            );
        }
        text.push_str("      </properties>\n");
    }
    write_end(&case.end, text);
    text.push_str("    </testcase>\n");
}

fn write_end(end: &End, text: &mut String) {
    let (element, said) = match end {
        End::Passed => return,
        End::Skipped(message) => {
            let _ = writeln!(text, "      <skipped message=\"{}\"/>", escaped(message));
            return;
        }
        End::Failed(said) => ("failure", said),
        End::Error(said) => ("error", said),
    };
    let _ = writeln!(
        text,
        "      <{element} type=\"{}\" message=\"{}\">{}</{element}>",
        escaped(&said.kind),
        escaped(&said.message),
        escaped(&said.text)
    );
}

/// A text as it stands in XML; what XML does not allow at all becomes a question mark.
fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\n' | '\t' => escaped.push(character),
            '\u{0}'..='\u{1f}' | '\u{fffe}' | '\u{ffff}' => escaped.push('?'),
            other => escaped.push(other),
        }
    }
    escaped
}
