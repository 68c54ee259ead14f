//! A technique that is not built in: a coin whose tosses stand in a file, brought by whoever runs the study.

use crate::support::{Copy, host};
use corroborate::evidence::{
    AssetRole, Comparison, Cost, Denominator, Evidence, Finding, Guarantee, Measure, MethodAnswer,
    Outcome, Subject, Tool,
};
use corroborate::host::store::Inputs;
use corroborate::technique::{
    Asked, CountedConstant, Files, Kept, Prepared, Produced, Propositions, Technique, Techniques,
    Working, confidence, counts,
};
use corroborate::{Audit, Freshness, Problem, RunPlan, RunRequest, StudyResult, VerifyRequest};
use std::path::{Path, PathBuf};

/// What the ledger asks of a coin.
const ENTRY: &str = r#"
[[evidence]]
id = "E3"
title = "A coin"
technique = "experiment"
producer = "coin"
conditions = "typical"
with = { tosses = "coin.txt", requirement = "1" }
changed = "The charger has gone, and a coin stands for it."
"#;

/// Tosses of a coin, each of which shows heads (`1`) or not (`0`); a file `bent` beside them says that they do not count, and
/// `sampled` that a model was tossed, whose probability they estimate.
struct Coin;

/// The tosses of one entry.
struct Tosses<'a> {
    asked: Asked<'a>,
    requirement: String,
    heads: u64,
    tosses: u64,
    is_bent: bool,
    is_sampled: bool,
}

impl<'a> Tosses<'a> {
    fn read(asked: Asked<'a>, files: &Files<'_>) -> Result<Self, Problem> {
        let with = asked.entry.work.told();
        let told = |key: &str| with.and_then(|it| it.get(key)?.as_str());
        let (Some(path), Some(requirement)) = (told("tosses"), told("requirement")) else {
            return Err(Problem::new(
                "bad-coin",
                "a coin has `tosses` and a `requirement`",
            ));
        };
        let text = files.text(AssetRole::Data, Path::new(path))?.text;
        let bent = files.text_if_any(AssetRole::Data, Path::new("bent"))?;
        let sampled = files.text_if_any(AssetRole::Data, Path::new("sampled"))?;
        let shown = text.chars().filter(|it| "01".contains(*it));
        Ok(Self {
            asked,
            requirement: requirement.to_owned(),
            heads: shown.clone().filter(|it| *it == '1').count() as u64,
            tosses: shown.count() as u64,
            is_bent: bent.is_some(),
            is_sampled: sampled.is_some(),
        })
    }

    /// A probability of which the interval of the counts is known, at its level.
    fn sampled(&self, counted: Measure) -> Measure {
        let interval = counted.interval().expect("it was tossed");
        Measure::Probability {
            answer: MethodAnswer {
                method: "tossed".into(),
                value: self.heads as f64 / self.tosses as f64,
                complement: None,
                guarantee: Guarantee::Statistical {
                    confidence: self.asked.study.about.confidence,
                    low: interval.low,
                    high: interval.high,
                },
                iterations: None,
            },
            others: Vec::new(),
            credible: None,
        }
    }

    fn found(&self) -> Result<Produced, Problem> {
        let level = confidence(self.asked.study.about.confidence)?;
        let measure = match self.is_bent {
            false if self.is_sampled => self.sampled(counts(self.heads, self.tosses, None, level)?),
            false => counts(self.heads, self.tosses, None, level)?,
            true => Measure::NotCovered {
                reason: "The coin is bent.".into(),
                constant: None,
            },
        };
        Ok(Produced {
            tool: Tool {
                name: "a coin".into(),
                version: "1".into(),
                settings: "tossed by hand".into(),
            },
            findings: vec![Finding {
                subject: Subject::Requirement(self.requirement.clone()),
                measure,
                denominator: Denominator::default(),
                trigger: None,
                undecided: 0,
                left_out: 0,
                completions: None,
                witnesses: Vec::new(),
                readings: Vec::new(),
            }],
            form_differences: Vec::new(),
            failures: Vec::new(),
            description_gaps: Vec::new(),
            clusters: None,
            alike_trials: None,
            repeated_recordings: Vec::new(),
            findings_once: Vec::new(),
            influences: Vec::new(),
            cost: Cost {
                evidence: self.asked.entry.id.clone(),
                ..Cost::default()
            },
        })
    }
}

