//! Every "at least", "below", "open", "conflicts", "corroborates", limit and effective sample size on the page against the
//! data beside it, in studies that are drawn: nothing in them is chosen to fit.

use crate::markup;
use crate::support::{Uniform, any_study};

use evidence::*;
use report::assurance::{self, Kind};
use std::collections::BTreeSet;

/// Studies that are drawn.
const STUDIES: u64 = 32;

/// The result of a drawn study, as a run makes it.
fn drawn(seed: u64) -> StudyResult {
    let mut uniform = Uniform(1000 + seed);
    let (evidence, requirements) = any_study(&mut uniform);
    let looks = uniform.chance(0.5).then(|| Looks {
        looks: vec![Look::of(&evidence)],
    });
    let influences = Influences::learn(&evidence);
    let study = Study {
        requirements: &requirements,
        failure_modes: &[],
        evidence: &evidence,
        influences: &influences,
        looks: looks.as_ref(),
        levels: Levels::new(0.95, 0.95).expect("levels"),
    };
    let costs = TrialCosts::default();
    let mut comparisons = compare(&study);
    let undecided = undecided(&study, &mut comparisons, &costs);
    let mut conclusions = conclude(&study, &comparisons);
    bear_clustering(&study, &mut comparisons, &mut conclusions);
    let pairs = (comparisons.as_slice(), undecided);
    let synthesis = synthesise(&study, pairs, &conclusions, costs, &Weights::default());
    let gaps = coverage_gaps(&study);
    StudyResult {
        format: "1.0".into(),
        title: "A drawn study".into(),
        summary: String::new(),
        confidence: 0.95,
        comparisons,
        conclusions,
        synthesis,
        suspects: vec![],
        diagnosis: None,
        disagreement: None,
        exploration: None,
        calibration: None,
        gaps,
        published: vec![],
        costs: vec![],
        produced_by: "test".into(),
        requirements,
        failure_modes: vec![],
        evidence,
    }
}

fn plain(html: &str) -> String {
    markup::text(html).replace('\u{a0}', " ")
}

/// What stands between two texts of the page.
fn between<'p>(page: &'p str, start: &str, end: &str) -> &'p str {
    let from = page.find(start).unwrap_or_else(|| panic!("no {start}"));
    let rest = &page[from + start.len()..];
    &rest[..rest.find(end).unwrap_or(rest.len())]
}

/// The parts of a text that begin with a mark.
fn parts<'p>(text: &'p str, mark: &str) -> Vec<&'p str> {
    text.split(mark).skip(1).collect()
}

/// The word that the matrix has for a standing.
fn word(requirement: &Requirement, standing: Standing) -> Option<String> {
    let threshold = requirement.threshold?;
    let level = format!("{} %", (threshold.value * 1e6).round() / 1e4);
    Some(match (standing, threshold.direction) {
        (Standing::Supports, Direction::AtLeast) => format!("✓ at least {level}"),
        (Standing::Supports, Direction::AtMost) => format!("✓ at most {level}"),
        (Standing::Denies, Direction::AtLeast) => format!("✗ below {level}"),
        (Standing::Denies, Direction::AtMost) => format!("✗ above {level}"),
        (Standing::Neither, _) => format!("? open at {level}"),
    })
}

/// Each cell of the matrix has the word, the figures and the runs of the conclusion, and no other word.
fn check_matrix(study: &StudyResult, page: &str) {
    let matrix = between(page, "<section id=\"matrix\"", "</section>");
    let body = between(matrix, "<tbody", "</tbody>");
    let rows = parts(body, "<tr role=\"row\">");
    assert_eq!(rows.len(), study.requirements.len());
    for ((requirement, conclusion), row) in
        study.requirements.iter().zip(&study.conclusions).zip(rows)
    {
        let entries = parts(row, "<div class=\"entry\">");
        let of_cell = |entry: &str| plain(entry.split("</td>").next().unwrap_or(entry));
        let entries: Vec<String> = entries.into_iter().map(of_cell).collect();
        for standing in &conclusion.standings {
            if standing.step == Step::Corroborated {
                continue;
            }
            let words = plain_words(&standing.words);
            let of = |entry: &&String| entry.contains(&words);
            let cell = entries.iter().find(of);
            if !conclusion.rests_on.contains(&standing.evidence) {
                // Neither for nor against, where it is shown at all.
                assert!(cell.is_none(), "{words}");
                continue;
            }
            let cell = cell.unwrap_or_else(|| panic!("no cell has {words} of {entries:?}"));
            if let Some(word) = word(requirement, standing.standing) {
                assert!(cell.contains(&word), "{word} is not in {cell}");
            }
            assert!(
                cell.contains(&standing.condition),
                "{} {cell}",
                standing.condition
            );
            assert!(!cell.contains("spans"), "{cell}");
        }
        check_apart(conclusion, &entries);
        let verdict = plain(row);
        assert!(verdict.contains(said(conclusion.verdict)), "{verdict}");
    }
}

