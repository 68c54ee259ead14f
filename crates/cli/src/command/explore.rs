//! `corroborate explore`: episodes that are meant to show what nobody has
//! thought of.

mod causes;
mod disagreement;

use super::{Done, Host, json, use_threads};
use crate::args::{Explore, Format};
use corroborate::kept::EXPLORATION;
use corroborate::outcome::Outcome;
use corroborate::technique::exploration::{
    Abstraction, ExplorationReport, Explored, Exploring, FindingReport, Formal, Journal, MapSearch,
    Met, ModelTests, OpenBench, Plan, ShowsJudge, Situations, SourceKind, Watching, as_text,
    assets_of, inputs_of_all, shown_again, tests_of_model,
};
use corroborate::technique::rows;
use diagnostic::{Problem, did_you_mean};
use evidence::{Confirmation, Stopped};
use host::BuildId;
use host::Cancel;
use host::files::write_whole;
use judging::{Judges, SpaceTime};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Instant;
use study::{Finding, Shows, Study, Work};

/// The environment's name for the folder in which controllers leave which of
/// their lines ran.
const COVERAGE: &str = "CORROBORATE_COVERAGE";

/// Explores and writes what was found.
pub fn explore(arguments: &Explore, setting: &Host) -> Result<Done, Problem> {
    use_threads(arguments.threads)?;
    let mut study = Study::load(&arguments.study)?;
    study.about.seed = arguments.seed.unwrap_or(study.about.seed);
    let mut plan = Plan::load(&study.folder, &arguments.file)?;
    if let Some(episodes) = arguments.episodes {
        plan.data.budget.episodes = episodes;
        if let Some(disagreement) = &mut plan.data.disagreement {
            disagreement.episodes = episodes;
        }
    }
    let library = setting.physics_library.as_deref();
    let entry = study.entry(plan.evidence(arguments.disagreement))?;
    let bench = OpenBench::of_entry(&study, entry, library)?;
    plan.fits(&bench, arguments.disagreement)?;
    let folder = match &arguments.out {
        Some(folder) => folder.clone(),
        None => study.folder.join("results/exploration"),
    };
    let began = Instant::now();
    if arguments.disagreement {
        let search = MapSearch {
            study: &study,
            plan: &plan,
            bench: &bench,
            folder: &folder,
        };
        return disagreement::search(&search, arguments.format, setting);
    }
    let fast = plan.searching(&bench)?;
    let searched = fast.as_ref().unwrap_or(&bench);
    let mut explored = exploration(&study, &plan, searched, arguments, &folder, setting)?;
    let keeping = Keeping {
        study: &study,
        bench: &bench,
        is_fast: fast.is_some(),
        folder: &folder,
    };
    keeping.keep(&mut explored)?;
    if let Some(budget) = arguments.causes {
        let findings = explored.findings.len() as u64;
        let stage = setting
            .events
            .begin("shrinking findings: episodes", budget * findings);
        let causes = causes::Causes {
            study: &study,
            plan: &plan,
            benches: (&bench, fast.as_ref()),
            budget,
            folder: &folder,
            setting,
            stage: &stage,
        };
        causes.find(
            &explored.findings,
            &explored.met,
            &mut explored.report.found.findings,
        )?;
        if setting.cancel.is_cancelled() {
            // Causes that were not looked into are missing.
            explored.report.found.stopped = Stopped::Interrupted;
        }
    }
    let about = [
        ("study", study.about.title.as_str()),
        ("evidence", &bench.files.evidence),
    ];
    explored.rows.write(&folder.join(rows::FILE), &about)?;
    write(&explored, &folder, setting)?;
    let wall_secs = began.elapsed().as_secs_f64();
    setting
        .events
        .say(&format!("{wall_secs:.1} s of wall time"));
    let report = &explored.report;
    Ok(Done {
        output: match arguments.format {
            Format::Json => json(report)?,
            Format::Text => as_text(report),
        },
        outcome: outcome(report),
    })
}

fn outcome(report: &ExplorationReport) -> Outcome {
    let mut findings = report.found.findings.iter();
    // Simulators that fail say nothing of the robot.
    let is_found = findings.any(|finding| !finding.shows.is_of_simulator());
    let is_lost = report
        .found
        .findings
        .iter()
        .any(|finding| finding.shows.is_of_simulator() || !finding.found.replayed);
    match (report.found.stopped, is_found, is_lost) {
        (Stopped::Interrupted, ..) => Outcome::Interrupted,
        // What was found stands, whatever else was lost.
        (_, true, _) => Outcome::Violated,
        (_, _, true) => Outcome::DataLost,
        _ => Outcome::Holds,
    }
}

