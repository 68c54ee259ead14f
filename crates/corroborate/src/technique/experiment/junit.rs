//! JUnit XML of many runs as trials.
//!
//! # Definition
//! A test case is of a requirement if its property `verifies` names it, or if the ledger names its test (`tables.tests`). A *trial*
//! of a requirement is what its test cases show together: of one seed, where cases or their suites have a property `seed`; else of
//! one file, the first case of each test in it making the first trial, the second the next. What stands in brackets behind a test's
//! name (`test_grasp[3-10]`) tells trials of one test apart.
//!
//! A case without an element of its outcome shows what its attributes `status` and `result` say (`notrun`, `disabled`, `fail`, ...), and
//! else that it passed. A trial fails if one of its cases fails; it is unknown if one ended with an error of the harness and none failed; it passes if
//! one passed and the others did not apply. A case that was tried again (`flakyFailure`, `rerunFailure` and the same of errors) shows
//! each of its tries: what passed in the end is not all that was seen.
//!
//! # Assumes
//! Trials of different seeds or files are independent. Of unknown trials nothing: they count against and for.
//!
//! # Guarantee
//! A case that stands in several files with the same seed counts once; with different outcomes it is refused, since its seed does not
//! fix it then. Files of the same bytes are refused. No case that reports a rate, as this program writes them, is taken for a trial.

use crate::technique::files::Files;
use diagnostic::{Problem, Source};
use evidence::{AssetRole, Subject};
use host::store::hash_of;
use roxmltree::{Document, Node};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use study::Study;

/// What the cases of one requirement amount to.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Counted {
    pub(super) requirement: String,
    pub(super) passed: u64,
    pub(super) failed: u64,
    /// Trials whose harness broke.
    pub(super) unknown: u64,
    /// Trials to which no case applied.
    pub(super) skipped: u64,
}

/// What a case shows, the gravest last.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Shows {
    Skipped,
    Passed,
    Error,
    Failed,
}

/// Of which trial a case is.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum TrialId {
    Seed(String),
    Of { file: usize, number: u64 },
}

/// The trials of a requirement: by trial and test, what it shows and in which file.
type Trials = BTreeMap<TrialId, BTreeMap<String, (Shows, usize)>>;

/// Counts the trials of all files below `folder`, a path relative to the study's folder.
pub(super) fn read(
    study: &Study,
    folder: &Path,
    tests: &BTreeMap<String, String>,
    reader: &Files<'_>,
) -> Result<Vec<Counted>, Problem> {
    let mut gathered = Gathered {
        study,
        tests,
        files: Vec::new(),
        trials: BTreeMap::new(),
    };
    let mut hashes: BTreeMap<String, PathBuf> = BTreeMap::new();
    for path in files_below(&study.folder, folder)? {
        let source = reader.text(AssetRole::Data, &path)?;
        if let Some(other) = hashes.insert(hash_of(source.text.as_bytes()), path.clone()) {
            let message = format!(
                "{} and {} have the same content",
                other.display(),
                path.display()
            );
            return Err(Problem::new("bad-junit", message).remedy(
                "remove one of them: a copy is not another run; runs that are the same to the byte need a property `seed`",
            ));
        }
        gathered.file(&source, path)?;
    }
    Ok(gathered.counted())
}

/// The files of XML in a folder and those below it, or the one file, in the order of their names.
fn files_below(study: &Path, path: &Path) -> Result<Vec<PathBuf>, Problem> {
    let whole = study.join(path);
    if !whole.is_dir() {
        return Ok(vec![path.to_owned()]);
    }
    let cannot = |error: std::io::Error| Problem::cannot_read(&whole, &error);
    let entries = std::fs::read_dir(&whole).map_err(cannot)?;
    let mut names = Vec::new();
    for entry in entries {
        names.push(path.join(entry.map_err(cannot)?.file_name()));
    }
    names.sort();
    let mut files = Vec::new();
    for name in names {
        if study.join(&name).is_dir() {
            files.extend(files_below(study, &name)?);
        } else if name.extension().is_some_and(|it| it == "xml") {
            files.push(name);
        }
    }
    Ok(files)
}

struct Gathered<'a> {
    study: &'a Study,
    tests: &'a BTreeMap<String, String>,
    files: Vec<PathBuf>,
    trials: BTreeMap<String, Trials>,
}

