//! Results as JUnit XML: a case for each requirement, with what is known of it.

use crate::fixture;

use evidence::{Outcome, Subject, Verdict};
use report::junit::{Case, End, of_study, xml};

fn property<'a>(case: &'a Case, name: &str) -> Option<&'a str> {
    let mut found = case.properties.iter().filter(|(it, _)| it == name);
    found.next().map(|(_, value)| value.as_str())
}

#[test]
fn every_requirement_is_a_case_that_says_what_it_verifies() {
    let study = fixture::study();
    let suites = of_study(&study);
    let [suite] = suites.as_slice() else {
        panic!("{} suites", suites.len());
    };
    let open = study.open_conflicts();
    let conflicts = |id: &str| {
        let subject = Subject::Requirement(id.to_owned());
        open.iter().any(|it| it.subject == subject)
    };
    for (case, requirement) in suite.cases.iter().zip(&study.requirements) {
        assert_eq!(property(case, "verifies"), Some(requirement.id.as_str()));
        let conclusion = study
            .conclusions
            .iter()
            .find(|it| it.requirement == requirement.id);
        let verdict = conclusion.map_or(Verdict::NotCovered, |it| it.verdict);
        let passed = conclusion.is_some_and(|it| it.is_enough());
        let failed = matches!(verdict, Verdict::Violated | Verdict::Conflicting)
            || conflicts(&requirement.id);
        let passed = passed && !failed;
        assert_eq!(case.end == End::Passed, passed, "{}", requirement.id);
        assert_eq!(
            matches!(case.end, End::Failed(_)),
            failed,
            "{}",
            requirement.id
        );
        // Whoever is not decided says why.
        if let End::Skipped(why) = &case.end {
            assert!(!why.is_empty());
        }
        let stands = conclusion.is_some_and(|it| !it.standings.is_empty());
        assert_eq!(
            property(case, "guarantee").is_some(),
            stands,
            "{}",
            requirement.id
        );
    }
    let ends = |is: fn(&End) -> bool| suite.cases.iter().filter(|it| is(&it.end)).count();
    let (failed, skipped) = (
        ends(|end| matches!(end, End::Failed(_))),
        ends(|end| matches!(end, End::Skipped(_))),
    );
    assert!(failed > 0 && skipped > 0);
    let text = xml(&suites);
    let head = format!(
        "tests=\"{}\" failures=\"{failed}\" errors=\"0\" skipped=\"{skipped}\"",
        suite.cases.len()
    );
    assert!(text.contains(&head), "{text}");
}

/// What the exit code calls a conflict fails, whatever the verdict is; one of evidence that was laid aside does not.
#[test]
fn an_open_conflict_fails_whatever_the_verdict_is() {
    let mut study = fixture::study();
    for comparison in &mut study.comparisons {
        comparison.outcome = Outcome::Corroborates;
    }
    assert!(study.open_conflicts().is_empty());
    let at = 0;
    let satisfied = &mut study.conclusions[at];
    satisfied.verdict = Verdict::Satisfied;
    satisfied.step = Some(satisfied.needs);
    assert!(satisfied.is_enough());
    let id = study.conclusions[at].requirement.clone();
    let end = |study: &evidence::StudyResult| {
        let suites = of_study(study);
        let mut cases = suites[0].cases.clone().into_iter();
        cases.find(|it| it.name == id).expect("a case").end
    };
    assert_eq!(end(&study), End::Passed);
    let (left, right) = ("X".to_owned(), "Y".to_owned());
    study.comparisons[0].outcome = Outcome::Conflicts;
    study.comparisons[0].subject = Subject::Requirement(id.clone());
    study.comparisons[0].left.clone_from(&left);
    study.comparisons[0].right.clone_from(&right);
    assert_eq!(end(&study), End::Passed, "no conclusion rests on them");
    study.conclusions[at].rests_on.extend([left, right]);
    let End::Failed(said) = end(&study) else {
        panic!("{:?}", end(&study));
    };
    assert!(said.message.starts_with("X and Y conflict. "), "{said:?}");
    // A failure mode has no requirement that could fail.
    study.comparisons[0].subject = Subject::FailureMode("missed_contact".to_owned());
    assert_eq!(end(&study), End::Passed);
    let last = of_study(&study)[0].cases.last().cloned().expect("a case");
    assert_eq!(last.name, "failure mode: missed contact");
    assert!(matches!(last.end, End::Failed(_)));
}

#[test]
fn hostile_texts_stay_texts() {
    let study = fixture::hostile();
    let text = xml(&of_study(&study));
    assert_eq!(
        text.matches("<testcase ").count(),
        of_study(&study)[0].cases.len()
    );
    assert!(!text.contains("<script"), "{text}");
}
