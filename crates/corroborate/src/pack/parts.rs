//! The parts of a pack, gathered from the study, its results and what was handed in.

use super::{PACK, PackDrawing, PackRequest};
use super::{log, not_shown, readme, recordings, renewed, sbom, strategy, traceability};
use crate::assure;
use crate::kept::{CALIBRATION, DIAGNOSIS, DISAGREEMENT, EXPLORATION};
use crate::requirements::exchange::reqif;
use crate::results::{REPORT, RESULT, json};
use crate::run::COMPARISON;
use crate::verify::VerifyReport;
use ::pack::{About, Content, NotShown, Part, Role, Sace};
use diagnostic::Problem;
use evidence::StudyResult;
use host::Host;
use host::files::{MOST_BYTES, read_file};
use sha2::{Digest, Sha256};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use study::Study;

/// What parts are gathered from.
pub(super) struct Gathering<'g> {
    pub request: &'g PackRequest,
    pub study: &'g Study,
    pub result: &'g StudyResult,
    pub results: &'g Path,
    pub verified: &'g VerifyReport,
    pub is_signed: bool,
    pub host: &'g Host,
}

/// Parts, and what is said of them all.
pub(super) struct Gathered {
    pub parts: Vec<Part>,
    pub about: About,
}

/// Gathers all parts.
pub(super) fn gather(from: &Gathering<'_>, drawing: &PackDrawing<'_>) -> Result<Gathered, Problem> {
    let tests = traceability::tests(from.study)?;
    let mut lacks = Vec::new();
    no_absolute(from)?;
    let mut parts = study_files(from)?;
    parts.extend(kept_results(from)?);
    parts.extend(assurance(from, drawing)?);
    parts.extend(requirement_parts(from, &mut lacks));
    parts.extend(traceability::parts(from.result, &tests, drawing));
    parts.extend(strategy::part(from.study, from.result));
    parts.extend(log::part(from)?);
    parts.extend(in_other_formats(from, drawing));
    parts.extend(pdf(from, drawing, &mut lacks)?);
    parts.extend(sbom::parts(&from.request.sboms, &mut lacks)?);
    let recorded = recordings::of(from)?;
    parts.extend(recorded.parts);
    lacks.extend(left_out(from)?);
    lacks.extend(renewed::other_names(from, &recorded.list)?);
    let mut not_shown = not_shown::of(from, &recorded.list, lacks);
    not_shown.dedup();
    let about = About {
        study: from.result.title.clone(),
        result_sha256: hex(&Sha256::digest(json(from.result)?)),
        produced_by: from.result.produced_by.clone(),
        packed_by: String::new(),
        recordings: recorded.list,
        not_shown,
    };
    parts.push(readme::part(from, &about, &parts));
    Ok(Gathered { parts, about })
}

pub(super) fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// A file as a part; what is large is not held in memory.
pub(super) fn of_file(
    path: &Path,
    name: &str,
    role: Role,
    what: &str,
    host: &Host,
) -> Result<Part, Problem> {
    host.go_on()?;
    let content = recordings::content(path, host)?;
    Ok(Part::new(name, role, what, content))
}

/// The names of the study's own files: those that its form fixes, and all on which evidence rests but recordings.
pub(super) fn study_paths(from: &Gathering<'_>) -> Result<BTreeSet<String>, Problem> {
    let own = [
        "study.toml",
        "parameters.toml",
        "requirements.toml",
        "vocabulary.toml",
        "ledger.toml",
        "looks.toml",
        "topics.toml",
        "README.md",
    ];
    let mut paths: BTreeSet<String> = own.into_iter().map(str::to_owned).collect();
    paths.retain(|path| from.study.folder.join(path).is_file());
    for asset in from.result.evidence.iter().flat_map(|it| &it.assets) {
        paths.insert(asset.path.clone());
    }
    paths.extend(traceability::regressions(from.study)?.into_keys());
    paths.retain(|path| !recordings::is_recording(from.study, path));
    Ok(paths)
}

/// The study's own files as parts.
fn study_files(from: &Gathering<'_>) -> Result<Vec<Part>, Problem> {
    let paths = study_paths(from)?;
    let parts = paths.iter().map(|path| {
        let full = from.study.folder.join(path);
        // What a result names is the result's to say: what it does not reach is not handed on.
        from.study.reach.check(&full)?;
        let name = format!("study/{path}");
        match path.as_str() {
            "requirements.toml" => {
                let what = "what is required, in all its forms, as the study has it";
                let part = of_file(&full, &name, Role::Requirements, what, from.host)?;
                Ok(part.as_sace(Sace::Q))
            }
            "ledger.toml" => {
                let what = "which evidence was to be produced, as the study has it";
                let part = of_file(&full, &name, Role::Strategy, what, from.host)?;
                Ok(part.as_sace(Sace::RR))
            }
            _ => of_file(&full, &name, Role::Study, "a file of the study", from.host),
        }
    });
    parts.collect()
}

