//! The evidence pack: what an assessor asks for, in one archive with a signed manifest.
//!
//! # Definition
//! A pack holds the study's files, its result with all evidence, its assurance case, the table of traceability, the strategy and the
//! log of the verification, results in the formats of other tools, the software of the system as it was given, and the names and hashes
//! of recordings. The crate `pack` gives it its form, its manifest and its signature; here the parts are gathered.
//!
//! Before anything is written the result has to be current (every piece of evidence fresh) and has to follow from its
//! evidence ([`verify`](crate::verify())): a signature under a figure that somebody changed by hand would be worse than none.
//!
//! Guarantee: the same files of study and results, the same arguments, the same PDF and the same key give the same bytes; the PDF
//! depends on the browser that prints it, if it is not handed in. Nothing half written stays behind, and no file but an earlier pack
//! is written over. Of what lies in the folder of results, only what the verified result has is packed; the rest is named. What the pack lacks is listed in it ([`PackReport::not_shown`]).

mod log;
mod not_shown;
mod parts;
mod readme;
mod recordings;
mod renewed;
mod sbom;
mod strategy;
mod traceability;
mod verification;

pub use log::Log;
pub use verification::{PackSignature, PackVerification, verify_pack};

use crate::assure::Drawing;
use crate::plan::{Freshness, plan};
use crate::results::{read_current_result, results_folder};
use crate::run::RunRequest;
use crate::technique::Techniques;
use crate::verify::{INPUTS, VerifyReport, VerifyRequest, verify};
use ::pack::{About, Key, NotShown, Written};
use diagnostic::{Problem, counted};
use evidence::{StudyResult, TraceRow};
use host::Host;
use host::files::{read_source, write_whole_by};
use parts::Gathered;
use schemars::JsonSchema;
use serde::Serialize;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use study::Study;

/// The pack's file in the folder of results.
pub const PACK: &str = "evidence-pack.zip";

/// A pack to be made. [`PackRequest::new`] has the defaults.
#[derive(Clone, Debug)]
pub struct PackRequest {
    /// The study's folder.
    pub study: PathBuf,
    /// Where its results are; by default in the folder `results` of the study.
    pub out: Option<PathBuf>,
    /// The archive; by default `evidence-pack.zip` in the folder of results.
    pub to: Option<PathBuf>,
    /// The Ed25519 key that signs, in PEM; without one the pack is not signed, and says so.
    pub key: Option<PathBuf>,
    /// Bills of materials of the system under test (CycloneDX or SPDX, in JSON).
    pub sboms: Vec<PathBuf>,
    /// The report as PDF, made elsewhere.
    pub pdf: Option<PathBuf>,
    /// Whether recordings are put into the pack; otherwise they are named by their hashes.
    pub with_recordings: bool,
    /// Techniques that are not built in; by default none.
    pub techniques: Techniques,
}

impl PackRequest {
    /// Of the study in this folder, without a signature.
    pub fn new(study: impl Into<PathBuf>) -> Self {
        Self {
            study: study.into(),
            out: None,
            to: None,
            key: None,
            sboms: Vec::new(),
            pdf: None,
            with_recordings: false,
            techniques: Techniques::default(),
        }
    }

    /// Signed by the key in this file.
    #[must_use]
    pub fn key(mut self, file: impl Into<PathBuf>) -> Self {
        self.key = Some(file.into());
        self
    }

    /// Written to this file.
    #[must_use]
    pub fn to(mut self, file: impl Into<PathBuf>) -> Self {
        self.to = Some(file.into());
        self
    }

    /// With a bill of materials.
    #[must_use]
    pub fn sbom(mut self, file: impl Into<PathBuf>) -> Self {
        self.sboms.push(file.into());
        self
    }
}

/// How a face draws what the engine does not.
pub struct PackDrawing<'d> {
    /// The page and the argument.
    pub result: &'d Drawing<'d>,
    /// The verdicts as JUnit XML.
    pub junit: &'d dyn Fn(&StudyResult) -> String,
    /// What is violated or undecided, in SARIF, with places in the files of the study in this folder as the pack has them.
    pub sarif: &'d dyn Fn(&Path, &StudyResult) -> String,
    /// The verdicts in Markdown.
    pub markdown: &'d dyn Fn(&StudyResult) -> String,
    /// The table of traceability as a page.
    pub traceability: &'d dyn Fn(&StudyResult, &[TraceRow<'_>]) -> String,
    /// The page as PDF, or why there is none.
    pub pdf: &'d dyn Fn(&str) -> Result<Vec<u8>, String>,
}

