//! What an edit, or an exchange, explains: what goes away, what comes up, and its odds. The definition is that of [`super`].

use super::solved::Written;
use super::{Pairs, SAME, TextEdit};
use evidence::{Evidence, Rate, STRONG, Subject};
use std::collections::{BTreeMap, BTreeSet};

/// Decades for an edit if requirements alone disagree, or for one of a duration if those with a limit of time alone do.
pub(super) const STRUCTURE: f64 = 1.0;

/// Decades against an edit with which what it changes is the same in all runs.
pub(super) const PLAIN: f64 = -1.5;

/// Decades for an edit without which what it changes is the same in all runs.
pub(super) const WAS_PLAIN: f64 = 1.5;

/// Decades for what fixes pairs that otherwise need errors in several pieces, for each piece beyond the first.
pub(super) const COINCIDENCE: f64 = 1.0;

/// Pieces among which those that would have to be wrong are looked for, at most.
const MOST_PIECES: usize = 12;

/// The least and the most that an edit takes of what it explains.
const SHARES: [f64; 2] = [0.03, 0.97];

/// Decades by which what two numbers of one place explain differs, if both play no part.
const ALIKE: f64 = 0.05;

/// An edit with what it explains.
pub(super) struct Explained {
    pub(super) edit: TextEdit,
    /// The pairs that do not disagree strongly any more, with what goes away.
    pub(super) pairs: Pairs,
    /// What goes away, less what comes up: sums over subjects of the strongest.
    pub(super) score: f64,
    /// How well all agree on what it explains, and what the structure adds; in decades.
    pub(super) agreement: f64,
    /// Decades for or against it before the evidence.
    pub(super) prior: f64,
    /// The odds of all edits of its place that explain something: they accuse one asset.
    pub(super) odds: f64,
    /// Requirements that evidence misses now and meets with the edit, one clause each.
    pub(super) hides: Vec<String>,
}

/// What goes away if something is changed, and how well all agree then.
pub(super) struct Balance {
    pairs: Pairs,
    score: f64,
    agreement: f64,
}

impl Balance {
    pub(super) fn weight(&self) -> f64 {
        self.score + self.agreement
    }
}

/// What a change explains, if it makes little worse.
pub(super) fn balance(
    before: &Pairs,
    after: &Pairs,
    is_timed: &dyn Fn(&Subject) -> bool,
) -> Option<Balance> {
    let mut subjects: BTreeMap<&Subject, [f64; 2]> = BTreeMap::new();
    for (pair, was) in before {
        // A rate that is lost explains nothing.
        let is = *after.get(pair)?;
        let most = subjects.entry(&pair.2).or_insert([f64::NEG_INFINITY; 2]);
        *most = [most[0].max(*was), most[1].max(is)];
    }
    let (mut gone, mut come, mut agreement) = (0.0, 0.0, 0.0);
    let mut mended: Vec<&Subject> = Vec::new();
    for (subject, [was, is]) in &subjects {
        come += (is.max(0.0) - was.max(0.0)).max(0.0);
        if *was > STRONG && *is <= STRONG {
            gone += was - is.max(0.0);
            agreement += (-is).max(0.0);
            mended.push(subject);
        }
    }
    let is_mode = |subject: &Subject| matches!(subject, Subject::FailureMode(_));
    let mut modes = subjects.iter().filter(|(subject, _)| is_mode(subject));
    let modes_agree = subjects.keys().any(|subject| is_mode(subject))
        && modes.all(|(_, [was, _])| *was <= STRONG);
    let is_plain = mended
        .iter()
        .any(|subject| !is_mode(subject) && !is_timed(subject));
    if modes_agree && is_plain {
        agreement += STRUCTURE;
    }
    let pairs = before
        .iter()
        .filter(|(pair, was)| **was > STRONG && mended.contains(&&pair.2));
    let pairs: Pairs = pairs
        .map(|(pair, was)| (pair.clone(), was - after.get(pair).unwrap_or(was)))
        .collect();
    let beyond_one =
        fewest_wrong(pairs.keys().map(|(one, other, _)| (one, other))).saturating_sub(1);
    agreement += f64::from(beyond_one) * COINCIDENCE;
    let score = gone - come;
    (score > STRONG && come <= STRONG).then_some(Balance {
        pairs,
        score,
        agreement,
    })
}

