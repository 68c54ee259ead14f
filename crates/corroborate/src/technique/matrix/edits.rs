//! Requirement models changed one value at a time, each tried on all the evidence.
//!
//! # Definition
//! For every edit that something in the study suggests ([`super::candidates`]) what it reaches is produced again: the
//! formal models' answers, the tables' counts, or the verdicts on the recordings that are kept. Of each pair of pieces
//! under the same conditions the strength of disagreement ([`evidence::signed_strength`]) is taken before and after (of one that is
//! triggered in no run the strength with which this differs from how often the other is, if both are of one population); of a subject
//! the strongest counts. An edit *explains* the subjects that disagreed strongly ([`evidence::STRONG`]) and do not any
//! more. Its *score* is what goes away on them, less what comes up anywhere else; it is dropped if more than [`STRONG`]
//! comes up, since chance alone moves the weaker pairs. What a table has the wrong way round ([`evidence::put_right`]), or two pieces that
//! changed places ([`evidence::changed_places`]), are weighed as an edit is, and one that explains more takes the edits' place; likewise a number of a formal model that is solved
//! for ([`super::lines`]), at [`refinement::FREE_VALUE`] decades less, a branch or a gate that is another ([`super::gates`]), and a
//! number that runs are read through ([`solved`]), which is looked for where nothing says a value that explains what
//! disagrees. Of those that are left the ones that explain most are clues, and
//! those that explain as much are named with them. An edit with which every run of every piece is judged alike (a limit that
//! nothing keeps) explains nothing by that, unless something else in the study says its very value; nor does one with which a
//! model is certain of what others saw both ways.
//!
//! What an edit explains it shares with the system models, which explain it, too, by rates of their own. Its odds against
//! them are, in decades,
//!
//! * how well all agree on what it explains: the evidence for one rate, of each subject that of its weakest pair. Rates
//!   that are free agree with anything, and say nothing;
//! * [`explained::COINCIDENCE`] for each piece beyond the first that would have to be wrong, at the least, for the same pairs to
//!   disagree: two pieces that are read through one wrong word do so at once, and two errors that are alike are rarer than one;
//! * [`explained::STRUCTURE`], if it explains a requirement without a limit of time, and no failure mode disagrees: a system that fails
//!   otherwise fails somehow; likewise an edit of a duration, if requirements with a limit of time disagree and nothing else;
//! * [`SAID`], if something else in the study says this very value (the limit of the other form, a duration in the text, a
//!   unit in a field's name), [`FREE`], shared among all that are free for one place, if only a place
//!   is free for it (a column or a state that no proposition names);
//! * [`explained::PLAIN`], if the pieces that it changes are then each the same in all their runs, and nothing says it;
//! * less [`refinement::FREE_VALUE`], if a model gives what it explains within the margin alone, and not as it was counted
//!   ([`refinement::Ground::is_near`]), unless something says the value;
//! * [`explained::WAS_PLAIN`], if they are the same in all their runs now and are not then: a reading that judges all runs alike is
//!   wrong more often than a system that never or always fails;
//! * less the decades of the number of edits that were tried and change how any two pieces agree: the others say the same as
//!   no edit, and cannot explain anything by chance.
//!
//! Odds of edits of one place add up: whichever of its values is meant, the place is wrong. Numbers of one place that
//! explain the same are a limit that plays no part any more, and explain nothing.
//!
//! # Assumes
//! One value is wrong. Edits that were tried are equally likely before, but for the prior odds, which are guesses. The
//! strengths take trials as independent, or at their effective size.
//!
//! # Source and guarantee
//! The method of difference (J. S. Mill, 1843), and Bayes factors with the correction for the number of hypotheses of equal
//! prior probability (H. Jeffreys, "Theory of Probability", 1961, section 5.04). An edit has no free parameter: what it
//! predicts is computed, not fitted. [`explained::COINCIDENCE`], [`explained::STRUCTURE`], [`SAID`] and [`FREE`] are prior odds, which nothing here estimates.
//!
//! # Cost
//! For each edit the models solved, the tables read or recordings judged again: at most [`FEW_RUNS`] of each piece, and at most
//! [`MOST_RUNS`] where these do not show that it fixes nothing; only where there is strong disagreement.

