//! What truth signals speak of: robots, objects and people, and their parts.

use std::collections::BTreeMap;

use crate::geometry::{IDENTITY, Pose};
use crate::physics::{Layout, Motion};
use crate::scene::build::Built;
use crate::scene::data::{PersonBody, SceneData};
use crate::scene::person::HAND_BELOW_FOREARM;

/// What a thing is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Robot,
    Object,
    Person,
}

impl Kind {
    pub(super) fn word(self) -> &'static str {
        match self {
            Self::Robot => "robot",
            Self::Object => "object",
            Self::Person => "person",
        }
    }
}

/// Where a frame is: on a body, or fixed in the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Place {
    Body(usize, Pose),
    World(Pose),
}

/// A part of a thing, or the thing as a whole.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Part {
    /// As in topics behind `/truth/`: `arm`, or `arm/hand`.
    pub(super) label: String,
    pub(super) kind: Kind,
    pub(super) is_whole: bool,
    pub(super) place: Place,
    /// What can be touched of it.
    pub(super) shapes: Vec<usize>,
    /// What has mass of it.
    pub(super) bodies: Vec<usize>,
    /// Whether nothing that touches it moves it: a person's limb, what is fixed to the world.
    pub(super) never_yields: bool,
}

impl Part {
    pub(super) fn topic(&self) -> String {
        format!("/truth/{}", self.label)
    }

    /// As it stands behind a dot: `arm.hand`.
    pub(super) fn dotted(&self) -> String {
        self.label.replacen('/', ".", 1)
    }
}

/// A thing of the scene.
#[derive(Debug, Clone)]
pub(super) struct Thing {
    pub(super) name: String,
    pub(super) kind: Kind,
    /// The whole first, then its links, points of tools or limbs.
    pub(super) parts: Vec<Part>,
    pub(super) joints: BTreeMap<String, usize>,
}

impl Thing {
    pub(super) fn whole(&self) -> &Part {
        &self.parts[0]
    }
}

/// All of them, and what else can be touched.
#[derive(Debug, Clone)]
pub(super) struct Things {
    pub(super) list: Vec<Thing>,
    pub(super) ground: Vec<usize>,
    pub(super) shapes: usize,
    /// Who a shape belongs to, as a place in `owners`.
    pub(super) owner_of: Vec<usize>,
    /// The place in `list` of the thing that a shape is of; one more than the last for the ground.
    pub(super) thing_of: Vec<usize>,
    /// `none`, then the names of bodies and of what is fixed to the world.
    pub(super) owners: Vec<String>,
}

const AT_ORIGIN: Pose = Pose {
    position_m: [0.0; 3],
    orientation: IDENTITY,
};

impl Things {
    pub(super) fn new(data: &SceneData, built: &Built) -> Self {
        let layout = &built.layout;
        let robots = data.robots.iter().zip(&built.robots).map(|(robot, at)| {
            // Of shapes that are fixed in the world there is no body.
            let has_body = at.added.links.values().any(|body| *body == at.added.root);
            let place = match has_body {
                true => Place::Body(at.added.root, AT_ORIGIN),
                false => Place::World(AT_ORIGIN),
            };
            let mut thing = Thing::linked(
                (&robot.name, Kind::Robot),
                layout,
                place,
                (&at.added.links, &at.added.joints),
                at.added.shapes.clone(),
            );
            let points = data.tool_points.iter().filter(|it| it.robot == robot.name);
            for point in points {
                let Some(body) = at.body(point.link.as_deref()) else {
                    continue;
                };
                thing.parts.push(Part {
                    label: format!("{}/{}", robot.name, point.name),
                    place: Place::Body(body, point.pose()),
                    shapes: Vec::new(),
                    bodies: Vec::new(),
                    is_whole: false,
                    ..thing.parts[0].clone()
                });
            }
            thing
        });
        let objects = data.objects.iter().zip(&built.objects).map(|(object, at)| {
            let place = match at.body {
                Some(body) => Place::Body(body, AT_ORIGIN),
                None => Place::World(at.pose),
            };
            Thing::linked(
                (&object.name, Kind::Object),
                layout,
                place,
                (&at.links, &at.joints),
                at.shapes.clone(),
            )
        });
        let people = data.people.iter().zip(&built.people).map(|(person, at)| {
            let bodies = at.bodies.clone();
            let links = bodies.clone().map(|body| {
                let name = &layout.bodies[body].name;
                let limb = name.split_once('/').map_or(name.as_str(), |(_, limb)| limb);
                (limb.to_owned(), body)
            });
            let mut thing = Thing::linked(
                (&person.name, Kind::Person),
                layout,
                Place::Body(bodies.start, AT_ORIGIN),
                (&links.collect(), &BTreeMap::new()),
                at.shapes.clone(),
            );
            if person.body == PersonBody::Articulated {
                thing.add_hands(bodies.end, at.height_m);
            }
            thing
        });
        let list: Vec<Thing> = robots.chain(objects).chain(people).collect();
        let thing_of = (0..layout.shapes.len()).map(|shape| {
            let mut things = list.iter();
            let place = things.position(|thing| thing.whole().shapes.contains(&shape));
            place.unwrap_or(list.len())
        });
        let thing_of = thing_of.collect();
        let (owners, owner_of) = owners(data, built);
        Self {
            list,
            ground: built.ground.clone().collect(),
            shapes: layout.shapes.len(),
            thing_of,
            owner_of,
            owners,
        }
    }

