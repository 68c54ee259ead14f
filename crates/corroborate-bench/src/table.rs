//! The benchmark's tables: rates with their intervals, as CSV and as Markdown.

use crate::bench::Line;
use crate::coverage::Kind;
use crate::family::Family;
use crate::fault::Fault;
use crate::repair::{Flaw, Repair};
use crate::score::Score;
use crate::targets::targets;
use crate::trials::Told;
use stats::{Confidence, Sample};
use std::fmt::Write as _;

/// A table: a title, a note, and rows of texts under their headings.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// The name of its file, without ending.
    pub name: &'static str,
    /// What it shows.
    pub title: String,
    /// The headings.
    pub headings: Vec<&'static str>,
    /// The rows.
    pub rows: Vec<Vec<Cell>>,
}

/// One entry.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// Words.
    Text(String),
    /// So many of so many.
    Rate(u64, u64),
    /// A number of no further uncertainty, such as a mean of theoretical powers.
    Number(f64),
}

impl Cell {
    pub(crate) fn of<'a>(
        lines: impl Iterator<Item = &'a Score>,
        holds: impl Fn(&Score) -> bool,
    ) -> Self {
        let (mut count, mut all) = (0, 0);
        for line in lines {
            all += 1;
            count += u64::from(holds(line));
        }
        Cell::Rate(count, all)
    }

    /// As words: a rate in percent with its 95 % interval (Wilson), and of how many.
    #[must_use]
    pub fn words(&self) -> String {
        match self {
            Cell::Text(text) => text.clone(),
            Cell::Number(number) => format!("{:.1} %", 100.0 * number),
            Cell::Rate(_, 0) => "none".into(),
            Cell::Rate(count, all) => {
                let (rate, low, high) = rate(*count, *all);
                format!(
                    "{:.1} % [{:.1}, {:.1}] of {all}",
                    100.0 * rate,
                    100.0 * low,
                    100.0 * high
                )
            }
        }
    }

    fn csv(&self) -> String {
        match self {
            Cell::Text(text) => text.replace(',', ";"),
            Cell::Number(number) => format!("{number:.4}"),
            Cell::Rate(count, all) => format!("{count}/{all}"),
        }
    }
}

pub(crate) fn rate(count: u64, all: u64) -> (f64, f64, f64) {
    let sample = Sample {
        successes: count,
        trials: all,
    };
    let interval = stats::wilson(sample, Confidence::P95);
    (count as f64 / all as f64, interval.low, interval.high)
}

impl Table {
    /// As Markdown.
    #[must_use]
    pub fn markdown(&self) -> String {
        let mut text = format!(
            "{}\n\n| {} |\n|{}\n",
            self.title,
            self.headings.join(" | "),
            "---|".repeat(self.headings.len())
        );
        for row in &self.rows {
            let words: Vec<String> = row.iter().map(Cell::words).collect();
            let _ = writeln!(text, "| {} |", words.join(" | "));
        }
        text
    }

    /// As CSV: rates as `count/all`.
    #[must_use]
    pub fn csv(&self) -> String {
        let headings: Vec<String> = self
            .headings
            .iter()
            .map(|it| it.replace(',', ";"))
            .collect();
        let mut text = format!("{}\n", headings.join(","));
        for row in &self.rows {
            let cells: Vec<String> = row.iter().map(Cell::csv).collect();
            let _ = writeln!(text, "{}", cells.join(","));
        }
        text
    }
}

/// What the benchmark says of its studies, which were made from this seed: all tables in Markdown.
pub fn page(lines: &[Line], seed: u64) -> String {
    let of_tables = tables(lines);
    let of_tables = of_tables
        .iter()
        .map(|table| format!("\n{}", table.markdown()));
    format!(
        "{} studies, seed {seed}.\n{}",
        lines.len(),
        of_tables.collect::<String>()
    )
}

/// All tables of the benchmark.
#[must_use]
pub fn tables(lines: &[Line]) -> Vec<Table> {
    vec![
        targets(lines),
        power(lines),
        power_by_theory(lines),
        false_alarms(lines),
        localisation(lines),
        coverage(lines),
        calibration(lines),
        repairs(lines),
        catalogue(lines),
    ]
}

fn text(words: &str) -> Cell {
    Cell::Text(words.to_owned())
}

fn of_fault(lines: &[Line], fault: Fault) -> impl Iterator<Item = &Score> {
    lines
        .iter()
        .map(|line| &line.score)
        .filter(move |score| score.fault == fault)
}

fn mean(values: impl Iterator<Item = f64>) -> Cell {
    let values: Vec<f64> = values.collect();
    if values.is_empty() {
        return text("none");
    }
    Cell::Number(values.iter().sum::<f64>() / values.len() as f64)
}

const WAYS: [fn(&Score) -> bool; 3] = [|s| s.found, |s| s.by_points, |s| s.by_overlap];

/// The theories of power, by name.
pub(crate) const THEORIES: [fn(&Score) -> f64; 3] = [
    |s| s.theory.known,
    |s| s.theory.learned,
    |s| s.theory.of_all,
];

