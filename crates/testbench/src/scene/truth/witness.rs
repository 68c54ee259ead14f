//! The truth of one episode: what contacts remember, how people move, and the numbers of a row.

use super::contact::{Contact, Step, before};
use super::grasp::{grasp, pressed_newtons};
use super::motion::{Led, View, flag};
use super::names::{Quantity, Signal};
use super::quantity::{OfRegion, Plain};
use super::region::Sides;
use super::things::{Kind, Part, Place, Things};
use super::{Block, Declared};
use crate::geometry::{Pose, norm, subtract};
use crate::physics::{Layout, Physics, Touch, Twist};
use crate::scene::data::SceneData;

/// Looks on in an episode. Empty where nothing is declared, and then it costs nothing.
#[derive(Debug, Clone)]
pub(in crate::scene) struct Witness {
    things: Things,
    signals: Vec<Signal>,
    pub(in crate::scene) blocks: Vec<Block>,
    /// For each signal of a contact its place in `contacts`.
    contact_of: Vec<Option<usize>>,
    contacts: Vec<Contact>,
    /// Bodies that contacts look at.
    watched: Vec<usize>,
    before: Vec<Option<(Pose, Twist)>>,
    led: Vec<Option<Led>>,
    regions: Vec<Sides>,
    body_of: Vec<Option<usize>>,
}

impl Witness {
    pub(in crate::scene) fn new(declared: &Declared, data: &SceneData, layout: &Layout) -> Self {
        let mut contacts = Vec::new();
        let mut pairs: Vec<(&str, &[usize])> = Vec::new();
        let contact_of = declared.signals.iter().map(|signal| {
            let Quantity::Contact(other, _) = &signal.quantity else {
                return None;
            };
            let pair = (signal.topic.as_str(), other.as_slice());
            let known = pairs.iter().position(|known| *known == pair);
            Some(known.unwrap_or_else(|| {
                let shapes = declared.things.shapes;
                pairs.push(pair);
                contacts.push(Contact::new(&signal.part.shapes, other, shapes));
                contacts.len() - 1
            }))
        });
        let contact_of = contact_of.collect();
        let body_of: Vec<Option<usize>> = layout.shapes.iter().map(|it| it.body).collect();
        let mut watched: Vec<usize> = body_of
            .iter()
            .enumerate()
            .filter(|(shape, _)| contacts.iter().any(|it: &Contact| it.looks_at(*shape)))
            .filter_map(|(_, body)| *body)
            .collect();
        watched.sort_unstable();
        watched.dedup();
        Self {
            things: declared.things.clone(),
            signals: declared.signals.clone(),
            blocks: declared.blocks(),
            contact_of,
            contacts,
            watched,
            before: vec![None; layout.bodies.len()],
            led: vec![None; layout.bodies.len()],
            regions: data.regions.iter().map(Sides::new).collect(),
            body_of,
        }
    }

    pub(in crate::scene) fn is_idle(&self) -> bool {
        self.signals.is_empty()
    }

    /// A body was led on, in a time; at first it was placed.
    pub(in crate::scene) fn lead(&mut self, body: usize, pose: &Pose, secs: Option<f64>) {
        if self.is_idle() {
            return;
        }
        self.led[body] = Some(match (self.led[body], secs) {
            (Some(led), Some(secs)) => led.on_to(pose, secs),
            _ => Led {
                pose: *pose,
                twist: Twist::default(),
            },
        });
    }

