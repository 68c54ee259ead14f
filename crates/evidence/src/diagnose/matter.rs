//! What suspects are found in, and what each single thing says against an asset.

use super::rates::own_form;
use super::strength::{Rate, STRONG, strength};
use super::suspect::{
    Cell, Figure, JudgedBy, Suspect, SuspectAsset, SuspectKind, Symptom, Witness,
};
use crate::{
    AssetRole, Comparison, Evidence, FailureMode, Inaccuracy, Outcome, Requirement, Rerun, Subject,
    WitnessOf,
};
use crate::{Finding, Measure};

/// Files of data of one piece that are named one by one, at most.
const MOST_NAMED: usize = 8;

/// What suspects are found in.
#[derive(Clone, Copy, Debug)]
pub struct Matter<'a> {
    /// What is required, with its margins.
    pub requirements: &'a [Requirement],
    /// What can go wrong, with its margins.
    pub failure_modes: &'a [FailureMode],
    /// The ledger, oldest first.
    pub evidence: &'a [Evidence],
    /// Its pairs.
    pub comparisons: &'a [Comparison],
    /// Requirement models on traces, as far as they were judged.
    pub cells: &'a [Cell],
    /// Which table counts what, where a piece rests on several.
    pub tables: &'a [TableOf],
    /// How a command names the study.
    pub study: &'a str,
}

/// What a table counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Counted {
    /// Totals of requirements.
    Requirements,
    /// Totals of failure modes.
    FailureModes,
    /// Both, by person or session.
    BySubject,
}

/// A table of a piece of evidence, with what it counts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TableOf {
    /// The evidence.
    pub evidence: String,
    /// What it counts.
    pub counts: Counted,
    /// The file, relative to the study's folder, with `/`.
    pub file: String,
    /// The file that says which of its columns and codes count what, where one does.
    pub bound_in: Option<String>,
}

/// One thing that speaks against an asset.
#[derive(Clone, Debug, PartialEq)]
pub struct Clue {
    /// Which source of disagreement it would be.
    pub inaccuracy: Inaccuracy,
    /// The asset.
    pub asset: SuspectAsset,
    /// What it touches.
    pub subject: Subject,
    /// How much disagreement it explains; see [`Suspect::score`].
    pub score: f64,
    /// What is wrong, as a headline.
    pub title: String,
    /// The argument, with figures.
    pub explanation: String,
    /// What is wrong, for programs.
    pub symptom: Symptom,
    /// The figures of the argument.
    pub figures: Vec<Figure>,
    /// Runs that show it.
    pub witnesses: Vec<Witness>,
    /// What was found not to be the reason.
    pub ruled_out: Vec<String>,
    /// The later evidence in which it is fixed.
    pub resolved_by: Option<String>,
}

/// One way in which a piece of evidence judges a subject.
#[derive(Clone, Debug)]
pub(super) struct Judged {
    /// `property`, `monitor`, or a reading's name.
    pub(super) form: String,
    /// What it gives.
    pub(super) rate: Rate,
    /// Whether it is the form of the evidence's own finding.
    pub(super) main: bool,
}

/// The form by which a cell is judged.
fn form_of(cell: &Cell) -> &'static str {
    match cell.judged_by {
        JudgedBy::Property => "property",
        JudgedBy::Monitor => "monitor",
    }
}

/// The rate under another form. Some hundred paths alone say less than a computed value, and a conflict that shrinks only
/// for that is not explained: to the value is added what the two forms differ by on the same traces. Where its own
/// form could not judge them, it stands as long as the other does not contradict it. Traces without a verdict are counted
/// so that the two forms differ least: they show no difference.
fn judged_otherwise(rate: Rate, own: Option<&Cell>, other: &Cell, margin: f64) -> Rate {
    let near = rate.shares().iter().sum::<f64>() / 2.0;
    let counted = match other.undecided {
        0 => Rate::counted(other.count, other.trials),
        _ => Rate::Counted {
            count: other.share_near(near) * other.trials as f64,
            open: 0.0,
            trials: other.trials as f64,
        },
    };
    match (rate.computed(), own) {
        (Some(value), Some(own)) => {
            let ([low, high], [own_low, own_high]) = (other.shares(), own.shares());
            let shift = 0.0_f64.clamp(low - own_high, high - own_low);
            match shift == 0.0 {
                true => rate,
                false => Rate::Computed((value + shift).clamp(0.0, 1.0)),
            }
        }
        (Some(_), None) if strength(rate, counted, margin) < STRONG => rate,
        _ => counted,
    }
}

