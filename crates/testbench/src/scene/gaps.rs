//! What of the descriptions that a scene names is not simulated, or only approximately.
//!
//! Two steps lose something. `robot-model` reads a text into a tree and names what the tree does not hold, with its
//! place. A scene then takes of the tree what moves and what touches; sensors and drives are the scene's own, and every
//! contact is a point with Coulomb friction. What gets lost in that step has no place in the text, since the tree does
//! not keep places.
//!
//! The gaps of a description depend on its bytes and on those of the files that it names, and on nothing else.

use std::fmt;

use robot_model::{Geometry, JointKind, Loaded, Mask, Model, Role, Shape};

/// Something in the description of a robot or an object that is not simulated as it is described.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct SceneGap {
    /// The file, by its path relative to the scene's file: the description, or one that it includes.
    pub file: String,
    /// Line and column from 1; `None` for what the tree holds and a scene does not take.
    pub place: Option<[u32; 2]>,
    /// The element or attribute, as a path of the innermost names; empty for what is probably wrong.
    pub element: String,
    /// What was left out or approximated.
    pub what: String,
    /// What it concerns: `motion`, `contact`, `sensing`, `control`, `looks`, `nothing`, or `doubt` where the
    /// description is probably wrong.
    pub effect: String,
    /// What follows from it, or what to do about it.
    pub consequence: String,
}

impl fmt::Display for SceneGap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.file)?;
        if let Some([line, column]) = self.place {
            write!(f, ":{line}:{column}")?;
        }
        if !self.element.is_empty() {
            write!(f, ": {}", self.element)?;
        }
        write!(f, ": {} ({}: {})", self.what, self.effect, self.consequence)
    }
}

/// What a scene lacks of one description: what the reader passed over first, in the order of the text, then what is
/// probably wrong, then what the tree holds and a scene does not take. That it is refused is [`Loaded::refusals`].
#[must_use]
pub fn description_gaps(file: &str, loaded: &Loaded) -> Vec<SceneGap> {
    let read = loaded.gaps.iter().map(|gap| SceneGap {
        file: gap.place.file.to_string(),
        place: Some([gap.place.line, gap.place.column]),
        element: gap.element.clone(),
        what: gap.what.clone(),
        effect: gap.effect.to_string(),
        consequence: gap.consequence.clone(),
    });
    let doubtful = loaded.warnings.iter().map(|warning| SceneGap {
        file: warning.place.file.to_string(),
        place: Some([warning.place.line, warning.place.column]),
        element: String::new(),
        what: warning.message.clone(),
        effect: "doubt".to_owned(),
        consequence: warning.remedy.clone(),
    });
    let mut gaps: Vec<SceneGap> = read.chain(doubtful).collect();
    gaps.extend(not_taken(file, &loaded.model));
    gaps
}

/// What the tree holds and a scene does not take.
fn not_taken(file: &str, model: &Model) -> Vec<SceneGap> {
    let gap = |names: Vec<String>, element: &str, what: &str, effect: &str, consequence: &str| {
        (!names.is_empty()).then(|| SceneGap {
            file: file.to_owned(),
            place: None,
            element: element.to_owned(),
            what: format!("{} {what}", listed(&names)),
            effect: effect.to_owned(),
            consequence: consequence.to_owned(),
        })
    };
    let sensors = model.sensors.iter().map(|sensor| sensor.name.clone());
    let drives = model.actuators.iter().map(|drive| drive.name.clone());
    let found = [
        gap(
            sensors.collect(),
            "sensor",
            "described, which a scene does not take",
            "sensing",
            "only the scene's own `sensor` entries measure",
        ),
        gap(
            held(model),
            "joint",
            "that would let links float that hang on another link",
            "motion",
            "they are held where they are",
        ),
        gap(
            braked(model),
            "joint",
            "that are free with damping, dry friction or a drive's inertia",
            "motion",
            "a scene's free links move without them",
        ),
        gap(
            drives.collect(),
            "drive",
            "described, which a scene does not take",
            "control",
            "only the scene's own `actuator` entries move joints",
        ),
        gap(
            touched(model, |shape| {
                shape.mask.is_some_and(|mask| !is_plain(mask))
            }),
            "mask",
            "of shapes that touch some kinds of shapes only",
            "contact",
            "they touch everything but their own model's group",
        ),
        gap(
            touched(model, has_other_friction),
            "friction",
            "of shapes with other than sliding friction",
            "contact",
            "they slide by Coulomb's law, and neither twist nor roll against friction",
        ),
        gap(
            touched(model, |shape| is_empty_mesh(model, shape)),
            "mesh",
            "of shapes whose mesh encloses no volume",
            "contact",
            "nothing touches them",
        ),
    ];
    found.into_iter().flatten().collect()
}

/// Free joints of links that hang on others.
fn held(model: &Model) -> Vec<String> {
    let joints = model.joints.iter();
    let held = joints
        .filter(|joint| joint.kind == JointKind::Free && model.links[joint.link].parent.is_some());
    held.map(|joint| joint.name.clone()).collect()
}

/// Free joints with more than freedom.
fn braked(model: &Model) -> Vec<String> {
    let joints = model.joints.iter();
    let braked = joints.filter(|joint| {
        joint.kind == JointKind::Free
            && [
                joint.damping,
                joint.friction,
                joint.armature,
                joint.stiffness,
            ] != [0.0; 4]
    });
    braked.map(|joint| joint.name.clone()).collect()
}

/// Names of shapes that are touched and have a property, with their links.
fn touched(model: &Model, has: impl Fn(&Shape) -> bool) -> Vec<String> {
    let links = model.links.iter();
    let shapes = links.flat_map(|link| link.shapes.iter().map(move |shape| (link, shape)));
    let found = shapes.filter(|(_, shape)| shape.role == Role::Collision && has(shape));
    found
        .map(|(link, shape)| format!("{}/{}", link.name, shape.name))
        .collect()
}

/// Masks of shapes that touch all others, or none, are simulated.
fn is_plain(mask: Mask) -> bool {
    (mask.kind, mask.touches) == (1, 1) || (mask.kind, mask.touches) == (0, 0)
}

/// MuJoCo counts the dimensions of a contact: 1 has no friction, 3 slides, 4 and 6 also twist and roll.
fn has_other_friction(shape: &Shape) -> bool {
    let friction = shape.friction;
    let is_more = friction.is_some_and(|it| it.torsional_m.is_some() || it.rolling_m.is_some());
    shape
        .contact_dimensions
        .map_or(is_more, |dimensions| dimensions != 3)
}

fn is_empty_mesh(model: &Model, shape: &Shape) -> bool {
    match &shape.geometry {
        Geometry::Mesh { mesh } => !model.meshes.get(*mesh).is_some_and(|it| it.is_solid()),
        _ => false,
    }
}

/// How many, and the first three by name.
fn listed(names: &[String]) -> String {
    let shown = names.iter().take(3).cloned().collect::<Vec<_>>().join(", ");
    match names.len() {
        0..=3 => format!("{} ({shown})", names.len()),
        count => format!("{count} ({shown}, ...)"),
    }
}
