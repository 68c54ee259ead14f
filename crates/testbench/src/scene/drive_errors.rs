//! What becomes of commands in a drive that errs or fails.
//!
//! Definition: let `u(t)` be what is commanded, by field. A drive acts on `v(t)`, which is made in this order:
//!
//! 1. *delayed* by `D`: `u(t - D)`, and before that what it did when the episode began;
//! 2. *dead band* of half the width `d`: of a position, what it was until the command is more than `d` away
//!    from it; of every other field `sign(u) max(|u| - d, 0)`;
//! 3. *bias* `b` of the episode, the constant of an *offset*, and normal noise: `v = u + b + o + s n`. `n` is
//!    drawn anew at the rate `noise_hz` and kept in between, so that what noise does does not depend on the
//!    length of the time step; of several deviations the root of the sum of squares holds;
//! 4. *stuck*: what it was in the step before.
//!
//! A *weak* drive of strength `s` has the torque (or force) `clamp(s T, -s L, s L)`, where `T` is what its law
//! gives without the limit `L`: `k (v - q) - d q'` of a position, `g (v - q')` of a velocity, `v` of an effort. Its
//! gains and its limit are changed in the engine, which goes on to integrate them as it does those of a sound
//! drive ([`Physics::set_drive_strength`](crate::physics::Physics::set_drive_strength)).
//!
//! All numbers are drawn from the streams of their keys (`actuator.NAME.fault.0.from_secs`), so that setting
//! one changes no other. A drive without errors acts on its commands bit for bit.

use std::collections::{BTreeMap, VecDeque};

use stimulus::Distribution;

use super::data::{Actuator, ActuatorFault, ActuatorFaultKind, key_with_unit};
use super::draws::Draws;
use crate::controller::PortField;
use crate::random::Stream;

/// A fault in an episode.
#[derive(Debug, Clone, PartialEq)]
struct DrawnFault {
    kind: ActuatorFaultKind,
    from_secs: f64,
    until_secs: f64,
    /// The share that is left, or the delay.
    amount: f64,
    by_field: Vec<f64>,
}

/// What a test makes of a drive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ForcedDriveFault {
    /// It goes on with what it was doing.
    Stuck,
    /// It has no strength.
    Limp,
}

/// A drive's errors in an episode.
#[derive(Debug, Clone)]
pub(super) struct DriveErrors {
    /// The name of the stream of its noise.
    stream_name: String,
    bias: Vec<f64>,
    noise: Vec<f64>,
    noise_hz: f64,
    faults: Vec<DrawnFault>,
    /// What the test has made of it.
    pub(super) forced: Option<ForcedDriveFault>,
    stream: Stream,
    /// The draws that hold, and which of the episode's they are.
    drawn: Vec<f64>,
    drawn_number: Option<u64>,
    /// Commands with the times from which they held, the oldest first.
    commands: VecDeque<(f64, Vec<f64>)>,
    /// Whether a field's neutral is where it is, and not 0.
    holds: bool,
    /// What the dead band let through last.
    passed: Vec<f64>,
    acted_on: Vec<f64>,
}

impl DriveErrors {
    /// At the beginning of an episode, when the drive acts on `start`.
    pub(super) fn new(actuator: &Actuator, start: &[f64], holds: bool, draws: Draws) -> Self {
        let drawn =
            |field: &str, d: &Distribution| draws.of(actuator.list, &actuator.name, field, d);
        let fields = actuator.fields();
        let errors = |list: &str, errors: &BTreeMap<String, Distribution>| -> Vec<f64> {
            let error = |field: &PortField| {
                let key = key_with_unit(field);
                let given = errors.get(&key);
                given.map_or(0.0, |d| drawn(&format!("{list}.{key}"), d))
            };
            fields.iter().map(error).collect()
        };
        let fault = |(index, fault): (usize, &ActuatorFault)| {
            let field = |name: &str| format!("fault.{index}.{name}");
            let probability = drawn(&field("probability"), &fault.probability);
            let name = format!("{}.{}.{}", actuator.list, actuator.name, field("occurs"));
            let until_secs = fault.until_secs.as_ref();
            let number = |name: &str, d: &Option<Distribution>| {
                d.as_ref().map_or(0.0, |d| drawn(&field(name), d))
            };
            draws.stream(&name).chance(probability).then(|| DrawnFault {
                kind: fault.kind,
                from_secs: drawn(&field("from_secs"), &fault.from_secs),
                until_secs: until_secs.map_or(f64::INFINITY, |d| drawn(&field("until_secs"), d)),
                amount: match fault.kind {
                    ActuatorFaultKind::Delayed => number("delay_secs", &fault.delay_secs),
                    _ => number("strength", &fault.strength),
                },
                by_field: match fault.kind {
                    ActuatorFaultKind::DeadBand => errors(&field("dead_band"), &fault.dead_band),
                    ActuatorFaultKind::Noisy => errors(&field("noise"), &fault.noise),
                    _ => errors(&field("offset"), &fault.offset),
                },
            })
        };
        let faults = actuator.faults.iter().enumerate();
        Self {
            bias: errors("bias", &actuator.bias),
            noise: errors("noise", &actuator.noise),
            noise_hz: actuator.noise_hz,
            faults: faults.filter_map(fault).collect(),
            forced: None,
            stream: draws.stream(&errors_of(actuator)),
            drawn: vec![0.0; start.len()],
            drawn_number: None,
            commands: VecDeque::from([(f64::NEG_INFINITY, start.to_vec())]),
            holds,
            passed: start.to_vec(),
            acted_on: start.to_vec(),
            stream_name: errors_of(actuator),
        }
    }

