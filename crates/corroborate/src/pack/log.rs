//! The log of a verification: what was done, by which tool, on which files, and what was checked of the results before they were packed.

use super::parts::Gathering;
use crate::results::json;
use crate::verify::Checked;
use ::pack::{Content, Part, Role, Sace};
use diagnostic::Problem;
use evidence::{Asset, Cost, Looks, Technique, Tool};
use schemars::JsonSchema;
use serde::Serialize;

/// The log.
#[derive(Serialize, JsonSchema)]
pub struct Log<'l> {
    /// Version of this form.
    format: &'l str,
    /// The program and version that produced the results.
    produced_by: &'l str,
    /// What was done for each piece of evidence, oldest first.
    evidence: Vec<Done<'l>>,
    /// The counts by which the study was judged, look by look; absent if sample sizes were fixed.
    looks: Option<&'l Looks>,
    /// What held when everything was derived again before packing.
    derived_again: &'l [Checked],
    /// What was not derived again.
    not_derived_again: &'l [String],
}

/// What was done for a piece of evidence.
#[derive(Serialize, JsonSchema)]
struct Done<'l> {
    id: &'l str,
    title: &'l str,
    technique: Technique,
    tool: &'l Tool,
    conditions: &'l str,
    /// What was changed since the evidence before it.
    changed: &'l str,
    /// The files on which it rests, with their BLAKE3.
    assets: &'l [Asset],
    /// The hash of everything that its findings depend on.
    inputs: &'l str,
    /// What it took.
    cost: Option<&'l Cost>,
}

/// The log as a part.
pub(super) fn part(from: &Gathering<'_>) -> Result<[Part; 1], Problem> {
    let result = from.result;
    let evidence = result.evidence.iter().map(|piece| Done {
        id: &piece.id,
        title: &piece.title,
        technique: piece.technique,
        tool: &piece.tool,
        conditions: &piece.conditions,
        changed: &piece.changed,
        assets: &piece.assets,
        inputs: &piece.inputs,
        cost: result.costs.iter().find(|it| it.evidence == piece.id),
    });
    let log = Log {
        format: "1.0",
        produced_by: &result.produced_by,
        evidence: evidence.collect(),
        looks: result.synthesis.looks.as_ref(),
        derived_again: &from.verified.checked,
        not_derived_again: &from.verified.not_checked,
    };
    let what =
        "what was done, by which tool, on which files, and what was derived again before packing";
    let part = Part::new(
        "verification/log.json",
        Role::Log,
        what,
        Content::text(json(&log)?),
    );
    Ok([part.as_sace(Sace::SS)])
}
