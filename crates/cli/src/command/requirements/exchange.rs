//! `corroborate requirements import` and `export`: what was carried over, as text for people.

use super::super::{Done, Host, json};
use crate::args::{Exchange, Exchanged, Format, TakeChoice};
use corroborate::requirements::exchange::{
    Columns, ComparisonShown, Edited, SentenceShown, Take, Verdict,
};
use corroborate::{
    Ended, ExchangeReport, ExchangeRequest, export_requirements, import_requirements,
};
use diagnostic::{Problem, counted, shortened};
use std::fmt::Write;

/// Carries requirements over.
pub fn exchange(asked: &Exchange, setting: &Host) -> Result<Done, Problem> {
    let (arguments, report) = match asked {
        Exchange::Import(arguments) => (
            arguments,
            import_requirements(&request(arguments), setting)?,
        ),
        Exchange::Export(arguments) => (
            arguments,
            export_requirements(&request(arguments), setting)?,
        ),
    };
    Ok(Done {
        outcome: report.outcome(),
        output: match arguments.format {
            Format::Json => json(&report)?,
            Format::Text => text(&report),
        },
    })
}

fn request(arguments: &Exchanged) -> ExchangeRequest {
    let mut columns = Columns::default();
    for (field, name) in &arguments.field {
        match field {
            None => columns.id = Some(name.clone()),
            Some(field) => columns.fields.push((*field, name.clone())),
        }
    }
    ExchangeRequest {
        study: arguments.study.clone(),
        file: arguments.file.clone(),
        columns,
        take: arguments.take.map(|it| match it {
            TakeChoice::Study => Take::Study,
            TakeChoice::File => Take::File,
        }),
        only: arguments.only.clone(),
        sentences: arguments.sentences,
        dry_run: arguments.dry_run,
    }
}

/// The text, in which nothing that a file says is a control character of a terminal.
fn text(report: &ExchangeReport) -> String {
    let plain = |letter: char| match letter.is_control() && letter != '\n' {
        true => '\u{fffd}',
        false => letter,
    };
    lines(report).chars().map(plain).collect()
}

fn lines(report: &ExchangeReport) -> String {
    let mut out = String::new();
    let is_import = report.direction == "import";
    let (target, other) = match is_import {
        true => ("the study", report.file.as_str()),
        false => (report.file.as_str(), "the study"),
    };
    // Writing to a String cannot fail.
    let _ = writeln!(
        out,
        "{} ({}): {} the same",
        report.file,
        report.file_format,
        counted(report.same, "requirement")
    );
    list(&mut out, &format!("Added to {target}"), &report.added);
    edits(
        &mut out,
        &format!("Carried over to {target}"),
        &report.changed,
        is_import,
    );
    let remedy = if is_import { "export" } else { "import" };
    edits(
        &mut out,
        &format!("Edited in {target}, carried over to {other} by `requirements {remedy}`"),
        &report.waiting,
        !is_import,
    );
    conflicts(&mut out, report);
    list(
        &mut out,
        &format!("Removed from {}, still in the study", report.file),
        &report.removed_from_file,
    );
    list(
        &mut out,
        &format!("Removed from the study, still in {}", report.file),
        &report.removed_from_study,
    );
    list(
        &mut out,
        &format!("Only in {target}"),
        &report.only_in_target,
    );
    list(
        &mut out,
        "Kept in another file, so not added (name them with --only)",
        &report.kept_elsewhere,
    );
    sentences(&mut out, report);
    for note in &report.notes {
        let _ = writeln!(out, "note: {note}");
    }
    let verb = if report.dry_run {
        "Would write"
    } else {
        "Written"
    };
    match report.written.is_empty() {
        true => out.push_str("Nothing to write.\n"),
        false => _ = writeln!(out, "{verb}: {}", report.written.join(", ")),
    }
    out
}

fn list(out: &mut String, title: &str, ids: &[String]) {
    const SHOWN: usize = 20;
    if ids.is_empty() {
        return;
    }
    let shown: Vec<&str> = ids.iter().take(SHOWN).map(String::as_str).collect();
    let more = match ids.len() > SHOWN {
        true => format!(" and {} more", ids.len() - SHOWN),
        false => String::new(),
    };
    let _ = writeln!(out, "{title}: {}{more}", shown.join(", "));
}

/// A value in one line.
fn in_line(value: &str) -> String {
    match value.is_empty() {
        true => "(empty)".to_owned(),
        false => shortened(value).replace('\n', " / "),
    }
}

