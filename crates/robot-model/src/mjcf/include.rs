//! `<include file>`: replaced by the children of the named file's root.

use std::sync::Arc;

use crate::reader::{Reader, joined};
use crate::xml::Element;

/// Includes inside includes.
const MAX_DEPTH: usize = 16;

/// Replaces all includes below an element. Files are looked for beside the main file, then beside the including one.
pub(super) fn expand(
    reader: &mut Reader<'_, '_>,
    element: &mut Element,
    main: &Arc<str>,
    depth: usize,
) {
    let children = std::mem::take(&mut element.children);
    for mut child in children {
        if child.name != "include" {
            expand(reader, &mut child, main, depth);
            element.children.push(child);
            continue;
        }
        let file = reader.required(&child, "file").to_owned();
        if file.is_empty() {
            continue;
        }
        if depth >= MAX_DEPTH {
            let message = format!("includes are nested more than {MAX_DEPTH} deep");
            reader.problem(
                &child.place,
                message,
                "remove the include that names itself",
            );
            continue;
        }
        let addresses = [joined(main, &file), joined(&child.place.file, &file)];
        if let Some(mut root) = reader.needed_document(&child.place, &addresses) {
            if !matches!(root.name.as_str(), "mujoco" | "mujocoinclude") {
                let message = format!("{file} starts with <{}>", root.name);
                reader.problem(
                    &child.place,
                    message,
                    "include a file that starts with <mujoco>",
                );
                continue;
            }
            expand(reader, &mut root, main, depth + 1);
            element.children.append(&mut root.children);
        }
    }
}