impl<'a> Matter<'a> {
    /// The declared margin of a subject.
    pub fn margin(&self, subject: &Subject) -> f64 {
        crate::margin_of(self.requirements, self.failure_modes, subject)
    }

    pub(super) fn piece(&self, id: &str) -> Option<&'a Evidence> {
        self.evidence.iter().find(|e| e.id == id)
    }

    /// The pieces that speak for themselves: no steps on the way, and no published counts that others
    /// of ours reproduce.
    pub(super) fn speaking(&self) -> impl Iterator<Item = &'a Evidence> {
        let all = self.evidence.iter();
        all.filter(|e| !(e.intermediate || e.published && e.reproduced_by.is_some()))
    }

    /// The conflicts between pieces that speak for themselves, each quantity once.
    pub(super) fn conflicts(&self) -> Vec<&'a Comparison> {
        let speaks = |id: &str| self.speaking().any(|e| e.id == id);
        let is_own = |subject: &Subject| match subject {
            Subject::Requirement(id) => {
                let mut all = self.requirements.iter();
                all.all(|r| &r.id != id || r.same_quantity_as.is_none())
            }
            Subject::FailureMode(_) => true,
        };
        let all = self.comparisons.iter();
        // What never came in one of them has no rate there.
        let has_rates = |c: &Comparison| {
            let sides = [&c.left, &c.right].map(|id| self.piece(id)?.finding(&c.subject));
            let mut known = sides.into_iter().flatten();
            !known.any(|it| matches!(it.measure, Measure::NotCovered { .. }))
        };
        all.filter(|c| c.outcome == Outcome::Conflicts && has_rates(c))
            .filter(|c| speaks(&c.left) && speaks(&c.right) && is_own(&c.subject))
            .collect()
    }

    /// All the ways in which a piece judges a subject, its own first.
    pub(super) fn judged(&self, piece: &Evidence, subject: &Subject) -> Vec<Judged> {
        let finding = piece.finding(subject);
        let Some((finding, rate)) = finding.and_then(|f| Some((f, Rate::on(piece, subject)?)))
        else {
            return Vec::new();
        };
        let own = own_form(piece);
        let mut all = vec![Judged {
            form: own.into(),
            rate,
            main: true,
        }];
        let own_cell = self.cell(piece, subject, own);
        for cell in self.cells {
            let form = form_of(cell);
            let is_other = &cell.subject == subject && cell.evidence == piece.id && form != own;
            // The property of a failure mode speaks of runs, not of opportunities.
            let is_rate = matches!(subject, Subject::Requirement(_)) || form == "monitor";
            if is_other && is_rate && cell.trials > 0 {
                all.push(Judged {
                    form: form.into(),
                    rate: judged_otherwise(rate, own_cell, cell, self.margin(subject)),
                    main: false,
                });
            }
        }
        all.extend(
            super::forms::under_sentence(piece, subject).map(|rate| Judged {
                form: super::forms::SENTENCE.into(),
                rate,
                main: false,
            }),
        );
        let readings = finding.readings.iter().filter(|r| r.trials > 0);
        all.extend(readings.map(|reading| Judged {
            form: reading.name.clone(),
            rate: Rate::counted(reading.count, reading.trials),
            main: false,
        }));
        all
    }

    /// What a form says of the traces of a piece.
    fn cell(&self, piece: &Evidence, subject: &Subject, form: &str) -> Option<&'a Cell> {
        let mut cells = self.cells.iter();
        cells.find(|cell| {
            &cell.subject == subject
                && cell.evidence == piece.id
                && form_of(cell) == form
                && cell.trials > 0
        })
    }

    /// How strongly two pieces differ on a subject, by their own findings.
    pub(super) fn difference(&self, one: &Evidence, other: &Evidence, subject: &Subject) -> f64 {
        match (Rate::on(one, subject), Rate::on(other, subject)) {
            (Some(a), Some(b)) => strength(a, b, self.margin(subject)),
            _ => 0.0,
        }
    }

    /// The command that runs an episode of a piece again, or shows a path.
    pub(super) fn replay(&self, piece: &Evidence, run: &str) -> String {
        let study = self.study;
        let number: String = run.chars().filter(char::is_ascii_digit).collect();
        let number = number.trim_start_matches('0');
        match piece.technique.traits().rerun {
            Rerun::Path => {
                format!("corroborate diagnose {study} --show {}:{number}", piece.id)
            }
            Rerun::None => format!("corroborate run {study} --only {}", piece.id),
            Rerun::Episode => format!("corroborate replay {study} {}:{number}", piece.id),
            Rerun::Recording | Rerun::RecordingIfKept => {
                format!("corroborate monitor {study} {}", self.recording(piece, run))
            }
        }
    }

    /// Where a recording lies, for a command: within the study, if a file of the piece ends so and no other does.
    fn recording(&self, piece: &Evidence, run: &str) -> String {
        let assets = piece.assets.iter().filter(|it| it.role == AssetRole::Data);
        let mut found = assets.filter(|it| {
            let rest = it.path.strip_suffix(run);
            rest.is_some_and(|rest| rest.is_empty() || rest.ends_with('/'))
        });
        match (found.next(), found.next()) {
            (Some(asset), None) => format!("{}/{}", self.study, asset.path),
            _ => run.to_owned(),
        }
    }

    /// The asset in which a piece's figure on a subject stands: the table that counts it, or else its system model.
    pub(super) fn asset_of(&self, piece: &Evidence, subject: &Subject) -> SuspectAsset {
        let whole = system_model(piece);
        let totals = match subject {
            Subject::FailureMode(_) => Counted::FailureModes,
            Subject::Requirement(_) => Counted::Requirements,
        };
        let table_of = |counts: Counted| {
            let mut all = self.tables.iter();
            all.find(|table| table.evidence == piece.id && table.counts == counts)
        };
        let order = match piece.finding(subject).is_some_and(is_by_subject) {
            true => [Counted::BySubject, totals],
            false => [totals, Counted::BySubject],
        };
        let table = order.into_iter().find_map(table_of);
        match table.filter(|_| whole.kind == SuspectKind::Data) {
            None => whole,
            Some(table) => SuspectAsset {
                file: Some(table.file.clone()),
                part: None,
                together: whole
                    .file
                    .into_iter()
                    .chain(whole.together)
                    .filter(|file| file != &table.file)
                    .collect(),
                ..whole
            },
        }
    }

    /// The table that counts a subject of a piece, and what says which of its columns that is: who exchanges either does the
    /// same to the counts.
    pub(super) fn table_and_words(&self, piece: &Evidence, subject: &Subject) -> SuspectAsset {
        let mut asset = self.asset_of(piece, subject);
        let counts_it = |table: &&TableOf| {
            table.evidence == piece.id && Some(&table.file) == asset.file.as_ref()
        };
        let words = self.tables.iter().find(counts_it);
        let words = words.and_then(|table| table.bound_in.clone());
        asset.together.extend(words);
        asset
    }

    pub(super) fn witnesses(&self, piece: &Evidence, runs: &[String], shows: &str) -> Vec<Witness> {
        let of = |run: &String| Witness {
            name: format!("{} {run}", piece.id),
            shows: shows.to_owned(),
            replay: self.replay(piece, run),
        };
        // What others published or counted by hand cannot be replayed.
        let replayable = match piece.technique.traits().rerun {
            Rerun::Path | Rerun::Recording => true,
            Rerun::Episode => !piece.published,
            Rerun::None | Rerun::RecordingIfKept => false,
        };
        let runs = runs.iter().filter(|_| replayable);
        runs.map(of).collect()
    }
}

