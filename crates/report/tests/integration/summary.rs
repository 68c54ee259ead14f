//! The terminal's summary: fits its width, verdict first, plain unless colour
//! is asked for.

use crate::fixture;

use unicode_width::UnicodeWidthStr;

#[test]
fn every_line_fits_the_width() {
    for study in [fixture::study(), fixture::hostile(), fixture::empty()] {
        for width in [40, 57, 80, 100, 200] {
            for line in report::text(&study, width, false).lines() {
                assert!(
                    line.width() <= width,
                    "{} columns of {width}: {line}",
                    line.width()
                );
            }
        }
    }
}

#[test]
fn a_width_too_small_is_widened() {
    assert_eq!(
        report::text(&fixture::study(), 0, false),
        report::text(&fixture::study(), 40, false)
    );
}

#[test]
fn the_verdict_comes_first_and_names_its_symbol() {
    let text = report::text(&fixture::study(), 100, false);
    let verdict = text.find("✗ 1a  Not satisfied.").expect("verdict");
    assert!(verdict < text.find("Requirements by techniques").expect("matrix"));
    assert!(text.contains("✓ 1b  Satisfied."));
    assert!(text.contains("○ 8   Not covered."));
}

#[test]
fn fits_and_conflicts_are_said() {
    let text = report::text(&fixture::study(), 200, false);
    for part in [
        "A fit, 1a and 1b: E3 and E4",
        "Independent, 1a and 1b: E2",
        "(requirement model inaccuracy, score 5.3, still open)",
        "fixed in E5",
        "Not covered by any evidence",
    ] {
        assert!(text.contains(part), "missing: {part}");
    }
}

#[test]
fn without_colour_there_are_no_escapes_even_from_the_study() {
    let text = report::text(&fixture::hostile(), 80, false);
    assert!(text.chars().all(|c| c == '\n' || !c.is_control()));
}

#[test]
fn colour_changes_nothing_but_colour() {
    let study = fixture::hostile();
    let coloured = report::text(&study, 80, true);
    assert!(coloured.contains("\u{1b}[31;1m"));
    let mut plain = String::new();
    let mut rest = coloured.as_str();
    while let Some(start) = rest.find('\u{1b}') {
        plain.push_str(&rest[..start]);
        let end = rest[start..].find('m').expect("escape ends") + start;
        let code = &rest[start + 2..end];
        assert!(
            code.chars().all(|c| c.is_ascii_digit() || c == ';'),
            "{code}"
        );
        rest = &rest[end + 1..];
    }
    plain.push_str(rest);
    let trimmed: Vec<&str> = plain.lines().map(str::trim_end).collect();
    let expected = report::text(&study, 80, false);
    assert_eq!(trimmed, expected.lines().collect::<Vec<_>>());
}

#[test]
fn an_empty_study_says_so() {
    assert!(report::text(&fixture::empty(), 80, false).contains("no conclusion yet"));
}
