//! Names of parts: whatever a study's files are called, a part's name is a relative path that is safe to unpack anywhere.
//!
//! # Definition
//! A path is taken component by component. Letters, digits, spaces and `-_.+=@,()[]&'~#!` of ASCII stay; every other byte is
//! written `%XX`: control characters, what Windows or Markdown would take for something else, and letters beyond ASCII, which not
//! every `unzip` writes alike. So are a space at either end of a component,
//! the first byte of a component that would mean something to a program (`.`, `..`, a leading `-`, a device of Windows such
//! as `NUL`) and a final dot. A component that is longer than 180 bytes ends in a hash of itself.
//!
//! Guarantee: no name leads out of the folder in which it is unpacked, none has a line break, a backslash, a quotation mark `"`, a `$` or
//! a backquote, none is taken for an option, and two different paths
//! have different names (up to a collision of SHA-256 for long components).

use sha2::{Digest, Sha256};

/// Components up to this length are written in full.
const LONGEST: usize = 180;
/// What is kept of a longer one.
const KEPT: usize = 120;
/// Names that Windows gives to devices, whatever follows a dot.
const DEVICES: [&str; 4] = ["con", "prn", "aux", "nul"];

/// A path as a part's name. A leading `/` counts as a component.
pub fn encoded(path: &str) -> String {
    let absolute = path.starts_with('/').then(|| "%2F".to_owned());
    let components = path.split('/').filter(|it| !it.is_empty()).map(component);
    let all: Vec<String> = absolute.into_iter().chain(components).collect();
    all.join("/")
}

fn component(text: &str) -> String {
    let first = is_special(text);
    let last = text.len() - 1;
    let mut name = String::new();
    for (at, byte) in text.bytes().enumerate() {
        let is_trimmed = at == last && byte == b'.' || (at == last || at == 0) && byte == b' ';
        match is_plain(byte) && !(at == 0 && first) && !is_trimmed {
            true => name.push(char::from(byte)),
            false => name.push_str(&format!("%{byte:02X}")),
        }
    }
    if name.len() <= LONGEST {
        return name;
    }
    let hash = crate::hex(&Sha256::digest(text.as_bytes())[..16]);
    // Not within `%XX`.
    let kept = name[..KEPT].rfind('%').filter(|at| at + 3 > KEPT);
    format!("{}-{hash}", &name[..kept.unwrap_or(KEPT)])
}

fn is_plain(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || b"-_.+=@, ()[]&'~#!".contains(&byte)
}

/// Whether a component means something by its beginning.
fn is_special(text: &str) -> bool {
    let stem = text.split('.').next().unwrap_or_default().to_lowercase();
    let is_port = |port: &str| {
        let number = stem.strip_prefix(port);
        number.is_some_and(|it| it.len() == 1 && it.bytes().all(|c| c.is_ascii_digit()))
    };
    text.bytes().all(|byte| byte == b'.')
        || text.starts_with('-')
        || DEVICES.contains(&stem.as_str())
        || is_port("com")
        || is_port("lpt")
}

/// Whether a name is one that [`encoded`] could have given.
pub(crate) fn is_safe(name: &str) -> bool {
    let is_escaped = |part: &str| {
        let mut rest = part;
        while let Some(at) = rest.find('%') {
            let digits = rest.get(at + 1..at + 3);
            let upper = |c: u8| c.is_ascii_digit() || (b'A'..=b'F').contains(&c);
            if !digits.is_some_and(|it| it.bytes().all(upper)) {
                return false;
            }
            rest = &rest[at + 3..];
        }
        true
    };
    let is_component = |part: &str| {
        !part.is_empty()
            && part.len() <= LONGEST
            && part.bytes().all(|byte| is_plain(byte) || byte == b'%')
            && !is_special(part)
            && !part.ends_with('.')
            && part.trim_matches(' ') == part
            && is_escaped(part)
    };
    !name.is_empty() && name.split('/').all(is_component)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hostile_paths_stay_in_the_folder() {
        for (path, name) in [
            ("models/a.prism", "models/a.prism"),
            ("../../etc/passwd", "%2E%2E/%2E%2E/etc/passwd"),
            ("/etc/passwd", "%2F/etc/passwd"),
            ("a\\..\\b", "a%5C..%5Cb"),
            ("a b\n\u{1b}[2J", "a b%0A%1B[2J"),
            (" a (1) ", "%20a (1)%20"),
            ("$(x) `y`;\"z\"", "%24(x) %60y%60%3B%22z%22"),
            ("-rf/NUL.txt/com7", "%2Drf/%4EUL.txt/%63om7"),
            ("Pr\u{fc}fung.csv", "Pr%C3%BCfung.csv"),
            ("C:/x.", "C%3A/x%2E"),
            ("%2E./x", "%252E%2E/x"),
            ("./a//b", "%2E/a/b"),
        ] {
            assert_eq!(encoded(path), name);
            assert!(is_safe(name), "{name}");
        }
        let (long, other) = ("\u{fc}".repeat(300), "\u{fc}".repeat(301));
        assert!(is_safe(&encoded(&long)), "{}", encoded(&long));
        assert_ne!(encoded(&long), encoded(&other));
    }

    #[test]
    fn names_that_no_pack_has_are_told_apart() {
        for name in [
            "", "/", "a/", "/a", "../a", "a/./b", " a", "a ", "a\\b", "%2e", "%2", "NUL", "-x",
            "a.", "\u{fc}",
        ] {
            assert!(!is_safe(name), "{name}");
        }
    }
}