/// A pack that was written.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct PackReport {
    /// Version of this form.
    pub format: String,
    /// The archive.
    pub pack: PathBuf,
    /// Its size in bytes.
    pub bytes: u64,
    /// Its SHA-256 in hexadecimal.
    pub sha256: String,
    /// How many parts its manifest names.
    pub parts: u64,
    /// The SHA-256 of the public key that verifies its signature; absent if it is not signed.
    pub signed_by: Option<String>,
    /// What the pack does not show, as it stands in it.
    #[schemars(with = "Vec<std::collections::BTreeMap<String, String>>")]
    pub not_shown: Vec<NotShown>,
}

/// Makes the pack of a study that has been run.
///
/// # Errors
/// `pack-over-file` if something else is there under the archive's name, `absolute-path` if evidence rests on a file that is named
/// by an absolute path, `not-run` without a run, `stale-result` if something of the study has changed since, `result-does-not-follow` if
/// [`verify`](crate::verify()) finds a fault, `bad-key`, `bad-sbom`, `bad-pdf`, `pack-too-large`, `cannot-read`, `cannot-write`;
/// `interrupted` if the host was asked to stop.
pub fn pack(
    request: &PackRequest,
    host: &Host,
    drawing: &PackDrawing<'_>,
) -> Result<PackReport, Problem> {
    let folder = results_folder(&request.study, request.out.as_deref());
    let to = request.to.clone().unwrap_or_else(|| folder.join(PACK));
    replaces_no_other(&to)?;
    let study = Study::load_for(&request.study, &host.trust)?;
    let result = read_current_result(&request.study, &folder)?;
    is_fresh(request, host)?;
    let verified = follows(request, &folder, host, drawing)?;
    let key = request.key.as_deref().map(secret_key).transpose()?;
    let gathering = parts::Gathering {
        request,
        study: &study,
        result: &result,
        results: &folder,
        verified: &verified,
        is_signed: key.is_some(),
        host,
    };
    let written =
        parts::gather(&gathering, drawing).and_then(|gathered| write(&to, gathered, key.as_ref()));
    // A file that is read when somebody asks to stop fails like any other.
    let (written, bytes, sha256) =
        written.map_err(|problem| host.go_on().err().unwrap_or(problem))?;
    Ok(PackReport {
        format: "1.0".into(),
        pack: to,
        bytes,
        sha256,
        parts: written.manifest.subject.len() as u64,
        signed_by: written.signed_by,
        not_shown: written.manifest.predicate.not_shown,
    })
}

/// What is there under the archive's name is an earlier pack, or empty: nothing else is written over.
fn replaces_no_other(to: &Path) -> Result<(), Problem> {
    let known = match std::fs::metadata(to) {
        Ok(known) => known,
        // A link to nothing is a file of somebody, too.
        Err(_) if std::fs::symlink_metadata(to).is_err() => return Ok(()),
        Err(error) => return Err(Problem::cannot_read(to, &error)),
    };
    if known.is_file() {
        let cannot = |error: std::io::Error| Problem::cannot_read(to, &error);
        let mut begin = Vec::new();
        let file = std::fs::File::open(to).map_err(cannot)?;
        std::io::Read::read_to_end(&mut std::io::Read::take(file, 256), &mut begin)
            .map_err(cannot)?;
        if begin.is_empty() || ::pack::begins_as_pack(&begin) {
            return Ok(());
        }
    }
    let message = format!(
        "{} exists and is not an evidence pack; a pack is never written over another file",
        to.display()
    );
    Err(Problem::new("pack-over-file", message)
        .remedy("name a new file with --to, or move that one away"))
}

/// Nothing of the study has changed since its evidence was produced.
fn is_fresh(request: &PackRequest, host: &Host) -> Result<(), Problem> {
    let run = RunRequest {
        out: request.out.clone(),
        techniques: request.techniques.clone(),
        ..RunRequest::new(&request.study)
    };
    let plan = plan(&run, host)?;
    if plan.is_fresh() {
        return Ok(());
    }
    let is_stale = |it: &Freshness| *it != Freshness::Fresh;
    let evidence = plan.evidence.iter().filter(|it| is_stale(&it.freshness));
    let mut stale: Vec<&str> = evidence.map(|it| it.id.as_str()).collect();
    if plan.comparison.as_ref().is_some_and(is_stale) {
        stale.push("the comparison");
    }
    let are = if stale.len() == 1 { "is" } else { "are" };
    let message = format!(
        "{} {are} not of the study's present files and settings",
        stale.join(", ")
    );
    let study = request.study.display();
    let out = request
        .out
        .as_ref()
        .map_or(String::new(), |it| format!(" --out {}", it.display()));
    Err(Problem::new("stale-result", message).remedy(format!(
        "run `corroborate run {study}{out}` first; `corroborate plan {study}{out}` says what changed"
    )))
}

