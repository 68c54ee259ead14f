//! Estimates of a campaign under way, which may be looked at as often as one likes.

use super::tally::Tally;
use evidence::Subject;
use study::Study;

/// The rate of each requirement that is judged, with the interval of a confidence sequence at the
/// study's level: `1a 83.1 % (74.9 to 89.6); intervals hold at every look`. Those of the report are of one look, and narrower.
pub fn estimates(study: &Study, tally: &Tally) -> String {
    let Ok(level) = stats::Confidence::new(study.about.confidence) else {
        return String::new();
    };
    let own = study
        .requirements
        .iter()
        .filter(|r| r.same_quantity_as.is_none());
    let told = own.filter_map(|requirement| {
        let subject = Subject::Requirement(requirement.id.clone());
        let sample = tally.sample(&subject);
        let rate = 100.0 * sample.rate()?;
        // Runs without a verdict count both ways.
        let ends = tally.completions(&subject);
        let [lowest, highest] = ends.map(|end| stats::confidence_sequence(end, level));
        let (low, high) = (100.0 * lowest.low, 100.0 * highest.high);
        Some(format!(
            "{} {rate:.1} % ({low:.1} to {high:.1})",
            requirement.id
        ))
    });
    let told: Vec<String> = told.collect();
    match told.is_empty() {
        true => String::new(),
        false => format!("{}; intervals hold at every look", told.join(", ")),
    }
}
