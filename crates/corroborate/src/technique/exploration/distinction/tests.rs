use super::*;
use trace::{Field, Trace};

const STATES: [&str; 4] = ["idle", "reach", "carry", "place"];

fn layout() -> Trace {
    let mut trace = Trace::new();
    let fields = vec![
        Field::enumeration("state", STATES),
        Field::bool("full"),
        Field::bool("lamp"),
        Field::number("load", "kg"),
        Field::bool("dropped"),
        Field::number("now", "s"),
    ];
    trace.add_channel("/cell", fields).expect("a new topic");
    trace
}

/// Numbers that look random, the same each time.
struct Drawn(u64);

impl Drawn {
    fn below(&mut self, n: u64) -> u64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % n
    }
}

/// An episode of a cell: its number, the row, and the row's values.
type Drops<'d> = &'d mut dyn FnMut(u64, u32, &[f64; 6]) -> bool;

/// Episodes of a cell whose state goes through all four, in a mode and with a load that are drawn; `drops` says at which
/// rows it shows the finding.
fn cells(count: u64, start: u64, drops: Drops<'_>) -> (Signals, Recorded, Vec<(u64, f64)>) {
    let layout = layout();
    let signals = Signals::of(&layout);
    let (mut recorded, mut showed) = (Recorded::new(), Vec::new());
    let mut drawn = Drawn(start);
    for episode in 1..=count {
        let mut trace = layout.clone();
        trace.complete = true;
        let full = drawn.below(2) as f64;
        let load = drawn.below(1000) as f64 / 100.0;
        let mut first = None;
        for row in 0..8_u32 {
            // A clock that goes on over two episodes.
            let now = f64::from(row) + if episode % 2 == 0 { 100.0 } else { 0.0 };
            let lamp = drawn.below(2) as f64;
            let mut values = [f64::from(row / 2), full, lamp, load, 0.0, now];
            if drops(episode, row, &values) && first.is_none() {
                first = Some(f64::from(row));
                values[4] = 1.0;
            }
            let pushed = trace.channels[0].push(f64::from(row), &values);
            pushed.expect("in order");
        }
        let times: Vec<f64> = first.into_iter().collect();
        recorded.insert(episode, Moments::of(&signals, &trace, &times));
        showed.extend(first.map(|secs| (episode, secs)));
    }
    (signals, recorded, showed)
}

fn told(of: &(Signals, Recorded, Vec<(u64, f64)>)) -> Told {
    let (signals, recorded, showed) = of;
    let level = Confidence::new(0.95).expect("a level");
    let search = Search {
        signals,
        recorded,
        level,
    };
    search.of(showed, &BTreeSet::from(["/cell.dropped".to_owned()]))
}

#[test]
fn the_state_and_the_mode_that_were_planted_are_told_with_their_counts() {
    let cells = cells(80, 5, &mut |_, _, values| {
        values[0] == 2.0 && values[1] == 1.0
    });
    let showed = cells.2.len() as u64;
    assert!((25..55).contains(&showed), "{showed}");
    let found = told(&cells).expect("a rule");
    // Every episode carries; those that showed it were full, and showed it while they carried.
    assert_eq!(
        found.rule_in_words(),
        "/cell.state = carry and /cell.full = true"
    );
    assert_eq!(found.shown, [showed, showed]);
    assert_eq!(found.elsewhere, [0, 80 - showed]);
    assert!(!found.just_before && found.p_value < Some(1e-10));
    assert!(found.moment_p_value < Some(1e-10), "{found:?}");
    // Two of the seven seconds between eight samples.
    let share = found.share_of_time.expect("a share");
    assert!((share - 2.0 / 7.0).abs() < 1e-6, "{share}");
    let words = found.in_words();
    let expected =
        "always and only while /cell.state = carry and /cell.full = true (when it shows in";
    assert!(words.starts_with(expected), "{words}");
}