/// Whoever verifies has no file at an absolute path, or another one, and what folders are called here is nobody's business.
fn no_absolute(from: &Gathering<'_>) -> Result<(), Problem> {
    let mut assets = from.result.evidence.iter().flat_map(|it| &it.assets);
    let is_absolute = |path: &str| {
        let path = path.replace('\\', "/");
        path.starts_with('/') || path.as_bytes().get(1..3) == Some(b":/")
    };
    let Some(asset) = assets.find(|it| is_absolute(&it.path)) else {
        return Ok(());
    };
    let message = format!(
        "evidence rests on {}, which is named by an absolute path: it could not be verified elsewhere",
        asset.path
    );
    Err(Problem::new("absolute-path", message).remedy(
        "put the file into the study's folder, name it from there (as in `models/robot.prism`), and run the study again",
    ))
}

/// What runs have kept, so that `verify` can derive every figure again in the unpacked folder.
fn kept_results(from: &Gathering<'_>) -> Result<Vec<Part>, Problem> {
    let mut parts = Vec::new();
    let mut add = |path: &Path, name: &str, role, what: &str| -> Result<(), Problem> {
        let name = format!("study/results/{name}");
        let part = of_file(path, &name, role, what, from.host)?;
        parts.push(match role {
            Role::Results | Role::Evidence => part.as_sace(Sace::TT),
            _ => part,
        });
        Ok(())
    };
    for (name, what) in [
        (RESULT, "the whole result"),
        (REPORT, "the result as a page"),
        (COMPARISON, "comparisons and conclusions as they were kept"),
        (DIAGNOSIS, "what was found by changing one asset at a time"),
    ] {
        let path = from.results.join(name);
        if path.is_file() && renewed::is_of(from, name) {
            add(&path, name, Role::Results, what)?;
        }
    }
    for path in files_of(from)? {
        let name = below(from.results, &path);
        if recordings::has_format(&name) {
            continue;
        }
        let what = match path.file_name().and_then(|it| it.to_str()) {
            Some("journal") => "the verdicts of every episode",
            Some(EXPLORATION | DISAGREEMENT) => "what was found by searching",
            Some(CALIBRATION) => "what of a simulator was fitted",
            _ => "kept of producing the evidence",
        };
        add(&path, &name, Role::Evidence, what)?;
    }
    Ok(parts)
}

/// The folders of results from which files are taken.
const FOLDERS: [&str; 4] = ["evidence", "episodes", "exploration", "calibration"];

/// The files in the folders of results that belong to the result.
pub(super) fn files_of(from: &Gathering<'_>) -> Result<Vec<PathBuf>, Problem> {
    let mut found = all_files(from)?;
    found.retain(|path| renewed::is_of(from, &below(from.results, path)));
    Ok(found.into_iter().collect())
}

/// What lies beside it, and is not of it.
fn left_out(from: &Gathering<'_>) -> Result<Vec<NotShown>, Problem> {
    let mut names: Vec<String> = vec![DIAGNOSIS.to_owned()];
    names.retain(|name| from.results.join(name).is_file());
    let all = all_files(from)?;
    names.extend(all.iter().map(|path| below(from.results, path)));
    names.retain(|name| !renewed::is_of(from, name));
    Ok(renewed::in_words(&names))
}

/// The files in the folders of results, without what is hidden or half written.
fn all_files(from: &Gathering<'_>) -> Result<BTreeSet<PathBuf>, Problem> {
    let mut found = BTreeSet::new();
    let mut folders: Vec<PathBuf> = FOLDERS.iter().map(|it| from.results.join(it)).collect();
    folders.retain(|it| it.is_dir());
    while let Some(folder) = folders.pop() {
        from.host.go_on()?;
        let cannot = |error: std::io::Error| Problem::cannot_read(&folder, &error);
        for entry in std::fs::read_dir(&folder).map_err(cannot)? {
            let entry = entry.map_err(cannot)?;
            let (kind, path) = (entry.file_type().map_err(cannot)?, entry.path());
            let name = entry.file_name().to_string_lossy().into_owned();
            if name.starts_with('.') || name.ends_with(".partial") || name == PACK {
                continue;
            }
            if kind.is_dir() {
                folders.push(path);
            } else if path.is_file() {
                found.insert(path);
            }
        }
    }
    Ok(found)
}

/// A path relative to a folder, with `/` between its folders.
pub(super) fn below(folder: &Path, path: &Path) -> String {
    let path = path.strip_prefix(folder).unwrap_or(path);
    let parts = path.components().map(|it| it.as_os_str().to_string_lossy());
    parts.collect::<Vec<_>>().join("/")
}