/// A number that takes no part has no mark for or against.
fn check_apart(conclusion: &Conclusion, entries: &[String]) {
    for excluded in &conclusion.excluded {
        let words = plain_words(&excluded.words);
        for entry in entries.iter().filter(|entry| entry.contains(&words)) {
            assert!(!entry.contains(['✓', '✗']), "{entry}");
            assert!(entry.starts_with("· takes no part"), "{entry}");
        }
    }
}

fn plain_words(text: &str) -> String {
    text.replace('\u{a0}', " ")
}

fn said(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Satisfied => "✓ satisfied",
        Verdict::Violated => "✗ not satisfied",
        Verdict::Undecided => "? undecided",
        Verdict::Conflicting => "≠ conflicting evidence",
        Verdict::NotCovered => "○ not covered",
    }
}

/// A verdict stands with its statement, the runs of each figure and all that it leaves out, and it has a reason.
fn check_verdicts(study: &StudyResult, page: &str, summary: &str) {
    let section = between(page, "<section id=\"verdict\"", "</section>");
    let items = parts(section, "<li class=\"conclusion");
    assert_eq!(items.len(), study.conclusions.len());
    for (conclusion, item) in study.conclusions.iter().zip(items) {
        let item = plain(&format!("<li class=\"conclusion{item}").replace("</li></ol>", ""));
        let mut expected: Vec<String> = vec![plain_words(&conclusion.statement)];
        // What all of several leave out is said once behind them.
        let others = &study.conclusions;
        let is_common = |words: &&str| {
            others.len() > 1
                && others
                    .iter()
                    .all(|it| it.left_out().any(|own| own == *words))
        };
        let (common, own): (Vec<&str>, Vec<&str>) = conclusion.left_out().partition(is_common);
        expected.extend(own.into_iter().map(plain_words));
        for words in common.into_iter().map(plain_words) {
            let behind = between(section, "Left out of every verdict", "</ul>");
            assert!(
                plain(behind).contains(&words),
                "missing: {words} in {behind}"
            );
        }
        expected.extend(
            conclusion
                .conditions()
                .iter()
                .map(|(_, it)| plain_words(it)),
        );
        expected.extend(
            conclusion
                .looking
                .iter()
                .map(|it| plain_words(&it.statement)),
        );
        for part in &expected {
            assert!(item.contains(part), "missing: {part} in {item}");
        }
        let rows: String = summary.split_whitespace().collect::<Vec<_>>().join(" ");
        let said = conclusion.left_out();
        let said = said.chain(conclusion.conditions().into_iter().map(|(_, it)| it));
        for part in said {
            let part: String = part.split_whitespace().collect::<Vec<_>>().join(" ");
            assert!(rows.contains(&part), "missing: {part} in {summary}");
        }
        check_reason(study, conclusion, page);
        check_bounds(study, conclusion);
    }
}

/// What is left open says why, and what would decide; what conflicts has a pair that does.
fn check_reason(study: &StudyResult, conclusion: &Conclusion, page: &str) {
    let synthesis = &study.synthesis;
    let id = &conclusion.requirement;
    let is_planned = synthesis.deciding.iter().any(|it| &it.requirement == id);
    let reason = synthesis
        .not_planned
        .iter()
        .find(|it| &it.requirement == id);
    let is_left = conclusion.is_open() || conclusion.verdict == Verdict::Conflicting;
    assert_eq!(is_planned || reason.is_some(), is_left, "{conclusion:?}");
    assert!(!(is_planned && reason.is_some()), "{conclusion:?}");
    if is_left {
        let section = plain(between(page, "<section id=\"further\"", "</section>"));
        assert!(
            section.contains(&format!("Requirement {id}: ")),
            "{section}"
        );
        if let Some(reason) = reason {
            assert!(section.contains(&reason.reason), "{section}");
        }
    }
    let conflicts = study.comparisons.iter().any(|it| {
        let current = |id: &String| conclusion.rests_on.contains(id);
        it.outcome == Outcome::Conflicts && current(&it.left) && current(&it.right)
    });
    if conclusion.verdict == Verdict::Conflicting {
        assert!(conflicts, "{conclusion:?}");
    }
}

