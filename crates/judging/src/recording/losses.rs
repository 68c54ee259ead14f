//! Where in a recording messages are missing.
//!
//! # Definition
//! A loss with known times spans these. Another one is where it stands in the file: between the latest
//! message before it and the earliest one behind it; one behind all messages ends the recording, which is
//! then not complete. Where neither is known, and by other times than log time, which lost messages do not
//! have, samples may be missing anywhere. The same holds of messages that were read and left out because
//! their time is not known or no place was left for them.

use super::ReadingRules;
use crate::watched;
use crate::{Judges, Losses};
use diagnostic::Problem;
use recording::{Loss, SignalStream, StreamNoteKind, TimeSource};
use std::path::Path;

impl ReadingRules {
    /// Where samples may be missing in a recording whose end `stream` has reached.
    pub(super) fn losses(
        &self,
        judges: &Judges<'_>,
        path: &Path,
        stream: &SignalStream,
        go_on: &dyn Fn() -> Result<(), Problem>,
    ) -> Result<Losses, Problem> {
        let mut losses = Losses {
            unlocated: has_left_out(stream) || watched::missed(stream.metadata()).is_some(),
            ..Losses::default()
        };
        let lost = stream.losses();
        let unspanned = lost.iter().filter(|it| it.span_nanos.is_none());
        let places: Vec<u64> = unspanned.map(|it| it.offset).collect();
        let neighbours = match places.is_empty() {
            true => Vec::new(),
            false => self.neighbours(judges, path, places, go_on)?,
        };
        let by_log = stream.time_source() == TimeSource::Log;
        for loss in lost.iter().filter(|it| it.messages != Some(0)) {
            match span_of(loss, &neighbours) {
                Span::AtEnd => {}
                Span::Between(from, to) if by_log => {
                    losses.spans.push((stream.secs(from), stream.secs(to)));
                }
                Span::Between(..) | Span::Unknown => losses.unlocated = true,
            }
        }
        losses.spans.sort_by(|one, other| one.0.total_cmp(&other.0));
        Ok(losses)
    }

    /// Reads a recording to find what is before and behind places of its file.
    fn neighbours(
        &self,
        judges: &Judges<'_>,
        path: &Path,
        places: Vec<u64>,
        go_on: &dyn Fn() -> Result<(), Problem>,
    ) -> Result<Vec<(u64, i64, i64)>, Problem> {
        let mut stream = self.stream(judges, path)?;
        stream.find_neighbours(places);
        let mut instants = 0_u64;
        // What stops the reading stopped it before.
        while let Ok(Some(_)) = stream.next_instant() {
            instants += 1;
            if instants.is_multiple_of(1 << 16) {
                go_on()?;
            }
        }
        Ok(stream.neighbours().to_vec())
    }
}

enum Span {
    Between(i64, i64),
    AtEnd,
    Unknown,
}

fn span_of(loss: &Loss, neighbours: &[(u64, i64, i64)]) -> Span {
    if let Some((from, to)) = loss.span_nanos {
        return Span::Between(from.min(to), to.max(from));
    }
    let found = neighbours.iter().find(|it| it.0 == loss.offset);
    match found {
        Some((_, i64::MIN, _)) | None => Span::Unknown,
        Some((_, _, i64::MAX)) => Span::AtEnd,
        // Without an order in the file, nothing follows from the place.
        Some((_, from, to)) if from > to => Span::Unknown,
        Some((_, from, to)) => Span::Between(*from, *to),
    }
}

/// Whether messages were left out that have a place somewhere.
fn has_left_out(stream: &SignalStream) -> bool {
    let by_header = stream.time_source() == TimeSource::Header;
    let is_left_out = |kind: StreamNoteKind| match kind {
        StreamNoteKind::Late | StreamNoteKind::Unstamped | StreamNoteKind::BadTransform => true,
        StreamNoteKind::Undecodable => by_header,
        _ => false,
    };
    stream.notes().iter().any(|note| is_left_out(note.kind))
}