fn power(lines: &[Line]) -> Table {
    let faults = Fault::ALL.into_iter().filter(|fault| fault.is_conflict());
    let rows = faults.map(|fault| {
        let mut row = vec![text(fault.name())];
        row.extend(THEORIES.map(|theory| mean(of_fault(lines, fault).map(theory))));
        row.extend(WAYS.map(|way| Cell::of(of_fault(lines, fault), way)));
        row.extend(THEORIES.map(|theory| {
            let strong = of_fault(lines, fault).filter(move |score| theory(score) >= 0.95);
            Cell::of(strong, |s| s.found)
        }));
        row
    });
    Table {
        name: "power",
        title: "How often a planted fault is found.".into(),
        headings: vec![
            "fault",
            "power in theory: one test, likeness of attempts known",
            "one test, likeness learned",
            "all comparisons allowed for, likeness learned",
            "found",
            "point estimates within 5 points",
            "overlap of intervals",
            "found where the first theory has 95 % or more",
            "where the second has",
            "where the third has",
        ],
        rows: rows.collect(),
    }
}

/// The ends of the classes of theoretical power.
const CLASSES: [(f64, f64); 6] = [
    (0.0, 0.2),
    (0.2, 0.5),
    (0.5, 0.8),
    (0.8, 0.95),
    (0.95, 0.99),
    (0.99, 1.01),
];

fn power_by_theory(lines: &[Line]) -> Table {
    let theories = [
        "one test, likeness known",
        "one test, likeness learned",
        "all comparisons",
    ];
    let mut rows = Vec::new();
    for (theory, words) in THEORIES.into_iter().zip(theories) {
        for (low, high) in CLASSES {
            let within = || {
                let scores = lines.iter().map(|line| &line.score);
                scores
                    .filter(move |s| s.fault.is_conflict() && low <= theory(s) && theory(s) < high)
            };
            let class = match high > 1.0 {
                true => format!("{} % and more", 100.0 * low),
                false => format!("{} to {} %", 100.0 * low, 100.0 * high),
            };
            let mut row = vec![text(words), Cell::Text(class), mean(within().map(theory))];
            row.extend(WAYS.map(|way| Cell::of(within(), way)));
            rows.push(row);
        }
    }
    Table {
        name: "power_by_theory",
        title: "How near that is to what theory allows, over all faults.".into(),
        headings: vec![
            "theory",
            "power in theory",
            "mean of it",
            "found",
            "point estimates within 5 points",
            "overlap of intervals",
        ],
        rows,
    }
}

fn false_alarms(lines: &[Line]) -> Table {
    let mut rows = Vec::new();
    let mut add = |name: String, wanted: &dyn Fn(&Line) -> bool| {
        let chosen = || {
            lines
                .iter()
                .filter(|line| wanted(line))
                .map(|line| &line.score)
        };
        let mut row = vec![Cell::Text(name)];
        row.extend(WAYS.map(|way| Cell::of(chosen(), way)));
        row.push(Cell::of(chosen(), |s| s.suspects > 0));
        let one = lines.iter().filter(|line| wanted(line));
        let one: Vec<(bool, bool)> = one.filter_map(|line| line.comparison).collect();
        let share = |holds: &dyn Fn(&(bool, bool)) -> bool| {
            let count = one.iter().filter(|it| holds(it)).count();
            Cell::Rate(count as u64, one.len() as u64)
        };
        row.extend([share(&|(_, conflict)| *conflict), share(&|(raw, _)| *raw)]);
        rows.push(row);
    };
    let sound = |line: &Line| line.score.fault == Fault::None;
    add("all".into(), &sound);
    for family in Family::ALL {
        add(format!("family: {}", family.name()), &|line| {
            sound(line) && line.family == family
        });
    }
    add("constants known".into(), &|line| {
        sound(line) && !line.counted_constants
    });
    add("constants counted".into(), &|line| {
        sound(line) && line.counted_constants
    });
    let clustered = |line: &Line| line.score.fault == Fault::ClusteredSubjects;
    for told in Told::ALL {
        add(format!("clustered subjects: {}", told.name()), &|line| {
            clustered(line) && line.told == told
        });
    }
    Table {
        name: "false_alarms",
        title: "How often a study without a fault is said to have a conflict: anywhere, and in one comparison.".into(),
        headings: vec![
            "studies",
            "a conflict",
            "point estimates within 5 points",
            "overlap of intervals",
            "a suspect",
            "one comparison of each study: a conflict",
            "the same by its own p-value",
        ],
        rows,
    }
}

