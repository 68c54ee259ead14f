//! Everything that is built into the program, or used to test it, has a permissive licence.

use crate::support;

use support::metadata;

/// Licences that ask for no more than a notice. Copyleft licences are absent on purpose.
const PERMISSIVE: [&str; 14] = [
    "MIT",
    "MIT-0",
    "Apache-2.0",
    "BSD-2-Clause",
    "BSD-3-Clause",
    "ISC",
    "Zlib",
    "bzip2-1.0.6",
    "0BSD",
    "Unlicense",
    "CC0-1.0",
    "BSL-1.0",
    "Unicode-3.0",
    "Unicode-DFS-2016",
];

#[test]
fn every_package_can_be_used_under_a_permissive_licence() {
    let mut refused = Vec::new();
    let metadata = metadata();
    let built = metadata
        .resolve
        .as_ref()
        .expect("cargo resolved the packages");
    for node in &built.nodes {
        let package = &metadata[&node.id];
        let licence = package.license.as_deref().unwrap_or("(none stated)");
        if !is_permissive(licence) {
            refused.push(format!("{} {}: {licence}", package.name, package.version));
        }
    }
    assert!(
        built.nodes.len() > 20,
        "cargo metadata lists too few packages to be believed"
    );
    assert!(
        refused.is_empty(),
        "no permissive licence:\n{}",
        refused.join("\n")
    );
}

/// Whether an SPDX expression can be satisfied with permissive licences alone. `AND` binds more tightly than `OR`;
/// the old form `MIT/Apache-2.0` means `OR`; an exception (`WITH`) only ever permits more.
fn is_permissive(expression: &str) -> bool {
    let spaced = expression
        .replace('(', " ( ")
        .replace(')', " ) ")
        .replace('/', " OR ");
    let words: Vec<&str> = spaced.split_whitespace().collect();
    let (value, rest) = alternatives(&words);
    value && rest.is_empty()
}

fn alternatives<'a, 'b>(words: &'b [&'a str]) -> (bool, &'b [&'a str]) {
    let (mut value, mut rest) = conjunction(words);
    while rest.first() == Some(&"OR") {
        let (right, behind) = conjunction(&rest[1..]);
        value |= right;
        rest = behind;
    }
    (value, rest)
}

fn conjunction<'a, 'b>(words: &'b [&'a str]) -> (bool, &'b [&'a str]) {
    let (mut value, mut rest) = one(words);
    while rest.first() == Some(&"AND") {
        let (right, behind) = one(&rest[1..]);
        value &= right;
        rest = behind;
    }
    (value, rest)
}

fn one<'a, 'b>(words: &'b [&'a str]) -> (bool, &'b [&'a str]) {
    match words {
        ["(", inside @ ..] => {
            let (value, rest) = alternatives(inside);
            match rest {
                [")", behind @ ..] => (value, behind),
                _ => (false, rest),
            }
        }
        [name, "WITH", _, rest @ ..] | [name, rest @ ..] => (PERMISSIVE.contains(name), rest),
        [] => (false, words),
    }
}

#[test]
fn expressions_are_read_as_spdx_means_them() {
    for good in [
        "MIT",
        "MIT OR Apache-2.0",
        "MIT/Apache-2.0",
        "LGPL-3.0 OR MIT",
        "(MIT OR Apache-2.0) AND Unicode-3.0",
        "Apache-2.0 WITH LLVM-exception OR GPL-2.0",
    ] {
        assert!(is_permissive(good), "{good}");
    }
    for bad in [
        "GPL-3.0",
        "MIT AND LGPL-2.1",
        "(MIT OR Apache-2.0) AND MPL-2.0",
        "",
        "(MIT",
        "MIT Apache-2.0",
    ] {
        assert!(!is_permissive(bad), "{bad}");
    }
}
