//! Trials that are alike where a table does not say that they belong together: by a session, a day, an operator, a batch,
//! a time stamp, or the order of the rows.
//!
//! # Definition
//! A cohort's first column says which trials belong together. Of every other column that nothing is counted by, rows with
//! the same text are a group; of times, rows without a pause between them (of more than `PAUSE` times the median) are a
//! session, or rows of one day where there is no such pause. For each column by which something is counted, each grouping
//! and the order of the rows are tested by permutation (`stats::grouping`). Of the tests of a table the strongest is
//! reported; a question counts all tests of the study (Bonferroni, `copies::trials`).
//!
//! # Assumes
//! Under the hypothesis the rows of each table are exchangeable: no column that groups them goes with a rate. Nothing of
//! how the tests depend on each other.
//!
//! # Guarantee
//! If the rows of all tables are exchangeable, anything at all is below [`super::super::copies::LIMIT`] in at most that
//! share of studies. A column that says under which conditions a row was made is a group, too: then its rows are not of
//! one rate. Not found: groups of one row each, and totals, which have no rows. Measured by `cargo run --release -p corroborate-stats
//! --example groups`.

use super::Cohort;
use super::repeated::{counted_columns, tables};
use diagnostic::Problem;
use evidence::Subject;
use stats::{Sample, alike_by_label, alike_in_order};
use std::collections::{BTreeMap, BTreeSet};
use study::Study;
use trace::Table;

/// By how many times the median a pause is longer that parts two sessions.
const PAUSE: f64 = 10.0;

/// What headers of numbers say when the numbers are names of groups.
const GROUPS: [&str; 14] = [
    "session", "day", "date", "operator", "batch", "block", "shift", "week", "site", "robot",
    "group", "lot", "round", "crew",
];

/// What headers of numbers say when the numbers are times.
const TIMES: [&str; 3] = ["time", "stamp", "clock"];

/// Rows of one table that are alike.
pub struct AlikeRows {
    /// The evidence.
    pub evidence: String,
    /// What was counted.
    pub subject: Subject,
    /// The table, relative to the study.
    pub path: String,
    /// Where its rows begin.
    pub line: u64,
    /// The column by which something was counted.
    pub counted: String,
    /// What forms the groups, in words.
    pub groups: String,
    /// The p-value by itself.
    pub p_value: f64,
}

/// The strongest of each table, if anything can be tested, and how many tests there were.
pub fn alike_rows(study: &Study) -> Result<(Vec<AlikeRows>, u64), Problem> {
    let headers = counted_columns(study);
    let mut found: Vec<AlikeRows> = Vec::new();
    let mut tests = 0;
    for told in tables(study)? {
        let cohort = Cohort::new(study, told.table.clone())?;
        let groupings = groupings(&told.table, &headers);
        let line = told.table.columns().next().map_or(0, |it| it.line(0));
        let mut strongest: Option<AlikeRows> = None;
        let counted = counted_by(study).into_iter();
        let here = counted.filter(|(_, binding)| !cohort.left_to_others.contains(*binding));
        for (subject, binding) in here {
            let rows = cohort.counts(binding)?;
            for (groups, p_value) in tested(&rows, &groupings) {
                tests += 1;
                if strongest.as_ref().is_none_or(|it| p_value < it.p_value) {
                    strongest = Some(AlikeRows {
                        evidence: told.evidence.clone(),
                        subject: subject.clone(),
                        path: told.path.clone(),
                        line,
                        counted: binding.to_owned(),
                        groups,
                        p_value,
                    });
                }
            }
        }
        found.extend(strongest);
    }
    Ok((found, tests))
}

/// Each binding once, with the first subject that is counted by it.
fn counted_by(study: &Study) -> Vec<(&Subject, &str)> {
    let mut found: Vec<(&Subject, &str)> = Vec::new();
    for form in &study.forms.subjects {
        let proposition = form.experiment.as_ref();
        let proposition = proposition.and_then(|it| study.vocabulary.propositions.get(it));
        let Some(binding) = proposition.and_then(|it| it.column.as_ref()) else {
            continue;
        };
        if !found.iter().any(|(_, known)| *known == binding.text) {
            found.push((&form.subject, &binding.text));
        }
    }
    found
}

fn tested(rows: &[Sample], groupings: &[(String, Vec<usize>)]) -> Vec<(String, f64)> {
    let by_label = groupings
        .iter()
        .filter_map(|(groups, labels)| Some((groups.clone(), alike_by_label(rows, labels)?)));
    let in_order = alike_in_order(rows).map(|p| ("neighbouring rows".to_owned(), p));
    by_label.chain(in_order).collect()
}

/// The groupings that a table's columns form, in words and as labels.
fn groupings(table: &Table, counted: &BTreeSet<&str>) -> Vec<(String, Vec<usize>)> {
    let mut found: Vec<(String, Vec<usize>)> = Vec::new();
    for column in table.columns().skip(1) {
        let header = column.header();
        if header == "attempts" || counted.contains(header) {
            continue;
        }
        let cells = column.as_texts();
        let says = |words: &[&str]| {
            let header = header.to_lowercase();
            words.iter().any(|word| header.contains(word))
        };
        let times: Option<Vec<f64>> = cells.iter().map(|cell| seconds(cell)).collect();
        let numbers = column.as_numbers().ok();
        let grouping = match (times, numbers) {
            (Some(times), _) => match sessions(&times) {
                Some(labels) => (format!("rows of one session by `{header}`"), labels),
                None => {
                    let day = |secs: &f64| ((secs / 86_400.0).floor() as i64).to_string();
                    let days: Vec<String> = times.iter().map(day).collect();
                    (format!("rows of one day by `{header}`"), labels(&days))
                }
            },
            (None, Some(numbers)) if says(&TIMES) => match sessions(&numbers) {
                Some(labels) => (format!("rows of one session by `{header}`"), labels),
                None => continue,
            },
            (None, Some(_)) if !says(&GROUPS) => continue,
            _ => (format!("rows with the same `{header}`"), labels(&cells)),
        };
        // A column that groups as another does is the same question.
        if !found.iter().any(|(_, known)| *known == grouping.1) {
            found.push(grouping);
        }
    }
    found
}

