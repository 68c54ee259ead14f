//! `corroborate watch`: a study's monitors on a running system.
//!
//! Messages go through the same stream of signals and the same monitors as
//! recordings do, so the recording of a run, judged afterwards, has the same
//! verdicts. Instants come with messages alone: while all is silent, nothing
//! is judged.

mod connection;
mod event;
mod hub;
mod keeper;
mod reader;
mod teller;

use super::{Done, Setting};
use crate::args::{Format, TimeChoice, Watch};
use crate::outcome::Outcome;
use crate::problem::Problem;
use crate::study::Study;
use crate::technique::judging::{Judgement, Judges, Session};
use crate::technique::recording::ReadingRules;
use event::{LiveVerdict, WatchEvent};
use evidence::Subject;
use hub::{Hub, SharedHub, locked};
use keeper::Keeper;
use live::Source;
use reader::LiveReader;
use recording::{SignalStream, TimeSource, TopicMap, TypeDefinitions};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};
use teller::Teller;
use temporal::monitor::Verdict;

/// Judges a running system until it is told to end.
pub fn watch(arguments: &Watch, setting: &Setting) -> Result<Done, Problem> {
    let study = Study::load(&arguments.study)?;
    let judges = judges(&study, &arguments.only)?;
    let map = topic_map(&study, arguments)?;
    let signals: Vec<String> = judges.signals().into_iter().collect();
    let filter = connection::filter(&arguments.topics, &map, &signals);
    let source = connection::connect(arguments, filter)?;
    let types = types(arguments)?;
    connection::wait_for_topics(&*source, &types, &map, &signals, arguments.wait, setting)?;
    let hub = hub(arguments, setting, &*source)?;
    let reader = LiveReader::new(source, hub.clone(), types);
    let mut stream = SignalStream::new(Box::new(reader), &map, &signals)
        .map_err(|errors| unfit(errors.iter().map(ToString::to_string)))?;
    tell_beginning(&hub, &stream);
    let mut run = Run {
        hub: &hub,
        told: vec![None; judges.start(stream.layout())?.determined().count()],
        instants: 0,
    };
    let judgements = run.judge(&judges, &mut stream)?;
    Ok(run.finish(&stream, &judgements, arguments.format))
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
fn topic_map(study: &Study, arguments: &Watch) -> Result<TopicMap, Problem> {
    let mut map = ReadingRules::of_study(&study.folder, arguments.map.as_deref())?.map;
    if let Some(time) = arguments.time {
        map.time.source = match time {
            TimeChoice::Log => TimeSource::Log,
            TimeChoice::Publish => TimeSource::Publish,
            TimeChoice::Header => TimeSource::Header,
            TimeChoice::Clock => TimeSource::Clock,
        };
    }
    if map.time.source == TimeSource::Log {
        // Messages arrive in order of their arrival: nothing to wait for.
        map.time.reorder_secs = 0.0;
    }
    Ok(map)
}

fn types(arguments: &Watch) -> Result<TypeDefinitions, Problem> {
    TypeDefinitions::new(&arguments.message_path)
        .map_err(|error| Problem::new("cannot-read", error.to_string()))
}

fn hub(arguments: &Watch, setting: &Setting, source: &dyn Source) -> Result<SharedHub, Problem> {
    let clock = source.clock();
    let now_nanos = clock.now_nanos();
    let keeper = match &arguments.out {
        Some(folder) => Some(Keeper::new(folder, now_nanos, types(arguments)?)?),
        None => None,
    };
    let ends_at_nanos = arguments.limit.map(|limit| {
        let nanos = i64::try_from(limit.as_nanos()).unwrap_or(i64::MAX);
        now_nanos.saturating_add(nanos)
    });
    let hub = Hub::new(
        clock,
        Teller::new(arguments.format, now_nanos),
        keeper,
        setting.interrupt.clone(),
        ends_at_nanos,
    );
    Ok(Arc::new(Mutex::new(hub)))
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
    for absent in stream.absent() {
        let text = absent.to_string();
        hub.tell(now_nanos, WatchEvent::Notice { text });
    }
}

fn recording_of(hub: &Hub) -> Option<String> {
    let keeper = hub.keeper.as_ref()?;
    Some(keeper.path.display().to_string())
}

/// One run that is watched.
struct Run<'h> {
    hub: &'h SharedHub,
    /// For each monitor, its verdict and when that was told, by log time.
    told: Vec<Option<(i64, LiveVerdict)>>,
    instants: u64,
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
            match stream.next_instant() {
                Ok(Some(moment)) => {
                    session.step(moment.time_secs, stream.snapshot())?;
                    self.instants += 1;
                    self.tell_determined(&session, moment.log_nanos);
                    self.show(&session);
                }
                Ok(None) => break,
                Err(error) => {
                    locked(self.hub).miss(error.to_string());
                    break;
                }
            }
        }
        Ok(session.finish(stream.complete()))
    }

    /// Tells the verdicts that this instant determined.
    fn tell_determined(&mut self, session: &Session<'_, '_>, log_nanos: i64) {
        let mut determined = session.determined().zip(&self.told);
        if !determined.any(|((.., verdict), told)| verdict.is_some() && told.is_none()) {
            return;
        }
        let verdicts: Vec<Option<Verdict>> = session.determined().map(|(.., v)| v).collect();
        for (place, judgement) in session.so_far().iter().enumerate() {
            if verdicts[place].is_none() || self.told[place].is_some() {
                continue;
            }
            let verdict = LiveVerdict::of(judgement);
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
        if hub.teller.is_due(now_nanos) {
            let verdicts = session.so_far();
            hub.teller
                .know(verdicts.iter().map(LiveVerdict::of).collect());
            hub.teller.draw_when_due(now_nanos);
        }
    }

    /// Sums up, ends the recording, and decides on the outcome.
    fn finish(self, stream: &SignalStream, judgements: &[Judgement<'_>], format: Format) -> Done {
        let mut hub = locked(self.hub);
        let notes = stream.notes();
        for note in notes.iter().filter(|note| note.kind.is_loss()) {
            hub.miss(note.to_string());
        }
        let verdicts: Vec<LiveVerdict> = judgements.iter().map(LiveVerdict::of).collect();
        let complete = hub.is_complete();
        let about = BTreeMap::from([
            ("complete".to_owned(), complete.to_string()),
            ("received".to_owned(), hub.received().to_string()),
            ("lost".to_owned(), hub.lost().to_string()),
            ("missing".to_owned(), hub.missing().join("; ")),
        ]);
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
        hub.teller.finish();
        let told = told_at_end(self.told, &verdicts, now_nanos);
        if let Some(keeper) = &mut hub.keeper {
            keeper.finish_recording(&about);
            keeper.finish_verdicts(&told);
        }
        let missing = hub.missing();
        Done {
            output: match format {
                Format::Json => String::new(),
                Format::Text => summary(&verdicts, &hub, &missing, self.instants),
            },
            outcome: outcome(judgements, missing.is_empty()),
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

fn summary(verdicts: &[LiveVerdict], hub: &Hub, missing: &[String], instants: u64) -> String {
    let mut text = format!(
        "\n{:<34} {:<12} {:>8} {:>8} {:>8} {:>22}\n",
        "requirement or failure mode", "verdict", "covered", "passed", "failed", "robustness"
    );
    for verdict in verdicts {
        text.push_str(&teller::row(verdict));
    }
    for verdict in verdicts.iter().filter(|v| v.violation.is_some()) {
        text.push_str(&format!("{}: {}\n", verdict.label(), verdict.why()));
    }
    let (received, lost) = (hub.received(), hub.lost());
    text.push_str(&format!(
        "{received} messages, {lost} known to be lost, {instants} instants judged\n"
    ));
    for what in missing {
        text.push_str(&format!("missing: {what}\n"));
    }
    if let Some(path) = recording_of(hub) {
        text.push_str(&format!("recorded in {path}\n"));
    }
    text
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