    fn view<'a>(
        &'a self,
        data: &SceneData,
        layout: &'a Layout,
        physics: &'a dyn Physics,
    ) -> View<'a> {
        View {
            physics,
            layout,
            led: &self.led,
            upright_within_rad: data.truth.upright_within_rad,
        }
    }

    /// Before a step of the physics.
    pub(in crate::scene) fn look(
        &mut self,
        data: &SceneData,
        layout: &Layout,
        physics: &dyn Physics,
    ) {
        if self.contacts.is_empty() {
            return;
        }
        let mut then = std::mem::take(&mut self.before);
        before(&self.view(data, layout, physics), &self.watched, &mut then);
        self.before = then;
    }

    /// After it, with its touches.
    pub(in crate::scene) fn feel(&mut self, data: &SceneData, now_secs: f64, touches: &[Touch]) {
        if self.contacts.is_empty() {
            return;
        }
        let fastest_m_s = self.fastest_m_s();
        let step = Step {
            now_secs,
            step_secs: data.simulation.time_step_secs,
            standing_below_m_s: data.truth.standing_below_m_s,
            same_within_secs: data.truth.same_contact_within_secs,
            touches,
            body_of: &self.body_of,
            before: &self.before,
            thing_of: &self.things.thing_of,
            fastest_m_s: &fastest_m_s,
        };
        for contact in &mut self.contacts {
            contact.step(&step);
        }
    }

    /// How fast the fastest body of each thing moved before the step, as far as contacts look at it; the ground stands.
    fn fastest_m_s(&self) -> Vec<f64> {
        let mut fastest_m_s = vec![0.0_f64; self.things.list.len() + 1];
        for (shape, body) in self.body_of.iter().enumerate() {
            let known = body.and_then(|body| self.before[body]);
            if let Some((_, twist)) = known {
                let fastest = &mut fastest_m_s[self.things.thing_of[shape]];
                *fastest = fastest.max(norm(twist.linear_m_s));
            }
        }
        fastest_m_s
    }

    /// The numbers of all signals, in their order, for the rows that are written now.
    pub(in crate::scene) fn tell(
        &mut self,
        data: &SceneData,
        layout: &Layout,
        physics: &mut dyn Physics,
        touches: &[Touch],
        attached: &[(&str, &str)],
    ) -> Vec<f64> {
        let mut values = Vec::with_capacity(self.signals.len());
        for (signal, contact) in self.signals.iter().zip(&self.contact_of) {
            values.push(match (&signal.quantity, contact) {
                (Quantity::Contact(_, quantity), Some(contact)) => {
                    self.contacts[*contact].value(*quantity, &self.things.owner_of)
                }
                (Quantity::Distance(shapes), _) => {
                    let longest_m = data.simulation.longest_distance_m;
                    least_distance(physics, &signal.part.shapes, shapes, longest_m)
                }
                (Quantity::Plain(Plain::GraspedBy), _) => {
                    let attached = self.attached_to(attached, &signal.part);
                    attached.unwrap_or_else(|| self.holder(data, layout, touches, &signal.part))
                }
                (Quantity::Region(region, quantity), _) => {
                    let view = self.view(data, layout, physics);
                    self.in_region(data, &view, &signal.part, *region, *quantity)
                }
                (quantity, _) => {
                    let view = self.view(data, layout, physics);
                    of_motion(&view, &signal.part, quantity)
                }
            });
        }
        for contact in &mut self.contacts {
            contact.forget_seen();
        }
        values
    }

    /// The robot to which an object is attached, as a place among `nobody` and the holders.
    fn attached_to(&self, attached: &[(&str, &str)], object: &Part) -> Option<f64> {
        let (robot, _) = attached.iter().find(|(_, name)| {
            let thing = self.things.thing(name);
            thing.is_some_and(|thing| thing.whole().shapes == object.shapes)
        })?;
        let things = self.things.list.iter();
        let mut holders = things.filter(|thing| thing.kind != Kind::Object);
        let place = holders.position(|thing| thing.name == *robot)?;
        Some((place + 1) as f64)
    }

    /// Who grasps an object now, as a place among `nobody` and the holders.
    fn holder(&self, data: &SceneData, layout: &Layout, touches: &[Touch], object: &Part) -> f64 {
        let things = self.things.list.iter();
        let holders = things
            .filter(|thing| thing.kind != Kind::Object)
            .enumerate();
        let mut most = (0.0, 0.0);
        for (place, thing) in holders {
            let own = &thing.whole().shapes;
            let fingers = grasp(
                layout,
                touches,
                &|shape| own.contains(&shape),
                &|shape| object.shapes.contains(&shape),
                data.truth.grasp_newtons,
            );
            let pressed = fingers.map_or(0.0, |fingers| pressed_newtons(&fingers));
            if pressed > most.0 {
                most = (pressed, (place + 1) as f64);
            }
        }
        most.1
    }

    fn in_region(
        &self,
        data: &SceneData,
        view: &View<'_>,
        part: &Part,
        region: usize,
        quantity: OfRegion,
    ) -> f64 {
        let (sides, given) = (&self.regions[region], &data.regions[region]);
        let carrier = given.on.as_ref().and_then(|name| self.things.thing(name));
        let frame = match carrier {
            Some(thing) => view.pose(thing.whole().place).then(&given.pose()),
            None => given.pose(),
        };
        let depth_m = || sides.depth_m(&frame, view.pose(part.place).position_m);
        match quantity {
            OfRegion::In => flag(depth_m() >= 0.0),
            OfRegion::DepthIn => depth_m(),
            OfRegion::WhollyIn => flag(part.shapes.iter().all(|shape| {
                let plan = &view.layout.shapes[*shape];
                let at = match plan.body {
                    Some(body) => view.body_pose(body).then(&plan.pose),
                    None => plan.pose,
                };
                sides.holds(&frame, plan, &at)
            })),
        }
    }
}

/// Quantities that follow from where things are and how they move.
fn of_motion(view: &View<'_>, part: &Part, quantity: &Quantity) -> f64 {
    match quantity {
        Quantity::Plain(plain) => view.plain(part, *plain),
        Quantity::Joint(joint, quantity) => view.joint(*joint, *quantity),
        Quantity::OriginDistance(origins) => {
            let own = view.pose(part.place).position_m;
            let far = |place: &Place| norm(subtract(view.pose(*place).position_m, own));
            origins.iter().map(far).fold(f64::INFINITY, f64::min)
        }
        Quantity::Distance(_) | Quantity::Contact(..) | Quantity::Region(..) => f64::NAN,
    }
}

/// The distance between surfaces, at most `longest_m`.
fn least_distance(
    physics: &mut dyn Physics,
    own: &[usize],
    others: &[usize],
    longest_m: f64,
) -> f64 {
    let mut least_m = longest_m;
    for a in own {
        for b in others {
            least_m = least_m.min(physics.distance_m(*a, *b, least_m));
        }
    }
    least_m
}
