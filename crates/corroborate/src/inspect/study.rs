//! Which signals the recordings of a study's simulations have, and which truth a scene would record if a proposition named it.

use crate::rigs::Opening;
use diagnostic::Problem;
use evidence::DescriptionGap;
use host::Host;
use rig::Rig;
use schemars::JsonSchema;
use serde::Serialize;
use std::path::Path;
use study::{Simulated, Study};
use testbench::scene::TruthVocabulary;
use trace::{Field, FieldKind, Trace};

/// The signals of a study's simulations.
#[derive(Debug, Serialize, JsonSchema)]
pub struct StudySignals {
    /// Version of this form.
    pub format: String,
    /// The study's folder.
    pub study: String,
    /// Its simulations, in the order of the ledger; those of one scene once.
    pub simulations: Vec<SimulationSignals>,
}

/// The signals of one simulation.
#[derive(Debug, Serialize, JsonSchema)]
pub struct SimulationSignals {
    /// The entries of the ledger that run it.
    pub evidence: Vec<String>,
    /// What simulates.
    pub engine: String,
    /// What each recording has.
    pub recorded: Vec<Signal>,
    /// What a scene records besides, once a proposition or a requirement names it.
    pub truth: Option<Truth>,
    /// What of descriptions is not simulated as it is described, and doubts of what the scene asks for, each with its place.
    pub gaps: Vec<String>,
    /// What of it was checked before anything runs, and what could not be, each with its place.
    pub checked: Vec<String>,
}

/// A signal of a recording.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Signal {
    /// As propositions name it.
    pub name: String,
    /// Its unit; `bool`, or the names that it can have.
    pub unit: String,
    /// The frame that it is in, if it is in one.
    pub frame: Option<String>,
}

/// Truth that a scene can tell: any topic with any quantity that it has.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Truth {
    /// What it is told of.
    pub topics: Vec<TruthTopic>,
    /// Quantities, in which `OTHER`, `JOINT` and `REGION` stand for names.
    pub quantities: Vec<Quantity>,
    /// What can stand for `OTHER`.
    pub others: Vec<String>,
    /// What can stand for `REGION`.
    pub regions: Vec<String>,
}

/// Something that truth is told of.
#[derive(Debug, Serialize, JsonSchema)]
pub struct TruthTopic {
    /// Its topic.
    pub topic: String,
    /// A robot, an object, a person, or a part of one.
    pub kind: String,
    /// What can stand for `JOINT`.
    pub joints: Vec<String>,
}

/// A quantity.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Quantity {
    /// As it stands behind a topic and a dot.
    pub name: String,
    /// Its unit; `bool` or `name` for what has none.
    pub unit: String,
    /// `world`, or `body`: that of what is named.
    pub frame: Option<String>,
    /// What it is.
    pub meaning: String,
}

/// Opens each simulation of a study and lists its signals. Commands of others are left out: to know their signals they would
/// have to be run.
pub(super) fn signals_of(folder: &Path, host: &Host) -> Result<StudySignals, Problem> {
    let study = Study::load_for(folder, &host.trust)?;
    let mut simulations: Vec<SimulationSignals> = Vec::new();
    let mut known: Vec<Simulated<'_>> = Vec::new();
    for entry in &study.ledger {
        let Some(simulated) = entry.work.simulated() else {
            continue;
        };
        if !simulated.is_ours() {
            continue;
        }
        if let Some(place) = known.iter().position(|it| is_same(it, &simulated)) {
            simulations[place].evidence.push(entry.id.clone());
            continue;
        }
        let opening = Opening {
            any_engine: true,
            ..Opening::new(&study, host)
        };
        let rig = opening.open(simulated)?;
        simulations.push(SimulationSignals::new(&entry.id, rig.as_ref())?);
        known.push(simulated);
    }
    Ok(StudySignals {
        format: "1.1".into(),
        study: folder.display().to_string(),
        simulations,
    })
}

/// Whether two entries simulate the same files, in whatever test.
fn is_same(a: &Simulated<'_>, b: &Simulated<'_>) -> bool {
    if let (Simulated::Scene { scene: a, .. }, Simulated::Scene { scene: b, .. }) = (a, b) {
        return a == b;
    }
    let texts = |it: &Simulated<'_>| match *it {
        Simulated::Handover {
            scenario,
            parameters,
            ..
        } => Some([scenario.to_owned(), parameters.to_owned()]),
        Simulated::Scene { .. } | Simulated::Command(_) => None,
    };
    texts(a).is_some() && texts(a) == texts(b)
}

impl SimulationSignals {
    fn new(evidence: &str, rig: &dyn Rig) -> Result<Self, Problem> {
        let layout = rig.layout(&host::Cancel::default())?;
        Ok(Self {
            evidence: vec![evidence.to_owned()],
            engine: rig.engine(),
            recorded: recorded(&layout),
            truth: rig.truth().map(Truth::new),
            gaps: told(rig.gaps()),
            checked: rig.checked().to_vec(),
        })
    }
}

/// What can move a number, and how much else there is.
fn told(gaps: &[DescriptionGap]) -> Vec<String> {
    let matter = gaps.iter().filter(|it| it.can_matter());
    let mut lines: Vec<String> = matter.map(ToString::to_string).collect();
    let others = gaps.len() - lines.len();
    if others > 0 {
        lines.push(format!(
            "{others} more, which concern looks or nothing that is simulated: `corroborate inspect` of the description lists them"
        ));
    }
    lines
}

fn recorded(layout: &Trace) -> Vec<Signal> {
    let channels = layout.channels.iter();
    let fields = channels.flat_map(|channel| channel.fields.iter().map(move |it| (channel, it)));
    fields
        .map(|(channel, field)| Signal {
            name: format!("{}.{}", channel.topic, field.name),
            unit: unit_of(field),
            frame: field.frame.clone(),
        })
        .collect()
}

/// The unit, or what stands in its place.
fn unit_of(field: &Field) -> String {
    match &field.kind {
        FieldKind::Number => field.unit.clone(),
        FieldKind::Bool => "bool".to_owned(),
        FieldKind::Enumeration(names) if names.len() <= 8 => names.join(" | "),
        FieldKind::Enumeration(names) => format!("one of {} names", names.len()),
    }
}

impl Truth {
    fn new(vocabulary: TruthVocabulary) -> Self {
        let topics = vocabulary.topics.into_iter().map(|topic| TruthTopic {
            topic: topic.topic,
            kind: topic.kind,
            joints: topic.joints.into_iter().map(|(name, _)| name).collect(),
        });
        let quantities = vocabulary.quantities.into_iter().map(|it| Quantity {
            name: it.name,
            unit: it.unit,
            frame: it.frame,
            meaning: it.meaning,
        });
        Self {
            topics: topics.collect(),
            quantities: quantities.collect(),
            others: vocabulary.others,
            regions: vocabulary.regions,
        }
    }
}
