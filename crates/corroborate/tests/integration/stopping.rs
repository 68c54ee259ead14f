//! Campaigns that end once a requirement is decided.

use crate::support::{Copy, host};
use corroborate::evidence::{Evidence, Measure, Subject, Verdict};
use corroborate::{RunReport, RunRequest};

/// Requirements that share the level with that of the cart, and ask for nothing that its runs decide.
const OTHERS: &str = r#"
[[requirement]]
id = "often"
text = "The cart stands within 3.5 s of seeing the obstacle, six times in ten."
shall = "When obstacle_seen, the cart shall with probability at least 0.6 within stopping_time satisfy stands."
ending = "finite"
margin = 0.05
needs = "system"

[[requirement]]
id = "seldom"
text = "The cart stands within 2 s of seeing the obstacle, five times in ten."
shall = "When obstacle_seen, the cart shall with probability at least 0.5 within 2 s satisfy stands."
ending = "finite"
margin = 0.05
needs = "system"
"#;

/// The cart, which stops in six runs of ten, with a campaign that ends once it is decided at this confidence that it does not in
/// eight.
fn cart(confidence: &str) -> Copy {
    let study = Copy::of_cart(400);
    let rule =
        format!("episodes = 400\nuntil = {{ requirement = \"stops\", confidence = {confidence} }}");
    study.edit("ledger.toml", "episodes = 400", &rule);
    study.edit("requirements.toml", "at least 0.9", "at least 0.8");
    let id = "id = \"stops\"";
    study.edit(
        "requirements.toml",
        id,
        &format!("{id}\nneeds = \"simulation\""),
    );
    study
}

/// The verdict of the cart's requirement, and how many episodes were run for it.
fn judged(study: &Copy) -> (Verdict, u64) {
    let (host, _) = host(|_| false);
    let RunReport::Study(result) =
        corroborate::run(&RunRequest::new(study.path("")), &host).expect("it runs")
    else {
        panic!("the whole study was asked for");
    };
    let conclusion = result
        .conclusions
        .iter()
        .find(|it| it.requirement == "stops");
    let piece: &Evidence = &result.evidence[0];
    let finding = piece
        .finding(&Subject::Requirement("stops".into()))
        .expect("counted");
    let Measure::Counts { trials, .. } = finding.measure else {
        panic!("{finding:?}");
    };
    (conclusion.expect("concluded").verdict, trials)
}

/// With the study's own confidence, and with less: the study's verdict pays for looks and for other requirements, too.
#[test]
fn a_campaign_does_not_end_before_its_verdict_can_be_given() {
    let mut trials = Vec::new();
    for others in ["", OTHERS] {
        let study = cart("0.6");
        let path = study.path("requirements.toml");
        let text = std::fs::read_to_string(&path).expect("a text");
        std::fs::write(&path, text + others).expect("written");
        let (verdict, count) = judged(&study);
        assert_eq!(verdict, Verdict::Violated, "after {count} trials");
        assert!(count < 400, "it ends before the last");
        trials.push(count);
    }
    assert!(
        trials[0] < trials[1],
        "more requirements ask for more: {trials:?}"
    );
}
