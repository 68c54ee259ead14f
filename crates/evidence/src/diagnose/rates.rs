//! Clues against system models, requirement models and solvers: what is left of a conflict when one
//! asset is changed at a time.
//!
//! # Definition
//! A conflict of two pieces `X`, `Y` on a subject has the strength `T = c(X, Y)` (see
//! [`mod@super::strength`]). Each piece may have judged its runs by other forms of the requirement, and a
//! model by other methods.
//!
//! * *tool*: with the answer of a method whose bounds hold in place of one without, `T_s` is left; the
//!   solver's share is `T - T_s`;
//! * *names*: with two names of a table exchanged, where they were mixed up (`names`), `T_n` is left, and the table's share
//!   is `T_s - T_n`; likewise what two tables or models take that changed places with each other (`places`);
//! * *requirement model*: like is compared with like: property with property (cells A and B or C),
//!   monitor with monitor (D and E or F), and each reading of one piece with the other piece. Under the
//!   other form a computed value is moved by what the two forms differ by on the same sampled paths. Of these
//!   `m` is the least that is left; the requirement models' share is `T_s - m` if that is strong
//!   evidence (at least 1), else 0;
//! * *system model*: the rest, of the strongest of its conflicts what it differs by from all others together, where these
//!   have voices of their own and agree. It is shared out between `X` and `Y` as [`super::blame`] does.
//!
//! # Assumes
//! One asset at a time is wrong, so that what goes away with its change is due to it. Trials are independent, or count at
//! their effective size; two forms are held against each other on the same paths.
//!
//! # Source and guarantee
//! Changing one thing at a time and taking the difference is the method of difference (J. S. Mill, 1843);
//! the shares add up to the conflict, but for shares of a system model below [`NAMED`] and where a model counts what it
//! differs by from all others together. Each conflict gives at least one clue.

use super::blame::is_read_from_runs;
use super::exchanged::{Exchanged, exchanged, is_table};
use super::forms::SENTENCE;
use super::matter::{Clue, Judged, Matter, name_of, rate_in_words, requirement_form};
use super::strength::{CERTAIN, Rate, STRONG, strength, weighed};
use super::suspect::{Figure, ODD_ONE_OUT, SuspectAsset, SuspectKind, Symptom};
use crate::{AskedBy, Comparison, Evidence, Inaccuracy, Measure, Subject};

/// The most that two models count against each other: they differ for certain, but only data say which is wrong.
const MODELS: f64 = 2.0;

/// The least probability of being the odd one out at which a piece is named.
pub(super) const NAMED: f64 = 0.01;

/// What is left of a conflict when a requirement's forms are changed.
struct LikeForLike {
    left: f64,
    /// The piece whose form was changed, and the form in place of its own.
    changed: String,
    form: String,
}

impl<'a> Matter<'a> {
    /// Clues from all conflicts.
    pub(super) fn of_conflicts(&self) -> Vec<Clue> {
        let conflicts = self.conflicts();
        let clues = conflicts
            .iter()
            .flat_map(|conflict| self.of_conflict(conflict));
        let mut clues: Vec<Clue> = clues.collect();
        self.against_all(&mut clues);
        clues
    }

    /// Where a piece differs from several that have voices of their own and agree with one another, its strongest clue is
    /// as strong as what it differs by from all of them together.
    fn against_all(&self, clues: &mut [Clue]) {
        let mut groups: Vec<(String, Subject, Vec<usize>)> = Vec::new();
        for (place, clue) in clues.iter().enumerate() {
            let Symptom::RateDiffers { evidence, .. } = &clue.symptom else {
                continue;
            };
            let is_open = clue.resolved_by.is_none();
            if clue.inaccuracy != Inaccuracy::SystemModel || !is_open {
                continue;
            }
            let mut all = groups.iter_mut();
            match all.find(|(id, subject, _)| id == evidence && subject == &clue.subject) {
                Some((.., places)) => places.push(place),
                None => groups.push((evidence.clone(), clue.subject.clone(), vec![place])),
            }
        }
        for (id, subject, mut places) in groups {
            places.sort_by(|a, b| clues[*b].score.total_cmp(&clues[*a].score));
            if let Some(score) = self.against_pool(&id, &subject, &places, clues) {
                let strongest = &mut clues[places[0]];
                strongest.score = strongest.score.max(score);
            }
        }
    }

