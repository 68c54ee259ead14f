//! Families of generated studies: which productions each joins, and in whose words.

use super::machine::{Machine, Time};
use super::production::Builder;
use crate::random::Random;

/// A family of generated studies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// Actions, detours and limited attempts in series.
    Delivery,
    /// Queues and ways of several cells.
    Errands,
    /// Parts in an order that nothing prescribes: a decision process.
    Assembly,
    /// Messages that are lost and sent again.
    Protocol,
    /// Ways on a grid with a drift to the side.
    Navigation,
    /// Work that breaks and is repaired: continuous time.
    Repair,
}

/// The families on which nothing may be tuned: their studies are neither written nor shown unless that is asked for, and
/// their figures stand in a column of their own. The one list of them.
pub const HELD_OUT: [Kind; 3] = [Kind::Protocol, Kind::Navigation, Kind::Repair];

/// How a family's studies speak.
struct Pool {
    start: &'static str,
    acts: [&'static str; 4],
    waits: [&'static str; 3],
    detour: &'static str,
    near: &'static str,
    done: &'static str,
}

impl Kind {
    /// All families.
    pub const ALL: [Kind; 6] = [
        Kind::Delivery,
        Kind::Errands,
        Kind::Assembly,
        Kind::Protocol,
        Kind::Navigation,
        Kind::Repair,
    ];

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Kind::Delivery => "delivery",
            Kind::Errands => "errands",
            Kind::Assembly => "assembly",
            Kind::Protocol => "protocol",
            Kind::Navigation => "navigation",
            Kind::Repair => "repair",
        }
    }

    /// Whether nothing may be tuned on it.
    #[must_use]
    pub fn is_held_out(self) -> bool {
        HELD_OUT.contains(&self)
    }

    /// Draws a system.
    pub fn draw(self, random: &mut Random) -> Machine {
        let time = match self {
            Kind::Repair => Time::Rates,
            Kind::Assembly => Time::Choices,
            _ => Time::Steps,
        };
        let pool = self.pool(random);
        let step_secs = random.one_of(&[0.2, 0.5, 1.0, 2.0]);
        let mut builder = Builder::new(time, pool.start, step_secs, random);
        let last = match self {
            Kind::Delivery => delivery(&mut builder, &pool),
            Kind::Errands => errands(&mut builder, &pool),
            Kind::Assembly => assembly(&mut builder, &pool),
            Kind::Protocol => protocol(&mut builder, &pool),
            Kind::Navigation => navigation(&mut builder, &pool),
            Kind::Repair => repair(&mut builder, &pool),
        };
        let near = builder.location(pool.near);
        builder.pass(last, near, "approach");
        let done = builder.location(pool.done);
        builder.pass(near, done, "leave");
        let mut machine = builder.machine;
        (machine.near, machine.done) = (Some(near), done);
        machine
    }

    fn pool(self, random: &mut Random) -> Pool {
        let pool = |start, acts, waits, detour, near, done| Pool {
            start,
            acts,
            waits,
            detour,
            near,
            done,
        };
        let choices = match self {
            Kind::Delivery => [
                pool(
                    "loading",
                    ["slip", "tip", "jolt", "snag"],
                    ["dock", "lift", "gate"],
                    "blocked",
                    "handing",
                    "delivered",
                ),
                pool(
                    "mixing",
                    ["spill", "bubble", "clog", "chip"],
                    ["aspirate", "seal", "scan"],
                    "refilling",
                    "operator",
                    "dispensed",
                ),
            ],
            Kind::Errands => [
                pool(
                    "waking",
                    ["drop", "stall", "skid", "scrape"],
                    ["ward", "kitchen", "desk"],
                    "charging",
                    "bedside",
                    "finished_round",
                ),
                pool(
                    "parked",
                    ["spoil", "wedge", "tear", "leak"],
                    ["shelf", "belt", "pallet"],
                    "detour",
                    "picker",
                    "stocked",
                ),
            ],
            Kind::Assembly => [
                pool(
                    "tray",
                    ["bolt", "washer", "bracket", "cover"],
                    ["torque", "press", "align"],
                    "regrasp",
                    "colleague",
                    "assembled",
                ),
                pool(
                    "bench",
                    ["shaft", "bearing", "gear", "spring"],
                    ["grease", "snap", "test"],
                    "swap_tool",
                    "worker",
                    "mounted",
                ),
            ],
            Kind::Protocol => [
                pool(
                    "idle",
                    ["corrupt", "overrun", "deadlocked", "mismatch"],
                    ["hello", "grant", "confirm"],
                    "rekeying",
                    "shared_zone",
                    "agreed",
                ),
                pool(
                    "listening",
                    ["garbled", "stale", "refused", "lapsed"],
                    ["request", "offer", "commit"],
                    "handshake",
                    "crew",
                    "transferred",
                ),
            ],
            Kind::Navigation => [
                pool(
                    "hovering",
                    ["gust", "glare", "drain", "icing"],
                    ["descend", "traverse", "align"],
                    "holding",
                    "bystander",
                    "landed",
                ),
                pool(
                    "gate",
                    ["mud", "fog", "wheel", "kerb"],
                    ["lane", "alley", "row"],
                    "yielding",
                    "pedestrian",
                    "arrived",
                ),
            ],
            Kind::Repair => [
                pool(
                    "shift",
                    ["scrap", "fault", "fracture", "burr"],
                    ["mill", "weld", "polish"],
                    "tool_change",
                    "fence",
                    "shipped",
                ),
                pool(
                    "online",
                    ["burnout", "leakage", "seized", "trip"],
                    ["pump", "filter", "valve"],
                    "flushing",
                    "technician",
                    "batch_out",
                ),
            ],
        };
        let [first, second] = choices;
        if random.chance(0.5) { first } else { second }
    }
}

