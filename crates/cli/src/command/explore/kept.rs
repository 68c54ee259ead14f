//! What an exploration left beside a study's results, and whether its scenarios still show what they did.

use super::{EXPLORATION, shown_again};
use corroborate::technique::asset;
use corroborate::technique::exploration::OpenBench;
use diagnostic::Problem;
use evidence::Exploration;
use host::Host;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use study::{Finding, Study};

/// The folder of an exploration beside these results.
fn folder(results: &Path) -> PathBuf {
    results.join("exploration")
}

/// The exploration beside these results, if one was made of these very assets.
pub fn kept_exploration(study: &Study, results: &Path) -> Result<Option<Exploration>, Problem> {
    const REMEDY: &str = "run corroborate explore again, or remove the file";
    let path = folder(results).join(EXPLORATION);
    let Ok(bytes) = std::fs::read(&path) else {
        return Ok(None);
    };
    let found: Exploration = serde_json::from_slice(&bytes).map_err(|error| {
        Problem::new("bad-result", format!("{}: {error}", path.display())).remedy(REMEDY)
    })?;
    for of in &found.assets {
        if asset(&study.folder, of.role, Path::new(&of.path))? != *of {
            let message = format!("{} is of another {}", path.display(), of.path);
            return Err(Problem::new("stale-result", message).remedy(REMEDY));
        }
    }
    Ok(Some(found))
}

/// How many scenarios of an exploration were run again, and the files of those that no longer show what they did.
pub fn findings_again(
    study: &Study,
    found: &Exploration,
    results: &Path,
    setting: &Host,
) -> Result<(u64, Vec<String>), Problem> {
    let folder = folder(results);
    let causes = |finding: &evidence::Discovery| -> Vec<String> {
        let causes = finding.causes.iter().map(|cause| cause.file.clone());
        causes.chain([finding.file.clone()]).collect()
    };
    let shown = found.findings.iter().filter(|finding| finding.replayed);
    let files: Vec<String> = shown.flat_map(causes).collect();
    let (mut benches, mut judges) = (BTreeMap::new(), BTreeMap::new());
    let mut lost = Vec::new();
    for file in &files {
        setting.go_on()?;
        let finding = Finding::read(&folder.join(file))?;
        let key = format!("{:?}", finding.bench);
        if !benches.contains_key(&key) {
            let library = setting.physics_library.as_deref();
            benches.insert(
                key.clone(),
                OpenBench::of_files(study, &finding.bench, library)?,
            );
        }
        let again = match benches.get(&key) {
            Some(bench) => shown_again(study, bench, &finding, &mut judges, &setting.cancel)?,
            None => None,
        };
        if again.is_none() {
            lost.push(file.clone());
        }
    }
    Ok((files.len() as u64, lost))
}