impl Technique for Coin {
    fn prepare<'a>(
        &self,
        asked: Asked<'a>,
        files: &Files<'_>,
    ) -> Result<Box<dyn Prepared + 'a>, Problem> {
        Ok(Box::new(Tosses::read(asked, files)?))
    }

    fn is_computed_again_when_deep(&self) -> bool {
        false
    }

    fn verify(&self, asked: Asked<'_>, kept: &Kept<'_>, audit: &mut Audit) -> Result<(), Problem> {
        let again = Tosses::read(asked, &Files::of(&asked.study.folder))?.found()?;
        kept.is(again, "values of evidence follow from coins", audit)
    }
}

impl Prepared for Tosses<'_> {
    /// Nothing: what it reads is remembered by `Files`, and what it is told and given by whoever asks it.
    fn settings(&self, _: &[CountedConstant], _: &mut Inputs) -> Result<(), Problem> {
        Ok(())
    }

    fn constant(&self, _: &str) -> Option<f64> {
        None
    }

    fn propositions(&self) -> Option<Propositions<'_>> {
        None
    }

    fn obstacle(&self) -> Option<&Problem> {
        None
    }

    fn not_allowed(&self) -> Option<&Problem> {
        None
    }

    fn produce(&self, _: &Working<'_>) -> Result<Produced, Problem> {
        self.found()
    }

    fn kept_episodes(&self, _: &Path) -> Result<Option<u64>, Problem> {
        Ok(None)
    }
}

/// The study of the template, with a coin that shows heads in 95 of 100 tosses.
fn study() -> Copy {
    let study = Copy::of_template("Model");
    let ledger = study.path("ledger.toml");
    let text = std::fs::read_to_string(&ledger).expect("a text") + ENTRY;
    std::fs::write(ledger, text).expect("written");
    toss(&study, 95);
    study
}

fn toss(study: &Copy, heads: usize) {
    let text = "1".repeat(heads) + &"0".repeat(100 - heads);
    std::fs::write(study.path("coin.txt"), text).expect("written");
}

fn request(study: &Copy) -> RunRequest {
    RunRequest::new(study.path("")).techniques(Techniques::default().with("coin", Coin))
}

fn plan(study: &Copy) -> RunPlan {
    corroborate::plan(&request(study), &host(|_| false).0).expect("a plan")
}

fn run(study: &Copy) -> StudyResult {
    let report = corroborate::run(&request(study), &host(|_| false).0).expect("it runs");
    report.into_study().expect("all was asked for")
}

fn coin_of(result: &StudyResult) -> &Evidence {
    let coin = result.evidence.iter().find(|piece| piece.id == "E3");
    coin.expect("a coin was tossed")
}

fn verified(study: &Copy) -> corroborate::VerifyReport {
    let request = VerifyRequest::new(study.path("results"))
        .techniques(Techniques::default().with("coin", Coin));
    corroborate::verify(&request, &host(|_| false).0, None).expect("it is a study's")
}

#[test]
fn its_evidence_is_stale_when_what_it_read_changes_and_fresh_when_not() {
    let study = study();
    let freshness = |study: &Copy| plan(study).evidence[2].freshness.clone();
    assert_eq!(freshness(&study), Freshness::NotProduced);
    run(&study);
    assert!(plan(&study).is_fresh());

    std::fs::write(study.path("notes.txt"), "nobody reads this").expect("written");
    assert!(plan(&study).is_fresh());
    toss(&study, 96);
    let files = vec!["coin.txt".to_owned()];
    assert_eq!(freshness(&study), Freshness::FilesChanged { files });
    run(&study);
    assert!(plan(&study).is_fresh());

    // It looked for this file, and there was none.
    std::fs::write(study.path("bent"), "").expect("written");
    assert_ne!(freshness(&study), Freshness::Fresh);
    let bent = run(&study);
    assert!(matches!(
        coin_of(&bent).findings[0].measure,
        Measure::NotCovered { .. }
    ));
    study.edit("ledger.toml", "requirement = \"1\"", "requirement = \"2\"");
    assert_eq!(freshness(&study), Freshness::OtherInputs);
    run(&study);
    study.edit("requirements.toml", "At least 90%", "At least 90 %");
    let files = vec!["requirements.toml".to_owned()];
    assert_eq!(freshness(&study), Freshness::FilesChanged { files });
}

