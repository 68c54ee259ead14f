//! Planted differences are found, and none where none is planted.

use super::*;

fn square() -> Space {
    let parameter =
        |name| format!("[[parameter]]\nname = \"{name}\"\nsets = [\"{name}\"]\nuniform = [0, 1]\n");
    Space::from_toml(&["x", "y"].map(parameter).concat()).unwrap()
}

/// A prediction that depends on the context.
fn formal(context: &Point) -> f64 {
    0.95 - 0.1 * context.0[1]
}

/// A corner of 8 % of all contexts.
fn in_corner(context: &Point) -> bool {
    context.0[0] > 0.8 && context.0[1] < 0.4
}

struct Run {
    search: DisagreementSearch,
    explored_corner: usize,
    used: usize,
}

const EXPLORE: usize = 250;

/// Contexts have the predicted rate, but in the corner another one.
fn rate(context: &Point, corner_rate: Option<f64>) -> f64 {
    let planted = corner_rate.filter(|_| in_corner(context));
    planted.unwrap_or(formal(context))
}

fn run(seed: u64, corner_rate: Option<f64>, episodes: usize, margin: f64) -> Run {
    let options = DisagreementOptions {
        explore: EXPLORE,
        margin,
        ..DisagreementOptions::default()
    };
    let mut search = DisagreementSearch::new(square(), seed, options).unwrap();
    let mut simulator = Random::new(seed, "simulator");
    let (mut explored_corner, mut used) = (0, 0);
    while used < episodes && !search.is_over() {
        let contexts = search.ask(10, &formal);
        if search.confirmation.is_none() {
            explored_corner += contexts.iter().filter(|c| in_corner(c)).count();
        }
        used += contexts.len();
        let outcomes: Vec<_> = contexts
            .into_iter()
            .map(|context| {
                let happened = simulator.chance(rate(&context, corner_rate));
                (context, Some(happened))
            })
            .collect();
        search.tell(&outcomes);
    }
    Run {
        search,
        explored_corner,
        used,
    }
}

/// The mean difference of a region in truth.
fn true_difference(region: &Region, corner_rate: Option<f64>) -> f64 {
    let space = square();
    let rows = stats::design(2000, 2, 99);
    let contexts = rows.iter().map(|row| space.at(&region.at(row)));
    let differences = contexts.map(|context| rate(&context, corner_rate) - formal(&context));
    differences.sum::<f64>() / 2000.0
}

/// Whether a decision is wrong in truth, by more than what is wrong with the mean prediction.
fn is_wrong(finding: &Finding, corner_rate: Option<f64>, margin: f64) -> bool {
    let difference = true_difference(&finding.region, corner_rate).abs();
    match finding.agreement {
        Agreement::Differs => difference < margin - 0.005,
        Agreement::Agrees => difference > margin + 0.005,
        Agreement::Undecided => false,
    }
}

#[test]
fn a_planted_difference_is_found_and_delimited() {
    let margin = 0.1;
    let (mut found, mut wrong) = (0, 0);
    let (mut share, mut inside, mut decided, mut used) = (0.0, 0.0, 0.0, 0);
    let runs = 20;
    for seed in 0..runs {
        let run = run(seed, Some(0.4), 700, margin);
        let findings = run.search.findings();
        let differs = findings
            .iter()
            .filter(|f| f.agreement == Agreement::Differs);
        let differs: Vec<&Finding> = differs.collect();
        found += usize::from(!differs.is_empty());
        wrong += usize::from(findings.iter().any(|f| is_wrong(f, Some(0.4), margin)));
        share += run.explored_corner as f64 / EXPLORE as f64 / runs as f64;
        used += run.used;
        let decided_share = findings
            .iter()
            .filter(|f| f.agreement != Agreement::Undecided);
        decided += decided_share.map(|f| f.region.share()).sum::<f64>() / runs as f64;
        // How much of the corner lies in what differs.
        let space = square();
        let corner = stats::design(500, 2, 5)
            .into_iter()
            .map(|row| space.unit_of(&Point(vec![0.8 + 0.2 * row[0], 0.4 * row[1]])));
        let held = corner.filter(|unit| differs.iter().any(|f| f.region.holds(unit)));
        inside += held.count() as f64 / 500.0 / runs as f64;
    }
    println!(
        "found {found} of {runs}, wrong {wrong}, explored share {share:.3}, corner held {inside:.3}, decided {decided:.3}, episodes {used}"
    );
    assert!(found >= 18, "{found} of {runs}");
    assert!(wrong <= 3, "{wrong} of {runs}");
    // Blind sampling would spend 8 % of its episodes there.
    assert!(share > 0.16, "{share}");
    assert!(inside > 0.6 && decided > 0.5, "{inside} {decided}");
}