impl Gathered<'_> {
    fn file(&mut self, source: &Source, path: PathBuf) -> Result<(), Problem> {
        let document = Document::parse(&source.text).map_err(|error| {
            let at = error.pos();
            let lines = source.text.split_inclusive('\n').take(at.row as usize - 1);
            let start = lines.map(str::len).sum::<usize>();
            bad(
                source,
                start..start,
                format!("the XML cannot be read: {error}"),
            )
        })?;
        let root = document.root_element();
        if !["testsuites", "testsuite"].contains(&root.tag_name().name()) {
            let name = root.tag_name().name();
            let message =
                format!("the root of JUnit XML is `testsuites` or `testsuite`, this is `{name}`");
            return Err(bad(source, head(root), message));
        }
        self.files.push(path);
        let mut seen = Seen::default();
        let cases = root.descendants().filter(|it| it.has_tag_name("testcase"));
        for case in cases {
            self.case(source, case, &mut seen)?;
        }
        Ok(())
    }

    fn case(
        &mut self,
        source: &Source,
        case: Node<'_, '_>,
        seen: &mut Seen,
    ) -> Result<(), Problem> {
        let test = test_name(case);
        let requirements = self.requirements(source, case, &test)?;
        if requirements.is_empty() {
            return Ok(());
        }
        if properties(case, "guarantee").next().is_some() {
            let message = "this case reports a rate with its guarantee, not a trial";
            let problem = Problem::new("bad-junit", message).at(source, head(case));
            return Err(problem.remedy(
                "take the counts of its trials: `pytest --corroborate-out FOLDER` writes FOLDER/requirements.csv, which the entry names by \
                 `tables.requirements`",
            ));
        }
        let seed = seen.seed(case);
        for shows in tries(case) {
            let (trial, name) = match &seed {
                Some(seed) => (TrialId::Seed(seed.clone()), test.clone()),
                None => {
                    let base = without_brackets(&test).to_owned();
                    let number = seen.met.entry(base.clone()).or_default();
                    *number += 1;
                    let (file, number) = (self.files.len() - 1, *number);
                    (TrialId::Of { file, number }, base)
                }
            };
            for requirement in &requirements {
                self.add(source, case, requirement, (&trial, &name, shows))?;
            }
        }
        Ok(())
    }

    fn add(
        &mut self,
        source: &Source,
        case: Node<'_, '_>,
        requirement: &str,
        (trial, name, shows): (&TrialId, &str, Shows),
    ) -> Result<(), Problem> {
        let file = self.files.len() - 1;
        let trials = self.trials.entry(requirement.to_owned()).or_default();
        let cases = trials.entry(trial.clone()).or_default();
        let (before, of) = *cases.entry(name.to_owned()).or_insert((shows, file));
        if before == shows {
            return Ok(());
        }
        let seed = match trial {
            TrialId::Seed(seed) => seed.as_str(),
            TrialId::Of { .. } => "",
        };
        let message = format!(
            "`{name}` with seed {seed} is {} here and {} in {}: its seed does not fix it",
            words(shows),
            words(before),
            self.files[of].display()
        );
        Err(bad(source, head(case), message))
    }

    fn requirements(
        &self,
        source: &Source,
        case: Node<'_, '_>,
        test: &str,
    ) -> Result<Vec<String>, Problem> {
        let mut found: Vec<String> = Vec::new();
        for value in properties(case, "verifies") {
            let ids = value
                .split([',', ' ', '\n', '\t'])
                .filter(|it| !it.is_empty());
            for id in ids {
                if self
                    .study
                    .forms
                    .of(&Subject::Requirement(id.to_owned()))
                    .is_none()
                {
                    let message = format!("requirements.toml does not declare `{id}`");
                    return Err(Problem::new("unknown-subject", message)
                        .at(source, head(case))
                        .remedy("correct the identifier, or declare it"));
                }
                found.push(id.to_owned());
            }
        }
        let short = case.attribute("name").unwrap_or_default();
        let names = [test, without_brackets(test), short, without_brackets(short)];
        let named = self
            .tests
            .iter()
            .filter(|(_, name)| names.contains(&name.as_str()));
        found.extend(named.map(|(requirement, _)| requirement.clone()));
        found.sort();
        found.dedup();
        Ok(found)
    }

    fn counted(self) -> Vec<Counted> {
        let of_requirement = |(requirement, trials): (String, Trials)| {
            let gravest = |cases: &BTreeMap<String, (Shows, usize)>| {
                cases.values().map(|(shows, _)| *shows).max()
            };
            let count = |wanted: Shows| {
                let with = trials.values().filter(|it| gravest(it) == Some(wanted));
                with.count() as u64
            };
            Counted {
                passed: count(Shows::Passed),
                failed: count(Shows::Failed),
                unknown: count(Shows::Error),
                skipped: count(Shows::Skipped),
                requirement,
            }
        };
        self.trials.into_iter().map(of_requirement).collect()
    }
}

