//! Unified diffs of texts, line by line.
//!
//! # Definition
//! The longest common subsequence of the lines between the common beginning and
//! the common end (Wagner and Fischer 1974), in hunks with three lines around,
//! in the form of `diff -u`. Cost: product of the two middles' lengths; a
//! middle of more than 4 million pairs is shown as replaced.
//!
//! # Assumes
//! Nothing of the data.
//!
//! # Guarantee
//! `patch` makes the new text of the old one; of middles that are compared no diff has fewer changed lines.

use std::fmt::Write;

const AROUND: usize = 3;

/// The most pairs of lines that are compared.
const LARGEST: usize = 4_000_000;

#[derive(Clone, Copy, PartialEq)]
enum Line {
    Both,
    Old,
    New,
}

/// The diff of two texts under their names; empty if they are the same. A new
/// file has no old text.
pub fn unified(old_name: &str, new_name: &str, old: &str, new: &str) -> String {
    if old == new {
        return String::new();
    }
    let (before, after): (Vec<&str>, Vec<&str>) = (old.lines().collect(), new.lines().collect());
    let script = script(&before, &after);
    let mut text = format!("--- {old_name}\n+++ {new_name}\n");
    let mut at = 0;
    while let Some((from, to)) = next_hunk(&script, at) {
        write_hunk(&mut text, &script, from..to, &before, &after);
        at = to;
    }
    text
}

/// What happens to each line, in the order of both texts.
fn script(old: &[&str], new: &[&str]) -> Vec<Line> {
    let start = old.iter().zip(new).take_while(|(a, b)| a == b).count();
    let (old_rest, new_rest) = (&old[start..], &new[start..]);
    let pairs = old_rest.iter().rev().zip(new_rest.iter().rev());
    let end = pairs.take_while(|(a, b)| a == b).count();
    let middle = between(
        &old_rest[..old_rest.len() - end],
        &new_rest[..new_rest.len() - end],
    );
    let mut all = vec![Line::Both; start];
    all.extend(middle);
    all.extend(std::iter::repeat_n(Line::Both, end));
    all
}

fn between(old: &[&str], new: &[&str]) -> Vec<Line> {
    let (rows, columns) = (old.len(), new.len());
    if rows.saturating_mul(columns) > LARGEST {
        let mut all = vec![Line::Old; rows];
        all.extend(std::iter::repeat_n(Line::New, columns));
        return all;
    }
    let mut common = vec![vec![0_u32; columns + 1]; rows + 1];
    for i in (0..rows).rev() {
        for j in (0..columns).rev() {
            common[i][j] = match old[i] == new[j] {
                true => common[i + 1][j + 1] + 1,
                false => common[i + 1][j].max(common[i][j + 1]),
            };
        }
    }
    let (mut i, mut j) = (0, 0);
    let mut all = Vec::new();
    while i < rows || j < columns {
        if i < rows && j < columns && old[i] == new[j] {
            all.push(Line::Both);
            (i, j) = (i + 1, j + 1);
        } else if i < rows && (j == columns || common[i + 1][j] >= common[i][j + 1]) {
            all.push(Line::Old);
            i += 1;
        } else {
            all.push(Line::New);
            j += 1;
        }
    }
    all
}

/// The next run of changes with what is around it, at or behind `at`.
fn next_hunk(script: &[Line], at: usize) -> Option<(usize, usize)> {
    let first = at + script[at..].iter().position(|line| *line != Line::Both)?;
    let mut last = first;
    for (place, line) in script.iter().enumerate().skip(first) {
        if *line != Line::Both {
            last = place;
        } else if place - last > 2 * AROUND {
            break;
        }
    }
    let to = (last + 1 + AROUND).min(script.len());
    Some((first.saturating_sub(AROUND).max(at), to))
}

fn write_hunk(
    text: &mut String,
    script: &[Line],
    hunk: std::ops::Range<usize>,
    old: &[&str],
    new: &[&str],
) {
    let of = |part: &[Line], without: Line| part.iter().filter(|l| **l != without).count();
    let (mut i, mut j) = (
        of(&script[..hunk.start], Line::New),
        of(&script[..hunk.start], Line::Old),
    );
    let body = &script[hunk];
    let range = |start: usize, count: usize| match count {
        0 => format!("{start},0"),
        count => format!("{},{count}", start + 1),
    };
    let (old_range, new_range) = (range(i, of(body, Line::New)), range(j, of(body, Line::Old)));
    // Writing to a string cannot fail.
    let _ = writeln!(text, "@@ -{old_range} +{new_range} @@");
    for line in body {
        let _ = match line {
            Line::Both => writeln!(text, " {}", old[i]),
            Line::Old => writeln!(text, "-{}", old[i]),
            Line::New => writeln!(text, "+{}", new[j]),
        };
        i += usize::from(*line != Line::New);
        j += usize::from(*line != Line::Old);
    }
}

#[cfg(test)]
mod tests {
    use super::unified;

    #[test]
    fn changed_lines_stand_between_three_others() {
        let old = "1\n2\n3\n4\n5\n6\n7\n8\n9\n10\n11\n12\n13\n14\n";
        let new = old.replace("5\n", "five\n").replace("13\n", "13\nand\n");
        let shown = unified("a", "b", old, &new);
        assert_eq!(
            shown,
            "--- a\n+++ b\n@@ -2,7 +2,7 @@\n 2\n 3\n 4\n-5\n+five\n 6\n 7\n 8\n\
             @@ -11,4 +11,5 @@\n 11\n 12\n 13\n+and\n 14\n"
        );
        assert_eq!(unified("a", "b", old, old), "");
    }

    #[test]
    fn a_new_text_is_all_plus() {
        assert_eq!(
            unified("/dev/null", "b", "", "x\n"),
            "--- /dev/null\n+++ b\n@@ -0,0 +1,1 @@\n+x\n"
        );
    }
}
