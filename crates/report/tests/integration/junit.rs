//! Results as JUnit XML: a case for each requirement, with what is known of it.

use crate::fixture;

use evidence::Verdict;
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
    assert_eq!(suite.cases.len(), study.requirements.len());
    for (case, requirement) in suite.cases.iter().zip(&study.requirements) {
        assert_eq!(property(case, "verifies"), Some(requirement.id.as_str()));
        let conclusion = study
            .conclusions
            .iter()
            .find(|it| it.requirement == requirement.id);
        let verdict = conclusion.map_or(Verdict::NotCovered, |it| it.verdict);
        let passed = conclusion.is_some_and(|it| it.is_enough());
        assert_eq!(case.end == End::Passed, passed, "{}", requirement.id);
        let failed = matches!(verdict, Verdict::Violated | Verdict::Conflicting);
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

#[test]
fn hostile_texts_stay_texts() {
    let study = fixture::hostile();
    let text = xml(&of_study(&study));
    assert_eq!(text.matches("<testcase ").count(), study.requirements.len());
    assert!(!text.contains("<script"), "{text}");
}
