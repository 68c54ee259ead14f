//! The figures of generated studies, in two columns: families that may be tuned on, and families that are held out.

use super::catalogue::{Catalogue, Generated};
use super::family::{HELD_OUT, Kind};
use super::judge::Outcome;
use super::plant::Plant;
use crate::table::Cell;
use std::fmt::Write as _;

/// A study with what came of it.
type Judged<'a> = (&'a Generated, &'a Outcome);

fn rate<'a>(
    all: &[Judged<'a>],
    of: impl Fn(&Judged<'a>) -> bool,
    holds: impl Fn(&Judged<'a>) -> bool,
) -> String {
    let chosen: Vec<&Judged<'a>> = all.iter().filter(|it| of(it)).collect();
    let count = chosen.iter().filter(|it| holds(it)).count();
    Cell::Rate(count as u64, chosen.len() as u64).words()
}

fn is_sound(it: &Judged<'_>) -> bool {
    it.0.planted.plant == Plant::Nothing
}

/// One question to a set of studies.
struct Figure {
    name: &'static str,
    aim: &'static str,
    of: fn(&Judged<'_>) -> bool,
    holds: fn(&Judged<'_>) -> bool,
}

const FIGURES: [Figure; 10] = [
    Figure {
        name: "found where the best test has 95 % power",
        aim: "at least 95 %",
        of: |it| !is_sound(it) && it.0.planted.power >= 0.95,
        holds: |it| it.1.found,
    },
    Figure {
        name: "found, of all with a fault",
        aim: "",
        of: |it| !is_sound(it),
        holds: |it| it.1.found,
    },
    Figure {
        name: "first suspect right, of those found",
        aim: "at least 90 %",
        of: |it| !is_sound(it) && it.1.found,
        holds: |it| it.1.is_first_right,
    },
    Figure {
        name: "first proposal repairs, of those found that a text can mend",
        aim: "at least 80 %",
        of: |it| !is_sound(it) && it.1.found && !it.0.planted.mended_in.is_empty(),
        holds: |it| it.1.is_repaired,
    },
    Figure {
        name: "something offered, of the same",
        aim: "",
        of: |it| !is_sound(it) && it.1.found && !it.0.planted.mended_in.is_empty(),
        holds: |it| it.1.offered.is_some(),
    },
    Figure {
        name: "a harmful proposal without a warning",
        aim: "none",
        of: |_| true,
        holds: |it| !it.1.harmful.is_empty(),
    },
    Figure {
        name: "false alarms: a conflict where nothing is wrong",
        aim: "at most 5 %",
        of: is_sound,
        holds: |it| !it.1.conflicts.is_empty(),
    },
    Figure {
        name: "false alarms: a suspect with a score of 2 or more where nothing is wrong",
        aim: "at most 5 %",
        of: is_sound,
        holds: |it| it.1.suspects.iter().any(|suspect| suspect.score >= 2.0),
    },
    Figure {
        name: "refused where nothing is wrong",
        aim: "none",
        of: is_sound,
        holds: |it| it.1.refused.is_some(),
    },
    Figure {
        name: "first suspect right with a score of 1 or more, of those found",
        aim: "",
        of: |it| !is_sound(it) && it.1.found,
        holds: |it| it.1.is_first_strong,
    },
];

/// The page of all figures.
#[must_use]
pub fn page(catalogue: &Catalogue, studies: &[Generated], outcomes: &[Outcome]) -> String {
    let all: Vec<Judged<'_>> = studies.iter().zip(outcomes).collect();
    let (held, tuned): (Vec<Judged<'_>>, Vec<Judged<'_>>) =
        all.iter().partition(|it| it.0.draft.family.is_held_out());
    let names = |held: bool| {
        let of = Kind::ALL
            .into_iter()
            .filter(|kind| kind.is_held_out() == held);
        let names: Vec<&str> = of.map(Kind::name).collect();
        names.join(", ")
    };
    let mut text = format!(
        "{} studies, seed {}, {} of each fault in each family. Tuned on: {}. Held out: {} ({} families).\n\n",
        all.len(),
        catalogue.seed,
        catalogue.each,
        names(false),
        names(true),
        HELD_OUT.len(),
    );
    text.push_str("| figure | aim | families tuned on | held-out families |\n|---|---|---|---|\n");
    for figure in &FIGURES {
        let of = |set: &[Judged<'_>]| rate(set, figure.of, figure.holds);
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} |",
            figure.name,
            figure.aim,
            of(&tuned),
            of(&held)
        );
    }
    by_fault(&tuned, "By fault, families tuned on.", &mut text);
    by_fault(&held, "By fault, held-out families.", &mut text);
    by_family(&all, &mut text);
    text
}

fn by_fault(all: &[Judged<'_>], title: &str, text: &mut String) {
    let _ = write!(
        text,
        "\n{title}\n\n| fault | mean power | found | first suspect right, of those found | first proposal repairs, of those \
         found that a text can mend | harmful without a warning |\n|---|---|---|---|---|---|\n"
    );
    for plant in Plant::ALL
        .into_iter()
        .filter(|plant| *plant != Plant::Nothing)
    {
        let own: Vec<Judged<'_>> = all
            .iter()
            .filter(|it| it.0.planted.plant == plant)
            .copied()
            .collect();
        if own.is_empty() {
            continue;
        }
        let power = own.iter().map(|it| it.0.planted.power).sum::<f64>() / own.len() as f64;
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} | {} | {} |",
            plant.name(),
            Cell::Number(power).words(),
            rate(&own, |_| true, |it| it.1.found),
            rate(&own, |it| it.1.found, |it| it.1.is_first_right),
            rate(&own, FIGURES[3].of, FIGURES[3].holds),
            rate(&own, |_| true, |it| !it.1.harmful.is_empty()),
        );
    }
}

fn by_family(all: &[Judged<'_>], text: &mut String) {
    text.push_str(
        "\nBy family.\n\n| family | held out | found where the best test has 95 % power | first suspect right | first \
         proposal repairs | conflict where nothing is wrong |\n|---|---|---|---|---|---|\n",
    );
    for kind in Kind::ALL {
        let own: Vec<Judged<'_>> = all
            .iter()
            .filter(|it| it.0.draft.family == kind)
            .copied()
            .collect();
        if own.is_empty() {
            continue;
        }
        let of = |figure: &Figure| rate(&own, figure.of, figure.holds);
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} | {} | {} |",
            kind.name(),
            if kind.is_held_out() { "yes" } else { "no" },
            of(&FIGURES[0]),
            of(&FIGURES[2]),
            of(&FIGURES[3]),
            of(&FIGURES[6]),
        );
    }
}
