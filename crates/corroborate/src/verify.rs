//! Verifying results: whether every figure of a result follows from its evidence, and every hash
//! holds.
//!
//! # Definition
//! From the kept evidence (`evidence/*.json`) and the study's own files the whole result is formed
//! again: comparisons, conclusions, suspects, gaps, figures beside the publication's. The result
//! must be `study.json`, value by value and byte by byte, and the report drawn from it `report.html`.
//! The evidence itself is held against what it was counted from: tables are read again, journals of
//! episodes counted again, intervals formed again from their counts, and every value has to lie in its own interval. Assets and recordings must have
//! the hashes that are stated.
//!
//! # Guarantee
//! A figure that was changed anywhere between the evidence and the page is found, whatever else was
//! changed to fit. So is a count of tables or of journals. With `--deep` formal models are solved and
//! recordings judged again, too, and the diagnosis is made again: the same paths are sampled, the same
//! episodes judged, the same suspects ranked. The map of where model and simulation part is searched
//! again, by the outcomes in the journal of its episodes, and with `--deep` by running these. Kept recordings of a campaign are judged again then, and a
//! sample of its episodes is run again (`technique/campaign/again.rs`). Findings of an exploration are those that
//! it kept, and with `--deep` their scenarios are run again; a fit is the one that was kept. What is not derived again is listed as such. Nothing is written.

mod audit;
mod compare;
mod counts;
mod diagnosis;
mod found;
mod kept;
mod map;
mod sound;

pub use audit::{Audit, Checked, Fault, VerifyReport};
pub(crate) use compare::values_at as same_values;
pub(crate) use counts::check_intervals;

use crate::assure::{self, Drawing};
use crate::corroboration::{self, Piece};
use crate::results::{ASSURANCE, REPORT, RESULT, json, read_result};
use crate::run::COMPARISON;
use crate::technique::Techniques;
use crate::technique::campaign::Sampled;
use diagnostic::Problem;
use evidence::StudyResult;
use host::Host;
use host::store::Stored;
use std::path::{Path, PathBuf};
use study::Study;

/// Results to be verified. [`VerifyRequest::new`] has the defaults.
#[derive(Clone, Debug)]
pub struct VerifyRequest {
    /// The folder of results.
    pub results: PathBuf,
    /// The study's folder; by default the one in which the results lie.
    pub study: Option<PathBuf>,
    /// Also solves formal models, judges recordings, makes the diagnosis and runs a map's episodes again.
    pub deep: bool,
    /// How many episodes of each simulation are then run again.
    pub episodes: u64,
    /// The number from which these are drawn: one that whoever made the results did not know.
    pub draw: u64,
    /// Techniques that are not built in; by default none.
    pub techniques: Techniques,
}

impl VerifyRequest {
    /// Results in the folder of their study; nothing is solved, judged or run again.
    pub fn new(results: impl Into<PathBuf>) -> Self {
        Self {
            results: results.into(),
            study: None,
            deep: false,
            episodes: EPISODES_AGAIN,
            draw: 0,
            techniques: Techniques::default(),
        }
    }

    /// Results of the study in another folder.
    #[must_use]
    pub fn study(mut self, folder: impl Into<PathBuf>) -> Self {
        self.study = Some(folder.into());
        self
    }

    /// With techniques that are not built in.
    #[must_use]
    pub fn techniques(mut self, techniques: Techniques) -> Self {
        self.techniques = techniques;
        self
    }

    /// Also derives again what takes as long as at first.
    #[must_use]
    pub fn deep(mut self) -> Self {
        self.deep = true;
        self
    }

    /// With so many episodes of each simulation run again, drawn from this number.
    #[must_use]
    pub fn sampled(mut self, episodes: u64, draw: u64) -> Self {
        (self.episodes, self.draw) = (episodes, draw);
        self
    }
}

/// Episodes of each simulation that are run again by a deep verification, unless another number is asked for.
pub const EPISODES_AGAIN: u64 = 8;

/// What [`plan`](crate::plan()) knows, and a verification does not.
pub(crate) const INPUTS: &str =
    "hashes of all inputs of evidence (`run` forms them, and finds what is stale)";

/// Verifies the results of a study; without a `drawing` the page and the assurance case are not looked at, which is
/// said.
///
/// # Errors
/// `no-study`, `not-run` and what the study's files say wrong. What does not hold of the results is no error, but a
/// fault in the report.
pub fn verify(
    request: &VerifyRequest,
    host: &Host,
    drawing: Option<&Drawing<'_>>,
) -> Result<VerifyReport, Problem> {
    let results = &request.results;
    let folder = study_folder(request)?;
    let study = Study::load_for(&folder, &host.trust)?;
    let claimed = read_result(&folder, results)?;
    let mut audit = Audit::default();
    assets(&study, &claimed, results, &mut audit);
    let sampled = Sampled {
        episodes: request.episodes,
        draw: request.draw,
    };
    let how = (&request.techniques, host, (request.deep, sampled));
    let pieces = kept::pieces(&study, results, &claimed, how, &mut audit)?;
    match pieces {
        Some(pieces) => {
            let rests_on = (&study, pieces);
            let how = (host, request.deep);
            figures(rests_on, &claimed, results, how, &mut audit)?;
        }
        None => audit.not_checked("comparisons and conclusions: not all evidence could be read"),
    }
    match drawing {
        Some(drawing) => written(&claimed, results, drawing, &mut audit)?,
        None => audit.not_checked("the page and the assurance case: nothing here draws them"),
    }
    audit.not_checked(INPUTS);
    Ok(VerifyReport::new(results, &folder, audit))
}

