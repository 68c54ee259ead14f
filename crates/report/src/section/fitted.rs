//! What of the simulator was fitted to counts: posterior, what the counts identify, and what was held out.

use evidence::{
    CalibrationReport, HeldOutRunsReport, Likeness, ModeReport, ParameterReport, PredictionReport,
};
use maud::{Markup, html};

use crate::number;
use crate::view::{View, chip, section, unbroken};
use crate::words;

/// Width of a strip, in its own units.
const WIDTH: f64 = 100.0;
/// Correlations of at least this are told.
const NOTABLE: f64 = 0.4;
/// A parameter's part in a direction that is told.
const LOADING: f64 = 0.2;

/// The section; nothing where nothing was fitted.
pub fn render(view: View) -> Markup {
    let Some(fit) = &view.study.calibration else {
        return html! {};
    };
    let lead = html! {
        "Parameters of the simulator that were set so that it fails as " (view.link(&fit.evidence)) " did, by "
        (number::count(fit.episodes)) " simulated episodes. Agreement on what was fitted is not corroboration; what was held "
        "out is a test."
    };
    let body = html! {
        p class="likeness" { (chip(&words::likeness(fit.conclusion))) " " (capitalised(&fit.because)) "." }
        h3 { "What the counts say of each parameter" }
        (parameters(fit))
        (together(fit))
        h3 { "Ways to fail" }
        (modes(view, fit))
        (held_out(view, fit))
        p class="small shares" { (capitalised(&fit.guarantee)) ". Effective posterior sample size: " (number::count(fit.effective_size.round() as u64)) "." }
        details {
            summary { "The fitted set, and what it was made from" }
            p class="small" {
                (fit.engine) ", seed " (fit.lineage.seed) "; " code { (fit.lineage.calibration.file) }
                @for file in &fit.lineage.files { ", " code { (file.file) } }
            }
            pre { (fit.parameter_set) }
        }
    };
    section("fitted", "What was fitted", lead, body)
}

fn parameters(fit: &CalibrationReport) -> Markup {
    let level = format!("Posterior, {}", unbroken(&number::level(fit.confidence)));
    html! {
        div class="scroll" tabindex="0" role="region" aria-label="Fitted parameters" {
            table class="fitted cards" {
                caption class="visually-hidden" { "Parameters: prior, posterior and fitted value" }
                thead { tr {
                    th scope="col" { "Parameter" } th scope="col" { "Prior, and the posterior in it" }
                    th scope="col" { (level) } th scope="col" class="n" { "Fitted" }
                    th scope="col" { "Learnt" }
                } }
                tbody { @for parameter in &fit.parameters { (parameter_row(parameter, &level)) } }
            }
        }
    }
}

fn parameter_row(parameter: &ParameterReport, level: &str) -> Markup {
    let unit = parameter.unit.as_deref().unwrap_or("");
    html! {
        tr {
            th scope="row" { (parameter.name) @if !unit.is_empty() { " " span class="asks" { "(" (unit) ")" } } }
            td data-label="Prior" { (strip(parameter)) }
            td data-label=(level) {
                (plain(parameter.median)) " " span class="range" { "[" (plain(parameter.low)) "–" (plain(parameter.high)) "]" }
            }
            td class="n" data-label="Fitted" { b { (plain(parameter.fitted)) } }
            td data-label="Learnt" {
                (chip(&words::identification(parameter.identifiability))) " "
                span class="counts" { (number::percent(parameter.contraction.max(0.0))) " of the prior's variance is gone" }
            }
        }
    }
}

/// The prior's range as a line, the posterior's interval as a band in it, the fitted value as a mark.
fn strip(parameter: &ParameterReport) -> Markup {
    let [low, high] = parameter.prior;
    let at = |value: f64| match high > low {
        true => WIDTH * ((value - low) / (high - low)).clamp(0.0, 1.0),
        false => WIDTH / 2.0,
    };
    let (from, to) = (at(parameter.low), at(parameter.high));
    let words = format!(
        "prior {} to {}, posterior {} to {}, fitted {}",
        plain(low),
        plain(high),
        plain(parameter.low),
        plain(parameter.high),
        plain(parameter.fitted)
    );
    html! {
        svg class="posterior" viewBox={ "0 0 " (WIDTH) " 10" } preserveAspectRatio="none" role="img" aria-label=(words) {
            line class="zero" x1="0" y1="5" x2=(WIDTH) y2="5" vector-effect="non-scaling-stroke" {}
            rect class="band" x=(fixed(from)) y="2" width=(fixed((to - from).max(0.8))) height="6" {}
            line class="at" x1=(fixed(at(parameter.fitted))) y1="0" x2=(fixed(at(parameter.fitted))) y2="10" vector-effect="non-scaling-stroke" {}
        }
        span class="ends" { span { (plain(low)) } span { (plain(high)) } }
    }
}

/// What the counts say of several parameters together only.
fn together(fit: &CalibrationReport) -> Markup {
    let mut lines: Vec<String> = Vec::new();
    for (i, row) in fit.correlations.iter().enumerate() {
        for (j, correlation) in row.iter().enumerate().take(i) {
            if let (true, Some(one), Some(other)) = (
                correlation.abs() >= NOTABLE,
                fit.parameters.get(j),
                fit.parameters.get(i),
            ) {
                lines.push(format!(
                    "Known only together: {} and {} (correlation {correlation:+.2}).",
                    one.name, other.name
                ));
            }
        }
    }
    let unknown = fit.directions.iter();
    for direction in unknown.filter(|it| it.identifiability != evidence::Identification::Identified)
    {
        let parts = fit.parameters.iter().zip(&direction.loadings);
        let parts = parts.filter(|(_, loading)| loading.abs() > LOADING);
        let parts: Vec<String> = parts
            .map(|(parameter, loading)| format!("{loading:+.2} {}", parameter.name))
            .collect();
        lines.push(format!(
            "{}: {} ({} of the prior's variance is left).",
            capitalised(direction.identifiability.words()),
            parts.join(" "),
            number::percent(direction.variance_share)
        ));
    }
    html! {
        @if !lines.is_empty() { ul class="lines" { @for line in lines { li { (line) } } } }
    }
}

