//! Whether held things move in the fingers that hold them.
//!
//! Definition: while a robot grasps a loose object (see [`super::truth::grasp`]) that nothing else touches, the movement is how
//! far the object's origin has come in the frame of the finger that presses hardest, across that finger's normal, since the
//! grip was a quarter of a second old. If the fingers' friction was nearly used up, the object slid, as it would in reality;
//! if not, it crept: contacts of physics engines are soft, and what should stick moves on slowly. Then settings of the solver
//! help, and the account of the run names them.
//!
//! Cost: a look at the touches at each row of the truth.

use super::build::Built;
use super::data::SceneData;
use super::truth::grasp::{Finger, grasp, pressed_newtons};
use crate::bench::Creep;
use crate::geometry::{Pose, Vector, dot, inverse, norm, rotate, scale, subtract};
use crate::physics::{Layout, Physics, Touch};

/// How long a grip takes to settle.
const SETTLE_SECS: f64 = 0.25;
/// The share of friction from which on an object slides.
const USED_UP: f64 = 0.9;

/// Where an object is in a finger's frame.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Base {
    secs: f64,
    finger: usize,
    at_m: Vector,
    into: Vector,
}

/// An object and a robot that may hold it.
#[derive(Debug, Clone, PartialEq)]
struct Pair {
    robot: usize,
    object: usize,
    body: usize,
    since_secs: Option<f64>,
    base: Option<Base>,
    /// Sums of what fingers bore: along the normals, across them, and what friction would have borne.
    borne: [f64; 3],
    worst: Option<Creep>,
}

/// All of them.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Grips(Vec<Pair>);

impl Grips {
    pub(super) fn new(built: &Built) -> Self {
        let loose = built.objects.iter().enumerate().filter_map(|(object, at)| {
            let body = at.body?;
            let is_loose = built.layout.bodies[body].motion == crate::physics::Motion::Free;
            is_loose.then_some((object, body))
        });
        let pairs = loose.flat_map(|(object, body)| {
            (0..built.robots.len()).map(move |robot| Pair {
                robot,
                object,
                body,
                since_secs: None,
                base: None,
                borne: [0.0; 3],
                worst: None,
            })
        });
        Self(pairs.collect())
    }

    /// Looks at the touches of the last step.
    pub(super) fn look(
        &mut self,
        now_secs: f64,
        data: &SceneData,
        built: &Built,
        physics: &dyn Physics,
        touches: &[Touch],
    ) {
        if touches.is_empty() {
            self.0.iter_mut().for_each(Pair::let_go);
            return;
        }
        for pair in &mut self.0 {
            pair.look(now_secs, data, built, physics, touches);
        }
    }

    /// What moved by more than the scene lets pass.
    pub(super) fn crept(&self, data: &SceneData) -> Vec<Creep> {
        let worst = self.0.iter().filter_map(|pair| pair.worst.clone());
        worst
            .filter(|creep| creep.moved_m > data.truth.creep_above_m)
            .collect()
    }
}

impl Pair {
    fn let_go(&mut self) {
        self.since_secs = None;
        self.base = None;
    }

    fn look(
        &mut self,
        now_secs: f64,
        data: &SceneData,
        built: &Built,
        physics: &dyn Physics,
        touches: &[Touch],
    ) {
        let robot = &built.robots[self.robot].added.shapes;
        let object = &built.objects[self.object].shapes;
        let held = grasp(
            &built.layout,
            touches,
            &|shape| robot.contains(&shape),
            &|shape| object.contains(&shape),
            data.truth.grasp_newtons,
        );
        let Some(fingers) = held else {
            return self.let_go();
        };
        let is_other = |shape: &usize| !robot.contains(shape) && !object.contains(shape);
        let rests = touches.iter().any(|touch| {
            touch.normal_newtons > 0.0
                && touch.shapes.iter().any(|shape| object.contains(shape))
                && touch.shapes.iter().any(is_other)
        });
        if rests {
            return self.let_go();
        }
        let since_secs = *self.since_secs.get_or_insert(now_secs);
        let Some(base) = self.base else {
            if now_secs - since_secs >= SETTLE_SECS {
                self.base = self.base_at(now_secs, physics, &fingers);
                self.borne = [0.0; 3];
            }
            return;
        };
        self.bear(&built.layout, &fingers);
        let moved_m = across(self.place_in(physics, base.finger), &base);
        if self.worst.as_ref().is_none_or(|it| moved_m > it.moved_m) {
            self.worst = Some(self.creep(now_secs, moved_m, &base, data, physics));
        }
    }

    fn place_in(&self, physics: &dyn Physics, finger: usize) -> Vector {
        let object = physics.body_pose(self.body);
        object.seen_from(&physics.body_pose(finger)).position_m
    }

    fn base_at(&self, secs: f64, physics: &dyn Physics, fingers: &[Finger]) -> Option<Base> {
        let hardest = fingers
            .iter()
            .max_by(|a, b| a.normal_newtons.total_cmp(&b.normal_newtons))?;
        let frame: Pose = physics.body_pose(hardest.body);
        Some(Base {
            secs,
            finger: hardest.body,
            at_m: self.place_in(physics, hardest.body),
            into: rotate(inverse(frame.orientation), hardest.into),
        })
    }

    fn bear(&mut self, layout: &Layout, fingers: &[Finger]) {
        for finger in fingers {
            let friction = finger.shapes.map(|shape| layout.shapes[shape].friction);
            self.borne[1] += finger.tangential_newtons;
            self.borne[2] += finger.normal_newtons * friction[0].min(friction[1]);
        }
        self.borne[0] += pressed_newtons(fingers);
    }

    fn creep(
        &self,
        now_secs: f64,
        moved_m: f64,
        base: &Base,
        data: &SceneData,
        physics: &dyn Physics,
    ) -> Creep {
        let [normal, tangential, friction] = self.borne;
        let used = tangential / friction.max(1e-12);
        let slid = used >= USED_UP;
        Creep {
            object: data.objects[self.object].name.clone(),
            holder: data.robots[self.robot].name.clone(),
            moved_m,
            over_secs: now_secs - base.secs,
            load_over_grip: tangential / normal.max(1e-12),
            friction_used: used,
            slid,
            remedy: remedy(slid, data, physics.engine().0),
        }
    }
}

/// How far it came across the finger's normal.
fn across(at_m: Vector, base: &Base) -> f64 {
    let way = subtract(at_m, base.at_m);
    norm(subtract(way, scale(dot(way, base.into), base.into)))
}

fn remedy(slid: bool, data: &SceneData, engine: &str) -> String {
    if slid {
        return "raise the limit of the drive that closes the grip, or the friction of its material: the load is more than friction bears".to_owned();
    }
    if engine == "MuJoCo" {
        let solver = data.simulation.mujoco.solver();
        return match solver.no_slip_iterations {
            0 => format!(
                "set simulation.mujoco.no_slip_iterations = 10 (now 0), or raise simulation.mujoco.impratio (now {}): friction is softer than in reality",
                solver.impratio
            ),
            now => format!(
                "make the contact stiffer (contact_time_secs in the materials of both that touch), raise \
                 simulation.mujoco.no_slip_iterations (now {now}), or shorten simulation.time_step_secs"
            ),
        };
    }
    let substeps = data.simulation.rapier.solver().substeps;
    format!(
        "raise simulation.rapier.substeps (now {substeps}), or shorten simulation.time_step_secs: friction is softer than in reality"
    )
}
