//! `<worldbody>` and `<body>`: links with what they hold, through `<frame>`s.

use super::Context;
use super::compiler::FromGeoms;
use crate::checks;
use crate::diagnostics::{Effect, Place};
use crate::model::{Joint, JointKind, Link, Mark, Model};
use crate::pose::Pose;
use crate::shape::Inertial;
use crate::xml::Element;

/// Where an element stands: the frame it is in and the class it inherits.
#[derive(Clone)]
struct Around {
    /// The frame in the body's frame.
    frame: Pose,
    class: Option<String>,
}

/// What a body has gathered for its mass.
#[derive(Default)]
struct Masses {
    given: Option<Inertial>,
    of_geoms: Option<Inertial>,
}

impl Context<'_, '_, '_> {
    /// The world: its geoms go to a link called `world`.
    pub(super) fn world(&mut self, element: &Element, model: &mut Model, places: &mut Vec<Place>) {
        let around = Around {
            frame: Pose::IDENTITY,
            class: element.get("childclass").map(str::to_owned),
        };
        let has_geoms = element
            .children
            .iter()
            .any(|child| child.name == "geom" || child.name == "frame");
        let world = model.link("world").or_else(|| {
            has_geoms.then(|| {
                model
                    .links
                    .push(link("world".to_owned(), None, Pose::IDENTITY));
                places.push(element.place.clone());
                model.links.len() - 1
            })
        });
        let mut masses = Masses::default();
        self.content(element, &around, world, true, model, places, &mut masses);
    }

    #[expect(
        clippy::too_many_arguments,
        reason = "one walk fills the model, its places and the masses"
    )]
    fn content(
        &mut self,
        element: &Element,
        around: &Around,
        own: Option<usize>,
        in_world: bool,
        model: &mut Model,
        places: &mut Vec<Place>,
        masses: &mut Masses,
    ) {
        for child in &element.children {
            match (child.name.as_str(), own) {
                ("body", _) => {
                    let parent = own.filter(|_| !in_world);
                    self.body(child, around, parent, model, places);
                }
                ("frame", _) => {
                    self.ignored(child, &FRAME, Effect::Motion);
                    let below = self.frame(child, around);
                    self.content(child, &below, own, in_world, model, places, masses);
                }
                ("geom", Some(own)) => {
                    let made = self.geom(child, &around.frame, around.class.as_deref());
                    if let Some((shape, inertial)) = made {
                        model.links[own].shapes.extend(shape);
                        masses.of_geoms = match (masses.of_geoms, inertial) {
                            (Some(sum), Some(next)) => Some(sum.joined(&next)),
                            (sum, next) => sum.or(next),
                        };
                    }
                }
                ("site", _) => self.site(child, around, own, model),
                ("joint", Some(own)) if !in_world => {
                    self.joint(child, &around.frame, around.class.as_deref(), own, model);
                }
                ("freejoint", Some(own)) if !in_world => {
                    self.ignored(child, &["align"], Effect::Motion);
                    self.free(child, own, model);
                }
                ("inertial", Some(own)) => {
                    let name = model.links[own].name.clone();
                    masses.given = self.inertial(child, &around.frame, &name);
                }
                ("camera", _) => self.reader.passed_over("body", child, Effect::Sensing),
                ("light", _) => self.reader.passed_over("body", child, Effect::Looks),
                _ => self.reader.passed_over("body", child, Effect::Motion),
            }
        }
    }

    fn frame(&mut self, element: &Element, around: &Around) -> Around {
        let own = self.compiler.pose(self.reader, element);
        Around {
            frame: around.frame.then(&own),
            class: element
                .get("childclass")
                .map(str::to_owned)
                .or_else(|| around.class.clone()),
        }
    }

    fn body(
        &mut self,
        element: &Element,
        around: &Around,
        parent: Option<usize>,
        model: &mut Model,
        places: &mut Vec<Place>,
    ) {
        let known = [&FRAME[..], &["mocap", "gravcomp"]].concat();
        self.ignored(element, &known, Effect::Motion);
        let own = self.frame(element, around);
        let index = model.links.len();
        let name = element
            .get("name")
            .map_or_else(|| format!("body_{index}"), str::to_owned);
        if model.link(&name).is_some() {
            let message = format!("two bodies are called {name}");
            self.reader
                .problem(&element.place, message, "rename one of them");
        }
        let mut made = link(name, parent, own.frame);
        made.kinematic = element.get("mocap") == Some("true");
        made.gravity = match self.reader.number(element, "gravcomp") {
            None | Some(0.0) => true,
            Some(1.0) => false,
            Some(_) => {
                let what = "only 0 and 1 are carried over";
                let consequence = "gravity acts on the body in full";
                let path = "body@gravcomp";
                self.reader
                    .gap(&element.place, path, what, Effect::Motion, consequence);
                true
            }
        };
        model.links.push(made);
        places.push(element.place.clone());
        let mut masses = Masses::default();
        let inside = Around {
            frame: Pose::IDENTITY,
            class: own.class,
        };
        self.content(
            element,
            &inside,
            Some(index),
            false,
            model,
            places,
            &mut masses,
        );
        let given = match self.compiler.from_geoms {
            FromGeoms::Always => masses.of_geoms.or(masses.given),
            FromGeoms::IfMissing => masses.given.or(masses.of_geoms),
            FromGeoms::Never => masses.given,
        };
        model.links[index].inertial = self.compiler.bounded(given);
    }

    fn site(&mut self, element: &Element, around: &Around, own: Option<usize>, model: &mut Model) {
        let resolved = self
            .defaults
            .applied(self.reader, element, around.class.as_deref());
        let Some(name) = element.get("name") else {
            return;
        };
        let pose = self.pose_from_to(&resolved).map_or_else(
            || self.compiler.pose(self.reader, &resolved),
            |(pose, _)| pose,
        );
        model.marks.push(Mark {
            name: name.to_owned(),
            link: own,
            pose_in_link: around.frame.then(&pose),
        });
    }

    fn inertial(&mut self, element: &Element, frame: &Pose, link: &str) -> Option<Inertial> {
        let known = [&FRAME[..], &["mass", "diaginertia", "fullinertia"]].concat();
        self.ignored(element, &known, Effect::Motion);
        self.reader.required(element, "mass");
        let mass_kg = self.reader.number(element, "mass")?;
        let full = self.reader.attribute::<6>(element, "fullinertia");
        let diagonal = self.reader.attribute::<3>(element, "diaginertia");
        let tensor_kg_m2 = match (full, diagonal) {
            (Some(full), _) => full,
            (None, Some([x, y, z])) => [x, y, z, 0.0, 0.0, 0.0],
            (None, None) => [0.0; 6],
        };
        let own = Inertial {
            mass_kg,
            centre_m: [0.0; 3],
            tensor_kg_m2,
        };
        if !self.compiler.balances {
            checks::inertia(self.reader, &element.place, link, &own);
        }
        let pose = self.compiler.pose(self.reader, element);
        Some(own.placed(&frame.then(&pose)))
    }

    pub(super) fn free(&mut self, element: &Element, own: usize, model: &mut Model) {
        let name = element
            .get("name")
            .map_or_else(|| unnamed(model), str::to_owned);
        if model.links[own].parent.is_some() {
            let message = format!(
                "the free joint of body {} is not at the root",
                model.links[own].name
            );
            self.reader
                .problem(&element.place, message, "hang the body on the world");
        }
        model.joints.push(Joint::new(name, own, JointKind::Free));
    }
}

/// Attributes that place a frame.
pub(super) const FRAME: [&str; 7] = [
    "pos",
    "quat",
    "axisangle",
    "euler",
    "xyaxes",
    "zaxis",
    "childclass",
];

/// A name for a joint without one.
pub(super) fn unnamed(model: &Model) -> String {
    format!("joint_{}", model.joints.len())
}

fn link(name: String, parent: Option<usize>, pose_in_parent: Pose) -> Link {
    Link {
        name,
        parent,
        pose_in_parent,
        inertial: None,
        shapes: vec![],
        gravity: true,
        contact_group: None,
        kinematic: false,
    }
}
