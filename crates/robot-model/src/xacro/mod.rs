//! xacro: templates of XML with properties, macros, conditions and included files, to the XML that they stand for.
//!
//! Source: the Python program `xacro` 2.1, whose order of evaluation this follows: properties are evaluated when they are
//! first asked for, in the scope that has them; blocks that a macro is given are expanded by the caller and again where they are inserted.
//! Expressions are of Python's grammar without statements and lambdas, over numbers, texts, lists and dictionaries.
//!
//! Deviations. No environment is read: `$(env NAME)` is refused and `$(optenv NAME DEFAULT)` is its default. `$(find
//! PACKAGE)` is `package://PACKAGE`, which is resolved as in other addresses. Names of files are no patterns. Whole numbers
//! have 64 bits. Comments are dropped. Where a description is read, `xacro:arg` has the value that it is first given: a file of one's own that
//! declares it before it includes another gives the other its arguments.
//!
//! Guarantee: whatever the text, it ends: depth, elements, work and the size of values are bounded. A mistake has the place
//! of the element or attribute that has it.

mod builtin;
mod eval;
mod expand;
mod parse;
mod scopes;
mod text;
mod value;
mod yaml;

use crate::diagnostics::{Place, Problem, Problems};
use crate::reader::{Reader, Resolver};
use crate::xml::{self, Element};
use std::collections::BTreeMap;
use std::fmt::Write;

pub(crate) use expand::expand;

/// Values of `xacro:arg`s, by name.
pub type Arguments = BTreeMap<String, String>;

/// What is said of a value for an argument that no `xacro:arg` declares.
pub(crate) fn no_such_argument(place: &Place, name: &str, declared: &[String]) -> Problem {
    let message = match declared {
        [] => format!("the description has no arguments, and a value is given for `{name}`"),
        _ => format!(
            "the description has no argument `{name}`; it has {}",
            declared.join(", ")
        ),
    };
    Problem {
        place: place.clone(),
        message,
        remedy: "correct the name, or leave it out".to_owned(),
    }
}

/// Whether an element or one below it has to be expanded.
pub(crate) fn is_template(root: &Element) -> bool {
    let mut open = vec![root];
    while let Some(element) = open.pop() {
        let is_one = |name: &str| name.starts_with("xacro:");
        let mut attributes = element.attributes.iter();
        if is_one(&element.name)
            || attributes
                .any(|it| is_one(&it.name) || it.value.contains("${") || it.value.contains("$("))
        {
            return true;
        }
        open.extend(&element.children);
    }
    false
}

/// The XML that a xacro text, known as `file`, stands for, with values of its `xacro:arg`s by name. Elements and attributes are in
/// their order; comments are dropped.
///
/// ```
/// let text = r#"<robot xmlns:xacro="http://ros.org/wiki/xacro" name="r">
///   <xacro:arg name="radius" default="0.1"/>
///   <xacro:macro name="wheel" params="side *origin">
///     <link name="${side}_wheel"><visual>
///       <xacro:insert_block name="origin"/>
///       <geometry><sphere radius="${2 * radius}"/></geometry>
///     </visual></link>
///   </xacro:macro>
///   <xacro:property name="radius" value="$(arg radius)"/>
///   <xacro:wheel side="left"><origin xyz="0 0.2 0"/></xacro:wheel>
/// </robot>"#;
/// let arguments = [("radius".to_owned(), "0.25".to_owned())].into();
/// let mut none = |address: &str| Err(format!("{address} is not here"));
/// let expanded = robot_model::expand_xacro("r.xacro", text, &arguments, &mut none)?;
/// assert!(expanded.contains(r#"<link name="left_wheel">"#));
/// assert!(expanded.contains(r#"<sphere radius="0.5"/>"#));
/// # Ok::<(), robot_model::Problems>(())
/// ```
///
/// # Errors
/// What is wrong with it or with a file that it includes, with its place.
pub fn expand_xacro(
    file: &str,
    text: &str,
    arguments: &Arguments,
    resolve: &mut Resolver<'_>,
) -> Result<String, Problems> {
    let one = |problem| Problems(vec![problem]);
    let root = xml::read(file, text).map_err(one)?;
    let mut reader = Reader::new(resolve);
    let (root, _) = expand(&mut reader, root, arguments.clone()).map_err(one)?;
    let mut text = String::from("<?xml version=\"1.0\"?>\n");
    write(&root, 0, &mut text);
    Ok(text)
}

fn write(element: &Element, depth: usize, into: &mut String) {
    let indent = "  ".repeat(depth);
    let _ = write!(into, "{indent}<{}", element.name);
    for attribute in &element.attributes {
        let _ = write!(
            into,
            " {}=\"{}\"",
            attribute.name,
            escaped(&attribute.value)
        );
    }
    if element.children.is_empty() && element.text.is_empty() {
        into.push_str("/>\n");
        return;
    }
    let _ = write!(into, ">{}", escaped(&element.text));
    if !element.children.is_empty() {
        into.push('\n');
        for child in &element.children {
            write(child, depth + 1, into);
        }
        into.push_str(&indent);
    }
    let _ = writeln!(into, "</{}>", element.name);
}

fn escaped(text: &str) -> String {
    let plain = text.replace('&', "&amp;").replace('<', "&lt;");
    plain.replace('>', "&gt;").replace('"', "&quot;")
}