#[test]
fn where_nothing_is_planted_nothing_is_found_and_agreement_is_shown() {
    let (runs, margin) = (60, 0.1);
    let (mut alarms, mut agreed) = (0, 0.0);
    for seed in 0..runs {
        let findings = run(100 + seed, None, 700, margin).search.findings();
        let differs = |f: &Finding| f.agreement == Agreement::Differs;
        alarms += usize::from(findings.iter().any(differs));
        let agrees = findings.iter().filter(|f| f.agreement == Agreement::Agrees);
        agreed += agrees.map(|f| f.region.share()).sum::<f64>() / runs as f64;
    }
    println!("alarms {alarms} of {runs}, agreed {agreed:.3}");
    // The level allows for 3; that 9 or more come has then a probability below 0.003.
    assert!(alarms <= 8, "{alarms}");
    assert!(agreed > 0.8, "{agreed}");
}

#[test]
fn at_the_very_margin_decisions_are_rarely_wrong() {
    let runs = 400;
    let wrong = (0..runs).filter(|seed| {
        let question = |predicted: f64| Question {
            region: Region::whole(0),
            predicted,
            predicted_error: 0.0,
        };
        let mut confirmation =
            Confirmation::new(vec![question(0.9), question(0.7), question(0.5)], 0.1, 0.9);
        // At the margin from within, beyond it by a hair, and amid.
        let rates = [0.8, 0.8 + 1e-9, 0.5];
        let wrong = [Agreement::Differs, Agreement::Agrees, Agreement::Differs];
        let mut simulator = Random::new(*seed, "simulator");
        for _ in 0..600 {
            let Some(index) = confirmation.ask() else {
                break;
            };
            confirmation.tell(index, Some(simulator.chance(rates[index])));
        }
        let mut tried = confirmation.findings().into_iter();
        tried.any(|f| {
            let index = [0.9, 0.7, 0.5].iter().position(|p| *p == f.predicted);
            f.agreement == wrong[index.unwrap()]
        })
    });
    let wrong = wrong.count();
    println!("wrong {wrong} of {runs}");
    // The level allows for 40; three deviations more are 58.
    assert!(wrong <= 58, "{wrong}");
}

#[test]
fn episodes_go_where_a_difference_may_be_shown_soonest() {
    let question = |predicted: f64| Question {
        region: Region::whole(0),
        predicted,
        predicted_error: 0.0,
    };
    // The first differs, the second is near the margin, the third agrees.
    let predictions = [0.9, 0.62, 0.5];
    let questions = predictions.map(question).to_vec();
    let mut confirmation = Confirmation::new(questions, 0.1, 0.95);
    let mut simulator = Random::new(4, "simulator");
    let mut decided_at = [None; 3];
    for episode in 0..2000 {
        let Some(index) = confirmation.ask() else {
            break;
        };
        confirmation.tell(index, Some(simulator.chance(0.5)));
        let findings = confirmation.findings();
        let asked = findings.iter().find(|f| f.predicted == predictions[index]);
        if asked.unwrap().agreement != Agreement::Undecided {
            decided_at[index] = Some(episode);
        }
    }
    let [first, near, agreeing] = decided_at;
    assert!(first.unwrap() < 60, "{decided_at:?}");
    assert!(agreeing.unwrap() < 700, "{decided_at:?}");
    assert!(
        near.is_none_or(|near| near > first.unwrap()),
        "{decided_at:?}"
    );
    let findings = confirmation.findings();
    assert_eq!(findings[0].agreement, Agreement::Differs);
    assert_eq!(findings[0].predicted, 0.9);
    assert!(findings[0].further.is_none() && findings[0].chance > 0.9);
}