/// One piece has one lower bound at one level, and a second one says at which level it is another.
fn check_bounds(study: &StudyResult, conclusion: &Conclusion) {
    let mut combined = study.synthesis.combined.iter();
    let combined = combined.find(|it| it.requirement == conclusion.requirement);
    let Some(common) = combined.and_then(|it| it.common.as_ref()) else {
        return;
    };
    if let Some(bound) = conclusion.common_lower_bound {
        assert!((bound - common.value).abs() < 1e-12, "{bound} {common:?}");
    }
    let current = conclusion.standings.iter().filter(|it| {
        !it.elsewhere && it.step != Step::Corroborated && common.pieces.contains(&it.evidence)
    });
    for standing in current {
        let (own, level) = match common.direction {
            Direction::AtLeast => (standing.limits.low, standing.level_met),
            Direction::AtMost => (1.0 - standing.limits.high, standing.level_met),
        };
        let all = match common.direction {
            Direction::AtLeast => common.value,
            Direction::AtMost => 1.0 - common.value,
        };
        // The weakest limit at the whole level is not above that of a piece at its share of it, unless it is at the whole.
        let whole = 1.0 - common.confidence;
        if (level - whole).abs() < 1e-12 {
            assert!(all <= own + 1e-9, "{common:?} {standing:?}");
        }
    }
    assert!(common.statement.contains("whole level"), "{common:?}");
}

/// An outcome has the p-values that it needs, on the page and in the data.
fn check_pairs(study: &StudyResult, page: &str) {
    let rows = parts(page, "<tr data-outcome=\"");
    let mut compared: Vec<&Comparison> = study.comparisons.iter().collect();
    compared.retain(|it| it.outcome != Outcome::NotComparable);
    assert_eq!(rows.len(), compared.len());
    for it in compared {
        let within = it.difference.is_some_and(|d| d.abs() < it.margin);
        match it.outcome {
            Outcome::Conflicts => {
                assert!(
                    it.p_difference_corrected.is_some_and(|p| p <= 0.05),
                    "{it:?}"
                );
                assert!(!within, "{it:?}");
            }
            Outcome::Corroborates => {
                let shown = it.p_equivalence.is_some_and(|p| p <= 0.05)
                    || it.probability_within_margin.is_some_and(|p| p >= 0.95);
                assert!(shown, "{it:?}");
            }
            _ => {}
        }
    }
    for row in rows {
        if row.starts_with("conflicts") {
            let corrected = plain(between(row, "<span class=\"small corrected\">", "</span>"));
            let p: f64 = match corrected.contains("×10") {
                true => 0.0,
                false => corrected.trim().parse().expect("a p-value"),
            };
            assert!(p <= 0.05, "conflicts with p = {p}");
        }
    }
}

/// A count has one effective sample size, in one set of digits.
fn check_sizes(study: &StudyResult, text: &str) {
    let findings = study.evidence.iter().flat_map(|piece| &piece.findings);
    let sizes: BTreeSet<String> = findings
        .filter_map(|it| match it.measure {
            Measure::Counts {
                effective_trials: Some(size),
                ..
            } => Some(effective_size(size)),
            _ => None,
        })
        .collect();
    for part in text.split("ffective sample size").skip(1) {
        let digits = part.trim_start_matches([':', ' ']);
        let end = digits.find(|c: char| !c.is_ascii_digit() && c != '.');
        let digits = digits[..end.unwrap_or(digits.len())].trim_end_matches('.');
        assert!(
            digits.is_empty() || sizes.contains(digits),
            "{digits} of {sizes:?}"
        );
    }
}

/// Nothing is called uncovered that has a number, unless the number is named with the reason why it takes no part.
fn check_gaps(study: &StudyResult) {
    for gap in study.gaps.iter().filter(|gap| gap.evidence.is_empty()) {
        for piece in &study.evidence {
            let number = piece.finding(&gap.subject);
            if number.is_some_and(|it| it.measure.estimate().is_some()) {
                let named = gap
                    .reason
                    .contains(&format!("{} has a number on it", piece.id));
                assert!(named, "{} {gap:?}", piece.id);
            }
        }
    }
}

