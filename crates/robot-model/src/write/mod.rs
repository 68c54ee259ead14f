//! The tree as MJCF that MuJoCo loads without any other file.
//!
//! Bodies are links, with the same names and frames, so poses and positions of joints mean the same on both sides;
//! positions follow the order of [`Model::joints`]. Inertias are given explicitly and shapes weigh nothing. A mesh
//! is written as its corners alone, from which MuJoCo builds the convex hull that it uses for contact anyway.

mod bodies;
mod joints;

pub use bodies::shape_name;

use std::fmt;
use std::fmt::Write;

use crate::model::{JointKind, Model};
use crate::shape::{Geometry, Role};

/// What the description leaves open, or the physics needs.
#[derive(Debug, Clone, PartialEq)]
pub struct MjcfOptions {
    /// Time step; if `None` the description's, if it has none MuJoCo's own (2 ms).
    pub time_step_secs: Option<f64>,
    /// Gravity; if `None` the description's, if it has none MuJoCo's own (0, 0, -9.81).
    pub gravity_m_s2: Option<[f64; 3]>,
    /// Whether shapes that are only seen are written too.
    pub visuals: bool,
    /// Whether drives are written. Those whose gains are not known are left out, with a note.
    pub actuators: bool,
    /// Whether MuJoCo may change inertias that no body can have (`balanceinertia`); otherwise it refuses them.
    pub balance_inertia: bool,
    /// Masses below are raised to this, kg, if it is not 0 (`boundmass`).
    pub smallest_mass_kg: f64,
    /// Principal moments below are raised to this, kg m², if it is not 0 (`boundinertia`).
    pub smallest_inertia_kg_m2: f64,
    /// MJCF text put behind `<compiler>` as it is, for settings that no other option names.
    pub extra: String,
}

impl Default for MjcfOptions {
    fn default() -> Self {
        Self {
            time_step_secs: None,
            gravity_m_s2: None,
            visuals: false,
            actuators: true,
            balance_inertia: false,
            smallest_mass_kg: 0.0,
            smallest_inertia_kg_m2: 0.0,
            extra: String::new(),
        }
    }
}

/// MJCF text, and what it could not say.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Mjcf {
    /// The text.
    pub text: String,
    /// What was left out or approximated, one sentence each.
    pub notes: Vec<String>,
}

/// Why a tree cannot be written as MJCF.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum MjcfError {
    /// A free joint below a link that moves.
    FreeBelowMoving {
        /// The joint.
        joint: String,
    },
    /// A link without a name, or two of one name.
    Name {
        /// The name.
        name: String,
    },
}

impl fmt::Display for MjcfError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::FreeBelowMoving { joint } => write!(
                f,
                "joint {joint} is free, but not at the root of the tree, which MJCF does not allow; hang its link on the world"
            ),
            Self::Name { name } => write!(
                f,
                "two links or joints are called \"{name}\"; rename one, or give models prefixes"
            ),
        }
    }
}

impl std::error::Error for MjcfError {}

/// The text under construction.
struct Writer<'a> {
    model: &'a Model,
    options: &'a MjcfOptions,
    text: String,
    notes: Vec<String>,
    /// Whether a mesh has been written.
    written_meshes: Vec<bool>,
}

/// Appends formatted text. Writing to a `String` cannot fail.
macro_rules! put {
    ($text:expr, $($argument:tt)*) => {{ let _ = write!($text, $($argument)*); }};
}
use put;

/// Writes a model as MJCF.
///
/// # Errors
/// When names are not unique, or a free joint is not at the root.
pub fn to_mjcf(model: &Model, options: &MjcfOptions) -> Result<Mjcf, MjcfError> {
    check(model)?;
    let mut writer = Writer {
        model,
        options,
        text: String::with_capacity(4096),
        notes: vec![],
        written_meshes: vec![false; model.meshes.len()],
    };
    writer.header();
    writer.assets();
    writer.bodies();
    writer.contacts();
    writer.couplings();
    if options.actuators {
        writer.actuators();
    }
    writer.text.push_str("</mujoco>\n");
    Ok(Mjcf {
        text: writer.text,
        notes: writer.notes,
    })
}

