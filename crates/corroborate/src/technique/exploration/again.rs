//! Whether the scenarios of an exploration's findings still show what they did, and of which files it was made.

use super::{OpenBench, Plan, ShowsJudge};
use crate::kept::exploration_folder;
use crate::technique::{asset, assets};
use diagnostic::Problem;
use evidence::{Asset, AssetRole, Discovery, Exploration};
use host::store::{Inputs, hash_of};
use host::{BuildId, Cancel, Host};
use std::collections::BTreeMap;
use std::path::Path;
use study::{Finding, Shows, Study};
use testbench::Unwatched;

/// The files that bench, model and plan rest on, each once.
pub fn assets_of(study: &Study, plan: &Plan, disagreement: bool) -> Result<Vec<Asset>, Problem> {
    let mut found = vec![asset(
        &study.folder,
        AssetRole::Data,
        Path::new(&plan.file),
    )?];
    let searched = plan.data.disagreement.as_ref().filter(|_| disagreement);
    let model = searched.and_then(|it| it.model.as_deref());
    let model = model.or(plan.data.model.as_deref());
    for entry in [Some(plan.evidence(disagreement)), model]
        .into_iter()
        .flatten()
    {
        found.extend(assets(study, study.entry(entry)?)?);
    }
    found.sort_by(|a, b| a.path.cmp(&b.path));
    found.dedup();
    Ok(found)
}

/// What decides what any episode shows, beside its seed and its stimulus.
pub fn inputs_of_all(study: &Study, plan: &Plan, bench: &OpenBench, build: &BuildId) -> Inputs {
    let mut inputs = Inputs::default();
    inputs.add("program", build.as_str().as_bytes());
    inputs.add("plan", plan.source.text.as_bytes());
    inputs.add_json("files", &bench.files);
    bench.inputs(&mut inputs);
    judging::inputs_of(study, &mut inputs);
    for (name, proposition) in &study.vocabulary.propositions {
        if let Some(graded) = &proposition.graded {
            inputs.add(name, graded.text.as_bytes());
        }
    }
    inputs
}

/// The hash of the recording of a finding's episode if it shows it again.
pub fn shown_again<'s>(
    study: &'s Study,
    bench: &OpenBench,
    finding: &Finding,
    judges: &mut BTreeMap<Shows, ShowsJudge<'s>>,
    interrupt: &Cancel,
) -> Result<Option<String>, Problem> {
    let run = bench.again(&finding.stimulus, finding.seed, &mut Unwatched, interrupt);
    let Ok(recorded) = run else {
        return Ok(None);
    };
    if !judges.contains_key(&finding.shows) {
        let judge = ShowsJudge::new(study, &finding.shows, interrupt)?;
        judges.insert(finding.shows.clone(), judge);
    }
    let shows = match judges.get(&finding.shows) {
        Some(judge) => judge.shows(&recorded)?,
        None => false,
    };
    if !shows {
        return Ok(None);
    }
    let bytes = recording::to_mcap(&recorded.trace)
        .map_err(|error| Problem::new("cannot-write", error.to_string()))?;
    Ok(Some(hash_of(&bytes)))
}

/// How many scenarios of an exploration were run again, and the files of those that no longer show what they did.
pub fn findings_again(
    study: &Study,
    found: &Exploration,
    results: &Path,
    host: &Host,
) -> Result<(u64, Vec<String>), Problem> {
    let folder = exploration_folder(results);
    let shown = found.findings.iter().filter(|finding| finding.replayed);
    let files: Vec<String> = shown.flat_map(scenarios).collect();
    let (mut benches, mut judges) = (BTreeMap::new(), BTreeMap::new());
    let mut lost = Vec::new();
    for file in &files {
        host.go_on()?;
        let finding = Finding::read(&folder.join(file))?;
        let key = format!("{:?}", finding.bench);
        if !benches.contains_key(&key) {
            benches.insert(
                key.clone(),
                OpenBench::of_files(study, &finding.bench, host)?,
            );
        }
        let again = match benches.get(&key) {
            Some(bench) => shown_again(study, bench, &finding, &mut judges, &host.cancel)?,
            None => None,
        };
        if again.is_none() {
            lost.push(file.clone());
        }
    }
    Ok((files.len() as u64, lost))
}

/// The files that show a finding: those of its causes, and its own.
fn scenarios(finding: &Discovery) -> Vec<String> {
    let causes = finding.causes.iter().map(|cause| cause.file.clone());
    causes.chain([finding.file.clone()]).collect()
}