/// In the argument, what denies a requirement is drawn against it, and what supports it is not.
fn check_argument(study: &StudyResult) {
    let argument = assurance::case(study).safety;
    for conclusion in &study.conclusions {
        for standing in &conclusion.standings {
            let of = |kind: Kind| {
                let name = format!("-{}-{}", conclusion.requirement, standing.evidence);
                let mut nodes = argument.nodes.iter();
                nodes.any(|node| node.kind == kind && node.id.ends_with(&name))
            };
            if standing.step == Step::Corroborated {
                continue;
            }
            match standing.standing {
                Standing::Denies => assert!(!of(Kind::Solution), "{standing:?}"),
                Standing::Supports => assert!(!of(Kind::CounterSolution), "{standing:?}"),
                Standing::Neither => {}
            }
        }
    }
}

#[test]
fn every_statement_on_the_page_holds_against_the_data_beside_it() {
    let mut seen = BTreeSet::new();
    for seed in 0..STUDIES {
        let study = drawn(seed);
        let page = report::html(&study);
        let summary = report::text(&study, 200, false);
        check_matrix(&study, &page);
        check_verdicts(&study, &page, &summary);
        check_pairs(&study, &page);
        check_sizes(&study, &format!("{} {summary}", plain(&page)));
        check_gaps(&study);
        check_argument(&study);
        seen.extend(study.conclusions.iter().map(|it| said(it.verdict)));
    }
    assert!(seen.len() >= 4, "hardly any verdicts come up: {seen:?}");
}

/// 88 of 100 is evidence against "at least 95 %", wherever it is drawn.
#[test]
fn a_count_that_misses_its_threshold_is_drawn_against_the_goal() {
    let study = (0..STUDIES).map(drawn).find(|study| {
        let conclusions = study.conclusions.iter();
        conclusions
            .clone()
            .any(|it| it.verdict == Verdict::Violated)
    });
    let study = study.expect("a violated requirement");
    let argument = assurance::case(&study).safety;
    let against = argument.nodes.iter();
    let against = against.filter(|node| node.kind == Kind::CounterSolution);
    assert!(against.count() > 0);
    let defeated = argument.nodes.iter().filter(|node| node.defeated);
    assert!(defeated.count() > 1);
}

/// The first answer says yes, no and not yet exactly where the verdicts do; none of the five names what is not there.
#[test]
fn answers_say_what_the_verdicts_say() {
    let (mut said_yes, mut said_no) = (0, 0);
    for seed in 0..STUDIES {
        let study = drawn(seed);
        let [met, not_met, sure, untested, next] = report::answers(&study);
        let all = &study.conclusions;
        let of = |wanted: Verdict| all.iter().filter(move |it| it.verdict == wanted);
        let is_undisputed =
            study.open_conflicts().is_empty() && study.differences_of_one().is_empty();
        let is_yes = all.iter().all(Conclusion::is_enough) && is_undisputed;
        let is_of_system = |it: &Conclusion| it.step >= Some(Step::Corroborated);
        let is_no = of(Verdict::Violated).any(is_of_system);
        assert_eq!(met.short.starts_with("Yes, "), is_yes, "{seed}: {met:?}");
        assert_eq!(met.short.starts_with("No: "), is_no, "{seed}: {met:?}");
        said_yes += u64::from(is_yes);
        said_no += u64::from(is_no);

        let is_calm = of(Verdict::Violated).next().is_none() && is_undisputed;
        assert_eq!(not_met.lines.is_empty(), is_calm, "{seed}: {not_met:?}");
        let decided = of(Verdict::Satisfied).count() + of(Verdict::Violated).count();
        let is_undecided = sure.short == "Nothing is decided.";
        assert_eq!(is_undecided, decided == 0, "{seed}: {sure:?}");
        let is_whole = untested.short.starts_with("No gap");
        assert_eq!(is_whole, untested.lines.is_empty(), "{seed}: {untested:?}");
        let is_open = all.iter().any(Conclusion::is_open);
        if next.short == "Nothing is open." {
            assert!(
                is_calm && of(Verdict::NotCovered).next().is_none(),
                "{seed}: {next:?}"
            );
            assert!(
                !is_open || study.synthesis.deciding.is_empty(),
                "{seed}: {next:?}"
            );
        }
        for conclusion in all {
            let id = &conclusion.requirement;
            let named = met.lines.iter().flatten().filter(|part| match part {
                report::Part::Link(_, text) => text == id,
                report::Part::Text(_) => false,
            });
            assert_eq!(named.count(), 1, "{seed}: {met:?}");
        }
    }
    assert!(said_yes > 0 || said_no > 0, "neither was drawn");
}