/// A number for each text, in the order in which they are met.
pub(in crate::technique) fn labels<'c, T: AsRef<str>>(cells: &'c [T]) -> Vec<usize> {
    let mut known: BTreeMap<&str, usize> = BTreeMap::new();
    let label = |cell: &'c T| {
        let next = known.len();
        *known.entry(cell.as_ref()).or_insert(next)
    };
    cells.iter().map(label).collect()
}

/// The sessions that pauses part, of times in any unit; `None` where there is no pause, or nothing but pauses.
pub(in crate::technique) fn sessions(times: &[f64]) -> Option<Vec<usize>> {
    let mut order: Vec<usize> = (0..times.len()).collect();
    order.sort_by(|a, b| times[*a].total_cmp(&times[*b]));
    let gaps: Vec<f64> = order
        .windows(2)
        .map(|pair| times[pair[1]] - times[pair[0]])
        .collect();
    let mut sorted: Vec<f64> = gaps.iter().copied().filter(|gap| *gap > 0.0).collect();
    sorted.sort_by(f64::total_cmp);
    let median = *sorted.get(sorted.len() / 2)?;
    let mut labels = vec![0; times.len()];
    let mut session = 0;
    for (gap, place) in gaps.iter().zip(&order[1..]) {
        session += usize::from(*gap > PAUSE * median);
        labels[*place] = session;
    }
    (session > 0).then_some(labels)
}

/// Seconds since the beginning of the year 1970 of a time in the form of ISO 8601, without regard to its zone.
fn seconds(cell: &str) -> Option<f64> {
    let cell = cell.trim();
    let (date, time) = match cell.find(['T', ' ']) {
        Some(at) => (&cell[..at], Some(&cell[at + 1..])),
        None => (cell, None),
    };
    let mut parts = date.split('-');
    let (year, month, day) = (parts.next()?, parts.next()?, parts.next()?);
    if parts.next().is_some() || year.len() != 4 {
        return None;
    }
    let (year, month, day): (i64, i64, i64) =
        (year.parse().ok()?, month.parse().ok()?, day.parse().ok()?);
    if !(1..=12).contains(&month) || !(1..=31).contains(&day) {
        return None;
    }
    // Days of the civil calendar, counted from March (H. Hinnant, "chrono-compatible low-level date algorithms").
    let from_march = (month + 9) % 12;
    let year = year - i64::from(month <= 2);
    let era = year.div_euclid(400);
    let of_era = year.rem_euclid(400);
    let of_year = (153 * from_march + 2) / 5 + day - 1;
    let days = era * 146_097 + of_era * 365 + of_era / 4 - of_era / 100 + of_year - 719_468;
    let of_day = match time {
        Some(time) => seconds_of_day(time)?,
        None => 0.0,
    };
    Some(days as f64 * 86_400.0 + of_day)
}

fn seconds_of_day(time: &str) -> Option<f64> {
    let clock = time.trim_end_matches('Z').split('+').next()?;
    let mut parts = clock.split(':');
    let hours: f64 = parts.next()?.parse().ok()?;
    let minutes: f64 = parts.next()?.parse().ok()?;
    let seconds: f64 = parts.next().map_or(Some(0.0), |it| it.parse().ok())?;
    Some(3600.0 * hours + 60.0 * minutes + seconds)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_read_in_the_form_of_the_standard_and_part_into_sessions() {
        assert_eq!(seconds("1970-01-02"), Some(86_400.0));
        assert_eq!(seconds("2000-03-01T00:00:01Z"), Some(951_868_801.0));
        assert_eq!(seconds("2024-02-29 12:30"), Some(1_709_209_800.0));
        for other in ["7", "p3", "2024-13-01", "12:30", ""] {
            assert_eq!(seconds(other), None, "{other}");
        }
        // Two sessions, whatever the order of the rows.
        let times = [0.0, 1000.0, 1.0, 1001.0, 2.0, 1002.5];
        assert_eq!(sessions(&times), Some(vec![0, 1, 0, 1, 0, 1]));
        assert_eq!(sessions(&[0.0, 1.0, 2.0, 3.5]), None);
        assert_eq!(sessions(&[5.0, 5.0]), None);
    }

    #[test]
    fn texts_and_named_numbers_form_groups_and_measurements_do_not() {
        let text = "person,attempts,successes,operator,day,height_cm,started\n\
                    a,4,3,kim,1,170.5,2024-05-01T09:00\nb,4,4,lee,1,181,2024-05-01T09:05\n\
                    c,4,2,kim,2,165,2024-05-02T09:00\nd,4,2,lee,2,177,2024-05-02T09:05\n";
        let table = Table::parse("t.csv", text).expect("a table");
        let found = groupings(&table, &BTreeSet::from(["successes"]));
        let words: Vec<&str> = found.iter().map(|(words, _)| words.as_str()).collect();
        // The sessions of the times are the days.
        assert_eq!(
            words,
            ["rows with the same `operator`", "rows with the same `day`"]
        );
        assert_eq!(found[0].1, [0, 1, 0, 1]);
        assert_eq!(found[1].1, [0, 0, 1, 1]);
    }
}
