//! What the robot did where a finding showed that it does not do elsewhere, as a rule over recorded signals.
//!
//! # Definition
//! A rule is a condition on one signal (an enumeration or truth value has a value; a number is at least or at most a cut)
//! or two such conditions on different signals, at most one of them on a number. Of an episode that showed the finding it
//! is asked whether the rule held at that moment, or just before it (at the last sample of an earlier time); of every
//! other whole episode whether it *ever* held. A rule separates by how far these two shares lie apart: the two-sided p-value of
//! Fisher's exact test. Signals that define the finding (that its requirement reads, or by which abstract states are told
//! apart) are left out, since they would only say it again; so are clocks, numbers in a unit of time that never fall.
//!
//! Episodes that are told apart may do many things, of which the finding shows in one. So conditions on names are
//! added, at most until there are two or one besides two, that hold for a small share of the time of the episodes that showed it and yet when it shows. Were it to show at any time
//! of its episode with the same chance, the number of episodes in which the conditions hold then would be a sum of independent trials whose
//! chances are those shares of time (Poisson binomial); the p-value is the chance of as many or more.
//!
//! # Assumes
//! Under the hypothesis episodes are independent, and those that showed the finding differ from the others by chance. What
//! shows does so at any time of its episode with the same chance. Those of an exploration are chosen, so that neither is
//! sure.
//!
//! # Guarantee
//! Others have all their moments to meet a rule and a finding has one, so the comparison is against the rule. There are
//! four kinds of rules (a name, a cut, two names, a name and a cut). Each p-value is multiplied by the number of rules of its kind that
//! the signals allow, whether they were looked at or not, and by the number of kinds (Bonferroni), and a rule is told only where that is below
//! one minus the study's confidence. A second condition is told only where it separates, in the same sense, among the
//! episodes that meet the first; one on moments only where its own p-value, times the names that there are, is. That holds of episodes that
//! differ by chance. Those of an exploration are chosen, so that what is told is an association to look into, and neither a cause nor a rate.
//!
//! # Cost
//! O(rules × other episodes × combinations of an episode).

use super::moments::{Condition, Moments, Number, Signals, Values};
use diagnostic::counted;
use evidence::{Distinction, SignalRelation, SignalTerm};
use stats::{Confidence, Sample, fisher_exact};
use std::collections::{BTreeMap, BTreeSet};

/// Kinds of rules.
const KINDS: u64 = 4;

/// Rules as good as the best that are named.
const NAMED: usize = 5;

/// Conditions that a rule has once those on moments are added, at most; one is added to two as well. More would say when within
/// a state a finding first shows, and not in which state.
const MOST_CONDITIONS: usize = 2;

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
    /// What these episodes had at any time, in the same order.
    own: Vec<&'a Moments>,
    others: Vec<&'a Moments>,
}

/// How many of the two groups meet a rule.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Counts {
    shown: u64,
    elsewhere: u64,
}