/// The study whose results these are: as named, or the folder around them.
fn study_folder(request: &VerifyRequest) -> Result<PathBuf, Problem> {
    if let Some(study) = &request.study {
        return Ok(study.clone());
    }
    let results = &request.results;
    let whole = std::fs::canonicalize(results);
    let whole = whole.map_err(|error| Problem::cannot_read(results, &error))?;
    match whole
        .parent()
        .filter(|parent| parent.join("study.toml").exists())
    {
        Some(_) => Ok(results.join("..")),
        None => Err(Problem::new(
            "no-study",
            format!("{} does not lie in a study's folder", results.display()),
        )
        .remedy("name the study, too: corroborate verify RESULTS STUDY")),
    }
}

/// Every asset has the content of which the hash is stated.
fn assets(study: &Study, claimed: &StudyResult, results: &Path, audit: &mut Audit) {
    let file = results.join(RESULT);
    let mut held = std::collections::BTreeSet::new();
    for (e, piece) in claimed.evidence.iter().enumerate() {
        for (a, asset) in piece.assets.iter().enumerate() {
            let place = format!("/evidence/{e}/assets/{a}/hash");
            let path = study.folder.join(&asset.path);
            match kept::hash_of_file(&path) {
                Some(hash) if hash == asset.hash => {
                    held.insert(asset.path.clone());
                }
                Some(_) => {
                    let fault =
                        format!("{} is not the file that {} rests on", asset.path, piece.id);
                    audit.fault(&file, &place, fault);
                }
                None => {
                    let fault = format!("{} cannot be read", path.display());
                    audit.fault(&file, &place, fault);
                }
            }
        }
    }
    audit.checked(held.len() as u64, "assets have the stated hash");
}

/// What is claimed is what follows from the evidence.
fn figures(
    (study, pieces): (&Study, Vec<Piece>),
    claimed: &StudyResult,
    results: &Path,
    (host, is_deep): (&Host, bool),
    audit: &mut Audit,
) -> Result<(), Problem> {
    let mut expected = corroboration::corroborate(study, pieces)?;
    if expected.produced_by != claimed.produced_by {
        audit.not_checked(&format!(
            "the program: this is {}, the result is of {}",
            expected.produced_by, claimed.produced_by
        ));
        expected.produced_by.clone_from(&claimed.produced_by);
    }
    let file = results.join(RESULT);
    let compared = expected.clone();
    let deep = is_deep.then_some(host);
    expected.diagnosis = diagnosis::again((study, &expected), claimed, results, deep, audit)?;
    expected.disagreement = map::again(study, claimed, results, (host, is_deep), audit)?;
    expected.exploration = found::again(study, claimed, results, deep, audit)?;
    expected.calibration = found::calibration(study, claimed, results, audit);
    let values = compare::values(&file, &expected, claimed, audit)?;
    audit.checked(values, "values of study.json follow from the evidence");
    let text = host::files::read_source(&file)?.text;
    compare::bytes(&file, &json(claimed)?, &text, audit);
    let path = results.join(COMPARISON);
    if let Some(kept) = kept::read::<Stored<StudyResult>>(&path, audit) {
        if !kept.is_as_kept() {
            audit.fault(&path, "/digest", "the hash of the content does not hold");
        }
        let values = compare::values_at(&path, "/content", &compared, &kept.content, audit)?;
        audit.checked(values, "values of comparison.json follow from the evidence");
    }
    Ok(())
}

/// What was written of the claimed result is what this program writes of it.
fn written(
    claimed: &StudyResult,
    results: &Path,
    drawing: &Drawing<'_>,
    audit: &mut Audit,
) -> Result<(), Problem> {
    let path = results.join(REPORT);
    match std::fs::read_to_string(&path) {
        Ok(found) => {
            if compare::bytes(&path, &(drawing.page)(claimed), &found, audit) {
                audit.checked(1, "report is drawn from study.json, byte by byte");
            }
        }
        Err(error) => audit.fault(&path, "", format!("it cannot be read: {error}")),
    }
    let folder = results.join(ASSURANCE);
    if !folder.exists() {
        return Ok(());
    }
    let mut same = 0;
    for (name, content) in assure::files(claimed, drawing)? {
        let path = folder.join(&name);
        match std::fs::read_to_string(&path) {
            Ok(found) => same += u64::from(compare::bytes(&path, &content, &found, audit)),
            Err(error) => audit.fault(&path, "", format!("it cannot be read: {error}")),
        }
    }
    audit.checked(same, "files of the assurance case are as they were written");
    Ok(())
}
