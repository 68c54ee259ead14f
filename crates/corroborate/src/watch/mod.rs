//! A study's monitors on a running system.
//!
//! Messages go through the same stream of signals and the same monitors as
//! recordings do, so the recording of a run, judged afterwards, has the same
//! verdicts.
//!
//! # Silence
//! Instants come with messages, but time does not stop without them. By log
//! time (that of arrival), a deadline that has passed by 100 ms without a
//! message is judged as missed: the monitors, copied, are shown an instant 100
//! ms ago of which nothing is known, and a verdict that is then determined
//! holds whatever comes. A message that arrives later counts as later, in the
//! recording too. When watching ends, what is overdue is judged alike, and the
//! recording says until when was listened, so that it is judged the same
//! afterwards. A signal with a staleness is only held as long as that allows.
//! By other times a message may always come later than it was measured:
//! there, deadlines are judged with the next message.

mod bench;
mod connection;
mod event;
mod hub;
mod keeper;
mod reader;

pub use event::{LiveCause, LiveVerdict, LiveViolation, WatchEvent, WatchLine};

use crate::outcome::Outcome;
use bench::Bench;
use diagnostic::Problem;
use evidence::Subject;
use host::Host;
use hub::{Hub, SharedHub, locked};
use judging::recording::{ReadingRules, news_of};
use judging::{Judgement, Judges, Session};
use keeper::Keeper;
use live::Source;
use reader::{Inbox, LiveReader, SharedInbox, opened};
use recording::{Moment, Polled, SignalStream, StreamError, TimeSource, TopicMap, TypeDefinitions};
use rig::Link;
use std::collections::BTreeMap;
use std::net::IpAddr;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::Duration;
use study::Study;
use temporal::monitor::Verdict;

/// How long after its time a message may still come before a deadline counts
/// as missed.
const OVERDUE_AFTER_NANOS: i64 = 100_000_000;

/// How often to look, at most, whether a deadline has passed.
const LOOK_EVERY_NANOS: i64 = 50_000_000;

/// How long to wait for topics where a request does not say.
const WAIT_FOR_TOPICS: Duration = Duration::from_secs(30);

/// What is asked of [`watch()`].
#[derive(Clone, Debug)]
pub struct WatchRequest {
    /// The study whose requirements and failure modes are judged.
    pub study: PathBuf,
    /// Only these requirements and failure modes; all if empty.
    pub only: Vec<String>,
    /// Where messages come from.
    pub from: LiveSystem,
    /// Topics to listen to and record beside those that the requirements need; `*` stands for anything.
    pub topics: Vec<String>,
    /// Where the signals are, instead of the study's topics.toml.
    pub map: Option<PathBuf>,
    /// Which time of a message counts, instead of what the topic map says.
    pub time: Option<TimeSource>,
    /// Folders of `.msg` files, for types that the connection does not define.
    pub message_path: Vec<PathBuf>,
    /// How long to wait for the topics that the requirements need.
    pub wait: Duration,
    /// How long to watch; until it is cancelled if not said.
    pub limit: Option<Duration>,
    /// The folder in which messages, events and verdicts are kept.
    pub out: Option<PathBuf>,
    /// The rest of the robot, where it is simulated.
    pub rest: Option<SimulatedRest>,
}

impl WatchRequest {
    /// To judge all of a study on a system, until it is cancelled.
    #[must_use]
    pub fn new(study: impl Into<PathBuf>, from: LiveSystem) -> Self {
        Self {
            study: study.into(),
            only: Vec::new(),
            from,
            topics: Vec::new(),
            map: None,
            time: None,
            message_path: Vec::new(),
            wait: WAIT_FOR_TOPICS,
            limit: None,
            out: None,
            rest: None,
        }
    }
}

/// A running system.
#[derive(Clone, Debug)]
pub enum LiveSystem {
    /// ROS 2, or plain DDS.
    Dds {
        /// Its domain, 0 to 232.
        domain: u16,
        /// This machine's addresses on the network of the robot; all networks if empty.
        networks: Vec<IpAddr>,
    },
    /// A Foxglove WebSocket, `ws://HOST:PORT`.
    Foxglove {
        /// Its address.
        url: String,
    },
}

/// A simulated robot of which some topics come from outside.
#[derive(Clone, Debug)]
pub struct SimulatedRest {
    /// The entry of the ledger that is simulated.
    pub entry: String,
    /// Topics that come from outside.
    pub outside: Vec<String>,
    /// The number of the episode, from 1.
    pub episode: u64,
    /// The seed instead of the study's.
    pub seed: Option<u64>,
}