mod explained;
mod kept;
mod rivals;
pub(crate) mod scratch;
mod solved;

use super::candidates::{Reach, TextEdit, candidates, limits};
use super::lines::OfModels;
use super::{Diagnosing, Gathered};
use crate::refine::proposal::ground;
use crate::technique::experiment::Tables;
use crate::technique::kinds::{Asked, TreeChange, tree_values};
use crate::technique::model_checking::Compiled;
use crate::technique::operation::only_violations;
use crate::technique::simulation;
use diagnostic::Problem;
use evidence::{
    Clue, Evidence, Figure, Finding, Inaccuracy, Measure, MethodAnswer, Rate, STRONG, Subject,
    SuspectAsset, SuspectKind, Symptom, signed_strength,
};
use explained::{Explained, PLAIN, WAS_PLAIN, drop_limits_that_play_no_part, explained};
use host::{Events, Host};
use judging::Judges;
use judging::recording::ReadingRules;
use rayon::prelude::*;
use refinement::FREE_VALUE;
use scratch::Scratch;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use study::Study;

/// Decades for an edit whose very value something else says, too.
const SAID: f64 = 2.5;

/// Decades for an edit to what is free.
const FREE: f64 = 1.0;

/// Recordings of one piece of evidence that are judged again, at most.
const MOST_RUNS: usize = 400;

/// Recordings of one piece by which an edit is dropped that leaves all strong disagreement as it is.
const FEW_RUNS: usize = 60;

/// Disagreement by these few that all runs will hardly take away.
const FEW_STRONG: f64 = 3.0 * STRONG;

/// Strengths that differ by less explain as much.
const AS_MUCH: f64 = 0.5;

/// Values of a model that differ by less are the same.
const SAME: f64 = 1e-6;

/// Pairs of pieces on a subject, with how strongly they disagree.
type Pairs = BTreeMap<(String, String, Subject), f64>;

/// What a model answers, by subject.
type Values = BTreeMap<Subject, Option<f64>>;

/// What the models answer, by their files.
type ModelValues = BTreeMap<PathBuf, Values>;

/// What an edit does to the evidence.
enum After {
    /// It fixes nothing by a few runs; whether it changes how pieces agree.
    Little { is_telling: bool },
    /// All evidence as it is then.
    All(Vec<Evidence>),
}

/// What edits are tried on.
struct Context<'a> {
    scratch: &'a Scratch,
    now: &'a ModelValues,
    before: &'a Pairs,
    strong: &'a BTreeSet<&'a Subject>,
    few: &'a Pairs,
}