#[test]
fn what_cannot_happen_and_does_differs_at_once() {
    let question = Question {
        region: Region::whole(0),
        predicted: 0.0,
        predicted_error: 0.0,
    };
    let mut confirmation = Confirmation::new(vec![question], 0.0, 0.999);
    assert_eq!(confirmation.ask(), Some(0));
    confirmation.tell(0, Some(true));
    let finding = &confirmation.findings()[0];
    assert_eq!(finding.agreement, Agreement::Differs);
    assert!(finding.ln_evidence == f64::INFINITY && finding.sure_difference > 0.0);
    assert!(confirmation.is_over() && confirmation.ask().is_none());
}

#[test]
fn what_cannot_be_judged_is_no_outcome() {
    let options = DisagreementOptions {
        explore: 10,
        ..DisagreementOptions::default()
    };
    let mut search = DisagreementSearch::new(square(), 1, options).unwrap();
    for _ in 0..5 {
        let contexts = search.ask(5, &formal);
        let unjudged: Vec<_> = contexts.into_iter().map(|c| (c, None)).collect();
        search.tell(&unjudged);
    }
    let findings = search.findings();
    assert_eq!(findings.len(), 1);
    assert_eq!(findings[0].sample.trials, 0);
    assert_eq!(findings[0].agreement, Agreement::Undecided);
}

#[test]
fn searches_go_on_from_their_written_form() {
    let options = DisagreementOptions {
        explore: 30,
        regions: 3,
        ..DisagreementOptions::default()
    };
    let mut search = DisagreementSearch::new(square(), 3, options).unwrap();
    let mut simulator = Random::new(3, "simulator");
    for round in 0..12 {
        let contexts = search.ask(6, &formal);
        let text = serde_json::to_string(&search).unwrap();
        let mut resumed: DisagreementSearch = serde_json::from_str(&text).unwrap();
        let outcomes: Vec<_> = contexts
            .into_iter()
            .map(|c| (c, Some(simulator.chance(0.8))))
            .collect();
        search.tell(&outcomes);
        resumed.tell(&outcomes);
        assert_eq!(
            resumed.clone().ask(4, &formal),
            search.clone().ask(4, &formal),
            "{round}"
        );
        assert_eq!(resumed.findings(), search.findings());
    }
    assert!((1..=3).contains(&search.findings().len()));
    assert_eq!(search.map(0, 1, 5, &formal).len(), 25);
    assert_eq!(search.explored(), 30);
}

#[test]
fn the_map_shows_where_it_is() {
    let search = run(4, Some(0.3), 250, 0.05).search;
    let difference = |cell: &MapCell| cell.predicted - cell.simulated;
    let cells = search.map(0, 1, 10, &formal);
    let mean = |inside: bool| {
        let chosen: Vec<f64> = cells
            .iter()
            .filter(|cell| in_corner(&cell.context) == inside)
            .map(difference)
            .collect();
        chosen.iter().sum::<f64>() / chosen.len() as f64
    };
    assert!(
        mean(true) > 0.3 && mean(false).abs() < 0.15,
        "{} {}",
        mean(true),
        mean(false)
    );
}

#[test]
fn settings_out_of_range_are_refused() {
    let with = |change: fn(&mut DisagreementOptions)| {
        let mut options = DisagreementOptions::default();
        change(&mut options);
        DisagreementSearch::new(square(), 1, options)
            .map(|_| ())
            .unwrap_err()
            .to_string()
    };
    assert!(with(|o| o.margin = 1.0).starts_with("`margin`"));
    assert!(with(|o| o.explore = 0).starts_with("`explore`"));
    assert!(with(|o| o.regions = 0).starts_with("`regions`"));
    assert!(with(|o| o.confidence = 1.5).starts_with("`confidence`"));
}

#[test]
fn predictions_are_asked_for_sparingly() {
    let asked = std::cell::Cell::new(0_usize);
    let counted = |context: &Point| {
        asked.set(asked.get() + 1);
        formal(context)
    };
    let options = DisagreementOptions {
        explore: 100,
        ..DisagreementOptions::default()
    };
    let mut search = DisagreementSearch::new(square(), 1, options).unwrap();
    let mut simulator = Random::new(1, "simulator");
    for _ in 0..40 {
        let contexts = search.ask(5, &counted);
        let outcomes: Vec<_> = contexts
            .into_iter()
            .map(|c| (c, Some(simulator.chance(0.9))))
            .collect();
        search.tell(&outcomes);
    }
    // The pool, for each explored context one when it is proposed and one when it is told, and
    // what each region's mean takes.
    assert!(asked.get() <= 400 + 2 * 100 + 8 * 128, "{}", asked.get());
}