fn localisation(lines: &[Line]) -> Table {
    let first = |s: &Score| s.rank == Some(1);
    let two = |s: &Score| s.rank.is_some_and(|rank| rank <= 2);
    let mut rows = Vec::new();
    let mut add = |name: &str, wanted: &dyn Fn(&Score) -> bool| {
        let chosen = || {
            lines
                .iter()
                .map(|line| &line.score)
                .filter(|s| s.fault.is_conflict() && wanted(s))
        };
        let strong = || chosen().filter(|s| s.theory.known >= 0.95 && s.found);
        rows.push(vec![
            text(name),
            Cell::of(chosen().filter(|s| s.found), first),
            Cell::of(chosen().filter(|s| s.found), two),
            Cell::of(strong(), first),
            Cell::of(strong(), two),
        ]);
    };
    add("all", &|_| true);
    for fault in Fault::ALL.into_iter().filter(|fault| fault.is_conflict()) {
        add(fault.name(), &|s| s.fault == fault);
    }
    Table {
        name: "localisation",
        title: "Where the faulty asset stands among the suspects, if the fault was found.".into(),
        headings: vec![
            "fault",
            "first",
            "first or second",
            "first, where theory has 95 % power or more",
            "first or second, likewise",
        ],
        rows,
    }
}

fn coverage(lines: &[Line]) -> Table {
    let row = |name: &str, wanted: &dyn Fn(Kind) -> bool| {
        let chosen = || {
            lines
                .iter()
                .flat_map(|line| &line.intervals)
                .filter(|(kind, _)| wanted(*kind))
        };
        let covered = chosen().filter(|(_, covered)| *covered).count() as u64;
        vec![text(name), Cell::Rate(covered, chosen().count() as u64)]
    };
    let mut rows = vec![row("all of single pieces", &Kind::is_of_a_piece)];
    rows.extend(Kind::ALL.map(|kind| row(kind.name(), &|other| other == kind)));
    Table {
        name: "coverage",
        title: "How often an interval of 95 % holds the truth.".into(),
        headings: vec!["kind of evidence", "covered"],
        rows,
    }
}

fn calibration(lines: &[Line]) -> Table {
    let calibrated = of_fault(lines, Fault::CalibratedOnSame);
    Table {
        name: "calibration",
        title: "How often agreement with the data of the calibration is called independent.".into(),
        headings: vec!["planted", "called independent"],
        rows: vec![vec![
            text(Fault::CalibratedOnSame.name()),
            Cell::of(calibrated, |s| s.false_independence),
        ]],
    }
}

fn repairs(lines: &[Line]) -> Table {
    const FLAWS: [Flaw; 4] = [
        Flaw::AnotherAsset,
        Flaw::NotMade,
        Flaw::StillDisagrees,
        Flaw::NotTheTruth,
    ];
    let mut rows = Vec::new();
    let mut add = |name: &str, wanted: &dyn Fn(&Line) -> bool| {
        let planted = || {
            let all = lines.iter().filter(|line| line.score.fault.is_conflict());
            all.filter(|line| wanted(line))
        };
        let repairable = || planted().filter(|line| line.repair != Repair::NotRepairable);
        let count = |all: &mut dyn Iterator<Item = &Line>, holds: &dyn Fn(&Line) -> bool| {
            let (mut count, mut of) = (0, 0);
            for line in all {
                of += 1;
                count += u64::from(holds(line));
            }
            Cell::Rate(count, of)
        };
        let repaired = |line: &Line| line.repair == Repair::Repaired;
        let mut row = vec![
            text(name),
            count(&mut planted(), &|line| line.repair != Repair::NotRepairable),
            count(&mut repairable().filter(|line| line.score.found), &repaired),
            count(&mut repairable(), &repaired),
        ];
        let all = repairable().count() as u64;
        let mut part = |wanted: Repair| {
            let count = repairable().filter(|line| line.repair == wanted).count();
            row.push(Cell::Text(if all == 0 {
                "none".into()
            } else {
                count.to_string()
            }));
        };
        part(Repair::NothingOffered);
        for flaw in FLAWS {
            part(Repair::Failed(flaw));
        }
        rows.push(row);
    };
    add("all", &|_| true);
    for fault in Fault::ALL.into_iter().filter(|fault| fault.is_conflict()) {
        add(fault.name(), &|line| line.score.fault == fault);
    }
    Table {
        name: "proposals",
        title: "How often the first proposal repairs the study.".into(),
        headings: vec![
            "fault",
            "repairable",
            "repaired, of the repairable that were found",
            "repaired, of all repairable",
            "nothing offered",
            "another asset changed",
            "could not be made",
            "still disagrees",
            "not the truth",
        ],
        rows,
    }
}

/// Every pair of fault and family: so many studies, or why there are none.
fn catalogue(lines: &[Line]) -> Table {
    let rows = Fault::ALL.map(|fault| {
        let mut row = vec![text(fault.name())];
        row.extend(Family::ALL.map(|family| {
            let own = |line: &&Line| line.family == family && line.score.fault == fault;
            match fault.missing_in(family) {
                Some(reason) => text(reason),
                None => Cell::Text(lines.iter().filter(own).count().to_string()),
            }
        }));
        row
    });
    let mut headings = vec!["fault"];
    headings.extend(Family::ALL.map(Family::name));
    Table {
        name: "catalogue",
        title: "Studies of each fault in each family.".into(),
        headings,
        rows: rows.into(),
    }
}