fn modes(view: View, fit: &CalibrationReport) -> Markup {
    html! {
        div class="scroll" tabindex="0" role="region" aria-label="Ways to fail, counted and predicted" {
            table class="fitted cards" {
                caption class="visually-hidden" { "Ways to fail: counted, predicted, and in the fitted set's own episodes" }
                thead { tr {
                    th scope="col" { "Way to fail" } th scope="col" { "Counted in " (view.link(&fit.evidence)) }
                    th scope="col" { "Predicted, 95\u{a0}%" } th scope="col" class="n" { "p" }
                    th scope="col" { "Fitted set, fresh episodes" } th scope="col" class="n" { "p" }
                    th scope="col" { "Outcome" }
                } }
                tbody { @for mode in &fit.modes { (mode_row(view, mode)) } }
            }
        }
    }
}

fn mode_row(view: View, mode: &ModeReport) -> Markup {
    html! {
        tr {
            th scope="row" {
                (title(view, &mode.id)) " "
                span class="asks" { @if mode.held_out { "held out" } @else { "fitted" } }
            }
            td data-label="Counted" { (ratio(mode.fitted_occurrences, mode.fitted_opportunities)) }
            td data-label="Predicted" { (number::count(mode.predicted_low)) " to " (number::count(mode.predicted_high)) }
            td class="n" data-label="p" { (p(mode.predictive_p)) }
            td data-label="Fitted set" { (ratio(mode.check_occurrences, mode.check_opportunities)) }
            td class="n" data-label="p" { (number::p_value(mode.check_p)) }
            td data-label="Outcome" { (outcome(mode)) }
        }
    }
}

/// What the row shows: of what was fitted, agreement is a fit.
fn outcome(mode: &ModeReport) -> Markup {
    let shown = match (mode.held_out, mode.likeness) {
        (false, Likeness::Different) => Likeness::Different,
        (false, _) => Likeness::Fit,
        (true, likeness) => likeness,
    };
    html! {
        (chip(&words::likeness(shown)))
        @if mode.held_out && mode.likeness == Likeness::Fit {
            " " span class="counts" {
                "follows from what was fitted: " (number::percent(mode.derived_share.unwrap_or(1.0))) " of its occurrences"
            }
        } @else if mode.held_out {
            " " span class="counts" { "margin " (number::percent(mode.margin)) }
        }
        @if let Some(correlation) = mode.intraclass_correlation {
            " " span class="counts" { "trials of one subject correlate by " (number::decimal(correlation, 2)) }
        }
    }
}

fn held_out(view: View, fit: &CalibrationReport) -> Markup {
    html! {
        @if !fit.held_out_runs.is_empty() {
            h3 { "Runs that were held out" }
            div class="scroll" tabindex="0" role="region" aria-label="Runs that were predicted from the others" {
                table class="fitted cards" {
                    caption class="visually-hidden" { "Runs that were held out: counted and predicted" }
                    thead { tr {
                        th scope="col" { "Runs of" } th scope="col" { "Way to fail" }
                        th scope="col" { "Counted" } th scope="col" { "Predicted, 95\u{a0}%" } th scope="col" class="n" { "p" }
                    } }
                    tbody { @for group in &fit.held_out_runs { @for (i, one) in group.predictions.iter().enumerate() { (prediction(view, group, one, i == 0)) } } }
                }
            }
        }
    }
}

fn prediction(
    view: View,
    group: &HeldOutRunsReport,
    one: &PredictionReport,
    is_first: bool,
) -> Markup {
    html! {
        tr {
            th scope="row" {
                @if is_first {
                    (group.subjects.join(", ")) " "
                    span class="asks" {
                        @if group.fitted_set_without_them { "kept out of the fit" } @else { "predicted from the others" }
                    }
                } @else { span class="visually-hidden" { (group.subjects.join(", ")) } }
            }
            td data-label="Way to fail" { (title(view, &one.id)) }
            td data-label="Counted" { (ratio(one.occurrences, one.opportunities)) }
            td data-label="Predicted" { (number::count(one.predicted_low)) " to " (number::count(one.predicted_high)) }
            td class="n" data-label="p" { (p(one.predictive_p)) }
        }
    }
}

/// The requirement or failure mode of an identifier, as people call it.
fn title(view: View, id: &str) -> String {
    match view.requirement(id) {
        Some(_) => format!("Requirement {id} is violated"),
        None => view.title(&evidence::Subject::FailureMode(id.to_owned())),
    }
}

fn ratio(count: u64, of: u64) -> Markup {
    html! { span class="counts" { (number::count(count)) "/" (number::count(of)) } }
}

fn p(value: Option<f64>) -> String {
    value.map_or_else(|| "–".to_owned(), number::p_value)
}

/// A value to three significant digits.
fn plain(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let magnitude = value.abs().max(1e-12).log10().floor();
    let decimals = (2.0 - magnitude).clamp(0.0, 8.0) as usize;
    number::decimal(value, decimals)
}

/// A length of the drawing.
fn fixed(value: f64) -> String {
    format!("{value:.2}")
}

fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    match letters.next() {
        Some(first) => first.to_uppercase().chain(letters).collect(),
        None => String::new(),
    }
}