    pub(super) fn thing(&self, name: &str) -> Option<&Thing> {
        self.list.iter().find(|thing| thing.name == name)
    }

    pub(super) fn parts(&self) -> impl Iterator<Item = &Part> + Clone {
        self.list.iter().flat_map(|thing| &thing.parts)
    }
}

impl Thing {
    fn linked(
        (name, kind): (&str, Kind),
        layout: &Layout,
        place: Place,
        (links, joints): (&BTreeMap<String, usize>, &BTreeMap<String, usize>),
        shapes: std::ops::Range<usize>,
    ) -> Self {
        let yields = |body: usize| is_loose(layout, body);
        let bodies: Vec<usize> = match (links.is_empty(), place) {
            (true, Place::Body(body, _)) => vec![body],
            _ => links.values().copied().collect(),
        };
        let whole = Part {
            label: name.to_owned(),
            kind,
            is_whole: true,
            place,
            never_yields: !bodies.iter().any(|body| yields(*body)),
            shapes: shapes.clone().collect(),
            bodies,
        };
        let of_link = |(link, body): (&String, &usize)| Part {
            label: format!("{name}/{link}"),
            kind,
            is_whole: false,
            place: Place::Body(*body, AT_ORIGIN),
            never_yields: !yields(*body),
            shapes: shapes
                .clone()
                .filter(|shape| layout.shapes[*shape].body == Some(*body))
                .collect(),
            bodies: vec![*body],
        };
        let parts = std::iter::once(whole).chain(links.iter().map(of_link));
        Self {
            name: name.to_owned(),
            kind,
            parts: parts.collect(),
            joints: joints.clone(),
        }
    }

    /// The ends of the forearms, which are a person's last two bodies.
    fn add_hands(&mut self, end: usize, height_m: f64) {
        for (hand, forearm) in [("left_hand", end - 2), ("right_hand", end - 1)] {
            let at = Pose {
                position_m: [0.0, 0.0, -HAND_BELOW_FOREARM * height_m],
                orientation: IDENTITY,
            };
            self.parts.push(Part {
                label: format!("{}/{hand}", self.name),
                place: Place::Body(forearm, at),
                shapes: Vec::new(),
                bodies: Vec::new(),
                is_whole: false,
                ..self.parts[0].clone()
            });
        }
    }
}

/// Whether a body can move at all.
fn is_loose(layout: &Layout, mut body: usize) -> bool {
    loop {
        let plan = &layout.bodies[body];
        match (plan.motion, plan.parent) {
            (Motion::Free | Motion::Jointed, _) => return true,
            (Motion::Led, _) | (Motion::Fixed, None) => return false,
            // Bodies come after their parents.
            (Motion::Fixed, Some(parent)) if parent < body => body = parent,
            (Motion::Fixed, Some(_)) => return false,
        }
    }
}

/// Names of whom shapes belong to, and the place of each shape's in them.
fn owners(data: &SceneData, built: &Built) -> (Vec<String>, Vec<usize>) {
    let layout = &built.layout;
    let bodies = layout.bodies.iter().map(|body| body.name.clone());
    let mut owners: Vec<String> = std::iter::once("none".to_owned()).chain(bodies).collect();
    let of_shape = layout.shapes.iter().enumerate().map(|(shape, plan)| {
        if let Some(body) = plan.body {
            return body + 1;
        }
        let objects = data.objects.iter().zip(&built.objects);
        let mut objects = objects.filter(|(_, at)| at.shapes.contains(&shape));
        let name = objects.next().map_or("ground", |(object, _)| &object.name);
        let known = owners.iter().position(|owner| owner == name);
        known.unwrap_or_else(|| {
            owners.push(name.to_owned());
            owners.len() - 1
        })
    });
    let of_shape = of_shape.collect();
    (owners, of_shape)
}