fn exploration(
    study: &Study,
    plan: &Plan,
    bench: &OpenBench,
    arguments: &Explore,
    folder: &Path,
    setting: &Host,
) -> Result<Explored, Problem> {
    let interrupt = &setting.cancel;
    let kinds = match (arguments.plain, arguments.source.is_empty()) {
        (true, _) => vec![SourceKind::Own],
        (_, false) => arguments.source.clone(),
        _ => plan.sources(),
    };
    let formal = match &plan.data.model {
        Some(model) => Some(Formal::of_entry(study, model, interrupt)?),
        None => None,
    };
    let abstraction = match &formal {
        Some(formal) => Abstraction::new(study, plan, formal)?,
        None => None,
    };
    let of_model = match &formal {
        Some(formal) => {
            tests_of_model(study, plan, formal, abstraction.as_ref(), &kinds, interrupt)?
        }
        None => ModelTests::default(),
    };
    let judges = Judges::new(study, |_| true)?;
    // A word that the bench's recordings do not know is told before anything runs.
    let layout = bench.layout(interrupt)?;
    judges.start(&layout)?;
    let code = std::env::var_os(COVERAGE).map(PathBuf::from);
    let journal = Journal::open(
        folder,
        &looked_at_by(study, plan, bench, &code, &setting.build)?,
    )?;
    let watching = Watching {
        study,
        bench,
        judges,
        searched: searched(study, plan, bench, &layout)?,
        layout,
        early_end: plan.data.budget.early_end,
        code,
        abstraction: abstraction.as_ref(),
        situations: Situations::new(study, plan)?,
    };
    let stage = setting.events.begin("exploring", plan.data.budget.episodes);
    let exploring = Exploring {
        plan,
        watching: &watching,
        of_model: &of_model,
        kinds: &kinds,
        assets: assets_of(study, plan, false)?,
        vary: !arguments.plain,
        journal: &journal,
        interrupt,
        stage: &stage,
        talk: &setting.events,
    };
    exploring.run()
}

/// What the searches of a plan go by.
fn searched<'a>(
    study: &'a Study,
    plan: &Plan,
    bench: &OpenBench,
    layout: &trace::Trace,
) -> Result<BTreeMap<String, SpaceTime<'a>>, Problem> {
    let mut searched = BTreeMap::new();
    for search in &plan.data.search {
        let id = &search.requirement;
        let Some(robustness) = SpaceTime::new(study, id, bench.ends_by_secs())? else {
            let message = format!("`{id}` is no requirement of this study that has a monitor");
            let known = study.forms.subjects.iter().map(|form| form.subject.id());
            let problem = plan.mistake(&format!("\"{id}\""), message);
            return Err(match did_you_mean(id, known) {
                Some(similar) => problem.remedy(format!("did you mean `{similar}`?")),
                None => {
                    problem.remedy("name a requirement of requirements.toml with a form for traces")
                }
            });
        };
        // A word that grades another and that the recordings do not know is told before anything runs.
        robustness.start(layout)?;
        searched.insert(id.clone(), robustness);
    }
    Ok(searched)
}

/// The hash of all that decides what an episode shows, beside its seed and
/// its stimulus.
fn looked_at_by(
    study: &Study,
    plan: &Plan,
    bench: &OpenBench,
    code: &Option<PathBuf>,
    build: &BuildId,
) -> Result<String, Problem> {
    let mut inputs = inputs_of_all(study, plan, bench, build);
    inputs.add("code", &[u8::from(code.is_some())]);
    if let Some(model) = &plan.data.model
        && let Work::Check { model, .. } = &study.entry(model)?.work
    {
        let (model, _) = host::files::read_prism(&study.folder.join(model))?;
        inputs.add("model", model.text.as_bytes());
    }
    Ok(inputs.hash())
}

/// Episodes of a finding that are run again in the full physics before it counts as not confirmed, at most.
const CONFIRMATIONS: usize = 8;

/// A finding, as it is told, with all episodes that showed it.
struct Found {
    finding: Finding,
    report: FindingReport,
    met: Vec<Met>,
}

/// Findings that are run again, and kept.
struct Keeping<'a> {
    study: &'a Study,
    /// That of the full physics.
    bench: &'a OpenBench,
    /// Whether the search ran in the fast one.
    is_fast: bool,
    folder: &'a Path,
}

