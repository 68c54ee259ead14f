//! Coverage against brute force, and its estimates against simulation.

use proptest::prelude::*;
use stats::Confidence;

use super::*;
use crate::random::Random;

const MODEL: &str = r#"
[[variable]]
name = "gaze"
labels = ["on", "away"]
[[variable]]
name = "pull"
labels = ["none", "weak", "strong"]
[[variable]]
name = "hand"
labels = ["near", "far"]
[[cross]]
name = "all"
of = ["gaze", "pull", "hand"]
exclude = [{ pull = "strong", hand = "far" }]
"#;

fn model() -> CoverageModel {
    CoverageModel::from_toml(MODEL).unwrap()
}

fn situation(labels: [&str; 3]) -> Situation {
    let names = ["gaze", "pull", "hand"];
    let pairs = names.iter().zip(labels);
    pairs
        .map(|(name, label)| ((*name).to_owned(), label.to_owned()))
        .collect()
}

#[test]
fn bins_are_counted_once_an_episode() {
    let mut coverage = Coverage::new(model());
    let near = situation(["on", "weak", "near"]);
    let new = coverage.record(&[near.clone(), near.clone()]).unwrap();
    assert_eq!(new.len(), 1);
    assert_eq!(new[0].labels, ["on", "weak", "near"]);
    assert!(
        coverage
            .record(std::slice::from_ref(&near))
            .unwrap()
            .is_empty()
    );
    assert_eq!(
        coverage.covered("all").unwrap(),
        [(new[0].labels.clone(), 2)]
    );
    assert_eq!(
        coverage.share("all").unwrap(),
        Share {
            covered: 1,
            total: 10
        }
    );
    assert_eq!(coverage.episodes(), 2);
    let text = serde_json::to_string(&coverage).unwrap();
    assert_eq!(serde_json::from_str::<Coverage>(&text).unwrap(), coverage);
    for (from, to) in [
        ("[0,1,0]", "[0,9,0]"),
        ("[0,1,0]", "[0,1]"),
        ("[[[0,1,0],2]]", ""),
    ] {
        assert!(text.contains(from), "{text}");
        let damaged = text.replacen(from, to, 1);
        assert!(
            serde_json::from_str::<Coverage>(&damaged).is_err(),
            "{damaged}"
        );
    }
}

#[test]
fn a_situation_that_says_less_counts_for_no_cell() {
    let mut coverage = Coverage::new(model());
    let mut partial = situation(["on", "weak", "near"]);
    partial.remove("hand");
    assert!(coverage.record(&[partial]).unwrap().is_empty());
}

#[test]
fn cells_that_cannot_occur_are_told_when_they_do() {
    let mut coverage = Coverage::new(model());
    coverage
        .record(&[situation(["on", "strong", "far"])])
        .unwrap();
    assert_eq!(coverage.share("all").unwrap().covered, 0);
    assert_eq!(
        coverage.seen_though_excluded("all").unwrap(),
        [["on", "strong", "far"]]
    );
}

#[test]
fn unknown_names_are_refused_and_nothing_is_recorded() {
    let mut coverage = Coverage::new(model());
    let error = coverage
        .record(&[situation(["on", "weak", "nera"])])
        .unwrap_err();
    assert_eq!(error.to_string(), "there is no label `hand=nera`");
    assert_eq!(coverage.episodes(), 0);
    assert!(coverage.holes("every", 1).is_err());
}

#[test]
fn holes_are_told_in_the_fewest_words() {
    let mut coverage = Coverage::new(model());
    for labels in [
        ["on", "none", "near"],
        ["on", "weak", "far"],
        ["on", "strong", "near"],
    ] {
        coverage.record(&[situation(labels)]).unwrap();
    }
    let holes = coverage.holes("all", 100).unwrap();
    let shown: Vec<String> = holes.iter().map(ToString::to_string).collect();
    assert_eq!(
        shown,
        [
            "gaze=away × pull=* × hand=* (5)",
            "gaze=* × pull=none × hand=far (2)",
            "gaze=* × pull=weak × hand=near (2)",
        ]
    );
    assert!(holes[0].holds(&situation(["away", "weak", "far"])));
    assert!(!holes[1].holds(&situation(["on", "none", "near"])));
    let weights = coverage.label_weights("all").unwrap();
    // Five of the seven missing cells have gaze=away.
    assert_eq!(
        weights["gaze"][1],
        ("away".to_owned(), 0.25 + 0.5 * 5.0 / 7.0)
    );
}