/// Who is told what happens while a system is watched. What it is told comes in order, and holds up the watching while it is
/// taken in.
pub trait Audience: Send {
    /// Something happened, at this time in nanoseconds since 1970; `json` is its line of [`WatchLine`].
    fn told(&mut self, at_nanos: i64, event: &WatchEvent, json: &str);
    /// A message of this topic came.
    fn message(&mut self, topic: &str);
    /// Whether it wants to know the verdicts so far, now.
    fn wants_verdicts(&self, now_nanos: i64) -> bool;
    /// The verdicts so far.
    fn verdicts(&mut self, now_nanos: i64, verdicts: Vec<LiveVerdict>);
    /// Nothing came for a moment.
    fn idle(&mut self, now_nanos: i64);
    /// Whether nobody listens any more; then watching ends.
    fn is_gone(&self) -> bool;
    /// Watching has ended.
    fn ended(&mut self);
}

/// Nobody.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoAudience;

impl Audience for NoAudience {
    fn told(&mut self, _: i64, _: &WatchEvent, _: &str) {}
    fn message(&mut self, _: &str) {}
    fn wants_verdicts(&self, _: i64) -> bool {
        false
    }
    fn verdicts(&mut self, _: i64, _: Vec<LiveVerdict>) {}
    fn idle(&mut self, _: i64) {}
    fn is_gone(&self) -> bool {
        false
    }
    fn ended(&mut self) {}
}

/// How watching ended.
#[derive(Clone, Debug)]
pub struct WatchReport {
    /// One for each monitor.
    pub verdicts: Vec<LiveVerdict>,
    /// Messages that were received.
    pub received: u64,
    /// Messages that are known to be lost.
    pub lost: u64,
    /// What is missing, a clause each; also what could not be kept.
    pub missing: Vec<String>,
    /// The instants that were judged.
    pub instants: u64,
    /// The recording of the run, if there is one.
    pub recording: Option<PathBuf>,
    /// What it amounts to.
    pub outcome: Outcome,
}

/// Judges a running system until the time is over, the host is cancelled or nobody listens any more.
///
/// # Errors
/// A mistake in the study, topics that do not come in time, and a connection that cannot be made. One that breaks later
/// ends the watching, and is said in the report.
pub fn watch(
    request: &WatchRequest,
    setting: &Host,
    audience: Box<dyn Audience>,
) -> Result<WatchReport, Problem> {
    let study = Study::load_for(&request.study, &setting.trust)?;
    let judges = judges(&study, &request.only)?;
    for warning in study.forms.warnings(&request.only) {
        setting.events.say(&warning.warning_line());
    }
    let map = topic_map(&study, request)?;
    let judged: Vec<String> = judges.signals().into_iter().collect();
    let bench = Bench::new(request, &study, &map, &judged, setting)?;
    let signals = with_inputs(judged, bench.as_ref());
    let filter = connection::filter(&request.topics, &map, &signals);
    let source: Box<dyn Source> = match &bench {
        Some(bench) => Box::new(bench.connect(&request.from, filter)?),
        None => connection::connect(&request.from, filter)?,
    };
    let asked = Asked {
        request,
        judges: &judges,
        map: &map,
        signals: &signals,
    };
    attached(&asked, setting, source, bench.as_ref(), audience)
}

/// What is to be watched.
struct Asked<'w> {
    request: &'w WatchRequest,
    judges: &'w Judges<'w>,
    map: &'w TopicMap,
    signals: &'w [String],
}

/// Judges what `source` gives until it is told to end.
fn attached(
    asked: &Asked<'_>,
    setting: &Host,
    source: Box<dyn Source>,
    bench: Option<&Bench>,
    audience: Box<dyn Audience>,
) -> Result<WatchReport, Problem> {
    let (request, map, signals) = (asked.request, asked.map, asked.signals);
    let types = types(request)?;
    connection::wait_for_topics(&*source, &types, map, signals, request.wait, setting)?;
    let hub = hub(request, setting, &*source, audience)?;
    let inbox = Inbox::new(source, hub.clone());
    let reader = LiveReader::new(inbox.clone(), hub.clone(), types);
    let mut stream = SignalStream::new(Box::new(reader), map, signals)
        .map_err(|errors| unfit(errors.iter().map(ToString::to_string)))?;
    tell_beginning(&hub, &stream);
    let link = match bench {
        Some(bench) => Some(bench.link(stream.layout())?),
        None => None,
    };
    if let Some(bench) = bench {
        bench.begin();
    }
    let mut run = Run {
        hub: &hub,
        inbox: &inbox,
        until_nanos: None,
        bench,
        link,
        told: vec![None; asked.judges.start(stream.layout())?.determined().count()],
        instants: 0,
        looked_nanos: i64::MIN,
    };
    let judgements = run.judge(asked.judges, &mut stream)?;
    Ok(run.finish(&stream, &judgements))
}