/// Every figure follows from its evidence.
fn follows(
    request: &PackRequest,
    results: &Path,
    host: &Host,
    drawing: &PackDrawing<'_>,
) -> Result<VerifyReport, Problem> {
    let asked = VerifyRequest::new(results)
        .study(&request.study)
        .techniques(request.techniques.clone());
    let report = verify(&asked, host, Some(drawing.result))?;
    let Some(first) = report.faults.first() else {
        let mut report = report;
        // That was looked at: everything is fresh.
        report.not_checked.retain(|it| it != INPUTS);
        return Ok(report);
    };
    let message = format!(
        "the results do not follow from their evidence ({}): {}: {}",
        counted(report.faults.len(), "fault"),
        first.file,
        first.fault
    );
    Err(Problem::new("result-does-not-follow", message).remedy(format!(
        "`corroborate verify {} {}` lists all; run the study again, and `corroborate assure` if the assurance case is older",
        results.display(),
        request.study.display()
    )))
}

fn secret_key(file: &Path) -> Result<Key, Problem> {
    Key::of_pem(&file.display().to_string(), &read_source(file)?.text)
}

/// Writes the archive whole or not at all; with its size and SHA-256.
fn write(
    to: &Path,
    gathered: Gathered,
    key: Option<&Key>,
) -> Result<(Written, u64, String), Problem> {
    let about = About {
        packed_by: format!("corroborate {}", env!("CARGO_PKG_VERSION")),
        ..gathered.about
    };
    let mut written = None;
    write_whole_by(to, |file| {
        let mut out = Counted::new(BufWriter::new(file));
        let manifest = ::pack::write(gathered.parts, about, key, &mut out)?;
        let (file, bytes, sha256) = out.finish(to)?;
        written = Some((manifest, bytes, sha256));
        Ok(file)
    })?;
    written.ok_or_else(|| Problem::new("cannot-write", format!("{} was not written", to.display())))
}

/// What goes by is counted and hashed.
struct Counted {
    out: BufWriter<std::fs::File>,
    bytes: u64,
    hash: sha2::Sha256,
}

impl Counted {
    fn new(out: BufWriter<std::fs::File>) -> Self {
        Self {
            out,
            bytes: 0,
            hash: sha2::Digest::new(),
        }
    }

    fn finish(self, to: &Path) -> Result<(std::fs::File, u64, String), Problem> {
        let file = self.out.into_inner();
        let file = file.map_err(|error| Problem::cannot_write(to, error.error()))?;
        let hash = sha2::Digest::finalize(self.hash);
        let hex = hash.iter().map(|byte| format!("{byte:02x}")).collect();
        Ok((file, self.bytes, hex))
    }
}

impl Write for Counted {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let count = self.out.write(bytes)?;
        self.bytes += count as u64;
        sha2::Digest::update(&mut self.hash, &bytes[..count]);
        Ok(count)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.out.flush()
    }
}

/// The files of a new key.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct NewKey {
    /// The secret key: who has it can sign.
    pub secret: PathBuf,
    /// The public key, by which signatures are verified.
    pub public: PathBuf,
    /// The SHA-256 of the public key in DER, which names it.
    pub id: String,
}

/// Writes a new key of this seed, which has to be random, and its public key beside it. The secret key can be read by its owner alone.
///
/// # Errors
/// `key-exists` if one of the files is there, `cannot-write`.
pub fn new_key(file: &Path, seed: [u8; 32]) -> Result<NewKey, Problem> {
    let key = Key::of_seed(seed);
    let public = file.with_extension("pub.pem");
    for path in [file, &public] {
        if std::fs::symlink_metadata(path).is_ok() {
            let message = format!(
                "{} exists; a key is never written over another file",
                path.display()
            );
            return Err(Problem::new("key-exists", message)
                .remedy("name a new file, or move the old one away"));
        }
    }
    write_new(file, &key.pem(), true)?;
    write_new(&public, &key.public().pem(), false).inspect_err(|_| {
        let _ = std::fs::remove_file(file);
    })?;
    Ok(NewKey {
        secret: file.to_owned(),
        public,
        id: key.public().id(),
    })
}

fn write_new(path: &Path, text: &str, is_secret: bool) -> Result<(), Problem> {
    let mut options = std::fs::OpenOptions::new();
    options.write(true).create_new(true);
    host::system::set_owner(&mut options, is_secret);
    let opened = options.open(path).and_then(|mut file| {
        let written = file
            .write_all(text.as_bytes())
            .and_then(|()| file.sync_data());
        written.inspect_err(|_| {
            let _ = std::fs::remove_file(path);
        })
    });
    opened.map_err(|error| Problem::cannot_write(path, &error))
}