#[test]
fn numbers_fall_into_intervals() {
    let text = "[[variable]]\nname = \"x\"\nedges = [0, 1, 2.5]\nunit = \"m\"";
    let model = CoverageModel::from_toml(text).unwrap();
    let label = |value| model.variables[0].label_of(value);
    assert_eq!(label(0.0).as_deref(), Some("0..1 m"));
    assert_eq!(label(1.0).as_deref(), Some("1..2.5 m"));
    assert_eq!(label(2.5).as_deref(), Some("1..2.5 m"));
    assert_eq!(
        [label(-0.1), label(2.6), label(f64::NAN)],
        [None, None, None]
    );
    let written = toml::to_string(&model).unwrap();
    assert_eq!(CoverageModel::from_toml(&written).unwrap(), model);
}

#[test]
fn mistakes_in_a_model_are_named() {
    for (from, to, expected) in [
        (
            "labels = [\"on\", \"away\"]",
            "labels = [\"on\", \"on\"]",
            "each label may stand there once",
        ),
        (
            "labels = [\"on\", \"away\"]",
            "",
            "`gaze` needs either labels or edges",
        ),
        ("labels = [\"on\", \"away\"]", "edges = [2, 1]", "ascending"),
        (
            "name = \"pull\"",
            "name = \"gaze\"",
            "given to two variables",
        ),
        ("\"hand\"]", "\"hands\"]", "there is no variable `hands`"),
        ("\"hand\"]", "\"gaze\"]", "each once"),
        (
            "hand = \"far\"",
            "hand = \"further\"",
            "no label `hand=further`",
        ),
        ("of =", "off =", "unknown field `off`"),
    ] {
        let error = CoverageModel::from_toml(&MODEL.replacen(from, to, 1)).unwrap_err();
        assert!(error.to_string().contains(expected), "{to}: {error}");
    }
    let wide = (0..5).map(|i| {
        let labels: Vec<String> = (0..30).map(|k| format!("\"{k}\"")).collect();
        format!(
            "[[variable]]\nname = \"v{i}\"\nlabels = [{}]\n",
            labels.join(", ")
        )
    });
    let text = wide.collect::<String>()
        + "[[cross]]\nname = \"c\"\nof = [\"v0\", \"v1\", \"v2\", \"v3\", \"v4\"]";
    assert!(
        CoverageModel::from_toml(&text)
            .unwrap_err()
            .to_string()
            .contains("too many cells")
    );
}

/// All maximal holes by trying every pattern against every cell.
fn holes_by_force(sizes: &[u16], covered: &[Vec<u16>]) -> Vec<Vec<Option<u16>>> {
    let mut patterns = vec![vec![]];
    for size in sizes {
        let longer = patterns.iter().flat_map(|p: &Vec<Option<u16>>| {
            let with = |digit| [p.clone(), vec![digit]].concat();
            std::iter::once(with(None)).chain((0..*size).map(move |d| with(Some(d))))
        });
        patterns = longer.collect();
    }
    let matches = |pattern: &[Option<u16>], cell: &[u16]| {
        pattern
            .iter()
            .zip(cell)
            .all(|(p, c)| p.is_none_or(|p| p == *c))
    };
    let is_hole = |pattern: &[Option<u16>]| !covered.iter().any(|cell| matches(pattern, cell));
    let maximal = |pattern: &Vec<Option<u16>>| {
        (0..sizes.len()).all(|i| {
            let mut wider = pattern.clone();
            wider[i] = None;
            pattern[i].is_none() || !is_hole(&wider)
        })
    };
    patterns
        .iter()
        .filter(|p| is_hole(p) && maximal(p))
        .cloned()
        .collect()
}

