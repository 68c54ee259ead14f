//! Trials of one piece that are alike where nothing says that they belong together, as questions.
//!
//! What is tested, and its guarantee, stand in `experiment::groups` (rows of tables) and `sessions` (recordings). Here the
//! p-values are multiplied by the number of all these tests of the study (Bonferroni). A question is settled by the piece's
//! own name in `independent`, which says why its trials are independent of each other.
//!
//! # Assumes
//! Where nothing is alike, rows and recordings are exchangeable (`stats::grouping`). Nothing of how the tests depend on
//! each other.

use super::{LIMIT, probability, subject_in_words};
use crate::technique::experiment::groups::{AlikeRows, alike_rows};
use diagnostic::Problem;
use evidence::{AlikeTrials, CopyKind, Evidence, LineageQuestion};
use study::Study;

/// The questions of all pieces, each with the place of its piece.
pub(super) fn questions(
    study: &Study,
    evidence: &[Evidence],
) -> Result<Vec<(usize, LineageQuestion)>, Problem> {
    let (rows, of_tables) = alike_rows(study)?;
    let recorded = evidence.iter().enumerate();
    let recorded: Vec<(usize, &AlikeTrials)> = recorded
        .filter_map(|(place, piece)| Some((place, piece.alike_trials.as_ref()?)))
        .collect();
    let of_recordings: u64 = recorded.iter().map(|(_, found)| found.tests).sum();
    let chance = |p_value: f64| (p_value * (of_tables + of_recordings) as f64).min(1.0);
    let in_tables = rows.iter().filter_map(|found| {
        let place = evidence.iter().position(|it| it.id == found.evidence)?;
        Some((place, of_rows(found, chance(found.p_value))))
    });
    let in_recordings = recorded.iter().map(|(place, found)| {
        let question = of_recorded(&evidence[*place], found, chance(found.p_value));
        (*place, question)
    });
    let all = in_tables.chain(in_recordings);
    Ok(all.filter(|(_, found)| found.chance <= LIMIT).collect())
}

fn of_rows(found: &AlikeRows, chance: f64) -> LineageQuestion {
    let id = &found.evidence;
    LineageQuestion {
        with: id.clone(),
        kind: CopyKind::Trials,
        subjects: vec![found.subject.clone()],
        finding: format!(
            "in {}, {} are alike in {} ({}; by chance with a probability of at most {} by itself)",
            found.path,
            found.groups,
            found.counted,
            subject_in_words(&found.subject),
            probability(found.p_value)
        ),
        places: vec![format!("{}:{}", found.path, found.line)],
        chance,
        blocks: true,
        settled: None,
        remedy: format!(
            "if they belong together, give each group one row with all its trials, so that the intervals allow for it; if \
             not, {}",
            settle(id)
        ),
    }
}

fn of_recorded(piece: &Evidence, found: &AlikeTrials, chance: f64) -> LineageQuestion {
    let id = &piece.id;
    LineageQuestion {
        with: id.clone(),
        kind: CopyKind::Trials,
        subjects: vec![found.subject.clone()],
        finding: format!(
            "{} are alike in {} (by chance with a probability of at most {} by itself)",
            found.groups,
            subject_in_words(&found.subject),
            probability(found.p_value)
        ),
        places: piece
            .assets
            .iter()
            .take(1)
            .map(|it| it.path.clone())
            .collect(),
        chance,
        blocks: true,
        settled: None,
        remedy: format!(
            "if they belong together, count them in a table of the cohort with one row for each group, so that the \
             intervals allow for it; if not, {}",
            settle(id)
        ),
    }
}

/// What of the ledger settles it.
fn settle(id: &str) -> String {
    format!("write `independent = {{ {id} = \"reason\" }}` in {id}'s entry of ledger.toml")
}
