//! Recordings that are alike where nothing says that they belong together: of one folder, of one session, or one after the
//! other.
//!
//! # Definition
//! Each recording is a trial with the verdicts of the study's monitors. Recordings of one folder are a group, where there
//! are several folders. By the times at which they begin, recordings without a pause between them
//! (`experiment::groups`) are a session, or recordings of one day where there is no such pause; times before the year
//! 1980 tell nothing but an order, since many recorders begin at 0. For each requirement and failure mode each grouping,
//! and the order of the times, are tested by permutation (`stats::grouping`) over the recordings that have a verdict.
//!
//! # Assumes
//! Under the hypothesis recordings with a verdict are exchangeable. The times at which they begin put them in order.
//!
//! # Guarantee
//! If the recordings are exchangeable, each p-value is at most `a` with a probability of at most `a`. The strongest is kept
//! with the number of tests, so that a question allows for all of them (`copies::trials`). Not found: groups of one
//! recording each.

use super::experiment::groups::{labels, sessions};
use evidence::{AlikeTrials, Subject};
use stats::{Sample, alike_by_label, alike_in_order};
use temporal::monitor::Verdict;

/// The first second, since 1970, that a clock which knows the date shows.
const FIRST_DATE: f64 = 315_532_800.0;

/// One recording.
pub(super) struct Recorded<'r> {
    /// Its path within the folder, with `/`.
    pub name: &'r str,
    /// When it begins, in seconds since 1970 as far as its clock knows.
    pub begins: Option<f64>,
    /// The same subjects in the same order for all recordings.
    pub verdicts: Vec<(&'r Subject, Verdict)>,
}