proptest! {
    #[test]
    fn any_tracefile_is_read_or_refused(lines in prop::collection::vec(
        prop_oneof!["(SF|DA|FN|FNDA|FNL|FNA|BRDA|LF|XX):[0-9a-z,.\\-]{0,12}", Just("end_of_record".to_owned()), "\\PC{0,9}"],
        0..12,
    )) {
        let text = lines.join("\n");
        if let Ok(coverage) = Lcov::parse(&text) {
            let mut twice = coverage.clone();
            twice.merge(&coverage);
            prop_assert_eq!(twice.lines(), coverage.lines());
        }
    }

    #[test]
    fn holes_are_those_of_brute_force(
        sizes in prop::collection::vec(1_u16..4, 1..4),
        seeds in prop::collection::vec(any::<u64>(), 0..12),
    ) {
        let mut model = CoverageModel::default();
        for (i, size) in sizes.iter().enumerate() {
            let labels: Vec<String> = (0..*size).map(|k| k.to_string()).collect();
            let labels: Vec<&str> = labels.iter().map(String::as_str).collect();
            model.variables.push(Variable::new(&format!("v{i}"), &labels));
        }
        let of = model.variables.iter().map(|v| v.name.clone()).collect();
        model.crosses.push(Cross { name: "c".into(), of, exclude: vec![] });
        let mut coverage = Coverage::new(model.clone());
        let cells: Vec<Vec<u16>> = seeds.iter().map(|seed| {
            let mut random = Random::new(*seed, "cell");
            sizes.iter().map(|size| random.index(usize::from(*size)) as u16).collect()
        }).collect();
        for cell in &cells {
            let names = model.variables.iter().zip(cell);
            let situation = names.map(|(v, c)| (v.name.clone(), c.to_string())).collect();
            coverage.record(&[situation]).unwrap();
        }
        let mut found: Vec<Vec<Option<u16>>> = coverage.holes("c", usize::MAX).unwrap().iter()
            .map(|h| h.pattern.iter().map(|(_, l)| l.as_ref().map(|l| l.parse().unwrap())).collect())
            .collect();
        let mut expected = holes_by_force(&sizes, &cells);
        found.sort();
        expected.sort();
        prop_assert_eq!(found, expected);
    }
}

#[test]
fn richness_is_that_of_the_published_formula() {
    // By hand: n = 20, S = 5, Q1 = 2, Q2 = 1: 5 + 19/20 * 4/2 = 6.9.
    let saturation = Saturation::new(20, [9, 5, 2, 1, 1], &[]);
    assert!((saturation.unseen() - 1.9).abs() < 1e-12);
    assert!((saturation.expected_new(1) - 0.1).abs() < 1e-12);
    let interval = saturation.total_interval(Confidence::P95).unwrap();
    assert!(interval.low > 5.0 && interval.low < 6.9 && interval.high > 6.9);
    // More and more episodes bring what is estimated to be unseen, and no more.
    assert!(saturation.expected_new(1_000_000) <= 1.9 + 1e-9);
    assert!(saturation.expected_new(50) < saturation.expected_new(100));
    let nothing = Saturation::new(0, [], &[]);
    assert_eq!(nothing.expected_new(5), 0.0);
    assert_eq!(nothing.chance_of_news_at_most(Confidence::P95), 1.0);
    let certain = Saturation::new(50, [50, 40], &[0, 1]);
    assert_eq!(
        (certain.unseen(), certain.total_interval(Confidence::P95)),
        (0.0, None)
    );
}

/// Episodes that cover each of 40 bins with a probability of its own, from 1/2 down to 1/2000.
fn simulated(seed: u64, episodes: u64) -> (SetCoverage<u32>, f64) {
    let mut random = Random::new(seed, "episodes");
    let chance = |bin: u32| 0.5 * 1000.0_f64.powf(-f64::from(bin) / 39.0);
    let mut coverage = SetCoverage::new(0..40);
    for _ in 0..episodes {
        let seen: Vec<u32> = (0..40).filter(|bin| random.chance(chance(*bin))).collect();
        coverage.record(seen);
    }
    let silent: f64 = coverage.missing().map(|bin| 1.0 - chance(*bin)).product();
    (coverage, 1.0 - silent)
}

#[test]
fn bounds_of_the_chance_of_news_hold_as_often_as_they_say() {
    let runs = 400;
    let mut violated = 0;
    let mut covered = 0;
    for seed in 0..runs {
        let (coverage, truth) = simulated(seed, 200);
        let saturation = coverage.saturation();
        violated += u32::from(truth > saturation.chance_of_news_at_most(Confidence::P95));
        let interval = saturation.total_interval(Confidence::P95);
        covered += u32::from(interval.is_none_or(|i| i.low <= 40.0));
    }
    // At most 5 % of 400 are expected beyond the bound: 20, and three deviations more are 33.
    assert!(violated <= 33, "{violated}");
    // Chao2 is a lower bound in expectation: its interval must not lie above the truth.
    assert!(covered >= 380, "{covered}");
}

