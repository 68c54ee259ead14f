//! A machine as a simulator: a program in awk with a file of parameters, and runs as recordings in the same columns.
//!
//! The program draws from the multiplicative congruential generator of S. K. Park and K. W. Miller ("Random number
//! generators: good ones are hard to find", 1988) with multiplier 48271, whose products are exact in double precision,
//! so that any awk gives the same runs. Its first numbers after a small seed are alike, so the seed is mixed and twenty are
//! thrown away.

use super::machine::{Factor, Guard, Machine, Run, Time, Update};
use std::fmt::Write as _;

/// The columns of recordings.
#[derive(Clone, Debug, PartialEq)]
pub struct Columns {
    /// Their headers: time, phase, gap, speed.
    pub headers: [&'static str; 4],
    /// What a second is in the column of time.
    pub time: f64,
    /// What a metre is in the column of the gap.
    pub gap: f64,
    /// What a metre per second is in the column of the speed.
    pub speed: f64,
}

/// How fast the robot is, and how far from a person.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Median of the speed near a person, in m/s; it is log-normal.
    pub median: f64,
    /// Spread of its logarithm.
    pub spread: f64,
}

/// Metres between robot and person when it is near, and when it is not.
pub const GAPS: [f64; 2] = [0.4, 3.0];

/// The speed away from people, in m/s.
pub const CRUISE: f64 = 0.5;

/// The file of parameters: a name and a number in each line.
#[must_use]
pub fn parameters(machine: &Machine, motion: Motion) -> String {
    let mut text = String::from("# name value\n");
    for constant in &machine.constants {
        let _ = writeln!(text, "sim_{} {}", constant.name, constant.value);
    }
    let _ = writeln!(
        text,
        "median_speed {}\nspread_of_speed {}",
        motion.median, motion.spread
    );
    text
}

fn weight(machine: &Machine, factors: &[Factor]) -> String {
    let factor = |it: &Factor| match it {
        Factor::Of(place) => format!("v[\"sim_{}\"]", machine.constants[*place].name),
        Factor::Not(place) => format!("(1-v[\"sim_{}\"])", machine.constants[*place].name),
    };
    let all: Vec<String> = factors.iter().map(factor).collect();
    if all.is_empty() {
        "1".to_owned()
    } else {
        all.join("*")
    }
}

/// The program.
#[must_use]
pub fn program(machine: &Machine, columns: &Columns) -> String {
    let mut text = String::from(
        "# Usage: awk -v seed=NUMBER -v out=FILE -f THIS PARAMETERS\n\
         function u() { x = (48271 * x) % 2147483647; return x / 2147483647 }\n\
         function row() { printf \"%.6f,%s,%.4f,%.6f\\n\", at * per_second, where, (where == close_by ? near_gap : far_gap), \
         (where == close_by ? speed : cruise) > out }\n\
         !/^#/ { v[$1] = $2 }\nEND {\n  x = (seed % 2147483000) * 1009 % 2147483647 + 17; x = x % 2147483646 + 1;\n  \
         for (i = 0; i < 20; i++) u();\n",
    );
    let near = machine
        .near
        .map_or("", |near| machine.locations[near].as_str());
    let _ = writeln!(
        text,
        "  per_second = {}; close_by = \"{near}\"; near_gap = {}; far_gap = {}; cruise = {};\n  \
         speed = {} * v[\"median_speed\"] * exp(v[\"spread_of_speed\"] * sqrt(-2*log(u())) * cos(6.283185307179586*u()));",
        columns.time,
        GAPS[0] * columns.gap,
        GAPS[1] * columns.gap,
        CRUISE * columns.speed,
        columns.speed,
    );
    let _ = writeln!(text, "  at = 0; where = \"{}\";", machine.locations[0]);
    for counter in &machine.counters {
        let _ = writeln!(text, "  n_{} = {};", counter.name, counter.first);
    }
    let _ = writeln!(
        text,
        "  print \"{}\" > out; row();\n  for (steps = 0; steps < 5000; steps++) {{\n    k = 0; total = 0;",
        columns.headers.join(",")
    );
    let mut number = 0;
    let mut effects = String::new();
    for command in &machine.commands {
        let _ = writeln!(
            text,
            "    if (where == \"{}\"{}) {{",
            machine.locations[command.at],
            guards(machine, &command.guards)
        );
        for branch in &command.branches {
            number += 1;
            let _ = writeln!(
                text,
                "      w[++k] = {}; total += w[k]; id[k] = {number};",
                weight(machine, &branch.weight)
            );
            let _ = writeln!(
                effects,
                "    {}if (b == {number}) {{ where = \"{}\";{} }}",
                if number > 1 { "else " } else { "" },
                machine.locations[branch.to],
                updates(machine, &branch.updates)
            );
        }
        text.push_str("    }\n");
    }
    let step = machine.step_secs;
    let passes = match machine.time {
        Time::Rates => format!("at += -{step} * log(u()) / total;"),
        _ => format!("at += {step};"),
    };
    let _ = write!(
        text,
        "    if (k == 0) break;\n    {passes}\n    left = u() * total;\n    \
         for (i = 1; i < k; i++) {{ left -= w[i]; if (left < 0) break }}\n    b = id[i];\n{effects}    row();\n  }}\n}}\n"
    );
    text
}

fn guards(machine: &Machine, guards: &[Guard]) -> String {
    let name = |place: &usize| &machine.counters[*place].name;
    let one = |guard: &Guard| match guard {
        Guard::Below(place, value) => format!(" && n_{} < {value}", name(place)),
        Guard::Is(place, value) => format!(" && n_{} == {value}", name(place)),
        Guard::Above(place, value) => format!(" && n_{} > {value}", name(place)),
    };
    guards.iter().map(one).collect()
}

fn updates(machine: &Machine, updates: &[Update]) -> String {
    let one = |update: &Update| match update {
        Update::Set(place, value) => format!(" n_{} = {value};", machine.counters[*place].name),
        Update::Add(place, value) => format!(" n_{} += {value};", machine.counters[*place].name),
    };
    updates.iter().map(one).collect()
}

/// A run as a recording.
#[must_use]
pub fn recording(machine: &Machine, run: &Run, speed: f64, columns: &Columns) -> String {
    let mut text = columns.headers.join(",");
    text.push('\n');
    for (at, state) in &run.states {
        let place = state[0] as usize;
        let is_near = machine.near == Some(place);
        let gap = GAPS[usize::from(!is_near)] * columns.gap;
        let speed = if is_near { speed } else { CRUISE } * columns.speed;
        let _ = writeln!(
            text,
            "{:.6},{},{gap:.4},{speed:.6}",
            at * columns.time,
            machine.locations[place]
        );
    }
    text
}