/// What was seen of a file.
#[derive(Default)]
struct Seen {
    /// How often each test was met without a seed.
    met: BTreeMap<String, u64>,
    /// The seed of each suite by its place, with those around it: a suite of many cases is looked through once.
    seeds: BTreeMap<usize, Option<String>>,
}

impl Seen {
    /// The seed of a case, or that of the innermost suite that has one.
    fn seed(&mut self, case: Node<'_, '_>) -> Option<String> {
        let own = properties(case, "seed").next();
        own.or_else(|| self.of_suite(case.parent()?))
    }

    fn of_suite(&mut self, suite: Node<'_, '_>) -> Option<String> {
        let place = suite.range().start;
        if let Some(known) = self.seeds.get(&place) {
            return known.clone();
        }
        let own = properties(suite, "seed").next();
        let seed = own.or_else(|| self.of_suite(suite.parent()?));
        self.seeds.insert(place, seed.clone());
        seed
    }
}

/// What a case says of itself without an element for it: CTest and GoogleTest name tests that did not run in attributes.
fn stated(case: Node<'_, '_>) -> Option<Shows> {
    let words = ["status", "result"].into_iter();
    let words = words.filter_map(|it| case.attribute(it));
    let shows = words.filter_map(|word| match word.to_ascii_lowercase().as_str() {
        "fail" | "failed" | "failure" => Some(Shows::Failed),
        "error" => Some(Shows::Error),
        "notrun" | "disabled" | "skipped" | "suppressed" => Some(Shows::Skipped),
        _ => None,
    });
    shows.max()
}

/// The outcome of a case, and of the tries before it.
fn tries(case: Node<'_, '_>) -> Vec<Shows> {
    let of = |names: [&str; 2]| {
        let children = case.children();
        children
            .filter(|it| names.iter().any(|name| it.has_tag_name(*name)))
            .count()
    };
    let has = |name: &str| case.children().any(|it| it.has_tag_name(name));
    let mut tries = vec![Shows::Failed; of(["flakyFailure", "rerunFailure"])];
    tries.extend(vec![Shows::Error; of(["flakyError", "rerunError"])]);
    tries.push(match (has("failure"), has("error"), has("skipped")) {
        (true, ..) => Shows::Failed,
        (_, true, _) => Shows::Error,
        (.., true) => Shows::Skipped,
        (false, false, false) => stated(case).unwrap_or(Shows::Passed),
    });
    tries
}

/// The values of a property of a case or suite, as an attribute or as text.
fn properties<'a>(of: Node<'a, '_>, name: &'a str) -> impl Iterator<Item = String> + 'a {
    let lists = of.children().filter(|it| it.has_tag_name("properties"));
    let all = lists
        .flat_map(|it| it.children())
        .filter(|it| it.has_tag_name("property"));
    let named = all.filter(move |it| it.attribute("name") == Some(name));
    named.map(|it| {
        it.attribute("value")
            .or(it.text())
            .unwrap_or_default()
            .trim()
            .to_owned()
    })
}

/// A test's name with what it is part of.
fn test_name(case: Node<'_, '_>) -> String {
    let name = case.attribute("name").unwrap_or_default();
    match case.attribute("classname").unwrap_or_default() {
        "" => name.to_owned(),
        class => format!("{class}.{name}"),
    }
}

fn without_brackets(name: &str) -> &str {
    match name.ends_with(']') {
        true => name.split('[').next().unwrap_or(name),
        false => name,
    }
}

fn words(shows: Shows) -> &'static str {
    match shows {
        Shows::Skipped => "skipped",
        Shows::Passed => "passed",
        Shows::Error => "an error",
        Shows::Failed => "failed",
    }
}

/// Where an element begins.
fn head(node: Node<'_, '_>) -> std::ops::Range<usize> {
    let start = node.range().start;
    start..start + 1 + node.tag_name().name().len()
}