    fn on(&self, now_secs: f64) -> impl Iterator<Item = &DrawnFault> {
        let is_on = move |fault: &&DrawnFault| {
            now_secs + 1e-9 >= fault.from_secs && now_secs + 1e-9 < fault.until_secs
        };
        self.faults.iter().filter(is_on)
    }

    /// Whether a fault is on, given by the scene or by the test.
    pub(super) fn is_faulty(&self, now_secs: f64) -> bool {
        self.forced.is_some() || self.on(now_secs).next().is_some()
    }

    /// The share of its strength that the drive has; 1 without a fault.
    pub(super) fn strength(&self, now_secs: f64) -> f64 {
        if self.forced == Some(ForcedDriveFault::Limp) {
            return 0.0;
        }
        let weak = self
            .on(now_secs)
            .filter(|fault| fault.kind == ActuatorFaultKind::Weak);
        weak.fold(1.0, |strength, fault| strength.min(fault.amount))
    }

    /// What the drive acts on in the step that begins now. Called once in each step.
    pub(super) fn act_on(&mut self, commanded: &[f64], now_secs: f64) -> &[f64] {
        let kind_on = |kind| self.on(now_secs).filter(move |fault| fault.kind == kind);
        let delay_secs = kind_on(ActuatorFaultKind::Delayed).map(|fault| fault.amount);
        let delay_secs = delay_secs.fold(0.0, f64::max);
        let bands = kind_on(ActuatorFaultKind::DeadBand).map(|fault| fault.by_field.clone());
        let band = bands.reduce(|a, b| a.iter().zip(&b).map(|(a, b)| a.max(*b)).collect());
        let is_stuck = self.forced == Some(ForcedDriveFault::Stuck)
            || kind_on(ActuatorFaultKind::Stuck).next().is_some();
        let mut values = self.delayed(commanded, now_secs, delay_secs);
        self.narrow(&mut values, band.as_deref());
        self.spoil(&mut values, now_secs);
        if !is_stuck {
            self.acted_on = values;
        }
        &self.acted_on
    }

    /// Keeps the command, and gives the one that held `delay_secs` ago.
    fn delayed(&mut self, commanded: &[f64], now_secs: f64, delay_secs: f64) -> Vec<f64> {
        let delays = self.faults.iter();
        let delays = delays.filter(|fault| fault.kind == ActuatorFaultKind::Delayed);
        let longest_secs = delays.map(|fault| fault.amount).fold(0.0, f64::max);
        if longest_secs == 0.0 {
            return commanded.to_vec();
        }
        if self
            .commands
            .back()
            .is_none_or(|(_, last)| last != commanded)
        {
            self.commands.push_back((now_secs, commanded.to_vec()));
        }
        // One of before the longest delay is still wanted.
        let is_past =
            |(since_secs, _): &(f64, Vec<f64>)| *since_secs <= now_secs - longest_secs + 1e-9;
        while self.commands.get(1).is_some_and(is_past) {
            self.commands.pop_front();
        }
        let mut kept = self.commands.iter().rev();
        let held = kept.find(|(since_secs, _)| *since_secs <= now_secs - delay_secs + 1e-9);
        held.map_or_else(|| commanded.to_vec(), |(_, values)| values.clone())
    }

    fn narrow(&mut self, values: &mut [f64], band: Option<&[f64]>) {
        if let Some(band) = band {
            for ((value, half), passed) in values.iter_mut().zip(band).zip(&self.passed) {
                *value = match self.holds {
                    true if (*value - passed).abs() > *half => *value,
                    true => *passed,
                    false => value.signum() * (value.abs() - half).max(0.0),
                };
            }
        }
        self.passed.copy_from_slice(values);
    }

    fn spoil(&mut self, values: &mut [f64], now_secs: f64) {
        let offsets = |fault: &DrawnFault| fault.kind == ActuatorFaultKind::Offset;
        let noisy = |fault: &DrawnFault| fault.kind == ActuatorFaultKind::Noisy;
        // Each draw is made at its time, whether or not it is wanted, so that faults do not move others.
        let number = ((now_secs + 1e-9) * self.noise_hz).floor() as u64;
        let is_drawn = self.noise.iter().any(|it| *it > 0.0) || self.faults.iter().any(noisy);
        if is_drawn && self.drawn_number != Some(number) {
            self.drawn_number = Some(number);
            for draw in &mut self.drawn {
                *draw = self.stream.standard_normal();
            }
        }
        for (index, value) in values.iter_mut().enumerate() {
            let on = || self.on(now_secs);
            let offset: f64 = on()
                .filter(|it| offsets(it))
                .map(|it| it.by_field[index])
                .sum();
            let more = on()
                .filter(|it| noisy(it))
                .map(|it| it.by_field[index].powi(2));
            let deviation = (self.noise[index].powi(2) + more.sum::<f64>()).sqrt();
            for error in [self.bias[index], offset, deviation * self.drawn[index]] {
                if error != 0.0 {
                    *value += error;
                }
            }
        }
    }

    /// Draws errors from here on anew.
    pub(super) fn draw_anew(&mut self, draws: Draws) {
        self.stream = draws.stream(&self.stream_name);
    }
}

/// The name of the stream of a drive's noise.
fn errors_of(actuator: &Actuator) -> String {
    format!("{}.{}.errors", actuator.list, actuator.name)
}