impl Keeping<'_> {
    /// Keeps the findings of an exploration, and tells those apart that the full physics does not show.
    fn keep(&self, explored: &mut Explored) -> Result<(), Problem> {
        let found = &mut explored.report.found;
        let findings = std::mem::take(&mut explored.findings).into_iter();
        let reports = std::mem::take(&mut found.findings).into_iter();
        let met = std::mem::take(&mut explored.met).into_iter();
        let all = findings.zip(reports).zip(met);
        let all = all.map(|((finding, report), met)| Found {
            finding,
            report,
            met,
        });
        let (kept, others) = self.sorted(all.collect())?;
        for one in kept {
            explored.findings.push(one.finding);
            explored.met.push(one.met);
            found.findings.push(one.report);
        }
        found.confirmation = self.is_fast.then(|| Confirmation {
            engine: self.bench.engine.clone(),
            not_confirmed: others.into_iter().map(|one| one.report).collect(),
        });
        Ok(())
    }

    /// Runs an episode of each finding again in the full physics, and writes the files: the findings, and what the fast
    /// physics showed and the full one does not.
    fn sorted(&self, all: Vec<Found>) -> Result<(Vec<Found>, Vec<Found>), Problem> {
        let (mut names, mut judges) = (BTreeMap::new(), BTreeMap::new());
        let (mut kept, mut others) = (Vec::new(), Vec::new());
        for mut one in all {
            let is_shown = self.run_again(&mut one, &mut judges)?;
            let is_kept = is_shown || !self.is_fast;
            let place = if is_kept { "findings" } else { "not-confirmed" };
            let file = PathBuf::from(place).join(name(&one.finding.shows, &mut names));
            one.report.found.file = file.display().to_string();
            self.write(&one.finding, &one.report, is_kept)?;
            match is_kept {
                true => kept.push(one),
                false => others.push(one),
            }
        }
        Ok((kept, others))
    }

    /// Runs episodes of a finding again until one shows it, which then stands for it: the first alone if it was found in
    /// the full physics, where nothing else but the same can come out.
    fn run_again<'s>(
        &'s self,
        of: &mut Found,
        judges: &mut BTreeMap<Shows, ShowsJudge<'s>>,
    ) -> Result<bool, Problem> {
        let Found {
            finding,
            report,
            met,
        } = of;
        // Findings are few: an interruption leaves them to be written all the same.
        let undisturbed = Cancel::default();
        let most = if self.is_fast { CONFIRMATIONS } else { 1 };
        for episode in met.iter().take(most) {
            let again = Finding {
                seed: episode.seed,
                stimulus: episode.stimulus.clone(),
                found_by: episode.found_by.clone(),
                ..finding.clone()
            };
            let shown = shown_again(self.study, self.bench, &again, judges, &undisturbed)?;
            if shown.is_some() {
                *finding = again;
                finding.recording = shown;
                report.found.first_episode = episode.episode;
                report.found.seed = episode.seed.to_string();
                report.found.found_by = episode.found_by.clone();
                report.found.replayed = true;
                return Ok(true);
            }
        }
        Ok(false)
    }

    fn write(
        &self,
        finding: &Finding,
        report: &FindingReport,
        is_kept: bool,
    ) -> Result<(), Problem> {
        let report = &report.found;
        let is_shown = match is_kept {
            true => "A witness: how often it was found says\nnothing of how often it happens.",
            false => "Not confirmed: the fast\nphysics shows it, and the full physics does not.",
        };
        let comment = format!(
            "{}\nFound in episode {} of an exploration. {is_shown}",
            report.in_words, report.first_episode
        );
        let path = self.folder.join(&report.file);
        finding.write(&path, &comment)?;
        if Finding::read(&path)? != *finding {
            let message = format!("{} does not hold what was written", path.display());
            return Err(Problem::data_lost("cannot-write", message));
        }
        Ok(())
    }
}

/// Writes the result.
fn write(explored: &Explored, folder: &Path, setting: &Host) -> Result<(), Problem> {
    let path = folder.join(EXPLORATION);
    write_whole(&path, json(&explored.report)?.as_bytes())?;
    setting
        .events
        .say(&format!("{} is written", path.display()));
    Ok(())
}

/// A file name that says what is shown; a number tells equal ones apart.
fn name(shows: &Shows, taken: &mut BTreeMap<String, u64>) -> String {
    let words = match shows {
        Shows::Violated(id) => format!("violated-{id}"),
        Shows::FailureMode(id) => format!("failure-{id}"),
        Shows::Failed(kind) => kind.name().to_owned(),
        Shows::Unknown(step) => match &step.to {
            Some(to) => format!("unknown-{}", changes(&step.from, to)),
            None if step.from.is_empty() => "unknown-end-nothing".to_owned(),
            None => format!("unknown-end-{}", step.from),
        },
    };
    let safe = |c: char| {
        if c.is_ascii_alphanumeric() || c == '_' {
            c
        } else {
            '-'
        }
    };
    let mut name: String = words.chars().map(safe).take(80).collect();
    let count = taken.entry(name.clone()).or_insert(0);
    *count += 1;
    if *count > 1 {
        name = format!("{name}-{count}");
    }
    format!("{name}.toml")
}