    fn against_pool(
        &self,
        id: &str,
        subject: &Subject,
        places: &[usize],
        clues: &[Clue],
    ) -> Option<f64> {
        let margin = self.margin(subject);
        let own = rate_or_never(self.piece(id)?, subject)?;
        let mut pool: Vec<(&Evidence, Rate)> = Vec::new();
        let mut share = 1.0_f64;
        for place in places {
            let clue = &clues[*place];
            let Symptom::RateDiffers { others, .. } = &clue.symptom else {
                continue;
            };
            let other = self.piece(&others.first()?.0)?;
            let Some(rate @ Rate::Counted { .. }) = rate_or_never(other, subject) else {
                continue;
            };
            let is_new = pool.iter().all(|(known, theirs)| {
                known.id != other.id
                    && !super::voices::share_assumption(known, other, subject)
                    && strength(*theirs, rate, margin) < STRONG
            });
            if is_new {
                pool.push((other, rate));
                let odd = clue.figures.iter().find(|it| it.name == ODD_ONE_OUT)?;
                share = share.min(odd.value);
            }
        }
        let all: Vec<Rate> = pool.iter().map(|(_, rate)| *rate).collect();
        (pool.len() > 1).then(|| share * strength(own, Rate::pooled(&all), margin))
    }

    fn of_conflict(&self, conflict: &Comparison) -> Vec<Clue> {
        let (Some(one), Some(other)) = (self.piece(&conflict.left), self.piece(&conflict.right))
        else {
            return Vec::new();
        };
        let subject = &conflict.subject;
        let mut clues = Vec::new();
        let mut left = self.difference(one, other, subject);
        if [one, other]
            .iter()
            .all(|piece| piece.technique.is_of_model())
        {
            left = left.min(MODELS);
        }
        for (piece, against) in [(one, other), (other, one)] {
            if let Some((clue, rest)) = self.of_solver(piece, against, subject, left) {
                left = rest;
                clues.push(clue);
            }
        }
        for (piece, against) in [(one, other), (other, one)] {
            let margin = |subject: &Subject| self.margin(subject);
            let exchanged = match exchanged(self.evidence, piece, &margin) {
                Some(Exchanged::Columns(_)) => self.of_columns(piece, against, subject, left),
                Some(Exchanged::Names(_)) => self.of_names(piece, against, subject, left),
                None => None,
            };
            if let Some((clue, rest)) = exchanged {
                left = rest;
                clues.push(clue);
            }
        }
        let (moved, rest) = self.of_places([one, other], subject, left);
        clues.extend(moved);
        left = rest;
        if left < STRONG && !clues.is_empty() {
            return clues;
        }
        let like = self.like_for_like(one, other, subject);
        if let Some(like) = like.filter(|like| left - like.left >= STRONG) {
            clues.push(self.of_form(&like, one, other, subject, left));
            left = like.left;
            if left < STRONG {
                return clues;
            }
        }
        clues.extend(self.of_systems(one, other, subject, left));
        clues
    }

    /// What of a conflict goes away with the answer of a sound method.
    fn of_solver(
        &self,
        piece: &Evidence,
        against: &Evidence,
        subject: &Subject,
        whole: f64,
    ) -> Option<(Clue, f64)> {
        let Measure::Probability { answer, others, .. } = &piece.finding(subject)?.measure else {
            return None;
        };
        let sound = others.iter().find(|other| other.guarantee.is_certain())?;
        if !answer.guarantee.is_estimated() {
            return None;
        }
        let theirs = Rate::on(against, subject)?;
        let rest = strength(Rate::Computed(sound.value), theirs, self.margin(subject));
        (whole - rest >= STRONG).then(|| {
            let clue = Clue {
                inaccuracy: Inaccuracy::Tool,
                asset: solver(piece, &answer.method),
                subject: subject.clone(),
                score: whole - rest,
                title: format!("the method `{}` stopped too early in {}", answer.method, piece.id),
                explanation: format!(
                    "For {}, `{}` answers {} and `{}` {} with bounds that hold. Of the conflict with {} \
                     (Bayes factor 10^{whole:.1}) 10^{rest:.1} is left with the latter.",
                    name_of(subject), answer.method, answer.value, sound.method, sound.value, against.id
                ),
                symptom: Symptom::SolverStopped {
                    subject: subject.clone(),
                    method: answer.method.clone(),
                    value: answer.value,
                    sound: sound.method.clone(),
                    sound_value: sound.value,
                },
                figures: Vec::new(),
                witnesses: Vec::new(),
                ruled_out: Vec::new(),
                resolved_by: None,
            };
            (clue, rest)
        })
    }

