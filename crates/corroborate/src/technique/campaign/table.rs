//! The table of a campaign's episodes, for pandas, polars, DuckDB and others: one row each.
//!
//! Processor times are left out, so that the same campaign gives the same bytes.

use super::driver::Campaigning;
use super::record::{EpisodeRecord, Journal, Judged};
use super::tally::Monitored;
use crate::technique::rows::column_of_key;
use crate::technique::simulation::problem_at;
use diagnostic::Problem;
use host::files::write_whole_by;
use judging::run_verdict;
use recording::{Cell, ParquetColumn, ParquetError, ParquetType, ParquetWriter};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;
use stimulus::{Setting, Stimulus};

/// Columns of each monitor.
const OF_MONITOR: usize = 5;

/// Writes the table of the first `count` episodes of a journal, whole or not at all.
pub fn write(
    path: &Path,
    plan: &Campaigning<'_>,
    monitors: &[Monitored],
    journal: &Journal,
    count: u64,
) -> Result<(), Problem> {
    write_whole_by(path, |file| {
        let all = Rows {
            plan,
            monitors,
            journal,
            count,
        };
        all.write(path, file)
    })
}

/// The rows of a table.
struct Rows<'a> {
    plan: &'a Campaigning<'a>,
    monitors: &'a [Monitored],
    journal: &'a Journal,
    count: u64,
}

impl Rows<'_> {
    /// Writes them one after the other, however many there are.
    fn write(&self, path: &Path, file: File) -> Result<File, Problem> {
        let plan = self.plan;
        let fail = |error: std::io::Error| Problem::cannot_write(path, &error);
        let unwritten = |error: ParquetError| match error {
            ParquetError::Write(error) => fail(error),
            other => Problem::data_lost("cannot-write", format!("{}: {other}", path.display())),
        };
        let stimulus = plan.rig.stimulus();
        let about = [
            ("study", plan.study.about.title.as_str()),
            ("evidence", plan.id),
        ];
        let drawn = drawn_in(plan, plan.numbers.start)?;
        let drawn: Vec<String> = drawn.into_keys().collect();
        let columns = columns(stimulus, &drawn, self.monitors);
        let file = BufWriter::new(file);
        let mut table = ParquetWriter::new(file, columns, &about).map_err(unwritten)?;
        for number in plan.numbers.start..plan.numbers.start + self.count {
            let record = self.record(number)?;
            let recording = record.recording.as_ref().map(|_| plan.recording(number));
            let name = recording.as_deref().and_then(Path::file_name);
            let name = name.map(|name| name.to_string_lossy().into_owned());
            let values = drawn_in(plan, number)?;
            let values: Vec<Option<f64>> =
                drawn.iter().map(|key| values.get(key).copied()).collect();
            let row = row(&record, name.as_deref(), stimulus, &values);
            table.push(&row).map_err(unwritten)?;
        }
        let file = table.finish().map_err(unwritten)?;
        file.into_inner().map_err(|error| fail(error.into_error()))
    }

    fn record(&self, number: u64) -> Result<EpisodeRecord, Problem> {
        let journal = self.journal;
        journal.read(number)?.ok_or_else(|| {
            Problem::data_lost(
                "cannot-read",
                format!(
                    "{} has no whole line of episode {number}",
                    journal.path().display()
                ),
            )
            .remedy("run the command again; the episode is made again")
        })
    }
}

/// What an episode drew once from its seed, by key; another simulator does not say.
fn drawn_in(plan: &Campaigning<'_>, number: u64) -> Result<BTreeMap<String, f64>, Problem> {
    let seed = plan.seeds.of(number);
    let drawn = plan.rig.drawn(plan.rig.stimulus(), seed);
    let drawn = drawn.map_err(|error| problem_at(seed, &error))?;
    let drawn = drawn.into_iter().flatten();
    Ok(drawn.map(|it| (it.key, it.value)).collect())
}