/// The judged signals and those that the simulated robot reads.
fn with_inputs(judged: Vec<String>, bench: Option<&Bench>) -> Vec<String> {
    let mut signals = judged;
    for signal in bench.map(Bench::signals).unwrap_or_default() {
        if !signals.contains(&signal) {
            signals.push(signal);
        }
    }
    signals
}

fn judges<'a>(study: &'a Study, only: &[String]) -> Result<Judges<'a>, Problem> {
    for id in only {
        if study.forms.by_id(id).is_none() {
            let message = format!("requirements.toml does not declare `{id}`");
            return Err(Problem::new("unknown-subject", message).remedy("check the identifier"));
        }
    }
    Judges::new(study, |subject| {
        only.is_empty() || only.iter().any(|id| id == subject.id())
    })
}

/// The topic map, with the time that was asked for.
fn topic_map(study: &Study, request: &WatchRequest) -> Result<TopicMap, Problem> {
    let mut map = ReadingRules::of_study(&study.folder, request.map.as_deref())?.map;
    if let Some(time) = request.time {
        map.time.source = time;
    }
    if map.time.source == TimeSource::Log {
        // Messages arrive in order of their arrival: nothing to wait for.
        map.time.reorder_secs = 0.0;
    }
    Ok(map)
}

fn types(request: &WatchRequest) -> Result<TypeDefinitions, Problem> {
    TypeDefinitions::new(&request.message_path)
        .map_err(|error| Problem::new("cannot-read", error.to_string()))
}

fn hub(
    request: &WatchRequest,
    setting: &Host,
    source: &dyn Source,
    audience: Box<dyn Audience>,
) -> Result<SharedHub, Problem> {
    let clock = source.clock();
    let now_nanos = clock.now_nanos();
    let keeper = match &request.out {
        Some(folder) => Some(Keeper::new(folder, now_nanos, types(request)?)?),
        None => None,
    };
    let ends_at_nanos = request.limit.map(|limit| {
        let nanos = i64::try_from(limit.as_nanos()).unwrap_or(i64::MAX);
        now_nanos.saturating_add(nanos)
    });
    let hub = Hub::new(
        clock,
        audience,
        keeper,
        setting.cancel.clone(),
        ends_at_nanos,
        planned(request),
    );
    Ok(Arc::new(Mutex::new(hub)))
}

/// What is to be over when watching ends, unless cancelling is to end it.
fn planned(request: &WatchRequest) -> Option<String> {
    match (&request.rest, request.limit) {
        (Some(_), _) => Some("the episode was over".into()),
        (None, Some(_)) => Some("its time was over".into()),
        (None, None) => None,
    }
}

fn unfit(texts: impl Iterator<Item = String>) -> Problem {
    let problems = texts.map(|text| Problem::new("no-live-topics", text));
    Problem::all(problems)
        .unwrap_or_else(|| Problem::new("no-live-topics", "its signals are not known"))
        .remedy("say in topics.toml where the signals are")
}

fn tell_beginning(hub: &SharedHub, stream: &SignalStream) {
    let mut hub = locked(hub);
    let event = WatchEvent::Judging {
        format: "1.0".into(),
        recording: recording_of(&hub),
        absent: stream.absent().iter().map(|e| e.signal.clone()).collect(),
    };
    let now_nanos = hub.clock.now_nanos();
    hub.tell(now_nanos, event);
    let unfinished = hub.keeper.as_ref().map(|it| it.unfinished.clone());
    for path in unfinished.unwrap_or_default() {
        let text = format!(
            "{} has no end: its run was killed or still goes on; it counts as incomplete (`corroborate monitor --partial` judges it)",
            path.display()
        );
        hub.tell(now_nanos, WatchEvent::Notice { text });
    }
    for absent in stream.absent() {
        let text = absent.to_string();
        hub.tell(now_nanos, WatchEvent::Notice { text });
    }
}

fn recording_of(hub: &Hub) -> Option<String> {
    recording_path(hub).map(|path| path.display().to_string())
}

