//! What the benchmark aims at, each with what was measured, whether that meets it, and how far it is off.
//!
//! A target is *met* where the measured rate is on its side. Where it is not, the distance is given in points, and whether
//! the 95 % interval of the rate reaches the target: then the studies are too few to tell.

use crate::bench::Line;
use crate::coverage::Kind;
use crate::fault::Fault;
use crate::repair::Repair;
use crate::score::Score;
use crate::table::{Cell, THEORIES, Table, rate};
use crate::trials::Told;

/// The side on which a rate should be.
#[derive(Clone, Copy)]
enum Aim {
    AtLeast(f64),
    AtMost(f64),
    /// Within these; above, the intervals are wider than they need be.
    Between(f64, f64),
}

impl Aim {
    fn words(self) -> String {
        match self {
            Aim::AtLeast(least) => format!("at least {:.0} %", 100.0 * least),
            Aim::AtMost(most) => format!("at most {:.0} %", 100.0 * most),
            Aim::Between(low, high) => format!("{:.0} to {:.0} %", 100.0 * low, 100.0 * high),
        }
    }

    /// Whether a rate meets it, in words.
    fn judged(self, count: u64, all: u64) -> String {
        if all == 0 {
            return "not measured".into();
        }
        let (found, low, high) = rate(count, all);
        let off = match self {
            Aim::AtLeast(least) => least - found,
            Aim::AtMost(most) => found - most,
            Aim::Between(least, most) => (least - found).max(found - most),
        };
        let reaches = match self {
            Aim::AtLeast(least) => high >= least,
            Aim::AtMost(most) => low <= most,
            Aim::Between(least, most) => high >= least && low <= most,
        };
        let points = 100.0 * off.abs();
        let above = matches!(self, Aim::Between(_, most) if found > most);
        match (off <= 0.0, above, reaches) {
            (true, _, _) => format!("met, by {points:.1} points"),
            (_, true, true) => format!(
                "{points:.1} points above, which its interval allows: conservative if anything"
            ),
            (_, true, false) => format!("{points:.1} points above: conservative"),
            (_, _, true) => format!("not met by {points:.1} points; its interval reaches it"),
            (_, _, false) => format!("not met by {points:.1} points"),
        }
    }
}

/// All targets.
#[must_use]
pub fn targets(lines: &[Line]) -> Table {
    let mut rows = Rows(Vec::new());
    power(lines, &mut rows);
    false_alarms(lines, &mut rows);
    located(lines, &mut rows);
    covered(lines, &mut rows);
    repaired(lines, &mut rows);
    Table {
        name: "targets",
        title: "What is aimed at, and what is measured.".into(),
        headings: vec!["target", "aim", "measured", "met"],
        rows: rows.0,
    }
}

struct Rows(Vec<Vec<Cell>>);

impl Rows {
    fn add<T>(
        &mut self,
        name: String,
        aim: Aim,
        of: impl Iterator<Item = T>,
        holds: impl Fn(&T) -> bool,
    ) {
        let (mut count, mut all) = (0, 0);
        for one in of {
            all += 1;
            count += u64::from(holds(&one));
        }
        self.0.push(vec![
            Cell::Text(name),
            Cell::Text(aim.words()),
            Cell::Rate(count, all),
            Cell::Text(aim.judged(count, all)),
        ]);
    }
}

fn planted(lines: &[Line]) -> impl Iterator<Item = &Score> {
    let scores = lines.iter().map(|line| &line.score);
    scores.filter(|score| score.fault.is_conflict())
}

fn faults() -> impl Iterator<Item = Fault> {
    Fault::ALL.into_iter().filter(|fault| fault.is_conflict())
}