    /// The least that is left of a conflict if both are judged alike.
    fn like_for_like(
        &self,
        one: &Evidence,
        other: &Evidence,
        subject: &Subject,
    ) -> Option<LikeForLike> {
        let (of_one, of_other) = (self.judged(one, subject), self.judged(other, subject));
        let margin = self.margin(subject);
        let mut found: Option<LikeForLike> = None;
        for a in &of_one {
            for b in &of_other {
                let Some((piece, form)) = changed(one, a, other, b) else {
                    continue;
                };
                let left = strength(a.rate, b.rate, margin);
                if found.as_ref().is_none_or(|best| left < best.left) {
                    let changed = piece.id.clone();
                    found = Some(LikeForLike {
                        left,
                        changed,
                        form,
                    });
                }
            }
        }
        found
    }

    /// The clue against the form that explains a conflict.
    fn of_form(
        &self,
        like: &LikeForLike,
        one: &Evidence,
        other: &Evidence,
        subject: &Subject,
        whole: f64,
    ) -> Clue {
        let (piece, against) = match one.id == like.changed {
            true => (one, other),
            false => (other, one),
        };
        let own = own_form(piece);
        // Where the real system contradicts one of the two, that is in doubt; else, where the sentence takes the side of
        // the piece's own form, the other.
        let against_sentence = |form: &str| self.differs_from_sentence(subject, form);
        let by_sentence = match (against_sentence(own), against_sentence(&like.form)) {
            (Some(false), Some(true)) => like.form.as_str(),
            _ => own,
        };
        let contradicted = self.contradicted(piece, subject, [own, &like.form]);
        let doubted = contradicted.unwrap_or(by_sentence);
        // The form of which piece it is.
        let holder = match doubted != own && own_form(against) == doubted {
            true => against,
            false => piece,
        };
        let (differing, runs, witnesses) = self.two_verdicts(piece, subject, &like.form);
        let said = match differing {
            0 => String::new(),
            n => format!(
                " On the same runs of {} the two give {n} other verdicts.",
                piece.id
            ),
        };
        let rates = format!(
            "{} against {}",
            rate_in_words(piece, subject),
            rate_in_words(against, subject)
        );
        let says_so_too = against_sentence(doubted) == Some(false);
        let sided = match contradicted {
            Some(form) if says_so_too => format!(
                " The counts of the real system contradict the {}; the sentence says the same as it, and is in doubt with it.",
                named(form)
            ),
            _ => String::new(),
        };
        Clue {
            inaccuracy: Inaccuracy::RequirementModel,
            asset: requirement_form(subject, doubted, &[&holder.id]),
            subject: subject.clone(),
            score: whole - like.left,
            title: format!(
                "the {} of {} explains a conflict",
                named(doubted),
                name_of(subject)
            ),
            explanation: format!(
                "{rates}: a conflict on {} {}; judged by `{}` instead, 10^{:.1}.{said}{sided}",
                name_of(subject),
                weighed(whole),
                like.form,
                like.left
            ),
            symptom: Symptom::FormsDiffer {
                subject: subject.clone(),
                form: doubted.to_owned(),
                reference: if doubted == own {
                    like.form.clone()
                } else {
                    own.to_owned()
                },
                evidence: piece.id.clone(),
                differing,
                runs,
            },
            figures: vec![
                figure("conflict, log10 Bayes factor", whole),
                figure("left of it, log10 Bayes factor", like.left),
            ],
            witnesses: self.witnesses(
                piece,
                &witnesses,
                &format!("{own} and `{}` differ", like.form),
            ),
            ruled_out: match like.left < STRONG {
                true => vec![format!(
                    "the system models of {} and {}: judged alike they do not differ",
                    one.id, other.id
                )],
                false => Vec::new(),
            },
            resolved_by: self.mended(piece, against, subject),
        }
    }

    /// On how many runs, of how many, a piece's own form and another differ, and some of them.
    fn two_verdicts(
        &self,
        piece: &Evidence,
        subject: &Subject,
        form: &str,
    ) -> (u64, u64, Vec<String>) {
        let finding = piece.finding(subject);
        let reading = finding.and_then(|f| f.readings.iter().find(|r| r.name == form));
        if let Some(reading) = reading {
            let trials = finding.map_or(0, |f| match f.measure {
                Measure::Counts { trials, .. } => trials,
                _ => 0,
            });
            return (
                reading.differing,
                trials.max(reading.trials),
                reading.witnesses.clone(),
            );
        }
        let all = piece.form_differences.iter();
        let mut of_form = all
            .filter(|d| &d.subject == subject && d.form == form)
            .peekable();
        let runs = of_form.peek().map_or(0, |d| d.runs);
        let (mut count, mut witnesses) = (0, Vec::new());
        for difference in of_form {
            count += difference.count;
            witnesses.extend(difference.witnesses.iter().cloned());
        }
        (count, runs, witnesses)
    }