/// What changes from one set of propositions to another.
fn changes(from: &str, to: &str) -> String {
    let (from, to): (Vec<&str>, Vec<&str>) = (
        from.split_whitespace().collect(),
        to.split_whitespace().collect(),
    );
    let gone = from
        .iter()
        .filter(|n| !to.contains(n))
        .map(|n| format!("not_{n}"));
    let come = to
        .iter()
        .filter(|n| !from.contains(n))
        .map(|n| (*n).to_owned());
    gone.chain(come).collect::<Vec<_>>().join("-")
}

#[cfg(test)]
mod tests {
    use super::*;
    use study::UnknownStep;

    #[test]
    fn the_committed_schema_is_the_form_that_is_written() {
        let schema: serde_json::Value = schemars::schema_for!(ExplorationReport).into();
        crate::command::tests::assert_schema_is_committed("exploration.schema.json", &schema);
    }

    /// What an exploration of the handover found in one physics: a grip that fails, in episodes with these frictions.
    fn found(study: &Study, frictions: &[f64]) -> Found {
        let file = study.folder.join("regressions/grip-failure.toml");
        let finding = Finding::read(&file).expect("a regression");
        let met = (1..).zip(frictions).map(|(episode, friction)| {
            let mut stimulus = finding.stimulus.clone();
            let key = "parameters.hand.friction".to_owned();
            stimulus.settings.insert(key, (*friction).into());
            Met {
                episode,
                seed: finding.seed,
                stimulus,
                found_by: format!("friction {friction}"),
            }
        });
        let met: Vec<Met> = met.collect();
        let found = serde_json::from_value(serde_json::json!({
            "in_words": finding.shows.to_string(),
            "subject": null,
            "file": "",
            "first_episode": 1,
            "seed": finding.seed.to_string(),
            "found_by": "friction",
            "episodes": frictions.len(),
            "replayed": false,
            "causes": [],
            "without_cause": null,
        }));
        Found {
            report: FindingReport {
                shows: finding.shows.clone(),
                found: found.expect("a discovery"),
            },
            finding,
            met,
        }
    }

    #[test]
    fn what_the_full_physics_does_not_show_is_told_apart() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let library = root.join(".tools/mujoco-3.17.0/libmujoco.so.3.17.0");
        if !library.exists() && std::env::var_os("CI").is_none() {
            return;
        }
        let study = Study::load(&root.join("case-studies/handover")).expect("a study");
        let entry = study.entry("E2").expect("an entry");
        let bench = OpenBench::of_entry(&study, entry, Some(&library)).expect("a bench");
        let folder = std::env::temp_dir().join(format!("confirmed-{}", std::process::id()));
        let keeping = |is_fast| Keeping {
            study: &study,
            bench: &bench,
            is_fast,
            folder: &folder,
        };
        // With the nominal friction the object does not slip: the first finding is shown by its second episode.
        let all = vec![found(&study, &[0.6, 0.3, 0.31]), found(&study, &[0.6, 0.6])];
        let (kept, others) = keeping(true).sorted(all).expect("they run");
        let [kept] = &kept[..] else {
            panic!("one is shown")
        };
        let told = &kept.report.found;
        assert_eq!(
            (told.first_episode, told.replayed, told.episodes),
            (2, true, 3)
        );
        assert_eq!(told.found_by, "friction 0.3");
        assert!(kept.finding.recording.is_some() && told.file.starts_with("findings/"));
        let [other] = &others[..] else {
            panic!("one is not")
        };
        assert!(!other.report.found.replayed && other.report.found.episodes == 2);
        assert!(other.report.found.file.starts_with("not-confirmed/"));
        let text = std::fs::read_to_string(folder.join(&other.report.found.file)).expect("kept");
        assert!(text.contains("the full physics does not"), "{text}");
        // A search in the full physics has nothing to confirm: an episode that does not repeat is lost data.
        let (kept, others) = keeping(false)
            .sorted(vec![found(&study, &[0.6, 0.3])])
            .expect("it runs");
        assert!(others.is_empty() && !kept[0].report.found.replayed);
        std::fs::remove_dir_all(&folder).expect("it was made");
    }

    #[test]
    fn names_say_what_changes_and_differ() {
        let step = |from: &str, to: Option<&str>| {
            Shows::Unknown(UnknownStep {
                exploration: "exploration.toml".into(),
                from: from.into(),
                to: to.map(str::to_owned),
            })
        };
        let mut taken = BTreeMap::new();
        let mut name = |shows: &Shows| name(shows, &mut taken);
        let drop = step("activated in_hand", Some("activated"));
        assert_eq!(name(&drop), "unknown-not_in_hand.toml");
        let later = step("activated in_hand sensing", Some("activated sensing"));
        assert_eq!(name(&later), "unknown-not_in_hand-2.toml");
        assert_eq!(name(&step("activated", None)), "unknown-end-activated.toml");
        assert_eq!(name(&Shows::Violated("5/b".into())), "violated-5-b.toml");
    }
}