fn check(model: &Model) -> Result<(), MjcfError> {
    let links = model.links.iter().map(|link| &link.name);
    let moving = model.joints.iter().filter(|j| j.kind != JointKind::Fixed);
    for names in [
        links.collect::<Vec<_>>(),
        moving.map(|joint| &joint.name).collect(),
    ] {
        let mut seen = std::collections::BTreeSet::new();
        for name in names {
            if name.is_empty() || !seen.insert(name) {
                return Err(MjcfError::Name { name: name.clone() });
            }
        }
    }
    for joint in &model.joints {
        if joint.kind == JointKind::Free && model.links[joint.link].parent.is_some() {
            let joint = joint.name.clone();
            return Err(MjcfError::FreeBelowMoving { joint });
        }
    }
    Ok(())
}

/// A text as the value of an attribute.
fn escaped(text: &str) -> String {
    let mut result = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => result.push_str("&amp;"),
            '<' => result.push_str("&lt;"),
            '>' => result.push_str("&gt;"),
            '"' => result.push_str("&quot;"),
            other => result.push(other),
        }
    }
    result
}

/// `1 2 3`.
fn list(numbers: &[f64]) -> String {
    let words: Vec<String> = numbers.iter().map(f64::to_string).collect();
    words.join(" ")
}

impl Writer<'_> {
    fn header(&mut self) {
        let (model, options) = (self.model, self.options);
        put!(self.text, "<mujoco model=\"{}\">\n", escaped(&model.name));
        put!(
            self.text,
            "<compiler angle=\"radian\" autolimits=\"true\" inertiafromgeom=\"false\" balanceinertia=\"{}\" boundmass=\"{}\" boundinertia=\"{}\"/>\n",
            options.balance_inertia,
            options.smallest_mass_kg,
            options.smallest_inertia_kg_m2
        );
        self.text.push_str(&options.extra);
        let step = options.time_step_secs.or(model.time_step_secs);
        let gravity = options.gravity_m_s2.or(model.gravity_m_s2);
        if step.is_some() || gravity.is_some() {
            self.text.push_str("<option");
            if let Some(step) = step {
                put!(self.text, " timestep=\"{step}\"");
            }
            if let Some(gravity) = gravity {
                put!(self.text, " gravity=\"{}\"", list(&gravity));
            }
            self.text.push_str("/>\n");
        }
    }

    /// The meshes that written shapes need.
    fn assets(&mut self) {
        let model = self.model;
        let shapes = model.links.iter().flat_map(|link| &link.shapes);
        let wanted = |role: Role| role == Role::Collision || self.options.visuals;
        let mut meshes: Vec<usize> = shapes
            .filter(|shape| wanted(shape.role))
            .filter_map(|shape| match shape.geometry {
                Geometry::Mesh { mesh } => Some(mesh),
                _ => None,
            })
            .collect();
        meshes.sort_unstable();
        meshes.dedup();
        self.text.push_str("<asset>\n");
        for index in meshes {
            let Some(mesh) = model.meshes.get(index) else {
                continue;
            };
            if mesh.vertices_m.is_empty() {
                continue;
            }
            if !mesh.is_solid() {
                let source = &mesh.source;
                self.notes.push(format!(
                    "the mesh {source} is flat and has no convex hull, so its shapes are left out"
                ));
                continue;
            }
            put!(self.text, "<mesh name=\"mesh_{index}\" vertex=\"");
            for corner in &mesh.vertices_m {
                put!(self.text, "{} ", list(corner));
            }
            self.text.push_str("\"/>\n");
            self.written_meshes[index] = true;
        }
        self.text.push_str("</asset>\n");
    }

    /// Pairs of links that do not touch.
    fn contacts(&mut self) {
        let model = self.model;
        let touching: Vec<usize> = (0..model.links.len())
            .filter(|link| {
                let mut shapes = model.links[*link].shapes.iter();
                shapes.any(|shape| shape.role == Role::Collision)
            })
            .collect();
        self.text.push_str("<contact>\n");
        for (position, first) in touching.iter().enumerate() {
            for second in &touching[position + 1..] {
                if !model.links[*first].touches_group(&model.links[*second]) {
                    self.exclude(*first, *second);
                }
            }
        }
        for [first, second] in &model.no_contact {
            if model.links[*first].touches_group(&model.links[*second]) {
                self.exclude(*first, *second);
            }
        }
        self.text.push_str("</contact>\n");
    }

    fn exclude(&mut self, first: usize, second: usize) {
        let [first, second] = [first, second].map(|link| escaped(&self.model.links[link].name));
        put!(
            self.text,
            "<exclude body1=\"{first}\" body2=\"{second}\"/>\n"
        );
    }
}