impl Diagnosing<'_> {
    /// Looks for single edits that explain strong disagreement.
    pub(super) fn edits(&self, offered: &OfModels, gathered: &mut Gathered) -> Result<(), Problem> {
        let before = self.disagreements(&self.result.evidence);
        if before.values().all(|apart| *apart <= STRONG) {
            return Ok(());
        }
        self.say_what_is_not_kept(gathered);
        let scratch = Scratch::new(self.study, self.folder)?;
        let now = self.models_now()?;
        let mut found: Vec<Explained> = Vec::new();
        let (mut tried, mut telling) = (0_u32, 0_u32);
        let strong = before.iter().filter(|(_, apart)| **apart > STRONG);
        let strong: BTreeSet<&Subject> = strong.map(|((.., subject), _)| subject).collect();
        let few = self.few_as_they_are(&scratch, &now);
        let all = candidates(
            self.study,
            &|subject| strong.contains(subject),
            &self.fields(),
        )?;
        let free: Vec<TextEdit> = all.iter().filter(|it| it.is_free()).cloned().collect();
        let context = Context {
            scratch: &scratch,
            now: &now,
            before: &before,
            strong: &strong,
            few: &few,
        };
        for edit in all.iter().cloned() {
            let outcome = self.tried(edit, &context)?;
            let Some((is_telling, explains)) = outcome else {
                continue;
            };
            tried += 1;
            telling += u32::from(is_telling);
            found.extend(explains);
        }
        // What is suggested by nothing is looked for where nothing says a value that explains what disagrees, of numbers of which
        // no slip explains it.
        if found.iter().all(|it| !it.edit.is_said) {
            let is_open = |place: &TextEdit| !found.iter().any(|it| it.edit.is_of_place(place));
            let open: Vec<TextEdit> = all.iter().filter(|it| is_open(it)).cloned().collect();
            found.extend(self.with_solved(&open, &context)?);
        }
        for it in &mut found {
            let hint = match (&it.edit.hint, it.edit.is_said) {
                (Some(_), true) => SAID,
                (Some(_), false) => {
                    let of_place = free.iter().filter(|other| other.is_of_place(&it.edit));
                    FREE - (of_place.count().max(1) as f64).log10()
                }
                (None, _) => 0.0,
            };
            it.prior += hint - f64::from(telling.max(1)).log10();
        }
        let exchange = self.exchange(&before);
        let rival = exchange.into_iter().chain(self.numbers(offered, &before));
        let rival = rival.max_by(f64::total_cmp);
        self.named(gathered, found, rival, ([tried, telling], &all));
        Ok(())
    }

    /// What numbers explain that are solved for, of each the round value that does so best for its cost.
    fn with_solved(
        &self,
        tried: &[TextEdit],
        context: &Context<'_>,
    ) -> Result<Vec<Explained>, Problem> {
        let mut found = Vec::new();
        for rounded in self.solved(context, tried)? {
            let mut best: Option<Explained> = None;
            for (edit, cost) in rounded {
                let Some((_, Some(mut explains))) = self.tried(edit, context)? else {
                    continue;
                };
                explains.prior -= cost;
                if best
                    .as_ref()
                    .is_none_or(|it| it.weight() < explains.weight())
                {
                    best = Some(explains);
                }
            }
            found.extend(best);
        }
        Ok(found)
    }

    /// Whether an edit changes how pieces agree, and what it explains; nothing if the study cannot be read with it.
    fn tried(
        &self,
        edit: TextEdit,
        context: &Context<'_>,
    ) -> Result<Option<(bool, Option<Explained>)>, Problem> {
        let Context {
            scratch,
            now,
            before,
            strong,
            few,
        } = context;
        self.setting.go_on()?;
        let after = scratch
            .with(&edit)
            .and_then(|study| self.after(&study, scratch, (&edit, now), (strong, few)));
        self.setting.go_on()?;
        let evidence = match after {
            Err(_) => return Ok(None),
            Ok(After::Little { is_telling }) => return Ok(Some((is_telling, None))),
            Ok(After::All(evidence)) => evidence,
        };
        let after = self.disagreements(&evidence);
        let is_telling = after != **before;
        let is_timed = |subject: &Subject| {
            let form = self.study.forms.of(subject);
            form.is_some_and(|form| limits::is_timed(self.study, form))
        };
        let is_said = edit.is_said;
        let explained = explained(edit, before, &after, &is_timed);
        let explained = explained.filter(|it| is_said || !it.is_constant(&evidence));
        let explained = explained.map(|it| Explained {
            hides: self.hidden_by(&evidence, &it.pairs),
            prior: self.off(&it, &evidence)
                + match !is_said && it.is_plain(&self.result.evidence, &evidence) {
                    true => PLAIN,
                    false if it.was_plain(&self.result.evidence, &evidence) => WAS_PLAIN,
                    false => 0.0,
                },
            ..it
        });
        Ok(Some((is_telling, explained)))
    }

    /// What counts against an edit with which a model gives what it explains within the margin alone, and not as it was counted:
    /// as against any change without a free number.
    fn off(&self, found: &Explained, evidence: &[Evidence]) -> f64 {
        if found.edit.reach != Reach::Models || found.edit.is_said {
            return 0.0;
        }
        let ground = ground(self.study, self.result);
        let mut subjects = found.pairs.keys().map(|(.., subject)| subject);
        let is_off = subjects.any(|subject| {
            let mut models = evidence.iter().filter(|it| it.technique.is_of_model());
            models.any(|piece| {
                let is = Rate::asked(piece, subject);
                let was = self.result.evidence.iter().find(|it| it.id == piece.id);
                let is_moved = was.is_none_or(|was| Rate::asked(was, subject) != is);
                let value = is.filter(|_| is_moved).and_then(Rate::computed);
                value.is_some_and(|value| !ground.is_near(piece, subject, value))
            })
        });
        if is_off { -FREE_VALUE } else { 0.0 }
    }

    /// Pieces whose runs cannot be judged again, since none is kept.
    fn say_what_is_not_kept(&self, gathered: &mut Gathered) {
        for entry in &self.study.ledger {
            let Some(folder) = self.runs_of(entry) else {
                continue;
            };
            let is_empty = recording::trials(&folder).map_or(true, |found| found.trials.is_empty());
            if is_empty && !entry.intermediate {
                gathered.not_done.push(format!(
                    "single edits on the runs of {}: none is kept in {}",
                    entry.id,
                    folder.display()
                ));
            }
        }
    }

    /// Where the recordings of an entry are kept.
    fn runs_of(&self, entry: &study::Entry) -> Option<PathBuf> {
        let recordings = entry.work.recordings().map(|of| self.study.folder.join(of));
        let episodes = || self.folder.join("episodes").join(&entry.id);
        recordings.or(entry.work.simulated().map(|_| episodes()))
    }

    /// How strongly the pieces disagree by a few runs of each, as the study is; nothing if these cannot be judged.
    fn few_as_they_are(&self, scratch: &Scratch, now: &ModelValues) -> Pairs {
        let nothing = TextEdit::none();
        let evidence = scratch
            .with(&nothing)
            .and_then(|study| self.produced_with(&study, scratch, (&nothing, now), FEW_RUNS));
        evidence.map_or_else(|_| Pairs::new(), |it| self.disagreements(&it))
    }

    /// What an edit does. Where runs are judged again, a few of them first: what these show to be in strong disagreement will
    /// be so by all.
    fn after(
        &self,
        study: &Study,
        scratch: &Scratch,
        edit: (&TextEdit, &ModelValues),
        (strong, few): (&BTreeSet<&Subject>, &Pairs),
    ) -> Result<After, Problem> {
        if matches!(edit.0.reach, Reach::Runs | Reach::All) {
            let after = self.produced_with(study, scratch, edit, FEW_RUNS)?;
            let after = self.disagreements(&after);
            let is_mended = |subject: &&Subject| {
                let mut own = after.iter().filter(|((.., it), _)| it == *subject);
                own.all(|(_, apart)| *apart <= FEW_STRONG)
            };
            if !strong.iter().any(is_mended) {
                let is_telling = &after != few;
                return Ok(After::Little { is_telling });
            }
        }
        let all = self.produced_with(study, scratch, edit, MOST_RUNS)?;
        Ok(After::All(all))
    }

    /// Clues against what the edits that explain most would change.
    fn named(
        &self,
        gathered: &mut Gathered,
        mut found: Vec<Explained>,
        rival: Option<f64>,
        ([tried, telling], all): ([u32; 2], &[TextEdit]),
    ) {
        gathered.in_order.push(format!(
            "{tried} single edits of vocabulary, forms and units were tried on all evidence; {telling} change how pieces agree, {} explain \
             what disagrees",
            found.len()
        ));
        drop_limits_that_play_no_part(&mut found, all);
        for place in 0..found.len() {
            let edit = &found[place].edit;
            let same = found.iter().filter(|it| it.edit.is_of_place(edit));
            found[place].odds = same.map(Explained::own_odds).sum();
        }
        found.sort_by(|a, b| b.weight().total_cmp(&a.weight()));
        let best = found.first().map_or(0.0, Explained::weight);
        if let Some(rival) = rival {
            let odds = |it: &Explained| 10.0_f64.powf(it.weight() - rival);
            found
                .iter_mut()
                .for_each(|it| it.odds = it.odds.min(odds(it)));
        }
        let best = best.max(rival.unwrap_or(0.0));
        found.retain(|it| it.weight() > best - AS_MUCH);
        let places: Vec<String> = found.iter().map(Explained::in_words).collect();
        for (at, it) in found.iter().enumerate() {
            let others = places.iter().enumerate();
            let others = others.filter(|(other, _)| *other != at);
            let others: Vec<String> = others.map(|(_, place)| place.clone()).collect();
            gathered.clues.extend(self.clues_of(it, &others, tried));
        }
    }

    /// How strongly the pieces that speak for themselves disagree, pair by pair.
    pub(super) fn disagreements(&self, evidence: &[Evidence]) -> Pairs {
        let speaks = |piece: &&Evidence| {
            !(piece.intermediate || piece.published && piece.reproduced_by.is_some())
        };
        let pieces: Vec<&Evidence> = evidence.iter().filter(speaks).collect();
        let mut pairs = Pairs::new();
        for (place, one) in pieces.iter().enumerate() {
            let others = pieces[place + 1..].iter();
            // Two models have no data between them that could tell.
            let both_computed =
                |other: &Evidence| one.technique.is_of_model() && other.technique.is_of_model();
            let comparable =
                |other: &&&Evidence| other.conditions == one.conditions && !both_computed(other);
            for other in others.filter(comparable) {
                for finding in &one.findings {
                    let subject = &finding.subject;
                    let rates = (Rate::asked(one, subject), Rate::asked(other, subject));
                    let apart = match rates {
                        (Some(a), Some(b)) => Some(signed_strength(a, b, self.margin(subject))),
                        _ => self.never_triggered([one, other], subject),
                    };
                    if let (Some(apart), true) = (apart, self.is_own(subject)) {
                        pairs.insert((one.id.clone(), other.id.clone(), subject.clone()), apart);
                    }
                }
            }
        }
        pairs
    }

    /// The evidence with what an edit reaches produced again.
    fn produced_with(
        &self,
        study: &Study,
        scratch: &Scratch,
        (edit, now): (&TextEdit, &ModelValues),
        most: usize,
    ) -> Result<Vec<Evidence>, Problem> {
        let mut evidence = self.result.evidence.clone();
        for piece in &mut evidence {
            let entry = self.study.entry(&piece.id)?;
            let (work, id) = (&entry.work, &piece.id);
            let findings = match (&edit.reach, work.model()) {
                (Reach::Tree(tree), _) if tree != id => continue,
                (Reach::Tree(_), _) => self.tree_with(entry, edit, &piece.findings)?,
                (Reach::Models | Reach::All, Some(model)) => {
                    let then = self.model_values(study, model)?;
                    answers(now.get(model), &then, &piece.findings)
                }
                (Reach::Models, None) => continue,
                (Reach::Tables | Reach::All, _) if work.tables().is_some() => {
                    let Some(files) = work.tables() else { continue };
                    let tables = Tables::read(study, files)?;
                    tables.produce(study, id, work.technique())?.findings
                }
                (Reach::Tables, _) => continue,
                (Reach::Runs, _) | (Reach::All, None) => {
                    let Some(folder) = self.runs_of(entry) else {
                        continue;
                    };
                    self.verdicts(study, scratch, &folder, most)?
                }
            };
            let known = findings.into_iter();
            for new in known {
                let old = piece.findings.iter_mut();
                if let Some(old) = old.into_iter().find(|old| old.subject == new.subject) {
                    *old = new;
                }
            }
        }
        Ok(evidence)
    }

    /// What a fault tree answers with another mission time; its kept values are its plain ones.
    fn tree_with(
        &self,
        entry: &study::Entry,
        edit: &TextEdit,
        known: &[Finding],
    ) -> Result<Vec<Finding>, Problem> {
        let cannot = || {
            // The program has made this value, so the ledger is not at fault.
            Problem::new(
                "bad-candidate",
                format!(
                    "the mission time that was tried for {} must be a number (got `{}`)",
                    entry.id, edit.new
                ),
            )
            .remedy("this is a mistake of this program, not of the study: report it")
        };
        let time: f64 = edit.new.parse().map_err(|_| cannot())?;
        // What there is to warn of was said when the study ran.
        let host = Host {
            events: Events::none(),
            ..self.setting.clone()
        };
        let asked = Asked {
            study: self.study,
            entry,
            host: &host,
        };
        let now = known.iter().filter_map(|finding| match &finding.measure {
            Measure::Probability { answer, .. } => {
                Some((finding.subject.clone(), Some(answer.value)))
            }
            _ => None,
        });
        Ok(answers(
            Some(&now.collect()),
            &tree_values(asked, &TreeChange::MissionTime(time))?,
            known,
        ))
    }

    /// What each formal model answers as the study is.
    fn models_now(&self) -> Result<ModelValues, Problem> {
        let mut all = ModelValues::new();
        for entry in &self.study.ledger {
            if let Some(model) = entry.work.model()
                && !all.contains_key(model)
            {
                // A model that cannot be solved has nothing that an edit could change.
                let values = self.model_values(self.study, model);
                self.setting.go_on()?;
                all.extend(values.ok().map(|values| (model.to_owned(), values)));
            }
        }
        Ok(all)
    }

    /// What a formal model answers to the questions of a study.
    fn model_values(&self, study: &Study, model: &Path) -> Result<Values, Problem> {
        let cancel = || self.setting.cancel.is_cancelled();
        let (source, _) = host::files::read_prism(&self.study.folder.join(model))?;
        Compiled::of_source(study, source)?.values_at(&[], &cancel)
    }

    /// The verdicts on recordings that are kept.
    fn verdicts(
        &self,
        study: &Study,
        scratch: &Scratch,
        folder: &Path,
        most: usize,
    ) -> Result<Vec<Finding>, Problem> {
        let Ok(found) = recording::trials(folder) else {
            return Ok(Vec::new());
        };
        if found.trials.is_empty() {
            return Ok(Vec::new());
        }
        let trials = spread(found.trials, most);
        let rules = ReadingRules::of_study(&scratch.folder, None)?;
        let judges = Judges::new(study, |_| true)?;
        let go_on = || self.setting.go_on();
        let judged: Vec<_> = trials
            .par_iter()
            .map(|trial| {
                let judged = rules
                    .judge_what_is_there(&judges, &trial.path, &go_on)?
                    .judged;
                Ok(match judged.complete {
                    true => judged.judgements,
                    false => only_violations(judged.judgements),
                })
            })
            .collect::<Result<_, Problem>>()?;
        let names: Vec<String> = trials.iter().map(|trial| trial.name.clone()).collect();
        simulation::findings(study, &judges, &judged, &names)
    }

    /// Requirements among what an edit explains that a piece misses as it is and meets as it then is.
    fn hidden_by(&self, evidence: &[Evidence], pairs: &Pairs) -> Vec<String> {
        let mut found = Vec::new();
        for (now, then) in self.result.evidence.iter().zip(evidence) {
            for requirement in &self.study.requirements {
                let subject = Subject::Requirement(requirement.id.clone());
                if pairs.keys().all(|(.., of)| *of != subject) {
                    continue;
                }
                let meets = |piece: &Evidence| {
                    let rate = piece.finding(&subject)?.measure.estimate()?;
                    Some(match &requirement.threshold {
                        Some(it) => match it.direction {
                            evidence::Direction::AtLeast => rate >= it.value,
                            evidence::Direction::AtMost => rate <= it.value,
                        },
                        None => rate >= 1.0,
                    })
                };
                if let (Some(false), Some(true)) = (meets(now), meets(then)) {
                    found.push(format!(
                        "{} misses requirement {} now and meets it then",
                        now.id, requirement.id
                    ));
                }
            }
        }
        found
    }

    /// The clues against what an edit would change, one for each subject.
    fn clues_of(&self, it: &Explained, others: &[String], tried: u32) -> Vec<Clue> {
        let edit = &it.edit;
        let subjects: std::collections::BTreeSet<&Subject> =
            it.pairs.keys().map(|(.., subject)| subject).collect();
        let line = self.line_of(edit);
        let of = |subject: &Subject| {
            let own = it.pairs.iter().filter(|((.., s), _)| s == subject);
            let pairs: Vec<[String; 2]> = own
                .clone()
                .map(|((a, b, _), _)| [a.clone(), b.clone()])
                .collect();
            let whole = own.map(|(_, apart)| *apart).fold(0.0, f64::max);
            let words: Vec<String> = pairs.iter().map(|[a, b]| format!("{a} and {b}")).collect();
            let hint = edit.hint.as_ref();
            let hint = hint.map_or(String::new(), |hint| format!(" And {hint}."));
            let hides = match it.hides.as_slice() {
                [] => String::new(),
                all => format!(
                    " {}: unless the text of the requirement says so, this would hide a defect of the system.",
                    all.join("; ")
                ),
            };
            let new = edit.new_in_words();
            Clue {
                inaccuracy: match edit.kind {
                    SuspectKind::TimeScale => Inaccuracy::SystemModel,
                    _ => Inaccuracy::RequirementModel,
                },
                asset: SuspectAsset {
                    kind: edit.kind,
                    file: Some(edit.file.into()),
                    part: Some(edit.part.clone()),
                    evidence: evidence_of(&pairs),
                    together: others.to_vec(),
                    line,
                },
                subject: subject.clone(),
                score: whole * it.share(),
                title: format!("`{new}` in place of `{}` explains a conflict", edit.old),
                explanation: format!(
                    "With `{new}` in place of `{}` {} agree on {} (a Bayes factor of 10^{whole:.1} goes away), and little else comes to \
                     disagree; of {tried} single edits that were tried.{hint}{hides}",
                    edit.old,
                    words.join(", "),
                    subject.in_words()
                ),
                symptom: Symptom::EditExplains {
                    subject: subject.clone(),
                    found: edit.old.clone(),
                    instead: edit.new.clone(),
                    pairs,
                    share: it.share(),
                },
                figures: vec![Figure {
                    name: "explained, log10 Bayes factor".into(),
                    value: whole,
                    interval: None,
                }],
                witnesses: Vec::new(),
                ruled_out: Vec::new(),
                resolved_by: None,
            }
        };
        subjects.into_iter().map(of).collect()
    }

    fn line_of(&self, edit: &TextEdit) -> Option<u32> {
        let text = std::fs::read_to_string(self.study.folder.join(edit.file)).ok()?;
        let (line, _) = prism_lang::line_and_column(&text, edit.span.start);
        u32::try_from(line).ok()
    }
}