/// Whether a finding counts the trials of each person or session.
pub(super) fn is_by_subject(finding: &Finding) -> bool {
    matches!(&finding.measure, Measure::Counts { by_subject, .. } if by_subject.is_some())
}

/// The system model on which a piece of evidence rests. What was shown is that the piece differs, not which of its files
/// is the reason: one is named, all others beside it. Named is the last of the files that say how the system behaves,
/// since parameters follow their scenario; descriptions and shapes of bodies, which other programs made, come last. Of many
/// recordings their folder is named, with how many they are.
pub fn system_model(piece: &Evidence) -> SuspectAsset {
    let (kind, role) = match (piece.technique.witness_of(), piece.published) {
        (WitnessOf::Model, _) => (SuspectKind::FormalModel, AssetRole::SystemModel),
        (WitnessOf::Simulator, false) => (SuspectKind::Simulation, AssetRole::SystemModel),
        // Published simulations are known by their counts alone.
        (WitnessOf::Simulator, true) | (WitnessOf::System, _) => {
            (SuspectKind::Data, AssetRole::Data)
        }
    };
    let files = piece.assets.iter().filter(|a| a.role == role);
    let files: Vec<&String> = files.map(|asset| &asset.path).collect();
    if let (SuspectKind::Data, Some(folder)) = (kind, folder_of(&files)) {
        return SuspectAsset {
            kind,
            file: Some(folder),
            part: Some(format!("{} files", files.len())),
            evidence: vec![piece.id.clone()],
            together: Vec::new(),
            line: None,
        };
    }
    let behaviour = files.iter().rposition(|file| !is_description(file));
    let named = behaviour.or(files.len().checked_sub(1));
    let together = files
        .iter()
        .enumerate()
        .filter(|(at, _)| Some(*at) != named);
    SuspectAsset {
        kind,
        file: named.map(|at| files[at].clone()),
        part: None,
        evidence: vec![piece.id.clone()],
        together: together.map(|(_, file)| (*file).clone()).collect(),
        line: None,
    }
}

