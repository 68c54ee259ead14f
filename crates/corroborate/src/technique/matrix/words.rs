//! What the runs of a simulator and recordings are read through: as suspect as what they show.
//!
//! # Definition
//! A simulator's episodes and recordings are judged by the words of vocabulary.toml on the signals of topics.toml, with the
//! limits of parameters.toml. Where such a piece is suspected because its rate differs from that of another, and no other
//! piece that is read so agrees with that other one, these files are named with the suspect, and requirements.toml where its monitor
//! was written by hand: a wrong word would show the same. With a formal model of which no line is named the words and the property go
//! through which it is asked.
//!
//! Where several pieces that are read so agree, and differ from another, what they are read through is a suspect of its own. It
//! is named by the line of a monitor that was written by hand or, without one, of the last predicate that the requirement
//! reads; before others those that nothing reads that agrees. All others are named with it.
//!
//! # Assumes
//! Nothing of the data.
//!
//! # Guarantee
//! None: that a file is named says that what was shown does not tell it apart.

use super::Diagnosing;
use super::candidates::{clauses::of_property, of_monitor};
use evidence::{
    CERTAIN, Evidence, Rate, STRONG, Subject, Suspect, SuspectKind, Symptom, signed_strength,
};

/// What a suspect's part ends with that is what several pieces are read through.
const READ: &str = ", as read from runs";

/// A place of a reading: the file, the part, the line, and whether something that agrees is read through it, too.
struct Place {
    file: &'static str,
    part: String,
    line: Option<u32>,
    is_confirmed: bool,
}

/// Whether a suspect is what several pieces are read through.
fn is_reading(suspect: &Suspect) -> bool {
    let part = suspect.asset.part.as_deref().unwrap_or_default();
    suspect.asset.kind == SuspectKind::Vocabulary && part.ends_with(READ)
}

/// Whether a suspect is a single edit of what runs are read through that explains what the reading is suspected for.
fn is_way_of(suspect: &Suspect, reading: &Suspect) -> bool {
    let part = suspect.asset.part.as_deref().unwrap_or_default();
    let is_of_models = ["model", "property", "column"]
        .iter()
        .any(|end| part.ends_with(&format!(", {end}")));
    suspect.is_open()
        && !is_of_models
        && suspect.symptoms.iter().any(|symptom| match symptom {
            Symptom::EditExplains { subject, pairs, .. } => {
                let read = &reading.asset.evidence;
                reading.subjects.contains(subject)
                    && pairs.iter().flatten().any(|id| read.contains(id))
            }
            _ => false,
        })
}

