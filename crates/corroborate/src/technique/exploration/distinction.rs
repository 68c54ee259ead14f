//! What the robot did where a finding showed that it does not do elsewhere, as a rule over recorded signals.
//!
//! # Definition
//! A rule is a condition on one signal (an enumeration or truth value has a value; a number is at least or at most a cut)
//! or two such conditions on different signals, at most one of them on a number. Of an episode that showed the finding it
//! is asked whether the rule held at that moment, or just before it (at the last sample of an earlier time); of every
//! other whole episode whether it *ever* held. A rule separates by how far these two shares lie apart: the two-sided p-value of
//! Fisher's exact test. Signals that define the finding (that its requirement reads, or by which abstract states are told
//! apart) are left out, since they would only say it again.
//!
//! # Guarantee
//! Others have all their moments to meet a rule and a finding has one, so the comparison is against the rule. There are
//! four kinds of rules (a name, a cut, two names, a name and a cut). Each p-value is multiplied by the number of rules of its kind that
//! the signals allow, whether they were looked at or not, and by the number of kinds (Bonferroni), and a rule is told only where that is below
//! one minus the study's confidence. A second condition is told only where it separates, in the same sense, among the
//! episodes that meet the first. That holds of episodes that differ by chance. Those of an exploration are chosen, so that what is told is
//! an association to look into, and neither a cause nor a rate.
//!
//! # Cost
//! O(rules × other episodes × combinations of an episode).

use super::moments::{Condition, Moments, Signals, Values};
use evidence::{Distinction, SignalRelation, SignalTerm};
use stats::{Confidence, Sample, fisher_exact};
use std::collections::{BTreeMap, BTreeSet};

/// Kinds of rules.
const KINDS: u64 = 4;

/// Rules as good as the best that are named.
const NAMED: usize = 5;

/// Why nothing is told.
const ALL_SHOWED: &str = "no other episode ran to its end, so nothing can be compared";

/// All episodes whose recordings are known, by number.
pub type Recorded = BTreeMap<u64, Moments>;

/// Looks for what tells a finding apart.
pub struct Search<'a> {
    /// The signals of the recordings.
    pub signals: &'a Signals,
    /// All episodes.
    pub recorded: &'a Recorded,
    /// Below one minus this a rule is told.
    pub level: Confidence,
}

/// What was found of one finding.
pub type Told = Result<Distinction, String>;

/// The episodes of one finding, and all others.
struct Table<'a> {
    /// The values when it showed and just before, of each episode that showed it.
    shown: Vec<[&'a Values; 2]>,
    others: Vec<&'a Moments>,
}

/// How many of the two groups meet a rule.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Counts {
    shown: u64,
    elsewhere: u64,
}

/// A rule that was looked at.
#[derive(Clone, Debug)]
struct Rule {
    /// 0 when it shows, 1 just before.
    moment: usize,
    conditions: Vec<Condition>,
    counts: Counts,
    /// Rules of its kind.
    of: u64,
    p_value: f64,
}