fn delivery(it: &mut Builder<'_>, pool: &Pool) -> usize {
    let mut at = 0;
    for place in 0..2 + it.random.below(2) {
        let next = it.location(&format!("after_{}", pool.acts[place]));
        it.act(at, next, pool.acts[place], 0.02, 0.2);
        at = next;
    }
    at = detour(it, pool, at, 3);
    let next = it.location(&format!("past_{}", pool.waits[0]));
    let most = 2 + it.random.below(2) as i32;
    it.retry(at, next, pool.waits[0], most);
    next
}

/// Something that does not happen in every run, and may fail where it does.
fn detour(it: &mut Builder<'_>, pool: &Pool, at: usize, act: usize) -> usize {
    let after = it.location(&format!("beyond_{}", pool.detour));
    let aside = it.fork(at, after, pool.detour);
    it.act(aside, after, pool.acts[act], 0.05, 0.3);
    it.machine.alarm = Some(aside);
    after
}

fn errands(it: &mut Builder<'_>, pool: &Pool) -> usize {
    let mut at = 0;
    for place in 0..1 + it.random.below(2) {
        let next = it.location(&format!("left_{}", pool.waits[place]));
        let waiting = 2 + it.random.below(3) as i32;
        it.serve(at, next, pool.waits[place], waiting);
        at = next;
    }
    let next = it.location(&format!("carried_{}", pool.acts[0]));
    let cells = 4 + it.random.below(8) as i32;
    it.travel(at, next, pool.acts[0], cells);
    let last = it.location(&format!("after_{}", pool.acts[1]));
    it.act(next, last, pool.acts[1], 0.02, 0.2);
    detour(it, pool, last, 2)
}

fn assembly(it: &mut Builder<'_>, pool: &Pool) -> usize {
    let joined = it.location("joined");
    let parts = 2 + it.random.below(2);
    it.assemble(0, joined, &pool.acts[..parts]);
    let at = detour(it, pool, joined, 3);
    let next = it.location(&format!("past_{}", pool.waits[0]));
    let most = 2 + it.random.below(2) as i32;
    it.retry(at, next, pool.waits[0], most);
    next
}

fn protocol(it: &mut Builder<'_>, pool: &Pool) -> usize {
    let mut at = 0;
    for place in 0..1 + it.random.below(2) {
        let next = it.location(&format!("got_{}", pool.waits[place]));
        let most = 2 + it.random.below(3) as i32;
        it.exchange(at, next, pool.waits[place], most);
        at = next;
    }
    let next = it.location(&format!("after_{}", pool.acts[0]));
    it.act(at, next, pool.acts[0], 0.03, 0.2);
    let at = detour(it, pool, next, 1);
    let next = it.location(&format!("got_{}", pool.waits[2]));
    it.exchange(at, next, pool.waits[2], 3);
    next
}

fn navigation(it: &mut Builder<'_>, pool: &Pool) -> usize {
    let next = it.location(&format!("out_of_{}", pool.waits[0]));
    let (length, half) = (5 + it.random.below(6) as i32, 1 + it.random.below(2) as i32);
    it.lattice(0, next, pool.waits[0], length, half);
    let at = detour(it, pool, next, 0);
    let next = it.location(&format!("across_{}", pool.acts[1]));
    let cells = 4 + it.random.below(10) as i32;
    it.travel(at, next, pool.acts[1], cells);
    let last = it.location(&format!("after_{}", pool.acts[2]));
    it.act(next, last, pool.acts[2], 0.02, 0.2);
    last
}

fn repair(it: &mut Builder<'_>, pool: &Pool) -> usize {
    let mut at = 0;
    for place in 0..1 + it.random.below(2) {
        let next = it.location(&format!("through_{}", pool.waits[place]));
        it.repairable(at, next, pool.waits[place]);
        at = next;
    }
    let next = it.location(&format!("after_{}", pool.acts[0]));
    it.act(at, next, pool.acts[0], 0.03, 0.2);
    detour(it, pool, next, 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_come_to_each_end_as_often_as_computed() {
        for kind in Kind::ALL {
            let mut random = Random::new(7, kind as u64);
            let machine = kind.draw(&mut random);
            let runs: Vec<_> = (0..3000).map(|_| machine.run(&mut random)).collect();
            let ends: Vec<usize> = machine
                .modes
                .iter()
                .map(|mode| mode.failed)
                .chain([machine.done])
                .collect();
            let mut total = 0.0;
            for end in ends {
                let value = machine.reaches(end);
                let counted = runs.iter().filter(|run| run.was_at(end)).count() as f64 / 3000.0;
                let error = (value * (1.0 - value) / 3000.0).sqrt();
                assert!(
                    (value - counted).abs() < 4.5 * error + 1e-9,
                    "{kind:?} {}: {value} {counted}",
                    machine.locations[end]
                );
                total += value;
            }
            assert!((total - 1.0).abs() < 1e-9, "{kind:?}: {total}");
        }
    }
}