#[test]
fn its_evidence_has_lineage_and_is_compared_concluded_and_shown() {
    let study = study();
    let result = run(&study);
    let coin = coin_of(&result);
    let asset = coin.assets.iter().find(|asset| asset.path == "coin.txt");
    let asset = asset.expect("it was read");
    assert_eq!(asset.role, AssetRole::Data);
    let text = std::fs::read(study.path("coin.txt")).expect("read");
    assert_eq!(asset.hash, corroborate::host::store::hash_of(&text));

    let pairs = result.comparisons.iter();
    let with_coin = pairs.filter(|pair| [&pair.left, &pair.right].contains(&&coin.id));
    assert!(with_coin.count() >= 2, "{:?}", result.comparisons);
    let mut conclusions = result.conclusions.iter();
    let conclusion = conclusions.find(|it| it.requirement == "1").expect("one");
    assert!(conclusion.rests_on.contains(&coin.id), "{conclusion:?}");
    let page = report::html(&result);
    for words in ["A coin", "tossed by hand", "coin.txt"] {
        assert!(page.contains(words), "the page lacks `{words}`");
    }
}

#[test]
fn its_evidence_is_derived_again_when_results_are_verified() {
    let study = study();
    run(&study);
    let report = verified(&study);
    assert_eq!(report.faults, []);
    let again = report.checked.iter().find(|it| it.what.contains("coins"));
    assert!(again.is_some_and(|it| it.count > 0), "{:?}", report.checked);

    // The counts that are claimed are not those of the file any more.
    toss(&study, 50);
    let places = verified(&study).faults.into_iter().map(|fault| {
        let file = PathBuf::from(fault.file);
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        format!("{name}{}", fault.place)
    });
    let places: Vec<String> = places.collect();
    let claimed = "E3.json/content/findings/0/measure";
    assert!(
        places.iter().any(|it| it.starts_with(claimed)),
        "{places:?}"
    );
    let asset = "study.json/evidence/2/assets";
    assert!(places.iter().any(|it| it.starts_with(asset)), "{places:?}");
}

#[test]
fn a_technique_that_nobody_brought_is_named_with_its_place() {
    let study = study();
    study.edit("ledger.toml", "producer = \"coin\"", "producer = \"coim\"");
    let problem = corroborate::plan(&request(&study), &host(|_| false).0).expect_err("no coim");
    assert_eq!(problem.code, "unknown-technique");
    assert!(problem.has_place());
    let said = problem.to_string();
    assert!(said.contains("did you mean `coin`?"), "{said}");

    study.edit("ledger.toml", "producer = \"coim\"\n", "");
    let problem = corroborate::plan(&request(&study), &host(|_| false).0).expect_err("no work");
    assert!(problem.has_place(), "{problem}");
}

/// The comparisons of the coin on the requirement, with the identifiers of the other evidence.
fn pairs_of_coin(result: &StudyResult) -> Vec<&Comparison> {
    let subject = Subject::Requirement("1".into());
    let pairs = result.comparisons.iter();
    pairs
        .filter(|it| it.subject == subject && [&it.left, &it.right].contains(&&"E3".to_owned()))
        .collect()
}

/// What is known at a level only shows no more than the counts do of which it is known, and no less than that it is known.
#[test]
fn a_statistical_probability_keeps_its_level_up_to_the_page() {
    let study = study();
    toss(&study, 70);
    let counted = run(&study);
    std::fs::write(study.path("sampled"), "").expect("written");
    let sampled = run(&study);
    let Measure::Probability { answer, .. } = &coin_of(&sampled).findings[0].measure else {
        panic!("it was sampled");
    };
    let Guarantee::Statistical {
        confidence,
        low,
        high,
    } = answer.guarantee
    else {
        panic!("{answer:?}");
    };
    assert_eq!(confidence, 0.95);
    let (of_counts, of_sample) = (pairs_of_coin(&counted), pairs_of_coin(&sampled));
    assert!(!of_counts.is_empty() && of_counts.len() == of_sample.len());
    for (counts, sample) in of_counts.iter().zip(&of_sample) {
        assert_ne!(sample.outcome, Outcome::NotComparable, "{}", sample.reason);
        let is_as_strong =
            sample.outcome == counts.outcome || sample.outcome == Outcome::Inconclusive;
        assert!(is_as_strong, "{}: {}", sample.reason, counts.reason);
    }
    let interval = coin_of(&sampled).findings[0]
        .measure
        .interval()
        .expect("one");
    assert!(interval.low <= low && interval.high >= high);
    assert!(report::html(&sampled).contains("statistical at 95"));
    assert_eq!(verified(&study).faults, []);
}