impl Search<'_> {
    /// What tells the episodes apart that showed something, each at its time; `defining` signals are left out.
    pub fn of(&self, showed: &[(u64, f64)], defining: &BTreeSet<String>) -> Told {
        let table = self.table(showed);
        if table.shown.is_empty() {
            return Err("its episodes left no recording".to_owned());
        }
        if table.others.is_empty() {
            return Err(ALL_SHOWED.to_owned());
        }
        let offered = Offered::new(self.signals, defining, table.shown.len());
        let mut rules: Vec<Rule> = Vec::new();
        for moment in [0, 1] {
            self.rules(&table, &offered, moment, &mut rules);
        }
        let best = self.best(&table, &offered, &rules);
        best.map(|best| self.told(&table, best, &rules)).ok_or_else(|| {
            format!(
                "no rule over the {} signals that were recorded separates its {} episodes from {} others beyond chance",
                offered.named.len() + offered.numbers.len(),
                table.shown.len(),
                table.others.len()
            )
        })
    }

    fn table(&self, showed: &[(u64, f64)]) -> Table<'_> {
        let moment = |(episode, secs): &(u64, f64)| {
            let moment = self.recorded.get(episode)?.at_secs(*secs)?;
            Some([&moment.then, &moment.before])
        };
        let numbers: BTreeSet<u64> = showed.iter().map(|(episode, _)| *episode).collect();
        let others = self.recorded.iter().filter(|(number, moments)| {
            // What was cut short may have done it later.
            moments.is_whole && !numbers.contains(number)
        });
        Table {
            shown: showed.iter().filter_map(moment).collect(),
            others: others.map(|(_, moments)| moments).collect(),
        }
    }

    /// All rules of a moment that hold of some episode that showed it.
    fn rules(&self, table: &Table<'_>, offered: &Offered, moment: usize, into: &mut Vec<Rule>) {
        let names = offered.names_at(table, moment);
        for name in &names {
            into.extend(table.rule(moment, vec![*name], offered.kinds[0]));
        }
        let cuts = offered.cuts_at(table, moment);
        for cut in &cuts {
            into.extend(table.rule(moment, vec![*cut], offered.kinds[1]));
        }
        // What is so everywhere adds nothing to another condition.
        let everywhere = Counts {
            shown: table.shown.len() as u64,
            elsewhere: table.others.len() as u64,
        };
        let varies = |name: &Condition| table.counts(moment, &[*name]) != everywhere;
        let names: Vec<Condition> = names.into_iter().filter(varies).collect();
        for (place, first) in names.iter().enumerate() {
            let others = names[place + 1..].iter();
            for second in others.filter(|it| place_of(**it) != place_of(*first)) {
                into.extend(table.rule(moment, vec![*first, *second], offered.kinds[2]));
            }
        }
        // Beside a name a cut is tried where it takes in all that the name does.
        for name in &names {
            for cut in offered.widest_at(table, moment, *name) {
                into.extend(table.rule(moment, vec![*name, cut], offered.kinds[3]));
            }
        }
    }

    /// The rule that separates best beyond chance; the first of equals, of which fewer conditions come first.
    fn best<'r>(&self, table: &Table<'_>, offered: &Offered, rules: &'r [Rule]) -> Option<&'r Rule> {
        let most = self.level.alpha();
        let mut told: Vec<&Rule> = rules.iter().filter(|rule| rule.p_value < most).collect();
        told.sort_by(|a, b| {
            let order = a.p_value.total_cmp(&b.p_value);
            order.then_with(|| self.rank(a).cmp(&self.rank(b)))
        });
        told.into_iter().find(|rule| {
            let [first, second] = rule.conditions[..] else {
                return true;
            };
            let many = offered.singles as f64;
            let adds = |given: Condition| table.adds(rule, given) * many < most;
            adds(first) && adds(second)
        })
    }

    /// Which of rules that separate equally is told: enumerations first, since a robot's states and modes are those, then
    /// when it shows, then by name.
    fn rank(&self, rule: &Rule) -> (usize, usize, usize, String) {
        let others = rule.conditions.iter().filter(|it| match it {
            Condition::Named(place, _) => !self.signals.named[*place].is_enumeration,
            Condition::AtLeast(..) | Condition::AtMost(..) => true,
        });
        let words: Vec<String> = rule.conditions.iter().map(|it| self.term(*it, None).to_string()).collect();
        (rule.conditions.len(), others.count(), rule.moment, words.join(" and "))
    }

    fn told(&self, table: &Table<'_>, best: &Rule, rules: &[Rule]) -> Distinction {
        let as_good = rules.iter().filter(|rule| {
            rule.counts == best.counts && rule.of == best.of && rule.conditions != best.conditions
        });
        let mut named: Vec<String> = Vec::new();
        for rule in as_good {
            let terms = self.terms(table, rule);
            let words: Vec<String> = terms.iter().map(ToString::to_string).collect();
            let words = words.join(" and ");
            if named.len() < NAMED && !named.contains(&words) {
                named.push(words);
            }
        }
        Distinction {
            terms: self.terms(table, best),
            just_before: best.moment == 1,
            shown: [best.counts.shown, table.shown.len() as u64],
            elsewhere: [best.counts.elsewhere, table.others.len() as u64],
            rules: best.of,
            p_value: best.p_value,
            as_good: named,
        }
    }

    fn terms(&self, table: &Table<'_>, rule: &Rule) -> Vec<SignalTerm> {
        let conditions = rule.conditions.iter();
        conditions.map(|it| self.term(*it, Some((table, rule)))).collect()
    }

    /// A condition in words. A cut is put between the values on its two sides, where it has as few digits as it can.
    fn term(&self, condition: Condition, of: Option<(&Table<'_>, &Rule)>) -> SignalTerm {
        let (place, relation, cut) = match condition {
            Condition::Named(place, code) => {
                let named = &self.signals.named[place];
                return SignalTerm {
                    signal: named.signal.clone(),
                    relation: SignalRelation::Equals,
                    value: named.names.get(usize::from(code)).cloned().unwrap_or_default(),
                    unit: String::new(),
                };
            }
            Condition::AtLeast(place, cut) => (place, SignalRelation::AtLeast, cut),
            Condition::AtMost(place, cut) => (place, SignalRelation::AtMost, cut),
        };
        let same = |value: f32| {
            of.is_none_or(|(table, rule)| {
                let moved = rule.conditions.iter().map(|it| match it {
                    Condition::AtLeast(place, _) => Condition::AtLeast(*place, value),
                    Condition::AtMost(place, _) => Condition::AtMost(*place, value),
                    named @ Condition::Named(..) => *named,
                });
                let moved: Vec<Condition> = moved.collect();
                table.counts(rule.moment, &moved) == rule.counts
            })
        };
        SignalTerm {
            signal: self.signals.numbers[place].signal.clone(),
            relation,
            value: shortest(cut, relation, &same),
            unit: self.signals.numbers[place].unit.clone(),
        }
    }
}