/// How many pieces have to be wrong, at the least, if in each of these pairs one is.
fn fewest_wrong<'p>(pairs: impl Iterator<Item = (&'p String, &'p String)>) -> u32 {
    let pairs: BTreeSet<(&String, &String)> = pairs.collect();
    let pieces: BTreeSet<&String> = pairs
        .iter()
        .flat_map(|(one, other)| [*one, *other])
        .collect();
    let pieces: Vec<&String> = pieces.into_iter().take(MOST_PIECES).collect();
    let wrong = |set: u32, piece: &String| {
        let place = pieces.iter().position(|it| *it == piece);
        // Whoever is not looked at may be wrong.
        place.is_none_or(|place| set >> place & 1 == 1)
    };
    let all = 0..1_u32 << pieces.len();
    let enough = all.filter(|set| {
        pairs
            .iter()
            .all(|(one, other)| wrong(*set, one) || wrong(*set, other))
    });
    enough.map(u32::count_ones).min().unwrap_or(0)
}

/// What an edit explains, if it makes little worse.
pub(super) fn explained(
    edit: TextEdit,
    before: &Pairs,
    after: &Pairs,
    is_timed: &dyn Fn(&Subject) -> bool,
) -> Option<Explained> {
    let found = balance(before, after, is_timed)?;
    let is_only_timed = found.pairs.keys().all(|(.., subject)| is_timed(subject))
        && before
            .iter()
            .any(|((.., subject), was)| *was <= STRONG && !is_timed(subject));
    let structure = match edit.is_of_time() && is_only_timed {
        true => STRUCTURE,
        false => 0.0,
    };
    Some(Explained {
        edit,
        pairs: found.pairs,
        score: found.score,
        agreement: found.agreement + structure,
        prior: 0.0,
        odds: 0.0,
        hides: Vec::new(),
    })
}

/// Takes out numbers of one place that do the same as another one, if the least or the greatest of all that were tried there is among
/// these, unless something says one of them: a duration that may be any, as long as it is long, explains nothing by its value.
/// Two numbers between which a model makes no difference may well be limits.
pub(super) fn drop_limits_that_play_no_part(found: &mut Vec<Explained>, tried: &[TextEdit]) {
    let plays_no_part = |it: &Explained| {
        let is_of_place = |other: &&Explained| other.edit.is_of_place(&it.edit);
        let is_alike = |other: &&Explained| {
            (other.agreement - it.agreement).abs() < ALIKE && (other.score - it.score).abs() < ALIKE
        };
        let alike: Vec<&TextEdit> = found
            .iter()
            .filter(|other| is_of_place(other) && is_alike(other))
            .map(|other| &other.edit)
            .collect();
        let own = tried.iter().filter(|other| other.is_of_place(&it.edit));
        let solved = found.iter().filter(is_of_place).map(|other| &other.edit);
        let numbers: Vec<f64> = own.chain(solved).filter_map(number_of).collect();
        let least = numbers.iter().copied().fold(f64::INFINITY, f64::min);
        let greatest = numbers.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let is_end =
            |edit: &&TextEdit| number_of(edit).is_none_or(|it| it <= least || it >= greatest);
        !it.edit.is_said && it.edit.is_number() && alike.len() > 1 && alike.iter().any(is_end)
    };
    let kept: Vec<bool> = found.iter().map(|it| !plays_no_part(it)).collect();
    let mut kept = kept.into_iter();
    found.retain(|_| kept.next().unwrap_or(true));
}

/// The number that an edit writes.
fn number_of(edit: &TextEdit) -> Option<f64> {
    Written::read(&edit.new).map(|it| it.value)
}

/// Whether it is the same in all runs.
fn is_extreme(rate: Rate) -> bool {
    match rate {
        Rate::Counted { .. } => rate.has_one_outcome(),
        Rate::Computed(value) => value <= SAME || value >= 1.0 - SAME,
        Rate::Never => true,
    }
}

/// The rates before and after of those of a pair whose rate changes.
fn changed(
    (one, other, subject): &(String, String, Subject),
    before: &[Evidence],
    after: &[Evidence],
) -> Vec<[Rate; 2]> {
    let of = |id: &String| {
        let (was, is) = (rate_of(before, id, subject), rate_of(after, id, subject)?);
        (was != Some(is)).then_some([was.unwrap_or(is), is])
    };
    [one, other].into_iter().filter_map(of).collect()
}

fn rate_of(evidence: &[Evidence], id: &str, subject: &Subject) -> Option<Rate> {
    let piece = evidence.iter().find(|piece| piece.id == id)?;
    Rate::asked(piece, subject)
}

