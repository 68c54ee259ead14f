//! Numbers in running text.

/// Below this a p-value is not told exactly: tests that look again give none that is smaller (`stats::p_of_stages`).
const LEAST: f64 = 1e-99;

/// A p-value with its relation sign: `= 0.042`, `= 2.2e-4`, `< 1e-99`.
pub(crate) fn p_value(p: f64) -> String {
    match p {
        p if p < LEAST => "< 1e-99".to_owned(),
        p if p < 0.001 => format!("= {p:.1e}"),
        p => format!("= {p:.3}"),
    }
}

/// A probability to three decimals that never rounds to certainty.
pub(crate) fn probability(p: f64) -> String {
    match p {
        p if p >= 1.0 => "1".to_owned(),
        p if p <= 0.0 => "0".to_owned(),
        p if p > 0.9995 => "above 0.999".to_owned(),
        p if p < 0.0005 => format!("{p:.1e}"),
        p => format!("{p:.3}"),
    }
}

/// A difference of rates in percentage points.
pub(crate) fn points(difference: f64) -> String {
    let value = rounded(100.0 * difference);
    if value == "1" {
        "1 point".to_owned()
    } else {
        format!("{value} points")
    }
}

/// A rate in percent, with more decimals near 0 and 1 so that it never rounds to certainty.
pub(crate) fn percent(rate: f64) -> String {
    let from_end = rate.min(1.0 - rate);
    if from_end > 0.0 && from_end < 1e-12 {
        let end = if rate < 0.5 { "0" } else { "100" };
        return format!("practically {end} %");
    }
    let mut decimals = 1;
    while from_end > 0.0 && from_end * 100.0 < 0.5 * 10_f64.powi(1 - decimals) && decimals < 12 {
        decimals += 1;
    }
    let text = format!("{:.*}", decimals as usize, 100.0 * rate);
    format!("{} %", text.trim_end_matches('0').trim_end_matches('.'))
}

/// Text with a full stop at its end.
pub(crate) fn sentence(text: &str) -> String {
    let text = text.trim_end();
    if text.ends_with(['.', '!', '?']) {
        text.to_owned()
    } else {
        format!("{text}.")
    }
}

/// A list in words: `a`, `a and b`, `a, b and c`.
pub(crate) fn list(items: &[String]) -> String {
    match items {
        [] => String::new(),
        [only] => only.clone(),
        [rest @ .., last] => format!("{} and {last}", rest.join(", ")),
    }
}

fn rounded(value: f64) -> String {
    let decimals = if value.abs() >= 0.1 || value == 0.0 {
        1
    } else {
        4
    };
    let text = format!("{value:.decimals$}");
    match text.strip_suffix(".0") {
        Some(whole) => whole.to_owned(),
        None => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_never_round_to_certainty() {
        assert_eq!(p_value(0.0), "< 1e-99");
        assert_eq!(p_value(1e-100), "< 1e-99");
        assert_eq!(p_value(0.10125), "= 0.101");
        assert_eq!(p_value(2.24e-4), "= 2.2e-4");
        assert_eq!(probability(0.99999), "above 0.999");
        assert_eq!(probability(1.0), "1");
        assert_eq!(percent(0.88), "88 %");
        assert_eq!(percent(0.8803785), "88 %");
        assert_eq!(percent(0.7694), "76.9 %");
        assert_eq!(percent(0.998), "99.8 %");
        assert_eq!(percent(0.9999948), "99.9995 %");
        assert_eq!(percent(1.0), "100 %");
        assert_eq!(percent(1.0 - 1e-15), "practically 100 %");
        assert_eq!(percent(0.0), "0 %");
    }

    #[test]
    fn differences_are_in_points() {
        assert_eq!(points(0.05), "5 points");
        assert_eq!(points(0.01), "1 point");
        assert_eq!(points(0.025), "2.5 points");
        assert_eq!(points(0.0002), "0.0200 points");
    }

    #[test]
    fn lists_and_sentences() {
        let items = ["a", "b", "c"].map(str::to_owned);
        assert_eq!(list(&items), "a, b and c");
        assert_eq!(list(&items[..2]), "a and b");
        assert_eq!(list(&items[..1]), "a");
        assert_eq!(list(&[]), "");
        assert_eq!(sentence("so"), "so.");
        assert_eq!(sentence("so."), "so.");
    }
}