/// A number that counts the same as `cut`, with as few digits as that takes: rounded away from what the rule takes in.
fn shortest(cut: f32, relation: SignalRelation, same: &dyn Fn(f32) -> bool) -> String {
    for digits in 0..7_i32 {
        let magnitude = if cut == 0.0 { 0 } else { cut.abs().log10().floor() as i32 };
        let step = 10_f64.powi(magnitude - digits);
        let scaled = f64::from(cut) / step;
        let rounded = match relation {
            SignalRelation::AtMost => scaled.ceil(),
            SignalRelation::AtLeast | SignalRelation::Equals => scaled.floor(),
        };
        let decimals = usize::try_from(digits - magnitude).unwrap_or(0);
        let text = format!("{:.decimals$}", rounded * step);
        if text.parse::<f32>().is_ok_and(same) {
            return text;
        }
    }
    cut.to_string()
}

fn place_of(condition: Condition) -> (bool, usize) {
    match condition {
        Condition::Named(place, _) => (true, place),
        Condition::AtLeast(place, _) | Condition::AtMost(place, _) => (false, place),
    }
}

impl Table<'_> {
    fn counts(&self, moment: usize, conditions: &[Condition]) -> Counts {
        let at = |values: &&[&Values; 2]| conditions.iter().all(|it| it.holds(values[moment]));
        let ever = |moments: &&&Moments| moments.may_have_held(conditions);
        Counts {
            shown: self.shown.iter().filter(at).count() as u64,
            elsewhere: self.others.iter().filter(ever).count() as u64,
        }
    }

    /// A rule with its p-value, if it holds more often of what showed the finding than elsewhere.
    fn rule(&self, moment: usize, conditions: Vec<Condition>, of: u64) -> Option<Rule> {
        let counts = self.counts(moment, &conditions);
        let (shown, others) = (self.shown.len() as u64, self.others.len() as u64);
        let p_value = more_often((counts.shown, shown), (counts.elsewhere, others))?;
        Some(Rule {
            moment,
            conditions,
            counts,
            of,
            p_value: (p_value * (of * KINDS) as f64).min(1.0),
        })
    }

    /// The p-value of a rule of two conditions among the episodes that meet one of them.
    fn adds(&self, rule: &Rule, given: Condition) -> f64 {
        let all = self.counts(rule.moment, &[given]);
        let (shown, elsewhere) = (rule.counts.shown, rule.counts.elsewhere);
        more_often((shown, all.shown), (elsewhere, all.elsewhere)).unwrap_or(1.0)
    }
}