impl Explained {
    /// Whether all that it makes agree is then the same in every run of every piece: who judges all runs alike agrees on
    /// anything. So does a model that is certain where what it is held against is not.
    pub(super) fn is_constant(&self, evidence: &[Evidence]) -> bool {
        let of_pair = |(one, other, subject): &(String, String, Subject)| {
            [one, other].map(|id| rate_of(evidence, id, subject))
        };
        let are_extreme = |pair| of_pair(pair).into_iter().flatten().all(is_extreme);
        let is_contradicted = |pair| {
            let [one, other] = of_pair(pair);
            let is_certain = |it: Option<Rate>| {
                matches!(it, Some(Rate::Computed(_))) && it.is_some_and(is_extreme)
            };
            let is_counted = |it: Option<Rate>| {
                matches!(it, Some(Rate::Counted { .. })) && it.is_some_and(|it| !is_extreme(it))
            };
            is_certain(one) && is_counted(other) || is_certain(other) && is_counted(one)
        };
        self.pairs.keys().all(are_extreme) || self.pairs.keys().any(is_contradicted)
    }

    /// Whether the pieces that it changes are then each the same in all their runs, where others are not.
    pub(super) fn is_plain(&self, before: &[Evidence], after: &[Evidence]) -> bool {
        let all = self
            .pairs
            .keys()
            .flat_map(|pair| changed(pair, before, after));
        all.into_iter().all(|[_, is]| is_extreme(is))
    }

    /// Whether they were each the same in all their runs, and are not then.
    pub(super) fn was_plain(&self, before: &[Evidence], after: &[Evidence]) -> bool {
        let all = self
            .pairs
            .keys()
            .flat_map(|pair| changed(pair, before, after));
        let mut all = all.peekable();
        all.peek().is_some() && all.all(|[was, is]| is_extreme(was) && !is_extreme(is))
    }

    /// Its odds against the system models.
    pub(super) fn own_odds(&self) -> f64 {
        10.0_f64.powf(self.agreement + self.prior)
    }

    /// The part of what it explains that it takes from the system models.
    pub(super) fn share(&self) -> f64 {
        (self.odds / (1.0 + self.odds)).clamp(SHARES[0], SHARES[1])
    }

    /// By what it is ranked among the edits.
    pub(super) fn weight(&self) -> f64 {
        self.score + self.agreement + self.prior
    }

    pub(super) fn in_words(&self) -> String {
        let edit = &self.edit;
        format!("{} ({}: `{}`)", edit.file, edit.part, edit.new_in_words())
    }
}

#[cfg(test)]
mod tests {
    use super::{Explained, Pairs, TextEdit, drop_limits_that_play_no_part, fewest_wrong};

    /// What a number in place of 12 explains, always as well.
    fn number(new: u32) -> Explained {
        Explained {
            edit: TextEdit {
                old: "12".to_owned(),
                new: new.to_string(),
                ..TextEdit::none()
            },
            pairs: Pairs::new(),
            score: 10.0,
            agreement: 1.0,
            prior: 0.0,
            odds: 0.0,
            hides: Vec::new(),
        }
    }

    #[test]
    fn limits_that_do_the_same_are_meant_unless_the_farthest_does_so_too() {
        let tried: Vec<TextEdit> = (4..=20).map(|it| number(it).edit).collect();
        let kept = |numbers: &[u32]| {
            let mut found: Vec<Explained> = numbers.iter().map(|it| number(*it)).collect();
            drop_limits_that_play_no_part(&mut found, &tried);
            found.len()
        };
        assert_eq!(kept(&[7, 8]), 2);
        assert_eq!(kept(&[8]), 1);
        assert_eq!(kept(&[17, 18, 19, 20]), 0);
        assert_eq!(kept(&[4, 5]), 0);
    }

    #[test]
    fn one_piece_may_be_wrong_against_all_others_but_two_sides_of_two_need_two() {
        let count = |pairs: &[(&str, &str)]| {
            let pairs: Vec<(String, String)> = pairs
                .iter()
                .map(|(a, b)| ((*a).to_owned(), (*b).to_owned()))
                .collect();
            fewest_wrong(pairs.iter().map(|(a, b)| (a, b)))
        };
        assert_eq!(count(&[]), 0);
        assert_eq!(count(&[("M", "S"), ("M", "T"), ("M", "O")]), 1);
        assert_eq!(count(&[("M", "S"), ("M", "O"), ("T", "S"), ("T", "O")]), 2);
        assert_eq!(count(&[("M", "S"), ("S", "T"), ("M", "T")]), 2);
    }
}
