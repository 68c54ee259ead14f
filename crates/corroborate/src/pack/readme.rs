//! The first page of a pack: what is in it, by which letters of SACE, and what it does not show.

use super::parts::Gathering;
use super::strategy::line;
use ::pack::{About, Content, Part, Role, Sace};
use std::collections::BTreeMap;
use std::fmt::Write;

/// The page about these parts.
pub(super) fn part(from: &Gathering<'_>, about: &About, parts: &[Part]) -> Part {
    let content = Content::text(page(from, about, parts));
    Part::new(
        "README.md",
        Role::Guide,
        "what is in this pack, and what it does not show",
        content,
    )
}

fn page(from: &Gathering<'_>, about: &About, parts: &[Part]) -> String {
    let mut text = format!("# Evidence pack: {}\n\n", line(&about.study));
    text.push_str(match from.is_signed {
        true => "Signed: `VERIFY.md` says how to check the signature and every part, with and without the tool that made it.\n",
        false => "**Not signed**: nothing shows who made this pack. `VERIFY.md` says how to check that it is undamaged.\n",
    });
    // Writing to a string cannot fail.
    let _ = verdicts(from, &mut text);
    let _ = contents(parts, &mut text);
    let _ = sace(parts, &mut text);
    let _ = recordings(about, &mut text);
    let _ = not_shown(about, &mut text);
    text
}

fn verdicts(from: &Gathering<'_>, text: &mut String) -> std::fmt::Result {
    text.push_str("\n## Verdicts\n\n| requirement | verdict | |\n|---|---|---|\n");
    for one in &from.result.conclusions {
        let step = one.step.map_or("", |it| it.words());
        writeln!(
            text,
            "| {} | {} {step} | {} |",
            line(&one.requirement),
            one.verdict.words(),
            line(&one.statement)
        )?;
    }
    Ok(())
}

/// Many files of one kind are named together.
fn contents(parts: &[Part], text: &mut String) -> std::fmt::Result {
    let mut groups: BTreeMap<(Role, &str), Vec<&str>> = BTreeMap::new();
    for part in parts {
        groups
            .entry((part.role, &part.what))
            .or_default()
            .push(&part.name);
    }
    text.push_str("\n## What is in it\n\n| | file | |\n|---|---|---|\n");
    for ((role, what), mut names) in groups {
        names.sort_unstable();
        let named = match names.as_slice() {
            [one] => format!("`{one}`"),
            [first, .., last] => format!("`{first}` to `{last}` ({} files)", names.len()),
            [] => continue,
        };
        writeln!(text, "| {} | {named} | {} |", role.words(), line(what))?;
    }
    text.push_str("| Pages about the pack | `manifest.json`, `SHA256SUMS`, `VERIFY.md` | every part with its SHA-256, and how to check them |\n");
    Ok(())
}

fn sace(parts: &[Part], text: &mut String) -> std::fmt::Result {
    text.push_str(
        "\n## By the letters of SACE\n\nThe artefacts of the stage \"AS verification assurance\" of SACE (Safety Assurance of autonomous systems \
         in Complex\nEnvironments, University of York) to which parts correspond. The stage's input [UU], the argument pattern, is SACE's own.\n\n\
         | artefact | parts |\n|---|---|\n",
    );
    for artefact in Sace::ALL {
        let mut names: Vec<&str> = Vec::new();
        for part in parts.iter().filter(|it| it.sace == Some(artefact)) {
            // Folders of many files by their names.
            let shown = match part.name.match_indices('/').nth(1) {
                Some((at, _)) => &part.name[..=at],
                None => &part.name,
            };
            if !names.contains(&shown) {
                names.push(shown);
            }
        }
        let names: Vec<String> = names.iter().map(|it| format!("`{it}`")).collect();
        writeln!(text, "| {} | {} |", artefact.words(), names.join(", "))?;
    }
    Ok(())
}

fn recordings(about: &About, text: &mut String) -> std::fmt::Result {
    if about.recordings.is_empty() {
        return Ok(());
    }
    text.push_str("\n## Recordings\n\n| path in the study | bytes | SHA-256 | in the pack |\n|---|---|---|---|\n");
    for one in about.recordings.iter().take(MOST_RECORDINGS) {
        let part = one
            .part
            .as_deref()
            .map_or("no".to_owned(), |it| format!("`{it}`"));
        writeln!(
            text,
            "| {} | {} | `{}` | {part} |",
            line(&one.path),
            one.bytes,
            one.sha256
        )?;
    }
    if about.recordings.len() > MOST_RECORDINGS {
        writeln!(text, "\nThe manifest names all {}.", about.recordings.len())?;
    }
    Ok(())
}

/// How many recordings the page lists.
const MOST_RECORDINGS: usize = 200;

fn not_shown(about: &About, text: &mut String) -> std::fmt::Result {
    text.push_str("\n## What this pack does not show\n\n");
    for one in &about.not_shown {
        writeln!(text, "* **{}**: {}", line(&one.of), line(&one.words))?;
    }
    Ok(())
}