/// Fisher's p-value of two shares; `None` if the first is not the greater one.
fn more_often(first: (u64, u64), second: (u64, u64)) -> Option<f64> {
    let sample = |(successes, trials): (u64, u64)| Sample::new(successes, trials).ok();
    let is_more = first.0 as u128 * second.1 as u128 > second.0 as u128 * first.1 as u128;
    let (a, b) = (sample(first)?, sample(second)?);
    is_more.then(|| fisher_exact(a, b))
}

/// The signals that rules may be over, and how many rules there are of each kind.
struct Offered {
    named: Vec<usize>,
    numbers: Vec<usize>,
    /// A name, a cut, two names, a name and a cut: at both moments.
    kinds: [u64; 4],
    /// Conditions that can be added to another.
    singles: u64,
}

impl Offered {
    fn new(signals: &Signals, defining: &BTreeSet<String>, shown: usize) -> Self {
        let is_free = |signal: &str| !defining.contains(signal);
        let named = signals.named.iter().enumerate();
        let named: Vec<usize> = named
            .filter(|(_, it)| is_free(&it.signal))
            .map(|(place, _)| place)
            .collect();
        let numbers = signals.numbers.iter().enumerate();
        let numbers: Vec<usize> = numbers
            .filter(|(_, it)| is_free(&it.signal))
            .map(|(place, _)| place)
            .collect();
        let names: u64 = named.iter().map(|it| signals.named[*it].names.len() as u64).sum();
        // In both directions, at the value of each episode.
        let cuts = 2 * shown as u64 * numbers.len() as u64;
        let pairs = names * names.saturating_sub(1) / 2;
        let kinds = [names, cuts, pairs, names * cuts].map(|it| 2 * it);
        Self {
            named,
            numbers,
            kinds,
            singles: names + cuts,
        }
    }

    /// The names that episodes had at a moment.
    fn names_at(&self, table: &Table<'_>, moment: usize) -> Vec<Condition> {
        let mut names = Vec::new();
        for place in &self.named {
            let codes = table.shown.iter().filter_map(|it| it[moment].named.get(*place));
            let codes: BTreeSet<u16> = codes.copied().filter(|code| *code != u16::MAX).collect();
            names.extend(codes.into_iter().map(|code| Condition::Named(*place, code)));
        }
        names
    }

    /// Cuts at the numbers that episodes had at a moment.
    fn cuts_at(&self, table: &Table<'_>, moment: usize) -> Vec<Condition> {
        let mut cuts = Vec::new();
        for place in &self.numbers {
            let mut values: Vec<f32> = table
                .shown
                .iter()
                .filter_map(|it| it[moment].numbers.get(*place).copied().flatten())
                .collect();
            values.sort_by(f32::total_cmp);
            values.dedup();
            cuts.extend(values.iter().map(|it| Condition::AtLeast(*place, *it)));
            cuts.extend(values.iter().map(|it| Condition::AtMost(*place, *it)));
        }
        cuts
    }

    /// The cuts that take in all episodes that had a name at a moment.
    fn widest_at(&self, table: &Table<'_>, moment: usize, name: Condition) -> Vec<Condition> {
        let mut cuts = Vec::new();
        for place in &self.numbers {
            let named = table.shown.iter().filter(|it| name.holds(it[moment]));
            let values: Option<Vec<f32>> = named
                .map(|it| it[moment].numbers.get(*place).copied().flatten())
                .collect();
            // Where one has no number, no cut takes it in.
            let Some(values) = values else { continue };
            let least = values.iter().copied().min_by(f32::total_cmp);
            let most = values.iter().copied().max_by(f32::total_cmp);
            cuts.extend(least.map(|it| Condition::AtLeast(*place, it)));
            cuts.extend(most.map(|it| Condition::AtMost(*place, it)));
        }
        cuts
    }
}