fn columns(stimulus: &Stimulus, drawn: &[String], monitors: &[Monitored]) -> Vec<ParquetColumn> {
    use ParquetType::{Bool, Double, Text, U64};
    let mut columns = vec![
        ParquetColumn::new("episode", U64).meaning("the episode's number"),
        ParquetColumn::new("seed", U64).meaning("from which everything random is drawn"),
        ParquetColumn::new("test", Text)
            .optional()
            .meaning("the abstract test that is enacted"),
        ParquetColumn::new("end", Text)
            .meaning("complete, decided (ended early, since all was), incomplete, or what failed: controller-failed, controller-hung, simulator-failed, simulator-hung"),
        ParquetColumn::new("simulated_secs", Double)
            .optional()
            .in_unit("s"),
        ParquetColumn::new("recording", Text)
            .optional()
            .meaning("its file, if it is kept"),
    ];
    for (key, setting) in &stimulus.settings {
        let kind = match setting {
            Setting::Bool(_) => Bool,
            Setting::Number(_) => Double,
            Setting::Text(_) => Text,
        };
        columns.push(ParquetColumn {
            kind,
            ..column_of_key("set", key)
        });
    }
    let drawn = drawn.iter().map(|key| column_of_key("drawn", key));
    columns.extend(drawn.map(|column| column.optional().meaning("drawn once in the episode")));
    for monitor in monitors {
        columns.extend(columns_of(monitor));
    }
    columns
}

fn columns_of(monitor: &Monitored) -> [ParquetColumn; OF_MONITOR] {
    use ParquetType::{Double, Text, U64};
    let id = match &monitor.reading {
        Some(reading) => format!("{}.{reading}", monitor.subject.id()),
        None => monitor.subject.id().to_owned(),
    };
    let name = |what: &str| format!("{id}.{what}");
    [
        ParquetColumn::new(name("verdict"), Text)
            .meaning("satisfied, violated, inconclusive or not-covered"),
        ParquetColumn::new(name("triggered"), U64).meaning("how often the precondition was met"),
        ParquetColumn::new(name("robustness_low"), Double)
            .optional()
            .meaning("the least by which it holds; below 0 it is violated"),
        ParquetColumn::new(name("robustness_high"), Double)
            .optional()
            .meaning("the greatest by which it holds"),
        ParquetColumn::new(name("decided_at_secs"), Double)
            .optional()
            .in_unit("s")
            .meaning("when the verdict was determined, if before the end"),
    ]
}

fn row<'a>(
    record: &'a EpisodeRecord,
    recording: Option<&'a str>,
    stimulus: &'a Stimulus,
    drawn: &[Option<f64>],
) -> Vec<Cell<'a>> {
    let text = |text: Option<&'a str>| text.map_or(Cell::Missing, Cell::Text);
    let double = |value: Option<f64>| value.map_or(Cell::Missing, Cell::Double);
    let mut row = vec![
        Cell::U64(record.number),
        Cell::U64(record.seed),
        Cell::Text(&stimulus.test.name),
        Cell::Text(&record.end),
        double(record.simulated_secs),
        text(recording),
    ];
    for setting in stimulus.settings.values() {
        row.push(match setting {
            Setting::Bool(value) => Cell::Bool(*value),
            Setting::Number(value) => Cell::Double(*value),
            Setting::Text(value) => Cell::Text(value),
        });
    }
    row.extend(drawn.iter().map(|value| double(*value)));
    let cells = |judged: &'a Judged| -> [Cell<'a>; OF_MONITOR] {
        [
            Cell::Text(run_verdict(judged.verdict).name()),
            Cell::U64(judged.triggered),
            double(judged.robustness.as_ref().map(|bounds| bounds.low)),
            double(judged.robustness.as_ref().map(|bounds| bounds.high)),
            double(judged.decided_at_secs),
        ]
    };
    row.extend(record.judged.iter().flat_map(cells));
    row
}