#[test]
fn a_campaign_says_when_it_has_seen_enough() {
    let mut random = Random::new(1, "episodes");
    let mut coverage = SetCoverage::new(["a", "b"]);
    let mut stopped = None;
    for episode in 0..2000_u64 {
        coverage.record([if random.chance(0.3) { "a" } else { "b" }]);
        let enough = coverage
            .saturation()
            .has_stopped_paying(100, 1.0, Confidence::P95);
        if enough && stopped.is_none() {
            stopped = Some(episode + 1);
        }
    }
    // No news in w episodes bounds the chance by 3.0/w: below 1/100 for w = 299, half of 598.
    assert_eq!(stopped, Some(598));
}

#[test]
fn sets_are_kept_as_text() {
    let mut transitions = SetCoverage::new([(0_u64, 1_u64), (1, 0)]);
    transitions.record([(0, 1), (5, 5)]);
    let text = serde_json::to_string(&transitions).unwrap();
    assert_eq!(
        serde_json::from_str::<SetCoverage<(u64, u64)>>(&text).unwrap(),
        transitions
    );
    assert_eq!(
        transitions.share(),
        Share {
            covered: 1,
            total: 2
        }
    );
    assert_eq!(transitions.unknown().collect::<Vec<_>>(), [(&(5, 5), 1)]);
}

const TRACEFILE: &str = "TN:unit\nSF:/src/a.cpp\nFN:3,9,max<int, int>\nFN:20,main\nFNDA:7,max<int, int>\n\
    FNDA:0,main\nFNF:2\nFNH:1\nBRDA:4,0,0,7\nBRDA:4,0,1,-\nBRF:2\nBRH:1\nDA:3,7\nDA:4,7,hash\nDA:20,0\n\
    LF:3\nLH:2\nend_of_record\n";

#[test]
fn tracefiles_are_read_and_merged() {
    let mut coverage = Lcov::parse(TRACEFILE).unwrap();
    assert_eq!(
        coverage.lines(),
        Share {
            covered: 2,
            total: 3
        }
    );
    assert_eq!(
        coverage.functions(),
        Share {
            covered: 1,
            total: 2
        }
    );
    assert_eq!(
        coverage.branches(),
        Share {
            covered: 1,
            total: 2
        }
    );
    assert_eq!(coverage.files["/src/a.cpp"].functions["max<int, int>"], 7);
    let newer = "SF:/src/a.cpp\nFNL:0,20,25\nFNA:0,2,main\nBRDA:4,0,1,3\nDA:20,2\nend_of_record\n\
                 SF:b.py\nDA:1,1\nend_of_record\n";
    let newer = Lcov::parse(newer).unwrap();
    let mut other_way = newer.clone();
    other_way.merge(&coverage);
    coverage.merge(&newer);
    assert_eq!(coverage, other_way);
    assert_eq!(
        coverage.lines(),
        Share {
            covered: 4,
            total: 4
        }
    );
    assert_eq!(
        coverage.functions(),
        Share {
            covered: 2,
            total: 2
        }
    );
    assert_eq!(coverage.branches().rate(), Some(1.0));
    assert_eq!(Lcov::default().lines().rate(), None);
}

#[test]
fn mistakes_in_tracefiles_have_their_line() {
    for (text, expected) in [
        ("DA:1,1\n", "line 1: `DA` outside"),
        (
            "SF:a\nDA:x,1\nend_of_record",
            "line 2: expected a line number, found `x`",
        ),
        (
            "SF:a\nDA:1\nend_of_record",
            "line 2: `DA:1` has too few fields",
        ),
        (
            "SF:a\nDA:1,many\nend_of_record",
            "line 2: expected a count, found `many`",
        ),
        ("SF:a\nSF:b\n", "line 2: SF before"),
        ("SF:a\nDA:1,1\n", "line 2: the text ends within a"),
        (
            "SF:a\nFNA:0,1,f\nend_of_record",
            "line 2: FNA of function 0",
        ),
        ("<html>", "line 1: `<html>` outside"),
    ] {
        let error = Lcov::parse(text).unwrap_err().to_string();
        assert!(error.starts_with(expected), "{text}: {error}");
    }
    assert_eq!(
        Lcov::parse("SF:a\nDA:1,-3\nend_of_record")
            .unwrap()
            .lines()
            .covered,
        0
    );
    assert_eq!(Lcov::parse("").unwrap(), Lcov::default());
}