    /// Clues against the two system models, as far as each is the odd one out.
    fn of_systems(
        &self,
        one: &Evidence,
        other: &Evidence,
        subject: &Subject,
        left: f64,
    ) -> Vec<Clue> {
        let is_formal = |piece: &Evidence| piece.technique.traits().asked_by == AskedBy::Property;
        let form = (is_formal(one) || is_formal(other)).then_some("property");
        let blame = self.blame([one, other], subject, form);
        let both = |shares: [f64; 2]| {
            let both = [(one, other, shares[0]), (other, one, shares[1])];
            both.into_iter().filter(|(.., share)| *share >= NAMED)
        };
        let systems = both(blame.pieces)
            .map(|(piece, against, share)| self.of_system(piece, against, subject, (left, share)));
        let readings = both(blame.reading)
            .map(|(piece, against, share)| self.of_reading(piece, against, subject, (left, share)));
        systems.chain(readings).collect()
    }

    /// The clue against what a piece is read through, with all others that are read so.
    fn of_reading(
        &self,
        piece: &Evidence,
        against: &Evidence,
        subject: &Subject,
        (left, share): (f64, f64),
    ) -> Clue {
        let read = self.speaking().filter(|it| {
            it.conditions == piece.conditions
                && is_read_from_runs(it)
                && it.finding(subject).is_some()
        });
        let read: Vec<String> = read.map(|it| it.id.clone()).collect();
        let all = read.join(" and ");
        let (verb, alike) = match read.len() {
            1 => ("is", format!("All runs of {all} come out alike, and are")),
            _ => ("are", format!("{all} agree, and are")),
        };
        let own = self.of_system(piece, against, subject, (left, share));
        Clue {
            inaccuracy: Inaccuracy::RequirementModel,
            asset: SuspectAsset {
                kind: SuspectKind::Vocabulary,
                file: Some("vocabulary.toml".to_owned()),
                part: Some(format!("{}, as read from runs", name_of(subject))),
                evidence: read,
                together: Vec::new(),
                line: None,
            },
            title: format!(
                "what {all} {verb} read through may mean something else in {}",
                name_of(subject)
            ),
            explanation: format!(
                "{} against {}: a conflict on {} {}. {alike} read through the same \
                 words and the same monitor: that one of these is wrong has a probability of {share:.2}.",
                rate_in_words(piece, subject),
                rate_in_words(against, subject),
                name_of(subject),
                weighed(left)
            ),
            ruled_out: Vec::new(),
            ..own
        }
    }

    pub(super) fn of_system(
        &self,
        piece: &Evidence,
        against: &Evidence,
        subject: &Subject,
        (left, share): (f64, f64),
    ) -> Clue {
        let finding = piece.finding(subject);
        let value = finding.and_then(|f| f.measure.estimate());
        let runs = finding.map_or_else(Vec::new, |f| f.witnesses.clone());
        // What something else takes of it is said, so that a pair has one figure.
        let whole = self.difference(piece, against, subject).max(left);
        let rest = match whole - left > 0.05 {
            true => format!(", of which 10^{left:.1} is left for these"),
            false => String::new(),
        };
        Clue {
            inaccuracy: Inaccuracy::SystemModel,
            asset: self.asset_of(piece, subject),
            subject: subject.clone(),
            score: left * share,
            title: format!("{} differs in {}", piece.id, name_of(subject)),
            explanation: format!(
                "{} against {}: a conflict on {} {}{rest}, with probability {share:.2} the odd one out.",
                rate_in_words(piece, subject),
                rate_in_words(against, subject),
                name_of(subject),
                weighed(whole)
            ),
            symptom: Symptom::RateDiffers {
                subject: subject.clone(),
                evidence: piece.id.clone(),
                value: value.unwrap_or(f64::NAN),
                others: vec![counts_of(against, subject)],
            },
            figures: vec![
                figure("conflict, log10 Bayes factor", left),
                figure(ODD_ONE_OUT, share),
            ],
            witnesses: self.witnesses(piece, &runs, &format!("{} shows", name_of(subject))),
            ruled_out: self.alike(piece, subject),
            resolved_by: self.mended(piece, against, subject),
        }
    }