/// The strongest of all tests; `None` where nothing can be told.
pub(super) fn alike(recorded: &[Recorded<'_>]) -> Option<AlikeTrials> {
    let mut in_order: Vec<&Recorded<'_>> = recorded.iter().collect();
    let timed = recorded.iter().all(|it| it.begins.is_some());
    if timed {
        in_order.sort_by(|a, b| a.begins.unwrap_or(0.0).total_cmp(&b.begins.unwrap_or(0.0)));
    }
    let groupings = groupings(&in_order);
    let mut strongest: Option<AlikeTrials> = None;
    let mut tests = 0;
    for (place, (subject, _)) in recorded.first()?.verdicts.iter().enumerate() {
        let rows = rows_of(&in_order, place);
        for (groups, p_value) in tested(&rows, &groupings, timed) {
            tests += 1;
            if strongest.as_ref().is_none_or(|it| p_value < it.p_value) {
                strongest = Some(AlikeTrials {
                    subject: (*subject).clone(),
                    groups,
                    p_value,
                    tests: 0,
                });
            }
        }
    }
    strongest.map(|it| AlikeTrials { tests, ..it })
}

/// The recordings with a verdict on one subject, by their places: 1 of 1 where it is kept, 0 of 1 where not.
fn rows_of(recorded: &[&Recorded<'_>], subject: usize) -> Vec<(usize, Sample)> {
    let row = |(at, it): (usize, &&Recorded<'_>)| {
        let successes = match it.verdicts.get(subject)?.1 {
            Verdict::Satisfied => 1,
            Verdict::Violated => 0,
            Verdict::Inconclusive | Verdict::NotCovered => return None,
        };
        let trials = 1;
        Some((at, Sample { successes, trials }))
    };
    recorded.iter().enumerate().filter_map(row).collect()
}

fn tested(
    rows: &[(usize, Sample)],
    groupings: &[(String, Vec<usize>)],
    timed: bool,
) -> Vec<(String, f64)> {
    let samples: Vec<Sample> = rows.iter().map(|(_, sample)| *sample).collect();
    let by_label = groupings.iter().filter_map(|(groups, all)| {
        let of_rows: Vec<usize> = rows
            .iter()
            .filter_map(|(at, _)| all.get(*at).copied())
            .collect();
        Some((groups.clone(), alike_by_label(&samples, &of_rows)?))
    });
    let neighbours = timed.then(|| alike_in_order(&samples)).flatten();
    let neighbours = neighbours.map(|p| ("recordings that follow each other".to_owned(), p));
    by_label.chain(neighbours).collect()
}

fn groupings(recorded: &[&Recorded<'_>]) -> Vec<(String, Vec<usize>)> {
    let folders: Vec<&str> = recorded
        .iter()
        .map(|it| it.name.rsplit_once('/').map_or("", |(folder, _)| folder))
        .collect();
    let mut found = vec![("recordings of one folder".to_owned(), labels(&folders))];
    let times: Option<Vec<f64>> = recorded
        .iter()
        .map(|it| it.begins.filter(|secs| *secs >= FIRST_DATE))
        .collect();
    let by_time = times.map(|times| match sessions(&times) {
        Some(labels) => ("recordings of one session".to_owned(), labels),
        None => {
            let day = |secs: &f64| ((secs / 86_400.0).floor() as i64).to_string();
            let days: Vec<String> = times.iter().map(day).collect();
            ("recordings of one day".to_owned(), labels(&days))
        }
    });
    // A folder for each session is one question, not two.
    found.extend(by_time.filter(|(_, of_time)| *of_time != found[0].1));
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    const DAY: f64 = 86_400.0;

    fn strongest(recordings: &[(&str, Option<f64>, Verdict)]) -> Option<AlikeTrials> {
        let subject = Subject::Requirement("1".into());
        let recorded = recordings.iter().map(|(name, begins, verdict)| Recorded {
            name,
            begins: *begins,
            verdicts: vec![(&subject, *verdict)],
        });
        alike(&recorded.collect::<Vec<_>>())
    }

    /// Forty recordings of four days; on the second day nearly all fail.
    fn four_days(
        folder: impl Fn(usize) -> &'static str,
    ) -> Vec<(&'static str, Option<f64>, Verdict)> {
        let one = |at: usize| {
            let fails = at / 10 == 1 && at != 13 || at == 27;
            let verdict = match fails {
                true => Verdict::Violated,
                false => Verdict::Satisfied,
            };
            let begins = 1.7e9 + (at / 10) as f64 * DAY + (at % 10) as f64 * 120.0;
            (folder(at), Some(begins), verdict)
        };
        (0..40).map(one).collect()
    }

    #[test]
    fn recordings_of_one_session_that_fail_together_are_found() {
        let found = strongest(&four_days(|_| "a.csv")).expect("tests");
        assert_eq!(found.groups, "recordings of one session");
        assert!(found.p_value < 1e-3, "{found:?}");
        // By session, and in their order.
        assert_eq!(found.tests, 2);
    }

    #[test]
    fn folders_that_are_the_sessions_are_asked_about_once() {
        let of_day = ["mon/a.csv", "tue/a.csv", "wed/a.csv", "thu/a.csv"];
        let found = strongest(&four_days(|at| of_day[at / 10])).expect("tests");
        assert_eq!(found.groups, "recordings of one folder");
        assert_eq!(found.tests, 2);
    }

    #[test]
    fn failures_without_a_pattern_are_not_accused_and_clocks_at_zero_are_no_dates() {
        let mixed = four_days(|_| "a.csv").into_iter().enumerate();
        let mixed: Vec<_> = mixed
            .map(|(at, (name, _, _))| {
                let verdict = match [3, 8, 14, 22, 25, 31, 39].contains(&at) {
                    true => Verdict::Violated,
                    false => Verdict::Satisfied,
                };
                (name, Some(0.5), verdict)
            })
            .collect();
        let found = strongest(&mixed).expect("a test");
        assert_eq!(found.tests, 1, "{found:?}");
        assert!(found.p_value > 0.05, "{found:?}");
    }

    #[test]
    fn what_has_no_verdict_is_no_trial() {
        let all = four_days(|_| "a.csv").into_iter();
        let open: Vec<_> = all
            .map(|(name, begins, _)| (name, begins, Verdict::Inconclusive))
            .collect();
        assert_eq!(strongest(&open), None);
    }
}