fn edits(out: &mut String, title: &str, all: &[Edited], to_study: bool) {
    if all.is_empty() {
        return;
    }
    let _ = writeln!(out, "{title}:");
    for edited in all {
        let (before, after) = match to_study {
            true => (&edited.in_study, &edited.in_file),
            false => (&edited.in_file, &edited.in_study),
        };
        let _ = writeln!(
            out,
            "  {}, {}: {}",
            edited.id,
            edited.field,
            in_line(before)
        );
        let _ = writeln!(out, "    now: {}", in_line(after));
    }
}

fn conflicts(out: &mut String, report: &ExchangeReport) {
    if report.conflicts.is_empty() {
        return;
    }
    out.push_str("Conflicts (edited on both sides, left alone):\n");
    for edited in &report.conflicts {
        let _ = writeln!(out, "  {}, {}", edited.id, edited.field);
        let _ = writeln!(out, "    study: {}", in_line(&edited.in_study));
        let _ = writeln!(out, "    file:  {}", in_line(&edited.in_file));
    }
    out.push_str(
        "  Edit one side until both are equal, or run it again with --take study or --take file.\n",
    );
}

fn sentences(out: &mut String, report: &ExchangeReport) {
    let all = &report.sentences;
    if all.is_empty() {
        return;
    }
    let translated = all.iter().filter(|it| it.sentence.is_some()).count();
    let of = |verdict: Verdict, get: fn(&SentenceShown) -> Option<&ComparisonShown>| {
        all.iter()
            .filter_map(get)
            .filter(|it| it.verdict == verdict)
            .count()
    };
    let _ = writeln!(
        out,
        "FRET's sentences: {translated} of {} translated; meaning the same as FRET's formulas: {}, another: {}, not compared: {}",
        all.len(),
        of(Verdict::Same, |it| it.runs.as_ref()),
        of(Verdict::Differs, |it| it.runs.as_ref()),
        of(Verdict::NotCompared, |it| it.runs.as_ref())
    );
    let at_end = of(Verdict::Excuses, |it| it.ends.as_ref());
    if at_end > 0 {
        let _ = writeln!(
            out,
            "  On recordings that end before a time is over, FRET excuses what could still have come in {at_end} of them; here \
             `ending` decides (`corroborate explain formula`)."
        );
    }
    for sentence in all {
        one(out, sentence);
    }
}

fn one(out: &mut String, shown: &SentenceShown) {
    let id = &shown.id;
    if let Some(reason) = &shown.not_translated {
        let _ = writeln!(out, "  {id}: kept as text: {reason}");
    }
    let drift = |what: &str, comparison: &Option<ComparisonShown>| {
        let found = comparison
            .as_ref()
            .filter(|it| it.verdict == Verdict::Differs);
        found.map(|it| {
            format!(
                "  {id}: {what}:\n    {}\n",
                it.reason.as_deref().unwrap_or_default()
            )
        })
    };
    let own = shown.own.as_deref().unwrap_or_default();
    let translated = shown.sentence.as_deref().unwrap_or_default();
    let all = [
        drift(
            &format!(
                "drift: the study's sentence `{own}` means something else than FRET's formula"
            ),
            &shown.own_runs,
        ),
        drift(
            &format!("`{translated}` means something else than FRET's formula"),
            &shown.runs,
        ),
        drift(
            &format!(
                "on recordings that end, `{translated}` means something else than FRET's formula"
            ),
            &shown.ends,
        ),
        drift(
            "FRET's text, read as a sentence of ours as it is, means something else than FRET's formula",
            &shown.verbatim,
        ),
    ];
    all.into_iter()
        .flatten()
        .for_each(|line| out.push_str(&line));
    for not_compared in [&shown.runs, &shown.own_runs].into_iter().flatten() {
        if let (Verdict::NotCompared, Some(reason)) = (not_compared.verdict, &not_compared.reason) {
            let _ = writeln!(out, "  {id}: not compared: {reason}");
        }
    }
    let remarks = shown.notes.iter().chain(&shown.probability);
    remarks.for_each(|remark| _ = writeln!(out, "  {id}: {remark}"));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_committed_schema_is_the_form_that_is_printed() {
        let schema: serde_json::Value = schemars::schema_for!(ExchangeReport).into();
        crate::command::tests::assert_schema_is_committed("exchange.schema.json", &schema);
    }
}
