//! What a recording of `corroborate watch` says of its run, and what follows
//! from that when it is judged afterwards.

use recording::SignalStream;
use std::collections::BTreeMap;

/// Whether all was received that was sent.
const COMPLETE: &str = "corroborate.watch.complete";

/// What was not.
const MISSING: &str = "corroborate.watch.missing";

/// Until when it is known what came, by log time in nanoseconds.
const UNTIL: &str = "corroborate.watch.until_nanos";

/// What was missing when the recording was made, if it says so itself.
pub fn missed(said: &BTreeMap<String, String>) -> Option<String> {
    said.get(COMPLETE).filter(|it| *it != "true")?;
    let what = said
        .get(MISSING)
        .map_or("it does not say what", String::as_str);
    Some(format!(
        "when it was recorded, something was missing: {what}"
    ))
}

/// Until when, in seconds from the first instant, it is known that nothing
/// came after the last message: what was overdue when watching ended, is.
pub fn until_secs(stream: &SignalStream) -> Option<f64> {
    let said = stream.metadata().get(UNTIL)?;
    stream.steady_until_secs(said.parse().ok()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_run_that_says_so_missed_something() {
        let said = |pairs: &[(&str, &str)]| {
            let owned = pairs
                .iter()
                .map(|(k, v)| ((*k).to_owned(), (*v).to_owned()));
            missed(&owned.collect())
        };
        assert_eq!(said(&[]), None);
        assert_eq!(said(&[(COMPLETE, "true"), (MISSING, "")]), None);
        let what = said(&[(COMPLETE, "false"), (MISSING, "three of /a")]);
        assert!(what.expect("missed").ends_with("three of /a"));
    }
}