fn bad(source: &Source, span: std::ops::Range<usize>, message: String) -> Problem {
    Problem::new("bad-junit", message).at(source, span).remedy(
        "name files that test runs wrote; `corroborate explain junit` says what is read of them",
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    const RUN: &str = "<?xml version=\"1.0\"?>\n<testsuites><testsuite name=\"s\"><properties><property name=\"seed\" value=\"7\"/>\
                       </properties><testcase classname=\"a\" name=\"b[1-2]\"><properties><property name=\"verifies\">2, 1</property>\
                       </properties><failure message=\"&lt;\">x</failure></testcase></testsuite></testsuites>\n";

    /// A study with the requirements 1 and 2, and its folder.
    fn study() -> (tempfile::TempDir, Study) {
        let folder = tempfile::tempdir().expect("a folder");
        let study = folder.path().join("study");
        crate::new_study(&study).expect("made");
        let study = Study::load(&study).expect("loaded");
        (folder, study)
    }

    fn read_text(study: &Study, text: &[u8]) -> Result<Vec<Counted>, Problem> {
        std::fs::write(study.folder.join("run.xml"), text).expect("written");
        let files = Files::of(&study.folder);
        read(study, Path::new("run.xml"), &BTreeMap::new(), &files)
    }

    #[test]
    fn a_case_is_of_all_requirements_that_it_names() {
        let (_folder, study) = study();
        let failed = |requirement: &str| Counted {
            requirement: requirement.into(),
            passed: 0,
            failed: 1,
            unknown: 0,
            skipped: 0,
        };
        let counted = read_text(&study, RUN.as_bytes()).expect("read");
        assert_eq!(counted, [failed("1"), failed("2")]);
    }

    /// The bytes are changed, cut and repeated in the same way each time: what is read is counted or refused.
    #[test]
    fn whatever_a_file_holds_is_counted_or_refused() {
        let (_folder, study) = study();
        let mut state = 0x9e37_79b9_7f4a_7c15_u64;
        let mut below = |limit: usize| {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state % limit.max(1) as u64) as usize
        };
        let (mut counted, mut refused) = (0, 0);
        for _ in 0..2000 {
            let mut bytes = RUN.as_bytes().to_vec();
            for _ in 0..=below(3) {
                let at = below(bytes.len());
                match below(4) {
                    0 if !bytes.is_empty() => bytes[at] = below(256) as u8,
                    1 => drop(bytes.drain(at..(at + below(20)).min(bytes.len()))),
                    2 => {
                        let piece = bytes[at..(at + below(60)).min(bytes.len())].to_vec();
                        drop(bytes.splice(at..at, piece));
                    }
                    _ => bytes.truncate(at.max(1)),
                }
            }
            match read_text(&study, &bytes) {
                Ok(_) => counted += 1,
                Err(problem) => {
                    assert!(problem.what_to_do().is_some(), "{problem}");
                    refused += 1;
                }
            }
        }
        assert!(counted > 20 && refused > 1000, "{counted} {refused}");
    }

    /// As CTest and GoogleTest write them, and with the words alone.
    #[test]
    fn what_did_not_run_is_no_success_and_what_failed_is_one_without_an_element() {
        let (_folder, study) = study();
        let verifies =
            "<properties><property name=\"verifies\" value=\"1\"/></properties></testcase>";
        let cases = [
            "status=\"disabled\"",
            "status=\"notrun\" result=\"suppressed\"",
            "status=\"run\" result=\"completed\"",
            "status=\"fail\"",
            "result=\"failed\"",
            "status=\"error\"",
        ];
        let cases = cases.iter().enumerate();
        let cases: String = cases
            .map(|(at, words)| format!("<testcase name=\"t\" {words}><!-- {at} -->{verifies}"))
            .collect();
        let text = format!("<testsuite name=\"s\">{cases}</testsuite>");
        let counted = read_text(&study, text.as_bytes()).expect("read");
        let [one] = &counted[..] else {
            panic!("{counted:?}")
        };
        assert_eq!(
            (one.passed, one.failed, one.unknown, one.skipped),
            (1, 2, 1, 2)
        );
    }

    /// A suite is looked through once for its seed, not once for each of its cases.
    #[test]
    fn cases_of_one_suite_have_its_seed_or_that_around_it() {
        let (_folder, study) = study();
        let case = "<testcase name=\"t\"><properties><property name=\"verifies\" value=\"1\"/></properties></testcase>";
        let seed = |seed: u32| {
            format!("<properties><property name=\"seed\" value=\"{seed}\"/></properties>")
        };
        let text = format!(
            "<testsuites><testsuite name=\"a\">{}{case}{case}</testsuite><testsuite name=\"b\">{}<testsuite name=\"c\">{case}</testsuite>\
             </testsuite></testsuites>",
            seed(1),
            seed(2)
        );
        let counted = read_text(&study, text.as_bytes()).expect("read");
        // Both cases of the first suite are one trial: the same test with the same seed.
        assert_eq!(counted[0].passed, 2, "{counted:?}");
    }
}