/// The folder, with `/`, that more files lie in than a reader looks through one by one, if all lie in it.
fn folder_of(files: &[&String]) -> Option<String> {
    let (folder, _) = files.first()?.rsplit_once('/')?;
    let folder = format!("{folder}/");
    let is_in = |file: &&String| file.starts_with(&folder);
    (files.len() > MOST_NAMED && files.iter().all(is_in)).then_some(folder)
}

/// Whether a file describes bodies: their links, joints and shapes.
fn is_description(file: &str) -> bool {
    const DESCRIPTIONS: [&str; 10] = [
        "urdf", "xacro", "sdf", "world", "xml", "mjcf", "stl", "obj", "dae", "ply",
    ];
    let extension = file.rsplit_once('.').map_or("", |(_, extension)| extension);
    DESCRIPTIONS.contains(&extension.to_ascii_lowercase().as_str())
}

/// A requirement's form.
pub fn requirement_form(subject: &Subject, form: &str, evidence: &[&str]) -> SuspectAsset {
    let what = match subject {
        Subject::Requirement(id) => format!("requirement {id}"),
        Subject::FailureMode(id) => format!("failure mode {id}"),
    };
    let (kind, form) = match form {
        "property" | "occurs" => (SuspectKind::Property, "property".to_owned()),
        "trigger" | "opportunity" | "experiment" => (SuspectKind::Property, form.to_owned()),
        "monitor" => (SuspectKind::Monitor, "monitor".to_owned()),
        "sentence" => (SuspectKind::Monitor, "sentence".to_owned()),
        reading => (SuspectKind::Monitor, format!("reading `{reading}`")),
    };
    SuspectAsset {
        kind,
        file: Some("requirements.toml".into()),
        part: Some(format!("{what}, {form}")),
        evidence: evidence.iter().map(|id| (*id).to_owned()).collect(),
        together: Vec::new(),
        line: None,
    }
}

/// A rate for people.
pub(super) fn rate_in_words(piece: &Evidence, subject: &Subject) -> String {
    use crate::Measure::{Counts, Probability};
    match piece.finding(subject).map(|f| &f.measure) {
        Some(Counts { count, trials, .. }) => format!("{count} of {trials} in {}", piece.id),
        Some(Probability { answer, .. }) => format!("{:.4} in {}", answer.value, piece.id),
        _ => format!("nothing in {}", piece.id),
    }
}

/// A subject for people.
pub(super) fn name_of(subject: &Subject) -> String {
    subject.in_words()
}

impl Suspect {
    /// A suspect of which one thing is known.
    pub(super) fn of(clue: Clue) -> Self {
        Self {
            rank: 0,
            inaccuracy: clue.inaccuracy,
            asset: clue.asset,
            subjects: vec![clue.subject],
            score: clue.score,
            title: clue.title,
            explanation: clue.explanation,
            symptoms: vec![clue.symptom],
            figures: clue.figures,
            witnesses: clue.witnesses,
            ruled_out: clue.ruled_out,
            resolved_by: clue.resolved_by,
        }
    }
}