fn power(lines: &[Line], rows: &mut Rows) {
    let theories = [
        "one test at 5 %, likeness of one person's attempts known",
        "one test at 5 %, likeness learned",
        "all comparisons allowed for, likeness learned",
    ];
    for (theory, words) in THEORIES.into_iter().zip(theories) {
        let name = format!("found where theory has 95 % power ({words})");
        let strong = planted(lines).filter(|score| theory(score) >= 0.95);
        rows.add(name, Aim::AtLeast(0.95), strong, |score| score.found);
        for fault in faults() {
            let strong = planted(lines).filter(|s| s.fault == fault && theory(s) >= 0.95);
            let (mut all, mut missed) = (0, 0);
            for score in strong {
                all += 1;
                missed += u32::from(!score.found);
            }
            // The others meet it, and stand in the table of power.
            if 20 * missed > all {
                let strong = planted(lines).filter(|s| s.fault == fault && theory(s) >= 0.95);
                let name = format!("the same, {}", fault.name());
                rows.add(name, Aim::AtLeast(0.95), strong, |score| score.found);
            }
        }
    }
}

fn false_alarms(lines: &[Line], rows: &mut Rows) {
    let of = |fault: Fault| lines.iter().filter(move |line| line.score.fault == fault);
    let most = Aim::AtMost(0.05);
    let all = of(Fault::None);
    rows.add(
        "false alarms, anywhere in a study".into(),
        most,
        all,
        |line| line.score.found,
    );
    let single = of(Fault::None).filter_map(|line| line.comparison);
    let name = "false alarms, in a comparison".to_owned();
    rows.add(name, most, single, |(_, conflict)| *conflict);
    let single = of(Fault::None).filter_map(|line| line.comparison);
    let name = "false alarms, in a comparison by its own p-value".to_owned();
    rows.add(name, most, single, |(raw, _)| *raw);
    for told in Told::ALL {
        let name = format!("false alarms, attempts alike; {}", told.name());
        let own = of(Fault::ClusteredSubjects).filter(|line| line.told == told);
        rows.add(name, most, own, |line| line.score.found);
    }
    let calibrated = of(Fault::CalibratedOnSame);
    let name = "agreement with the data of a calibration called independent".to_owned();
    rows.add(name, Aim::AtMost(0.0), calibrated, |line| {
        line.score.false_independence
    });
}

fn located(lines: &[Line], rows: &mut Rows) {
    let found = || planted(lines).filter(|score| score.found);
    for (most, aim, words) in [(1, 0.9, "first"), (2, 0.98, "first or second")] {
        let is_near = |score: &&Score| score.rank.is_some_and(|rank| rank <= most);
        let aim = Aim::AtLeast(aim);
        rows.add(
            format!("the faulty asset is the {words} suspect"),
            aim,
            found(),
            is_near,
        );
    }
}

fn covered(lines: &[Line], rows: &mut Rows) {
    let all = || lines.iter().flat_map(|line| &line.intervals);
    let name = "95 % intervals hold the truth: all single pieces";
    let aim = Aim::Between(0.94, 0.96);
    let pieces = all().filter(|(kind, _)| kind.is_of_a_piece());
    rows.add(name.into(), aim, pieces, |(_, covered)| *covered);
    for kind in Kind::ALL {
        let aim = if kind.is_bound() {
            Aim::AtLeast(0.95)
        } else {
            aim
        };
        let own = all().filter(|(other, _)| *other == kind);
        rows.add(
            format!("the same: {}", kind.name()),
            aim,
            own,
            |(_, covered)| *covered,
        );
    }
}

fn repaired(lines: &[Line], rows: &mut Rows) {
    let repairable = || {
        let planted = lines.iter().filter(|line| line.score.fault.is_conflict());
        planted.filter(|line| line.repair != Repair::NotRepairable)
    };
    let holds = |line: &&Line| line.repair == Repair::Repaired;
    let aim = Aim::AtLeast(0.8);
    let found = repairable().filter(|line| line.score.found);
    rows.add(
        "the first proposal repairs, of those found".into(),
        aim,
        found,
        holds,
    );
    rows.add(
        "the first proposal repairs, of all repairable".into(),
        aim,
        repairable(),
        holds,
    );
}