fn recording_path(hub: &Hub) -> Option<&Path> {
    hub.keeper.as_ref().map(|keeper| keeper.path.as_path())
}

/// One run that is watched.
struct Run<'h> {
    hub: &'h SharedHub,
    inbox: &'h SharedInbox,
    /// How long was listened, by log time.
    until_nanos: Option<i64>,
    /// The simulated rest of the robot, if there is one, and what it reads.
    bench: Option<&'h Bench>,
    link: Option<Box<dyn Link>>,
    /// For each monitor, its verdict and when that was told, by log time.
    told: Vec<Option<(i64, LiveVerdict)>>,
    instants: u64,
    /// When it was looked last whether something is overdue.
    looked_nanos: i64,
}

impl Run<'_> {
    /// Judges every instant until the end.
    fn judge<'a>(
        &mut self,
        judges: &Judges<'a>,
        stream: &mut SignalStream,
    ) -> Result<Vec<Judgement<'a>>, Problem> {
        let mut session = judges.start(stream.layout())?;
        loop {
            match self.next(stream) {
                Ok(Some(Polled::At(moment))) => self.take(&mut session, stream, moment)?,
                Ok(Some(Polled::Nothing) | None) => self.look_at_clock(&session, stream)?,
                Ok(Some(Polled::End)) => break,
                Err(error) => {
                    locked(self.hub).miss(error.to_string());
                    break;
                }
            }
        }
        self.until_nanos = self.silent_until();
        if let Some(bench) = self.bench {
            let mut hub = locked(self.hub);
            bench.missing().into_iter().for_each(|what| hub.miss(what));
        }
        let until_secs = self.until_nanos.and_then(|it| stream.steady_until_secs(it));
        session.finish_at(stream.complete(), until_secs)
    }

    /// Until when it is known what has come, by log time; `None` while
    /// something that has come waits to be read.
    fn silent_until(&self) -> Option<i64> {
        let now_nanos = locked(self.hub).clock.now_nanos();
        let is_empty = opened(self.inbox).is_empty();
        is_empty.then(|| now_nanos - OVERDUE_AFTER_NANOS)
    }

    /// The next instant or message; `None` if none came for a moment.
    fn next(&self, stream: &mut SignalStream) -> Result<Option<Polled>, StreamError> {
        if let Some(moment) = stream.ready()? {
            return Ok(Some(Polled::At(moment)));
        }
        // The lock is let go before anything is read.
        let has_come = opened(self.inbox).wait();
        has_come.then(|| stream.poll()).transpose()
    }

    /// Judges an instant.
    fn take(
        &mut self,
        session: &mut Session<'_, '_>,
        stream: &SignalStream,
        moment: Moment,
    ) -> Result<(), Problem> {
        if let Some(link) = &self.link {
            link.pass(stream.snapshot());
        }
        session.step_changed(
            moment.time_secs,
            stream.snapshot(),
            &news_of(stream, moment),
        )?;
        self.instants += 1;
        let now: Vec<_> = session.determined().map(|(.., it)| it).collect();
        let news =
            |(verdict, told): (&Option<Verdict>, &Option<_>)| verdict.is_some() && told.is_none();
        if now.iter().zip(&self.told).any(news) {
            let said = session.so_far().into_iter().zip(now);
            let determined = said.map(|(it, verdict)| verdict.map(|_| it)).collect();
            self.tell(determined, moment.log_nanos);
        }
        self.show(session);
        Ok(())
    }

    /// Judges what is overdue: a deadline has passed and nothing has come.
    fn look_at_clock(
        &mut self,
        session: &Session<'_, '_>,
        stream: &SignalStream,
    ) -> Result<(), Problem> {
        let now_nanos = locked(self.hub).clock.now_nanos();
        if now_nanos.saturating_sub(self.looked_nanos) < LOOK_EVERY_NANOS {
            return Ok(());
        }
        self.looked_nanos = now_nanos;
        let Some(until_nanos) = self.silent_until() else {
            return Ok(());
        };
        let Some(until_secs) = stream.steady_until_secs(until_nanos) else {
            return Ok(());
        };
        let overdue = session.overdue(until_secs)?;
        if overdue.iter().any(Option::is_some) {
            opened(self.inbox).judged_until(until_nanos);
            self.tell(overdue, until_nanos);
        }
        Ok(())
    }

    /// Tells the verdicts that are determined and were not told before.
    fn tell(&mut self, determined: Vec<Option<Judgement<'_>>>, log_nanos: i64) {
        for (place, judgement) in determined.into_iter().enumerate() {
            let Some(judgement) = judgement.filter(|_| self.told[place].is_none()) else {
                continue;
            };
            let verdict = LiveVerdict::of(&judgement);
            self.told[place] = Some((log_nanos, verdict.clone()));
            let mut hub = locked(self.hub);
            let now_nanos = hub.clock.now_nanos();
            let latency_secs = (now_nanos - log_nanos) as f64 / 1e9;
            hub.tell(
                now_nanos,
                WatchEvent::Verdict {
                    verdict,
                    latency_secs,
                },
            );
        }
    }

    fn show(&self, session: &Session<'_, '_>) {
        let mut hub = locked(self.hub);
        let now_nanos = hub.clock.now_nanos();
        if hub.audience.wants_verdicts(now_nanos) {
            let verdicts = session.so_far();
            let verdicts = verdicts.iter().map(LiveVerdict::of).collect();
            hub.audience.verdicts(now_nanos, verdicts);
        }
    }

    /// Sums up, ends the recording, and decides on the outcome.
    fn finish(self, stream: &SignalStream, judgements: &[Judgement<'_>]) -> WatchReport {
        let mut hub = locked(self.hub);
        let notes = stream.notes();
        for note in notes.iter().filter(|note| note.kind.is_loss()) {
            hub.miss(note.to_string());
        }
        let verdicts: Vec<LiveVerdict> = judgements.iter().map(LiveVerdict::of).collect();
        let complete = hub.is_complete();
        let mut about = BTreeMap::from([
            ("complete".to_owned(), complete.to_string()),
            ("received".to_owned(), hub.received().to_string()),
            ("lost".to_owned(), hub.lost().to_string()),
            ("missing".to_owned(), hub.missing().join("; ")),
        ]);
        if let Some(until_nanos) = self.until_nanos {
            about.insert("until_nanos".to_owned(), until_nanos.to_string());
        }
        if let Some(bench) = self.bench {
            about.extend(bench.about.clone());
            about.extend(bench.findings());
        }
        let now_nanos = hub.clock.now_nanos();
        let end = WatchEvent::End {
            reason: hub.reason().to_owned(),
            verdicts: verdicts.clone(),
            received: hub.received(),
            lost: hub.lost(),
            complete,
            missing: hub.missing(),
            instants: self.instants,
            recording: recording_of(&hub),
        };
        hub.tell(now_nanos, end);
        hub.audience.ended();
        let told = told_at_end(self.told, &verdicts, now_nanos);
        if let Some(keeper) = &mut hub.keeper {
            keeper.finish_recording(&about);
            keeper.finish_verdicts(&told);
        }
        let missing = hub.missing();
        WatchReport {
            outcome: match outcome(judgements, missing.is_empty()) {
                Outcome::Violated => Outcome::Violated,
                _ if hub.was_cut_short => Outcome::Interrupted,
                other => other,
            },
            verdicts,
            received: hub.received(),
            lost: hub.lost(),
            missing,
            instants: self.instants,
            recording: recording_path(&hub).map(Path::to_owned),
        }
    }
}

