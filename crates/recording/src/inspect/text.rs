//! An inspection as a table for a terminal.

use std::fmt;

use super::Inspection;

/// The ending of a noun.
fn plural(count: u64) -> &'static str {
    if count == 1 { "" } else { "s" }
}

impl fmt::Display for Inspection {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let duration_secs = self.duration_secs().unwrap_or(0.0);
        writeln!(
            out,
            "{} message{} on {} topic{} in {duration_secs:.3} s",
            self.messages,
            plural(self.messages),
            self.topics.len(),
            plural(self.topics.len() as u64)
        )?;
        for file in &self.files {
            writeln!(out, "{file}")?;
        }
        let width = self
            .topics
            .iter()
            .map(|topic| topic.name.chars().count())
            .max()
            .unwrap_or(5)
            .max(5);
        let types = self
            .topics
            .iter()
            .map(|topic| topic.type_name.chars().count());
        let type_width = types.max().unwrap_or(4).max(4);
        writeln!(
            out,
            "{:width$}  {:type_width$}  {:>9}  {:>9}  {:>10}  {:>11}  {:>5}  {:>8}",
            "topic", "type", "messages", "rate Hz", "jitter s", "longest gap", "gaps", "disorder"
        )?;
        let shown = |value: Option<f64>, digits: usize| {
            value.map_or("-".to_owned(), |it| format!("{it:.digits$}"))
        };
        for topic in &self.topics {
            writeln!(
                out,
                "{:width$}  {:type_width$}  {:>9}  {:>9}  {:>10}  {:>11}  {:>5}  {:>8}",
                topic.name,
                topic.type_name,
                topic.messages,
                shown(topic.rate_hz, 2),
                shown(topic.jitter_secs, 6),
                shown(topic.longest_gap_secs, 6),
                topic.gaps,
                topic.out_of_order
            )?;
        }
        self.problems(out)
    }
}

impl Inspection {
    fn problems(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        for topic in &self.topics {
            let name = &topic.name;
            if let Some(reason) = &topic.undecodable {
                writeln!(out, "{name} cannot be decoded: {reason}")?;
            }
            if let Some(first) = &topic.first_misfit {
                let misfits = topic.misfits;
                writeln!(
                    out,
                    "not as their schema says: {misfits} message{} of {name} ({first})",
                    plural(misfits)
                )?;
            }
            if topic.unstamped > 0 {
                writeln!(
                    out,
                    "with the stamp 0: {} message{} of {name}",
                    topic.unstamped,
                    plural(topic.unstamped)
                )?;
            }
        }
        for (problem, count) in &self.frame_problems {
            writeln!(
                out,
                "not usable: {count} transform{}: {problem}",
                plural(*count)
            )?;
        }
        for loss in &self.losses {
            writeln!(out, "lost {loss}")?;
        }
        if let Some(error) = &self.error {
            writeln!(out, "reading ended early: {error}")?;
        }
        if !self.complete {
            writeln!(out, "the recording is not complete")?;
        }
        Ok(())
    }
}