    /// What speaks for the requirement models of a piece.
    fn alike(&self, piece: &Evidence, subject: &Subject) -> Vec<String> {
        let forms = piece.form_differences.iter();
        let differing: u64 = forms
            .filter(|d| &d.subject == subject)
            .map(|d| d.count)
            .sum();
        let cell = self.cells.iter().find(|cell| {
            ['B', 'C'].contains(&cell.cell)
                && cell.evidence == piece.id
                && &cell.subject == subject
                && cell.trials > 0
        });
        match (cell, differing) {
            (Some(cell), 0) => vec![format!(
                "the forms of the requirement: on {} runs of {} all agree; the words that they share are not ruled out",
                cell.runs, piece.id
            )],
            _ => Vec::new(),
        }
    }

    /// Later evidence of the same technique that does not differ from what this one differs from; or in place of a model or
    /// a simulation that this one differs from (data are added to, not replaced), one under the same conditions that does
    /// not differ from this one.
    pub(super) fn mended(
        &self,
        piece: &Evidence,
        against: &Evidence,
        subject: &Subject,
    ) -> Option<String> {
        let is_made = !against.technique.is_of_system();
        self.replaced(piece, against, subject).or_else(|| {
            let by = is_made.then(|| self.replaced(against, piece, subject));
            let same = |id: &String| {
                let by = self.piece(id);
                by.is_some_and(|by| by.conditions == against.conditions)
            };
            by.flatten().filter(same)
        })
    }

    fn replaced(&self, piece: &Evidence, against: &Evidence, subject: &Subject) -> Option<String> {
        // Another campaign on the system is no later version of this one.
        if piece.technique.is_of_system() {
            return None;
        }
        let place = self.evidence.iter().position(|e| e.id == piece.id)?;
        let later = self.evidence.iter().skip(place + 1);
        let mut later =
            later.filter(|e| e.technique == piece.technique && !e.intermediate && !e.published);
        later
            .find(|e| {
                let has = e
                    .finding(subject)
                    .is_some_and(|f| f.measure.estimate().is_some());
                has && self.difference(e, against, subject) < STRONG
            })
            .map(|e| e.id.clone())
    }
}

/// The rate of a piece; a failure mode that a model cannot express never happens in it.
pub(super) fn rate_or_never(piece: &Evidence, subject: &Subject) -> Option<Rate> {
    let measure = &piece.finding(subject)?.measure;
    let has_nothing = matches!(subject, Subject::FailureMode(_))
        && matches!(measure, Measure::NotExpressible { .. })
        && piece.technique.is_of_model();
    match has_nothing {
        true => Some(Rate::Never),
        false => Rate::on(piece, subject),
    }
}

/// The form that a piece's own finding rests on.
pub(super) fn own_form(piece: &Evidence) -> &'static str {
    match piece.technique.traits().asked_by {
        AskedBy::Property => "property",
        AskedBy::Event => "event",
        AskedBy::Monitor => "monitor",
    }
}

/// A form for people.
fn named(form: &str) -> String {
    match form {
        "property" | "event" | "monitor" | SENTENCE => form.to_owned(),
        reading => format!("reading `{reading}`"),
    }
}

/// Which piece's form was changed so that both are judged alike, if they are.
fn changed<'e>(
    one: &'e Evidence,
    a: &Judged,
    other: &'e Evidence,
    b: &Judged,
) -> Option<(&'e Evidence, String)> {
    let is_reading = |judged: &Judged| !["property", "monitor"].contains(&judged.form.as_str());
    match (a.main, b.main) {
        (true, true) | (false, false) => None,
        // The form in which a table was counted is not known: any may be it.
        (true, false) => {
            (a.form == b.form || is_reading(b) || is_table(one)).then(|| (other, b.form.clone()))
        }
        (false, true) => {
            (a.form == b.form || is_reading(a) || is_table(other)).then(|| (one, a.form.clone()))
        }
    }
}

pub(super) fn solver(piece: &Evidence, method: &str) -> SuspectAsset {
    SuspectAsset {
        kind: SuspectKind::Solver,
        file: None,
        part: Some(format!("method `{method}`")),
        evidence: vec![piece.id.clone()],
        together: Vec::new(),
        line: None,
    }
}

/// A piece with its counts; a computed value has none.
pub(super) fn counts_of(piece: &Evidence, subject: &Subject) -> (String, u64, u64) {
    match piece.finding(subject).map(|f| &f.measure) {
        Some(Measure::Counts { count, trials, .. }) => (piece.id.clone(), *count, *trials),
        _ => (piece.id.clone(), 0, 0),
    }
}

pub(super) fn figure(name: &str, value: f64) -> Figure {
    Figure {
        name: name.into(),
        value: value.min(CERTAIN),
        interval: None,
    }
}
