//! An inspection as a table for a terminal.

use std::fmt;

use super::Inspection;

impl fmt::Display for Inspection {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let duration_secs = self.duration_secs().unwrap_or(0.0);
        writeln!(
            out,
            "{} messages on {} topics in {duration_secs:.3} s",
            self.messages,
            self.topics.len()
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
                    "{misfits} messages of {name} do not fit their schema ({first})"
                )?;
            }
            if topic.unstamped > 0 {
                writeln!(
                    out,
                    "{} messages of {name} have the stamp 0",
                    topic.unstamped
                )?;
            }
        }
        for (problem, count) in &self.frame_problems {
            writeln!(out, "{count} transforms cannot be used: {problem}")?;
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
