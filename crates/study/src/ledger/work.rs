//! What an entry of the ledger does, out of the keys that say so; keys that belong to other work are refused.

use super::read::{EntryText, Reader, TablesText};
use super::{CommandText, Method, PhysicsEngine, Sampling, TreeEvent, Work};
use crate::placed::toml_place;
use diagnostic::{Problem, Problems};
use evidence::Subject;
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::PathBuf;
use toml::Spanned;

/// What this work is in words, and the keys that say how it is done.
fn keys_of(work: &Work) -> (&'static str, &'static [&'static str]) {
    match work {
        Work::Check { .. } => ("model checking", &["model", "methods"]),
        Work::FaultTree { .. } => (
            "a fault tree",
            &["tree", "events", "mission_time", "triggered"],
        ),
        Work::Simulate { .. } => (
            "a simulation of a scenario",
            &[
                "scenario",
                "parameters",
                "engine",
                "episodes",
                "seeds",
                "until",
                "keep",
                "early_end",
                "on_failure",
            ],
        ),
        Work::SimulateScene { .. } => (
            "a simulation of a scene",
            &[
                "scene",
                "test",
                "engine",
                "episodes",
                "seeds",
                "until",
                "keep",
                "early_end",
                "on_failure",
            ],
        ),
        Work::Command { .. } => (
            "an outside command",
            &[
                "command",
                "assets",
                "stimulus",
                "leaves",
                "limit_secs",
                "persistent",
                "episodes",
                "seeds",
                "until",
                "keep",
                // Refused with a reason of its own.
                "early_end",
                "on_failure",
            ],
        ),
        Work::Judge { .. } => (
            "a judgement of recordings",
            &["recordings", "repeated_recordings"],
        ),
        Work::Read { .. } => ("a reading of tables", &["tables"]),
        Work::Other { .. } => ("work of a technique of one's own", &["producer", "with"]),
    }
}

/// The keys of an entry that say how its work is done, with the place of each that is given.
fn keys(text: &EntryText) -> [(&'static str, Option<Range<usize>>); 28] {
    fn at<T>(value: &Option<Spanned<T>>) -> Option<Range<usize>> {
        value.as_ref().map(Spanned::span)
    }
    // By name, so that the compiler asks of each new key whether it says how work is done.
    let EntryText {
        model,
        methods,
        tree,
        events,
        triggered,
        mission_time,
        scenario,
        parameters,
        scene,
        test,
        engine,
        episodes,
        command,
        assets,
        stimulus,
        leaves,
        limit_secs,
        persistent,
        seeds,
        until,
        keep,
        early_end,
        on_failure,
        tables,
        recordings,
        repeated_recordings,
        producer,
        with,
        id: _,
        title: _,
        technique: _,
        conditions: _,
        changed: _,
        intermediate: _,
        reproduced_by: _,
        calibrated: _,
        chosen: _,
        independent: _,
        undecided_at_random: _,
        published: _,
    } = text;
    let assets = assets.iter().flatten().next();
    [
        ("model", at(model)),
        ("methods", at(methods)),
        ("tree", at(tree)),
        ("events", at(events)),
        ("mission_time", at(mission_time)),
        ("triggered", at(triggered)),
        ("scenario", at(scenario)),
        ("parameters", at(parameters)),
        ("scene", at(scene)),
        ("test", at(test)),
        ("engine", at(engine)),
        ("episodes", at(episodes)),
        ("command", at(command)),
        ("assets", assets.map(Spanned::span)),
        ("stimulus", at(stimulus)),
        ("leaves", at(leaves)),
        ("limit_secs", at(limit_secs)),
        ("persistent", at(persistent)),
        ("seeds", at(seeds)),
        ("until", at(until)),
        ("keep", at(keep)),
        ("early_end", at(early_end)),
        ("on_failure", at(on_failure)),
        ("tables", at(tables)),
        ("recordings", at(recordings)),
        ("repeated_recordings", at(repeated_recordings)),
        ("producer", at(producer)),
        ("with", at(with)),
    ]
}

/// The physics engine that an entry names; MuJoCo, if it names none.
fn engine_of(text: &EntryText) -> PhysicsEngine {
    text.engine
        .as_ref()
        .map(|it| *it.get_ref())
        .unwrap_or_default()
}

impl Reader<'_> {
    /// The work of the entry that has this place in the ledger.
    pub(super) fn work(&self, text: &EntryText, place: usize) -> Result<Work, Problem> {
        use evidence::Technique::{Experiment, FaultTree, ModelChecking, Operation, Simulation};
        if let Some(producer) = &text.producer {
            let work = other(text, producer, *text.technique.get_ref());
            return self.no_other_keys(text, place, &work).map(|()| work);
        }
        let work = match text.technique.get_ref() {
            ModelChecking => self.check(text),
            FaultTree => self.fault_tree(text),
            technique @ (Simulation | Experiment) if text.command.is_some() => {
                self.command(text, *technique)
            }
            Simulation if text.tables.is_none() => self.simulate(text),
            Experiment if text.recordings.is_some() => self.judge(text, Experiment),
            technique @ (Simulation | Experiment) => self.read(text, *technique),
            Operation => self.judge(text, Operation),
        }?;
        self.no_other_keys(text, place, &work)?;
        Ok(work)
    }

    /// Refuses keys that say nothing about this work: whoever wrote them expects that they do.
    fn no_other_keys(&self, text: &EntryText, place: usize, work: &Work) -> Result<(), Problem> {
        let (what, used) = keys_of(work);
        let given = keys(text).into_iter();
        let given = given.filter_map(|(key, span)| span.is_some().then_some(key));
        let all: Vec<String> = used.iter().map(|key| format!("`{key}`")).collect();
        let (id, place) = (text.id.get_ref(), place.to_string());
        let mut found = Problems::new();
        for key in given.filter(|key| !used.contains(key)) {
            found.add(self.problem(
                "bad-ledger",
                format!("`{id}` is {what}, which does not use `{key}`"),
                toml_place(self.source, &["evidence", &place, key]),
                &format!("remove it; {what} uses {}", all.join(", ")),
            ));
        }
        found.or(())
    }

    fn check(&self, text: &EntryText) -> Result<Work, Problem> {
        let mut found = Problems::new();
        let model = found.keep(self.file(text, "model", text.model.as_ref()));
        let methods = match &text.methods {
            None => vec![Method::Sound],
            Some(methods) => methods.get_ref().clone(),
        };
        if let Some(given) = text.methods.as_ref().filter(|_| methods.is_empty()) {
            found.add(self.problem(
                "no-method",
                "`methods` is empty".into(),
                given.span(),
                "leave it out for the sound method",
            ));
        }
        let model = model.unwrap_or_default();
        found.or(Work::Check { model, methods })
    }

    fn fault_tree(&self, text: &EntryText) -> Result<Work, Problem> {
        let mut found = Problems::new();
        let tree = found.keep(self.file(text, "tree", text.tree.as_ref()));
        let Some(events) = text.events.as_ref().filter(|it| !it.get_ref().is_empty()) else {
            found.add(self.problem(
                "missing-entry",
                format!(
                    "the fault tree `{}` does not say of which requirement or failure mode it speaks",
                    text.id.get_ref()
                ),
                text.id.span(),
                "add for example `events = { \"1\" = \"top\" }`: by requirement the event that violates it, by failure mode \
                 the event that it is",
            ));
            return found.or(Work::FaultTree {
                tree: tree.unwrap_or_default(),
                mission_time: None,
                events: Vec::new(),
                is_triggered: false,
            });
        };
        let event = |(id, event): (&String, &Spanned<String>)| {
            Ok(TreeEvent {
                subject: self.subject(id, event)?,
                event: event.get_ref().clone(),
                span: event.span(),
            })
        };
        let events = events.get_ref().iter();
        let events = events.filter_map(|it| found.keep(event(it))).collect();
        let is_time = |it: &f64| it.is_finite() && *it >= 0.0;
        let mission_time = match &text.mission_time {
            Some(time) if !is_time(time.get_ref()) => {
                found.add(self.problem(
                    "bad-ledger",
                    format!("`mission_time` must be at least 0 (got {})", time.get_ref()),
                    time.span(),
                    "write a time in the unit of the tree's rates",
                ));
                None
            }
            time => time.as_ref().map(|it| *it.get_ref()),
        };
        found.or(Work::FaultTree {
            tree: tree.unwrap_or_default(),
            mission_time,
            events,
            is_triggered: text.triggered.as_ref().is_some_and(|it| *it.get_ref()),
        })
    }

    /// How many episodes are asked for.
    fn episodes(&self, text: &EntryText) -> Result<u64, Problem> {
        let episodes = text.episodes.as_ref().ok_or_else(|| {
            self.problem(
                "missing-entry",
                format!(
                    "missing field `episodes` of the simulation `{}`",
                    text.id.get_ref()
                ),
                text.id.span(),
                "add for example `episodes = 100`, or `tables.…` to read published counts",
            )
        })?;
        if !(1..=10_000_000).contains(episodes.get_ref()) {
            return Err(self.problem(
                "bad-episodes",
                format!(
                    "`episodes` must be between 1 and 10000000 (got {})",
                    episodes.get_ref()
                ),
                episodes.span(),
                "write how many episodes are run",
            ));
        }
        Ok(*episodes.get_ref())
    }

    fn command(&self, text: &EntryText, technique: evidence::Technique) -> Result<Work, Problem> {
        let others = [
            text.scenario.as_ref().map(Spanned::span),
            text.scene.as_ref().map(Spanned::span),
            text.tables.as_ref().map(Spanned::span),
            text.recordings.as_ref().map(Spanned::span),
        ];
        if let Some(span) = others.into_iter().flatten().next() {
            return Err(self.problem(
                "bad-ledger",
                format!("`{}` has a command and another source", text.id.get_ref()),
                span,
                "keep either `command` or this",
            ));
        }
        let (words, span) = match &text.command {
            Some(words) => (words.get_ref().clone(), words.span()),
            None => (Vec::new(), text.id.span()),
        };
        let names = |place: &str| words.iter().any(|word| word.contains(place));
        let is_usable = words.first().is_some_and(|word| !word.is_empty());
        let persistent = text.persistent.as_ref().is_some_and(|it| *it.get_ref());
        if persistent {
            let in_vain = ["{stimulus}", "{seed}", "{recording}"].into_iter();
            if let Some(place) = in_vain.into_iter().find(|place| names(place)) {
                return Err(self.problem(
                    "bad-command",
                    format!("a persistent command is not told `{place}` when it is started"),
                    span,
                    "leave it out: the command is asked for each episode by a line on its input (`corroborate explain command`)",
                ));
            }
        }
        if !is_usable || !persistent && (!names("{recording}") || !names("{seed}")) {
            return Err(self.problem(
                "bad-command",
                "the command has to be told where to leave its recording, and its seed".into(),
                span,
                "for example `command = [\"python3\", \"simulate.py\", \"{stimulus}\", \"{seed}\", \"{recording}\"]`",
            ));
        }
        let mut found = Problems::new();
        let assets = text.assets.iter().flatten();
        let stimulus = text.stimulus.as_ref();
        let command = CommandText {
            command: words,
            assets: assets
                .filter_map(|path| found.keep(self.existing(path)))
                .collect(),
            stimulus: stimulus.and_then(|path| found.keep(self.existing(path))),
            leaves: found.keep(self.leaves(text)).unwrap_or_default(),
            limit_secs: found.keep(self.limit_secs(text)).unwrap_or_default(),
            persistent,
        };
        let episodes = found.keep(self.episodes(text)).unwrap_or_default();
        found.or(Work::Command {
            technique,
            command,
            episodes,
        })
    }

    fn leaves(&self, text: &EntryText) -> Result<String, Problem> {
        let Some(leaves) = &text.leaves else {
            return Ok("mcap".into());
        };
        let extension = leaves.get_ref().trim_start_matches('.');
        if extension
            .chars()
            .all(|c| c.is_ascii_alphanumeric() || c == '.')
        {
            return Ok(extension.to_owned());
        }
        Err(self.problem(
            "bad-command",
            format!("`leaves` must be letters, digits and dots (got `{extension}`)"),
            leaves.span(),
            "write the extension of its recordings, for example `mcap`, `bag`, `db3`, `csv` or `jsonl`; leave it empty for a folder",
        ))
    }

    fn limit_secs(&self, text: &EntryText) -> Result<f64, Problem> {
        match &text.limit_secs {
            None => Ok(3600.0),
            Some(limit) if *limit.get_ref() > 0.0 && *limit.get_ref() <= 1e6 => {
                Ok(*limit.get_ref())
            }
            Some(limit) => Err(self.problem(
                "bad-command",
                format!(
                    "`limit_secs` must be more than 0 and at most 1000000 (got {})",
                    limit.get_ref()
                ),
                limit.span(),
                "write the seconds of real time after which an episode is ended",
            )),
        }
    }

    /// Another entry of the ledger.
    fn seeds(&self, text: &EntryText) -> Result<Option<String>, Problem> {
        let Some(of) = &text.seeds else {
            return Ok(None);
        };
        let own = text.id.get_ref();
        if of.get_ref() == own || !self.all.contains(of.get_ref()) {
            return Err(self.problem(
                "unknown-evidence",
                format!(
                    "`seeds` must name another entry of the ledger (got `{}`)",
                    of.get_ref()
                ),
                of.span(),
                "name the entry whose episodes it is to repeat, or leave `seeds` out",
            ));
        }
        Ok(Some(of.get_ref().clone()))
    }

    /// How episodes are run; only what has episodes may say so.
    pub(super) fn sampling(&self, text: &EntryText) -> Result<Sampling, Problem> {
        let spans = [
            text.until.as_ref().map(Spanned::span),
            text.keep.as_ref().map(Spanned::span),
            text.early_end.as_ref().map(Spanned::span),
            text.on_failure.as_ref().map(Spanned::span),
            text.seeds.as_ref().map(Spanned::span),
        ];
        if let (None, Some(span)) = (&text.episodes, spans.into_iter().flatten().next()) {
            return Err(self.problem(
                "bad-ledger",
                format!("`{}` runs no episodes", text.id.get_ref()),
                span,
                "`until`, `keep`, `early_end`, `on_failure` and `seeds` belong to entries with `episodes`",
            ));
        }
        if let (Some(_), Some(early)) = (&text.command, &text.early_end) {
            return Err(self.problem(
                "bad-ledger",
                "another simulator is judged by its recording, so it does not end early".into(),
                early.span(),
                "leave `early_end` out",
            ));
        }
        Ok(Sampling {
            seeds: self.seeds(text)?,
            until: text.until.as_ref().map(|it| it.get_ref().clone()),
            keep: text
                .keep
                .as_ref()
                .map(|it| *it.get_ref())
                .unwrap_or_default(),
            early_end: text.early_end.as_ref().is_some_and(|it| *it.get_ref()),
            on_failure: text
                .on_failure
                .as_ref()
                .map(|it| *it.get_ref())
                .unwrap_or_default(),
        })
    }

    fn simulate(&self, text: &EntryText) -> Result<Work, Problem> {
        let mut found = Problems::new();
        let episodes = found.keep(self.episodes(text)).unwrap_or_default();
        if let Some(scene) = &text.scene {
            let work = found.keep(self.simulate_scene(text, scene, episodes));
            return found.or(work.unwrap_or(Work::SimulateScene {
                scene: PathBuf::new(),
                test: None,
                engine: PhysicsEngine::default(),
                episodes,
            }));
        }
        let scenario = self.file(text, "scenario", text.scenario.as_ref());
        let parameters = self.file(text, "parameters", text.parameters.as_ref());
        let (scenario, parameters) = (found.keep(scenario), found.keep(parameters));
        found.or(Work::Simulate {
            scenario: scenario.unwrap_or_default(),
            parameters: parameters.unwrap_or_default(),
            engine: engine_of(text),
            episodes,
        })
    }

    fn simulate_scene(
        &self,
        text: &EntryText,
        scene: &Spanned<PathBuf>,
        episodes: u64,
    ) -> Result<Work, Problem> {
        if let Some(other) = text.scenario.as_ref().or(text.parameters.as_ref()) {
            return Err(self.problem(
                "bad-ledger",
                format!("`{}` names a scene and a scenario", text.id.get_ref()),
                other.span(),
                "keep either `scene` or `scenario` and `parameters`",
            ));
        }
        Ok(Work::SimulateScene {
            scene: self.existing(scene)?,
            test: text.test.as_ref().map(|test| test.get_ref().clone()),
            engine: engine_of(text),
            episodes,
        })
    }

    fn judge(&self, text: &EntryText, technique: evidence::Technique) -> Result<Work, Problem> {
        let (Some(recordings), None) = (&text.recordings, &text.tables) else {
            return Err(self.problem(
                "missing-entry",
                format!(
                    "`{}` has to name either `recordings` or, for an experiment, `tables`",
                    text.id.get_ref()
                ),
                text.id.span(),
                "add for example `recordings = \"runs/recordings\"`, a folder of the study",
            ));
        };
        self.in_reach(recordings)?;
        Ok(Work::Judge {
            technique,
            recordings: match self.folder.join(recordings.get_ref()).exists() {
                true => recordings.get_ref().clone(),
                false => self.existing(recordings)?,
            },
            repeated: self.reason("repeated_recordings", &text.repeated_recordings)?,
        })
    }

    fn read(&self, text: &EntryText, technique: evidence::Technique) -> Result<Work, Problem> {
        let Some(tables) = &text.tables else {
            return Err(self.problem(
                "missing-entry",
                format!("missing field `tables` of the experiment `{}`", text.id.get_ref()),
                text.id.span(),
                "add `tables.cohort`, `tables.requirements` or `tables.failure_modes`, or `recordings`",
            ));
        };
        let span = tables.span();
        let tables = tables.get_ref();
        let mut found = Problems::new();
        let given = [
            &tables.cohort,
            &tables.requirements,
            &tables.failure_modes,
            &tables.junit,
            &tables.episodes,
        ];
        if given.iter().all(|path| path.is_none()) {
            return Err(self.problem(
                "missing-entry",
                "`tables` is empty".into(),
                span,
                "add `cohort`, `requirements`, `failure_modes`, `junit` or `episodes`",
            ));
        }
        let one_for_all = found.keep(self.declared_for_all(tables)).flatten();
        let mut file = |path: &Option<Spanned<PathBuf>>| {
            path.as_ref()
                .and_then(|path| found.keep(self.existing(path)))
        };
        let (cohort, requirements) = (file(&tables.cohort), file(&tables.requirements));
        let failure_modes = file(&tables.failure_modes);
        // A folder of runs, or one file.
        let mut file_or_folder = |path: &Option<Spanned<PathBuf>>| {
            let path = path.as_ref()?;
            found.keep(self.in_reach(path))?;
            match self.folder.join(path.get_ref()).is_dir() {
                true => Some(path.get_ref().clone()),
                false => found.keep(self.existing(path)),
            }
        };
        let (junit, episodes) = (
            file_or_folder(&tables.junit),
            file_or_folder(&tables.episodes),
        );
        let cluster = found.keep(self.cluster(tables)).flatten();
        let tests = found.keep(self.tests(tables)).unwrap_or_default();
        found.or(Work::Read {
            technique,
            one_for_all,
            cohort,
            requirements,
            failure_modes,
            junit,
            episodes,
            cluster,
            tests,
        })
    }

    /// What makes episodes alike, which is to be declared of them and of nothing else.
    fn cluster(&self, tables: &TablesText) -> Result<Option<String>, Problem> {
        let choices = "`task`, `seed`, `checkpoint`, a column of the table, or `episode` if each stands by itself";
        match (&tables.episodes, &tables.cluster) {
            (None, None) => Ok(None),
            (Some(path), None) => Err(self.problem(
                "missing-entry",
                "`tables.episodes` does not say what makes episodes alike".into(),
                path.span(),
                &format!("add `cluster = `: {choices}"),
            )),
            (None, Some(cluster)) => Err(self.problem(
                "missing-entry",
                "`tables.cluster` is of `tables.episodes`, which is not there".into(),
                cluster.span(),
                "add `episodes = ` with their file or folder, or leave `cluster` out",
            )),
            (Some(path), Some(_)) if tables.cohort.is_some() => Err(self.problem(
                "missing-entry",
                "`tables.episodes` and `tables.cohort` are both a cohort".into(),
                path.span(),
                "leave one of them out, or make them two entries",
            )),
            (Some(_), Some(cluster)) => match cluster.get_ref().trim() {
                "" => Err(self.problem(
                    "missing-entry",
                    "`tables.cluster` is empty".into(),
                    cluster.span(),
                    &format!("write {choices}"),
                )),
                name => Ok(Some(name.to_owned())),
            },
        }
    }

    /// By requirement the test that verifies it.
    fn tests(&self, tables: &TablesText) -> Result<BTreeMap<String, String>, Problem> {
        if let (Some((_, first)), None) = (tables.tests.first_key_value(), &tables.junit) {
            return Err(self.problem(
                "missing-entry",
                "`tables.tests` names tests, and there is no `tables.junit`".into(),
                first.span(),
                "add `junit = ` with the folder of their results, or leave `tests` out",
            ));
        }
        let mut read = BTreeMap::new();
        for (id, test) in &tables.tests {
            let Subject::Requirement(id) = self.subject(id, test)? else {
                return Err(self.problem(
                    "unknown-subject",
                    format!("`{id}` is a failure mode, and a test verifies a requirement"),
                    test.span(),
                    "name the requirement",
                ));
            };
            read.insert(id, test.get_ref().clone());
        }
        Ok(read)
    }

    /// A declaration with its reason in words.
    pub(super) fn reason(
        &self,
        key: &str,
        text: &Option<Spanned<String>>,
    ) -> Result<Option<String>, Problem> {
        let Some(because) = text else {
            return Ok(None);
        };
        match because.get_ref().trim() {
            "" => Err(self.problem(
                "bad-ledger",
                format!("`{key}` gives no reason"),
                because.span(),
                "write why, in words, or leave it out",
            )),
            reason => Ok(Some(reason.to_owned())),
        }
    }

    /// Why one subject stands for all: a reason in words, of a cohort.
    fn declared_for_all(&self, tables: &TablesText) -> Result<Option<String>, Problem> {
        let Some(because) = &tables.one_for_all else {
            return Ok(None);
        };
        if tables.cohort.is_none() && tables.episodes.is_none() {
            return Err(self.problem(
                "one-for-all",
                "`one_for_all` needs a table `cohort`".into(),
                because.span(),
                "add `cohort`, or leave `one_for_all` out: a total does not say whose trials it counts",
            ));
        }
        match because.get_ref().trim() {
            "" => Err(self.problem(
                "one-for-all",
                "`one_for_all` gives no reason".into(),
                because.span(),
                "write why the one person or session of the cohort stands for all others",
            )),
            reason => Ok(Some(reason.to_owned())),
        }
    }
}

/// The work of a technique that is not built in; whether there is one of this name is seen when it is run.
fn other(text: &EntryText, producer: &Spanned<String>, technique: evidence::Technique) -> Work {
    let with = text.with.as_ref().map(|with| with.get_ref().clone());
    Work::Other {
        technique,
        producer: producer.get_ref().clone(),
        span: producer.span(),
        with: with.unwrap_or_default(),
    }
}
