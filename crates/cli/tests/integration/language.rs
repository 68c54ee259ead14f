//! Words that people should not have to read: each phrase here has a standard term, and stays away.

use crate::support;
use support::{files_below, read, root, shown};

/// What stands nowhere in a text of the product, and what to write instead.
const NEVER: [(&str, &str); 8] = [
    (" decades", "Bayes factor 10^x"),
    ("had thought of", "unexpected behaviour"),
    ("sample is worth", "effective sample size"),
    ("is worth {", "effective sample size {"),
    ("\"Worth \"", "Effective sample size"),
    ("\"by nothing\"", "by no evidence"),
    ("It holds (it asks", "is supported"),
    ("scatter too far", "too heterogeneous to pool"),
];

#[test]
fn texts_use_standard_terms() {
    let mut found = Vec::new();
    let folder = root().join("crates");
    let sources = files_below(&folder).into_iter().filter(|path| {
        let name = shown(path);
        name.contains("/src/") && name.ends_with(".rs") && !name.ends_with("tests.rs")
    });
    for path in sources {
        let source = read(&path);
        let product = source.split("#[cfg(test)]").next().unwrap_or_default();
        for (number, line) in product.lines().enumerate() {
            let is_comment = line.trim_start().starts_with("//");
            for (phrase, instead) in NEVER {
                if !is_comment && line.contains(phrase) {
                    found.push(format!(
                        "{}:{}: `{phrase}`; write `{instead}`",
                        shown(&path),
                        number + 1
                    ));
                }
            }
        }
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
}