/// Conditions on moments.
struct Added {
    moment: usize,
    conditions: Vec<Condition>,
    share_of_time: f64,
    p_value: f64,
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
        let offered = Offered::new(self, defining, table.shown.len());
        let mut rules: Vec<Rule> = Vec::new();
        for moment in [0, 1] {
            self.rules(&table, &offered, moment, &mut rules);
        }
        let best = self.best(&table, &offered, &rules);
        self.told(&table, &offered, best, &rules).ok_or_else(|| {
            format!(
                "no rule over {} separates its {} from {}, or its moments from other moments, beyond chance",
                counted(offered.named.len() + offered.numbers.len(), "recorded signal"),
                counted(table.shown.len(), "episode"),
                counted(table.others.len(), "other")
            )
        })
    }

    fn table(&self, showed: &[(u64, f64)]) -> Table<'_> {
        let moment = |(episode, secs): &(u64, f64)| {
            let own = self.recorded.get(episode)?;
            let moment = own.at_secs(*secs)?;
            Some(([&moment.then, &moment.before], own))
        };
        let (shown, own) = showed.iter().filter_map(moment).unzip();
        let numbers: BTreeSet<u64> = showed.iter().map(|(episode, _)| *episode).collect();
        let others = self.recorded.iter().filter(|(number, moments)| {
            // What was cut short may have done it later.
            moments.is_whole && !numbers.contains(number)
        });
        Table {
            shown,
            own,
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
    fn best<'r>(
        &self,
        table: &Table<'_>,
        offered: &Offered,
        rules: &'r [Rule],
    ) -> Option<&'r Rule> {
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
        let words: Vec<String> = rule
            .conditions
            .iter()
            .map(|it| self.term(*it, None).to_string())
            .collect();
        (
            rule.conditions.len(),
            others.count(),
            rule.moment,
            words.join(" and "),
        )
    }

    /// The rule that separates episodes, if there is one, with what separates moments within them, if that does.
    fn told(
        &self,
        table: &Table<'_>,
        offered: &Offered,
        best: Option<&Rule>,
        rules: &[Rule],
    ) -> Option<Distinction> {
        let moments = match best {
            Some(rule) => vec![rule.moment],
            None => vec![0, 1],
        };
        let of_episodes = best.map_or(Vec::new(), |rule| rule.conditions.clone());
        let added = moments
            .into_iter()
            .map(|moment| self.added(table, offered, moment, &of_episodes))
            .min_by(|a, b| a.p_value.total_cmp(&b.p_value))?;
        if best.is_none() && added.conditions.is_empty() {
            return None;
        }
        let conditions: Vec<Condition> = added
            .conditions
            .iter()
            .chain(&of_episodes)
            .copied()
            .collect();
        let counts = table.counts(added.moment, &conditions);
        let whole = Rule {
            moment: added.moment,
            conditions,
            counts,
            of: best.map_or(offered.singles, |rule| rule.of),
            p_value: 1.0,
        };
        let has_added = !added.conditions.is_empty();
        Some(Distinction {
            terms: self.terms(table, &whole),
            just_before: whole.moment == 1,
            shown: [counts.shown, table.shown.len() as u64],
            elsewhere: [counts.elsewhere, table.others.len() as u64],
            p_value: best.map(|rule| rule.p_value),
            share_of_time: has_added.then_some(added.share_of_time),
            moment_p_value: has_added.then_some(added.p_value),
            rules: whole.of,
            as_good: best.map_or(Vec::new(), |best| self.as_good(table, best, rules)),
        })
    }

    /// The conditions on names that separate the moments of a finding from others of its episodes.
    fn added(
        &self,
        table: &Table<'_>,
        offered: &Offered,
        moment: usize,
        given: &[Condition],
    ) -> Added {
        let most = self.level.alpha();
        let mut added = Added {
            moment,
            conditions: Vec::new(),
            share_of_time: 1.0,
            p_value: 1.0,
        };
        let names = offered.names_at(table, moment);
        let most_added = MOST_CONDITIONS.saturating_sub(given.len()).max(1);
        while added.conditions.len() < most_added {
            let have: Vec<Condition> = given.iter().chain(&added.conditions).copied().collect();
            let is_new =
                |it: &&Condition| have.iter().all(|known| place_of(*known) != place_of(**it));
            let tried = names.iter().filter(is_new).map(|name| {
                let (p_value, share) = table.moment_p_value(moment, &have, *name);
                ((p_value * offered.names as f64).min(1.0), share, *name)
            });
            let best = tried.min_by(|a, b| {
                let order = a.0.total_cmp(&b.0);
                order.then_with(|| self.rank_of(a.2).cmp(&self.rank_of(b.2)))
            });
            let Some((p_value, share_of_time, name)) = best.filter(|it| it.0 < most) else {
                break;
            };
            added.conditions.push(name);
            added.p_value = p_value.max(if added.conditions.len() > 1 {
                added.p_value
            } else {
                0.0
            });
            added.share_of_time = share_of_time;
        }
        added
    }

    fn rank_of(&self, name: Condition) -> (bool, String) {
        let is_enumeration = match name {
            Condition::Named(place, _) => self.signals.named[place].is_enumeration,
            Condition::AtLeast(..) | Condition::AtMost(..) => false,
        };
        (!is_enumeration, self.term(name, None).to_string())
    }

    /// Other rules with the same counts as the best.
    fn as_good(&self, table: &Table<'_>, best: &Rule, rules: &[Rule]) -> Vec<String> {
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
        named
    }

    fn terms(&self, table: &Table<'_>, rule: &Rule) -> Vec<SignalTerm> {
        let conditions = rule.conditions.iter();
        conditions
            .map(|it| self.term(*it, Some((table, rule))))
            .collect()
    }

    /// A condition in words. A cut is put between the values on its two sides, where it has as few digits as it can.
    fn term(&self, condition: Condition, of: Option<(&Table<'_>, &Rule)>) -> SignalTerm {
        let (place, relation, cut) = match condition {
            Condition::Named(place, code) => {
                let named = &self.signals.named[place];
                return SignalTerm {
                    signal: named.signal.clone(),
                    relation: SignalRelation::Equals,
                    value: named
                        .names
                        .get(usize::from(code))
                        .cloned()
                        .unwrap_or_default(),
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
        let magnitude = if cut == 0.0 {
            0
        } else {
            cut.abs().log10().floor() as i32
        };
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

impl Table<'_> {
    /// The p-value of a name among the moments that meet what is given, and for which share of the time of the episodes that
    /// showed the finding all of it holds.
    fn moment_p_value(&self, moment: usize, given: &[Condition], name: Condition) -> (f64, f64) {
        let all: Vec<Condition> = given.iter().copied().chain([name]).collect();
        let of_names = |conditions: &[Condition]| -> Vec<Condition> {
            conditions
                .iter()
                .filter(|it| !it.is_of_number())
                .copied()
                .collect()
        };
        let (given_names, all_names) = (of_names(given), of_names(&all));
        let (mut chances, mut times, mut share) = (Vec::new(), 0_usize, 0.0);
        for (values, own) in self.shown.iter().zip(&self.own) {
            let all_share = own.share_of_time(&all_names);
            share += all_share;
            if !given.iter().all(|it| it.holds(values[moment])) {
                continue;
            }
            // What was there for no time was there at the moment at least.
            let given_share = own.share_of_time(&given_names);
            let chance = if given_share > 0.0 {
                all_share / given_share
            } else {
                1.0
            };
            chances.push(chance.clamp(0.0, 1.0).max(LEAST_CHANCE));
            times += usize::from(name.holds(values[moment]));
        }
        (
            at_least(times, &chances),
            share / self.shown.len().max(1) as f64,
        )
    }
}

/// A finding shows at a sample, which may be of a state that had only just begun: no episode counts for more than this.
const LEAST_CHANCE: f64 = 0.05;

/// The chance that at least so many of independent trials succeed.
fn at_least(times: usize, chances: &[f64]) -> f64 {
    // By how many succeed; more than `times` are as good as that.
    let mut of_count = vec![0.0; times + 1];
    of_count[0] = 1.0;
    for chance in chances {
        for count in (0..=times).rev() {
            let stays = if count == times { 1.0 } else { 1.0 - chance };
            let from = if count > 0 {
                of_count[count - 1] * chance
            } else {
                0.0
            };
            of_count[count] = of_count[count] * stays + from;
        }
    }
    of_count[times].min(1.0)
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
    /// Names that conditions can be on.
    names: u64,
}

impl Offered {
    fn new(search: &Search<'_>, defining: &BTreeSet<String>, shown: usize) -> Self {
        let signals = search.signals;
        // What is measured in time and never falls is a clock: it says when, and not what was done.
        let is_clock = |place: usize, of: &Number| {
            of.is_time && !search.recorded.values().any(|it| it.has_fallen(place))
        };
        let is_free = |signal: &str| !defining.contains(signal);
        let named = signals.named.iter().enumerate();
        let named: Vec<usize> = named
            .filter(|(_, it)| is_free(&it.signal))
            .map(|(place, _)| place)
            .collect();
        let numbers = signals.numbers.iter().enumerate();
        let numbers: Vec<usize> = numbers
            .filter(|(place, it)| is_free(&it.signal) && !is_clock(*place, it))
            .map(|(place, _)| place)
            .collect();
        let names: u64 = named
            .iter()
            .map(|it| signals.named[*it].names.len() as u64)
            .sum();
        // In both directions, at the value of each episode.
        let cuts = 2 * shown as u64 * numbers.len() as u64;
        let pairs = names * names.saturating_sub(1) / 2;
        let kinds = [names, cuts, pairs, names * cuts].map(|it| 2 * it);
        Self {
            named,
            numbers,
            kinds,
            singles: names + cuts,
            names: 2 * names,
        }
    }

    /// The names that episodes had at a moment.
    fn names_at(&self, table: &Table<'_>, moment: usize) -> Vec<Condition> {
        let mut names = Vec::new();
        for place in &self.named {
            let codes = table
                .shown
                .iter()
                .filter_map(|it| it[moment].named.get(*place));
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
mod tests;