/// At most so many of a list, in its order, from all over it and with no period: what alternates in the list is not met by
/// steps of its own length. All multiples of the golden ratio lie evenly between whole numbers.
fn spread<T>(all: Vec<T>, most: usize) -> Vec<T> {
    const GOLDEN: f64 = 0.618_033_988_749_895;
    if all.len() <= most {
        return all;
    }
    let rank = |place: usize| (place as f64 * GOLDEN).fract();
    let mut ranks: Vec<f64> = (0..all.len()).map(rank).collect();
    ranks.sort_by(f64::total_cmp);
    let limit = ranks.get(most).copied().unwrap_or(1.0);
    let all = all.into_iter().enumerate();
    let kept = all.filter(|(place, _)| rank(*place) < limit);
    kept.map(|(_, it)| it).collect()
}

/// A model's findings with other answers; what it did not answer by its plain values before stays as it is.
fn answers(now: Option<&Values>, then: &Values, known: &[Finding]) -> Vec<Finding> {
    let changed = known.iter().filter_map(|finding| {
        let answered = match &finding.measure {
            Measure::Probability { answer, .. } => answer.value,
            Measure::NotCovered {
                constant: Some(truth),
                ..
            } => f64::from(u8::from(*truth)),
            _ => return None,
        };
        let now = now?.get(&finding.subject).copied().flatten()?;
        let then = then.get(&finding.subject).copied().flatten()?;
        if (now - answered).abs() > SAME {
            return None;
        }
        let mut finding = finding.clone();
        match &mut finding.measure {
            Measure::Probability { answer, .. } => answer.value = then,
            constant => {
                *constant = Measure::Probability {
                    answer: MethodAnswer::plain(then),
                    others: Vec::new(),
                    credible: None,
                }
            }
        }
        Some(finding)
    });
    changed.collect()
}

fn evidence_of(pairs: &[[String; 2]]) -> Vec<String> {
    let mut all: Vec<String> = pairs.iter().flatten().cloned().collect();
    all.sort();
    all.dedup();
    all
}

#[cfg(test)]
mod tests {
    use super::spread;

    #[test]
    fn a_few_of_a_list_have_no_period() {
        let few = spread((0..200_usize).collect(), 60);
        assert_eq!(few.len(), 60);
        for period in [2, 3, 5, 10] {
            let share = few.iter().filter(|it| *it % period == 0).count();
            let expected = 60 / period;
            assert!(
                share.abs_diff(expected) <= 3,
                "{share} of 60 are multiples of {period}"
            );
        }
        assert_eq!(spread(vec![1, 2], 60), [1, 2]);
    }
}