impl Diagnosing<'_> {
    /// Places what several pieces are read through in the files. Where single edits of it explain what disagrees, the best of
    /// them is what is suspected: that something of it is wrong speaks for them.
    pub(super) fn readings(&self, suspects: &mut Vec<Suspect>) {
        let all = std::mem::take(suspects);
        let (readings, mut rest): (Vec<Suspect>, Vec<Suspect>) =
            all.into_iter().partition(is_reading);
        for reading in readings {
            let best = rest.iter_mut().filter(|it| is_way_of(it, &reading));
            match best.max_by(|a, b| a.score.total_cmp(&b.score)) {
                Some(edit) => edit.score = (edit.score + reading.score).min(CERTAIN),
                None => rest.push(reading),
            }
        }
        // Of equal scores the order of the ranks stays.
        rest.sort_by(|a, b| b.score.total_cmp(&a.score).then(a.rank.cmp(&b.rank)));
        for (rank, suspect) in (1..).zip(&mut rest) {
            suspect.rank = rank;
        }
        *suspects = rest;
        self.place_readings(suspects);
    }

    fn place_readings(&self, suspects: &mut [Suspect]) {
        let apart = self.disagreements(&self.result.evidence);
        let disagrees = |subject: &Subject| {
            let mut own = apart.iter().filter(|((.., it), _)| it == subject);
            own.any(|(_, apart)| *apart > STRONG)
        };
        for suspect in suspects.iter_mut() {
            let part = suspect.asset.part.as_deref().unwrap_or_default();
            let is_reading = suspect.asset.kind == SuspectKind::Vocabulary && part.ends_with(READ);
            let subject = suspect.subjects.first();
            let (true, Some(subject)) = (is_reading, subject.cloned()) else {
                continue;
            };
            let mut places = self.places(&subject, &disagrees);
            places.sort_by_key(|it| it.is_confirmed);
            let mut files: Vec<String> = places
                .iter()
                .skip(1)
                .map(|it| format!("{} ({})", it.file, it.part))
                .collect();
            let evidence = suspect.asset.evidence.first().cloned().unwrap_or_default();
            let through = self.read_through(&evidence, &subject).into_iter();
            files.extend(through.filter(|file| file != "vocabulary.toml"));
            if let Some(first) = places.first() {
                suspect.asset.file = Some(first.file.to_owned());
                suspect.asset.part = Some(first.part.clone());
                suspect.asset.line = first.line;
            }
            suspect.asset.together.extend(files);
        }
    }

    /// Where a subject's runs are read: a monitor by hand, then the predicates, the last first.
    fn places(&self, subject: &Subject, disagrees: &dyn Fn(&Subject) -> bool) -> Vec<Place> {
        let Some(form) = self.study.forms.of(subject) else {
            return Vec::new();
        };
        let mut found = Vec::new();
        let line = |text: &str, at: usize| {
            let (line, _) = prism_lang::line_and_column(text, at);
            u32::try_from(line).ok()
        };
        if form.monitor.as_ref().is_some_and(|it| !it.from_sentence) {
            let source = &self.study.forms.source;
            found.push(Place {
                file: "requirements.toml",
                part: format!("{}, monitor", subject.in_words()),
                line: line(&source.text, form.span.start),
                is_confirmed: false,
            });
        }
        let vocabulary = std::fs::read_to_string(self.study.folder.join("vocabulary.toml"));
        let vocabulary = vocabulary.unwrap_or_default();
        for name in of_monitor(form).iter().rev() {
            let word = self.study.vocabulary.propositions.get(name);
            let Some(binding) = word.and_then(|it| it.trace.as_ref()) else {
                continue;
            };
            let mut forms = self.study.forms.subjects.iter();
            found.push(Place {
                file: "vocabulary.toml",
                part: format!("{name}, trace"),
                line: line(&vocabulary, binding.span.start),
                is_confirmed: forms
                    .any(|it| of_monitor(it).contains(name) && !disagrees(&it.subject)),
            });
        }
        found
    }

    /// Names the words that a suspect is read through where nothing else confirms them.
    pub(super) fn words(&self, suspects: &mut [Suspect]) {
        for suspect in suspects {
            let is_looked_at = match suspect.asset.kind {
                SuspectKind::Simulation | SuspectKind::Data => true,
                SuspectKind::FormalModel => suspect.asset.line.is_none(),
                _ => false,
            };
            if !suspect.is_open() || !is_looked_at {
                continue;
            }
            let mut files: Vec<String> = Vec::new();
            for symptom in &suspect.symptoms {
                if let Symptom::RateDiffers {
                    subject,
                    evidence,
                    others,
                    ..
                } = symptom
                    && others
                        .iter()
                        .any(|(other, ..)| !self.is_confirmed(evidence, other, subject))
                {
                    files.extend(self.read_through(evidence, subject));
                }
            }
            for file in files {
                if !suspect.asset.together.contains(&file) {
                    suspect.asset.together.push(file);
                }
            }
        }
    }

    /// Whether another piece that is read as this one agrees with the one that this one differs from.
    fn is_confirmed(&self, evidence: &str, against: &str, subject: &Subject) -> bool {
        let piece = |id: &str| self.result.evidence.iter().find(|it| it.id == id);
        let Some(against) = piece(against) else {
            return true;
        };
        let agrees = |other: &Evidence| {
            let rates = (Rate::on(other, subject), Rate::on(against, subject));
            match rates {
                (Some(a), Some(b)) => signed_strength(a, b, self.margin(subject)) <= STRONG,
                _ => false,
            }
        };
        let is_of_model = piece(evidence).is_some_and(|it| it.technique.is_of_model());
        let is_read_so = |other: &Evidence| match is_of_model {
            true => other.technique.is_of_model(),
            false => self.is_read(&other.id),
        };
        let mut others = self.result.evidence.iter();
        // The other piece itself may be read so, too.
        others.any(|other| other.id != evidence && is_read_so(other) && agrees(other))
    }

    /// Whether the runs of a piece are judged by the vocabulary's predicates on traces.
    fn is_read(&self, evidence: &str) -> bool {
        let entry = self.study.entry(evidence);
        entry.is_ok_and(|it| it.work.simulated().is_some() || it.work.recordings().is_some())
    }

    /// The files of words that a piece is read through.
    fn read_through(&self, evidence: &str, subject: &Subject) -> Vec<String> {
        let Ok(entry) = self.study.entry(evidence) else {
            return Vec::new();
        };
        if entry.work.model().is_some() {
            return self.asked_through(subject);
        }
        if !self.is_read(evidence) {
            return Vec::new();
        }
        let has_topics =
            entry.work.parts().uses_topics && self.study.folder.join("topics.toml").exists();
        let form = self.study.forms.of(subject);
        let has_limits =
            form.is_some_and(|form| super::candidates::reads_parameters(self.study, form));
        let by_hand = form.and_then(|form| form.monitor.as_ref());
        let by_hand = by_hand.is_some_and(|monitor| !monitor.from_sentence);
        let files = [
            Some("vocabulary.toml"),
            has_topics.then_some("topics.toml"),
            has_limits.then_some("parameters.toml"),
            by_hand.then_some("requirements.toml"),
        ];
        files.into_iter().flatten().map(str::to_owned).collect()
    }

    /// The files of the words and the property through which a formal model is asked.
    fn asked_through(&self, subject: &Subject) -> Vec<String> {
        let Some(form) = self.study.forms.of(subject) else {
            return Vec::new();
        };
        let words = &self.study.vocabulary.propositions;
        let has_words = of_property(form)
            .iter()
            .any(|name| words.get(name).is_some_and(|it| it.model.is_some()));
        let by_hand = form.property.as_ref().is_some_and(|it| !it.from_sentence);
        let files = [
            has_words.then_some("vocabulary.toml"),
            by_hand.then_some("requirements.toml"),
        ];
        files.into_iter().flatten().map(str::to_owned).collect()
    }
}