/// The assurance case, with its statements.
fn assurance(from: &Gathering<'_>, drawing: &PackDrawing<'_>) -> Result<Vec<Part>, Problem> {
    let files = assure::files(from.result, drawing.result)?;
    let parts = files.into_iter().map(|(name, text)| {
        let (role, sace, what) = match name.as_str() {
            RESULT => (Role::Results, Some(Sace::TT), "the whole result"),
            REPORT => (
                Role::Report,
                Some(Sace::TT),
                "the result as a page that opens offline",
            ),
            "argument.gsn.yaml" => (
                Role::Argument,
                Some(Sace::VV),
                "the argument, in Goal Structuring Notation",
            ),
            "confidence.gsn.yaml" => (
                Role::Argument,
                Some(Sace::VV),
                "the argument for confidence in the evidence",
            ),
            "argument.sacm.xmi" => (
                Role::Argument,
                Some(Sace::VV),
                "both arguments in SACM (XMI), for tools that exchange assurance cases",
            ),
            "provenance.json" => (
                Role::Provenance,
                Some(Sace::SS),
                "where each result comes from (W3C PROV)",
            ),
            _ => (
                Role::Evidence,
                Some(Sace::TT),
                "a piece of evidence, or an in-toto statement about it",
            ),
        };
        let part = Part::new(
            &format!("assurance/{name}"),
            role,
            what,
            Content::text(text),
        );
        Part { sace, ..part }
    });
    Ok(parts.collect())
}

/// Requirements in the formats of other tools.
fn requirement_parts(from: &Gathering<'_>, lacks: &mut Vec<NotShown>) -> Vec<Part> {
    match reqif(from.study) {
        Ok(bytes) => {
            let part = Part::new(
                "requirements/requirements.reqif",
                Role::Requirements,
                "the requirements in ReqIF",
                Content::bytes(bytes),
            );
            vec![part.as_sace(Sace::Q)]
        }
        Err(problem) => {
            lacks.push(NotShown {
                of: "the pack".into(),
                words: format!(
                    "ReqIF: not in this pack ({}). The requirements are in study/requirements.toml and in the table of traceability.",
                    problem.message()
                ),
            });
            Vec::new()
        }
    }
}

/// The verdicts as other tools read them.
fn in_other_formats(from: &Gathering<'_>, drawing: &PackDrawing<'_>) -> Vec<Part> {
    let (study, result) = (&from.study.folder, from.result);
    let parts = [
        (
            "results/junit.xml",
            "the verdicts as JUnit XML",
            (drawing.junit)(result),
        ),
        (
            "results/findings.sarif",
            "what is violated, conflicting or undecided, in SARIF",
            (drawing.sarif)(study, result),
        ),
        (
            "results/summary.md",
            "the verdicts in Markdown",
            (drawing.markdown)(result),
        ),
    ];
    let parts = parts.into_iter().map(|(name, what, text)| {
        Part::new(name, Role::Results, what, Content::text(text)).as_sace(Sace::TT)
    });
    parts.collect()
}

/// The report as PDF: as it was handed in, or as the face makes it.
fn pdf(
    from: &Gathering<'_>,
    drawing: &PackDrawing<'_>,
    lacks: &mut Vec<NotShown>,
) -> Result<Option<Part>, Problem> {
    let (bytes, what) = match &from.request.pdf {
        Some(file) => (handed_in(file)?, HANDED_IN),
        None => match (drawing.pdf)(&(drawing.result.page)(from.result)) {
            Ok(bytes) => (
                bytes,
                "the report as PDF, printed from the page by a browser",
            ),
            Err(why) => {
                lacks.push(NotShown {
                    of: "the pack".into(),
                    words: format!("Report as PDF: not in this pack ({why}). The page assurance/report.html has the same content."),
                });
                return Ok(None);
            }
        },
    };
    let part = Part::new(
        "results/report.pdf",
        Role::Report,
        what,
        Content::bytes(bytes),
    );
    Ok(Some(part.as_sace(Sace::TT)))
}

const HANDED_IN: &str =
    "the report as PDF, as it was handed in; its figures were not compared with the result";

/// A report that was made elsewhere.
fn handed_in(file: &Path) -> Result<Vec<u8>, Problem> {
    let bytes = read_file(file, MOST_BYTES)?;
    if bytes.starts_with(b"%PDF-") {
        return Ok(bytes);
    }
    let name = file.display();
    let message = format!("{name} is not a PDF: it does not begin with %PDF-");
    Err(Problem::new("bad-pdf", message).remedy("print report.html into a PDF, and name that file"))
}