#[test]
fn what_all_episodes_show_is_told_by_its_moments_alone() {
    let cells = cells(20, 6, &mut |_, _, values| values[0] == 2.0);
    assert_eq!(cells.2.len(), 20);
    let found = told(&cells).expect("a rule");
    assert_eq!(found.rule_in_words(), "/cell.state = carry");
    assert_eq!((found.p_value, found.elsewhere), (None, [0, 0]));
    assert!(found.moment_p_value < Some(1e-6), "{found:?}");
}

#[test]
fn a_number_is_cut_where_it_separates_with_few_digits() {
    let (mut least, mut greatest) = (f64::INFINITY, 0.0_f64);
    let cells = cells(60, 7, &mut |_, _, values| {
        match values[3] > 6.0 {
            true => least = least.min(values[3]),
            false => greatest = greatest.max(values[3]),
        }
        values[0] == 1.0 && values[3] > 6.0
    });
    let found = told(&cells).expect("a rule");
    let mut terms = found.terms.iter();
    let load = terms.find(|it| it.signal == "/cell.load").expect("a cut");
    assert_eq!(load.relation, SignalRelation::AtLeast);
    let cut: f64 = load.value.parse().expect("a number");
    assert!(
        greatest < cut && cut <= least && load.unit == "kg",
        "{load}"
    );
    assert!(load.value.len() <= 4, "{load}");
    assert!(
        found
            .terms
            .iter()
            .any(|it| it.to_string() == "/cell.state = reach"),
        "{found:?}"
    );
    assert_eq!(found.elsewhere[0], 0, "{found:?}");
}

#[test]
fn what_comes_by_chance_is_told_by_no_rule() {
    // In each episode with a chance of three in ten, at a row that is drawn, whatever the cell does.
    let mut claimed = 0;
    for start in 0..60_u64 {
        let cells = cells(40, start, &mut |episode, row, _| {
            let mut chance = Drawn(start * 7_919 + episode * 104_729);
            chance.below(10);
            chance.below(10) < 3 && chance.below(8) == u64::from(row)
        });
        assert!(cells.2.len() >= 3, "{start}");
        claimed += u32::from(told(&cells).is_ok());
    }
    // At most one in ten is expected, of episodes and of moments; by chance more than this come once in ten thousand times.
    assert!(claimed <= 15, "{claimed}");
}

#[test]
fn a_clock_tells_nothing() {
    // The clock alone separates the episodes.
    let cells = cells(40, 9, &mut |episode, row, _| episode % 2 == 0 && row == 7);
    assert_eq!(cells.2.len(), 20);
    assert!(cells.1.values().all(|it| !it.has_fallen(1)));
    let found = told(&cells).expect("a rule of moments");
    let told = (found.rule_in_words(), found.p_value);
    assert_eq!(told, ("/cell.state = place".to_owned(), None));
}

#[test]
fn an_episode_that_was_cut_short_is_not_held_against_a_rule() {
    let mut cells = cells(40, 8, &mut |_, _, values| {
        values[0] == 2.0 && values[1] == 1.0
    });
    let showed: BTreeSet<u64> = cells.2.iter().map(|(episode, _)| *episode).collect();
    for (number, moments) in &mut cells.1 {
        moments.is_whole = showed.contains(number);
    }
    let found = told(&cells).expect("a rule of moments");
    assert_eq!((found.elsewhere, found.p_value), ([0, 0], None));
}

#[test]
fn the_chance_of_as_many_is_that_of_independent_trials() {
    // By hand: of chances 1/2 and 1/4 both succeed in 1/8, one or more in 5/8.
    assert_eq!(at_least(2, &[0.5, 0.25]), 0.125);
    assert_eq!(at_least(1, &[0.5, 0.25]), 0.625);
    assert_eq!(at_least(0, &[0.5, 0.25]), 1.0);
    assert_eq!(at_least(1, &[]), 0.0);
    // The binomial: 1 - 0.9^10 of at least one of ten at a tenth.
    assert!((at_least(1, &[0.1; 10]) - (1.0 - 0.9_f64.powi(10))).abs() < 1e-12);
}
