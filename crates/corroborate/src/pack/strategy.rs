//! The strategy of a verification as a page: what was to be shown of each requirement, by what, and by which rules verdicts are
//! drawn.

use ::pack::{Content, Part, Role, Sace};
use evidence::{Direction, ErrorFamily, StudyResult};
use std::fmt::Write;
use study::{SampleSizes, Study};

/// The page.
pub(super) fn part(study: &Study, result: &StudyResult) -> [Part; 1] {
    let what = "how each requirement was to be verified, and by which rules verdicts are drawn";
    let content = Content::text(page(study, result));
    [Part::new("verification/strategy.md", Role::Strategy, what, content).as_sace(Sace::RR)]
}

fn page(study: &Study, result: &StudyResult) -> String {
    let mut text = format!(
        "# Verification strategy: {}\n\n{}\n\n## Rules\n\n",
        line(&result.title),
        line(&result.summary)
    );
    // Writing to a string cannot fail.
    let _ = rules(study, &mut text);
    let _ = requirements(result, &mut text);
    let _ = techniques(study, result, &mut text);
    text.push_str(
        "\nWhy these techniques and these numbers of trials are sufficient is not said here: whoever argues that it is, adds it.\n",
    );
    text
}

fn rules(study: &Study, text: &mut String) -> std::fmt::Result {
    let about = &study.about;
    writeln!(
        text,
        "* Level of all intervals: {}; level at which agreement counts as shown: {}.",
        about.confidence, about.agreement
    )?;
    let family = match about.verdicts.error_rate {
        ErrorFamily::Study => "all requirements of the study together, for each of the two claims",
        ErrorFamily::Requirement => "each requirement by itself",
    };
    writeln!(text, "* The error rate of a verdict holds for {family}.")?;
    let sizes = match about.sample_sizes {
        SampleSizes::Growing => {
            "Trials may be added after a look; looks are recorded, and tests allow for them"
        }
        SampleSizes::Fixed => "Numbers of trials were fixed before the first one",
    };
    writeln!(
        text,
        "* {sizes}.\n* Seed of everything random: {}.",
        about.seed
    )?;
    for (name, meaning) in &about.conditions {
        writeln!(text, "* Conditions `{}`: {}", line(name), line(meaning))?;
    }
    Ok(())
}

fn requirements(result: &StudyResult, text: &mut String) -> std::fmt::Result {
    text.push_str("\n## What was to be shown\n\n| requirement | text | asks for | needs to hold | margin of agreement |\n|---|---|---|---|---|\n");
    for one in &result.requirements {
        let asks = one.threshold.map_or("always".to_owned(), |it| {
            let side = match it.direction {
                Direction::AtLeast => "at least",
                Direction::AtMost => "at most",
            };
            format!("{side} {}", it.value)
        });
        writeln!(
            text,
            "| {} | {} | {asks} | {} | {} |",
            line(&one.id),
            line(&one.text),
            one.needs.words(),
            one.margin
        )?;
    }
    Ok(())
}

fn techniques(study: &Study, result: &StudyResult, text: &mut String) -> std::fmt::Result {
    text.push_str("\n## By what\n\n| evidence | title | technique | tool | settings | conditions |\n|---|---|---|---|---|---|\n");
    for entry in &study.ledger {
        let Some(piece) = result.evidence.iter().find(|it| it.id == entry.id) else {
            continue;
        };
        writeln!(
            text,
            "| {} | {} | {} | {} {} | {} | {} |",
            line(&piece.id),
            line(&piece.title),
            piece.technique.traits().heading,
            line(&piece.tool.name),
            line(&piece.tool.version),
            line(&piece.tool.settings),
            line(&piece.conditions)
        )?;
    }
    Ok(())
}

/// A text within a line of a table.
pub(super) fn line(text: &str) -> String {
    let kept = text.chars().map(|c| if c.is_control() { ' ' } else { c });
    let kept: String = kept.collect();
    kept.replace('|', "\\|").replace('<', "&lt;")
}
