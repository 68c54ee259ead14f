//! The style: text can be read in both themes, and only the page's own script
//! may run.

use crate::fixture;

use sha2::{Digest, Sha256};

const STYLE: &str = include_str!("../../src/style.css");

/// The colours of the first rule whose text begins at `start`, by name.
fn colours(start: &str) -> Vec<(String, [f64; 3])> {
    let from = STYLE
        .find(start)
        .unwrap_or_else(|| panic!("no rule {start}"));
    let rule = &STYLE[from..from + STYLE[from..].find('}').expect("the rule ends")];
    let parse = |declaration: &str| {
        let (name, value) = declaration.trim().rsplit('{').next()?.split_once(':')?;
        let hex = value.trim().strip_prefix('#').filter(|h| h.len() == 6)?;
        let channel = |i: usize| u8::from_str_radix(&hex[i..i + 2], 16).ok().map(f64::from);
        Some((
            name.trim().to_owned(),
            [channel(0)?, channel(2)?, channel(4)?],
        ))
    };
    rule.split(';').filter_map(parse).collect()
}

/// Relative luminance (Web Content Accessibility Guidelines 2.1).
fn luminance(colour: [f64; 3]) -> f64 {
    let linear = colour.map(|c| {
        let c = c / 255.0;
        if c <= 0.04045 {
            c / 12.92
        } else {
            ((c + 0.055) / 1.055).powf(2.4)
        }
    });
    0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]
}

fn contrast(a: [f64; 3], b: [f64; 3]) -> f64 {
    let (a, b) = (luminance(a), luminance(b));
    (a.max(b) + 0.05) / (a.min(b) + 0.05)
}

#[test]
fn text_has_contrast_aa_in_both_themes() {
    for theme in [
        ":root {",
        ":root:not([data-theme=\"light\"]) {",
        ":root[data-theme=\"dark\"] {",
    ] {
        let colours = colours(theme);
        let named = |name: &str| {
            let found = colours.iter().find(|(n, _)| n == name);
            found.unwrap_or_else(|| panic!("{theme} has no {name}")).1
        };
        for text in [
            "--ink", "--soft", "--accent", "--good", "--bad", "--open", "--none",
        ] {
            for ground in ["--paper", "--raised"] {
                let ratio = contrast(named(text), named(ground));
                assert!(ratio >= 4.5, "{theme} {text} on {ground}: {ratio:.2}");
            }
        }
        for tone in ["--good", "--bad", "--open"] {
            let (text, paper) = (named(tone), named("--paper"));
            let tinted = std::array::from_fn(|i| 0.15 * text[i] + 0.85 * paper[i]);
            let ratio = contrast(text, tinted);
            assert!(ratio >= 4.5, "{theme} {tone} on its tint: {ratio:.2}");
        }
    }
}

#[test]
fn both_ways_to_the_dark_theme_have_the_same_colours() {
    assert_eq!(
        colours(":root:not([data-theme=\"light\"]) {"),
        colours(":root[data-theme=\"dark\"] {")
    );
}

fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::new();
    for chunk in bytes.chunks(3) {
        let bits =
            chunk.iter().fold(0u32, |bits, b| bits << 8 | u32::from(*b)) << (8 * (3 - chunk.len()));
        for place in 0..4 {
            let digit = DIGITS[(bits >> (18 - 6 * place) & 63) as usize];
            text.push(if place > chunk.len() {
                '='
            } else {
                digit as char
            });
        }
    }
    text
}

#[test]
fn the_policy_admits_the_pages_script_and_no_other() {
    let page = report::html(&fixture::study());
    let start = page.find("<script>").expect("script") + "<script>".len();
    let script = &page[start..start + page[start..].find("</script>").expect("script ends")];
    let expected = format!("script-src 'sha256-{}'", base64(&Sha256::digest(script)));
    assert!(
        page.contains(&expected),
        "page.rs: SCRIPT_HASH must give {expected}"
    );
}