#[cfg(test)]
mod tests {
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
        ];
        trace.add_channel("/cell", fields).expect("a new topic");
        trace
    }

    /// Numbers that look random, the same each time.
    struct Drawn(u64);

    impl Drawn {
        fn below(&mut self, n: u64) -> u64 {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 33) % n
        }
    }

    /// Episodes of a cell whose state goes through all four, in a mode and with a load that are drawn; `drops` says at which
    /// rows it shows the finding.
    fn cells(
        count: u64,
        drops: &mut dyn FnMut(&mut Drawn, &[f64; 5]) -> bool,
    ) -> (Signals, Recorded, Vec<(u64, f64)>) {
        let layout = layout();
        let signals = Signals::of(&layout);
        let (mut recorded, mut showed) = (Recorded::new(), Vec::new());
        let mut drawn = Drawn(5);
        for episode in 1..=count {
            let mut trace = layout.clone();
            trace.complete = true;
            let full = drawn.below(2) as f64;
            let load = drawn.below(1000) as f64 / 100.0;
            let mut first = None;
            for row in 0..8_u32 {
                let mut values = [f64::from(row / 2), full, drawn.below(2) as f64, load, 0.0];
                if first.is_none() && drops(&mut drawn, &values) {
                    first = Some(f64::from(row));
                    values[4] = 1.0;
                }
                trace.channels[0].push(f64::from(row), &values).expect("in order");
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
        let search = Search { signals, recorded, level };
        search.of(showed, &BTreeSet::from(["/cell.dropped".to_owned()]))
    }

    fn rule(told: &Distinction) -> String {
        told.rule_in_words()
    }

    #[test]
    fn the_state_and_the_mode_that_were_planted_are_told_with_their_counts() {
        let mut seen = 0;
        let cells = cells(80, &mut |_, values| values[0] == 2.0 && values[1] == 1.0);
        let showed = cells.2.len() as u64;
        assert!((25..55).contains(&showed), "{showed}");
        seen += showed;
        let found = told(&cells).expect("a rule");
        assert_eq!(rule(&found), "/cell.state = carry and /cell.full = true");
        assert_eq!(found.shown, [seen, seen]);
        // Half of the others carry, and the other half is full; none of them does both.
        assert_eq!(found.elsewhere, [0, 80 - seen]);
        assert!(!found.just_before && found.p_value < 1e-10);
        let words = found.in_words();
        assert!(words.starts_with("always and only while /cell.state = carry and /cell.full = true"), "{words}");
    }

    #[test]
    fn a_number_is_cut_where_it_separates_with_few_digits() {
        let cells = cells(60, &mut |_, values| values[0] == 1.0 && values[3] > 6.0);
        let found = told(&cells).expect("a rule");
        let load = found.terms.iter().find(|it| it.signal == "/cell.load").expect("a cut");
        assert_eq!(load.relation, SignalRelation::AtLeast);
        let cut: f64 = load.value.parse().expect("a number");
        assert!((5.5..=6.3).contains(&cut) && load.unit == "kg", "{load}");
        assert!(load.value.len() <= 4, "{load}");
        assert_eq!(found.elsewhere[0], 0, "{found:?}");
    }

    #[test]
    fn what_comes_by_chance_is_told_by_no_rule() {
        // In each episode with a chance of three in ten, at a row that is drawn, whatever the cell does.
        let mut claimed = 0;
        for start in 0..40 {
            let mut episode = 0;
            let mut chance = Drawn(start * 7919 + 1);
            let mut at = u64::MAX;
            let cells = cells(40, &mut |_, values| {
                if values[0] == 0.0 && episode % 8 == 0 {
                    at = if chance.below(10) < 3 { episode + chance.below(8) } else { u64::MAX };
                }
                episode += 1;
                at == episode - 1
            });
            assert!(cells.2.len() >= 3, "{start}");
            claimed += u32::from(told(&cells).is_ok());
        }
        // At most one in twenty is expected; the test is conservative.
        assert!(claimed <= 2, "{claimed}");
    }

    #[test]
    fn without_whole_others_nothing_is_told() {
        let mut all = cells(20, &mut |_, values| values[0] == 2.0);
        assert_eq!(all.2.len(), 20);
        assert_eq!(told(&all), Err(ALL_SHOWED.to_owned()));
        all.2.truncate(10);
        for (number, moments) in &mut all.1 {
            moments.is_whole = *number <= 10;
        }
        assert_eq!(told(&all), Err(ALL_SHOWED.to_owned()));
    }
}