/// The verdicts with their times: those that were determined before the end,
/// then the others.
fn told_at_end(
    told: Vec<Option<(i64, LiveVerdict)>>,
    verdicts: &[LiveVerdict],
    now_nanos: i64,
) -> Vec<(i64, LiveVerdict)> {
    let mut all: Vec<(i64, LiveVerdict)> = Vec::new();
    for (told, verdict) in told.into_iter().zip(verdicts) {
        all.push(told.unwrap_or_else(|| (now_nanos, verdict.clone())));
    }
    all.sort_by_key(|(log_nanos, _)| *log_nanos);
    all
}

/// A violated requirement counts whatever was lost; a failure mode that occurs
/// is a finding, not a violation.
fn outcome(judgements: &[Judgement<'_>], complete: bool) -> Outcome {
    let requirements = || {
        judgements
            .iter()
            .filter(|j| matches!(j.subject, Subject::Requirement(_)) && j.reading.is_none())
    };
    if requirements().any(|j| j.findings.verdict == Verdict::Violated) {
        Outcome::Violated
    } else if !complete {
        Outcome::DataLost
    } else if requirements().any(|j| j.findings.verdict == Verdict::Inconclusive) {
        Outcome::Inconclusive
    } else {
        Outcome::Holds
    }
}

#[cfg(test)]
mod tests;
