//! Answers as text.

use diagnostic::{Problem, counted};
use query::{
    Built, CertificateReport, CheckReport, DistributionReport, PropertyReport, WitnessReport,
    number,
};

/// The size of a state space.
fn built(model: &str, built: &Built) -> String {
    let constants = built.constants.as_ref();
    let constants = constants.map_or(String::new(), |values| format!(" with {values}"));
    let mut line = format!(
        "{model}{constants}: {}, {}, {} initial, built in {:.3} s\n",
        counted(built.states, "state"),
        counted(built.transitions, "transition"),
        built.initial_states,
        built.build_secs
    );
    if let Some(explored) = built.states_up_to_symmetry {
        line.push_str(&format!(
            "explored {} up to symmetry\n",
            counted(explored, "state")
        ));
    }
    if built.deadlocks > 0 {
        line.push_str(&format!(
            "{} given a self-loop\n",
            counted(built.deadlocks, "deadlock state")
        ));
    }
    line
}

/// Whether a property is the first of a further state space.
fn begins(built: &Built, property: &PropertyReport) -> bool {
    built.valuation() == property.valuation()
}

/// One line for each answer.
pub(super) fn lines(report: &CheckReport) -> Result<String, Problem> {
    let mut output = String::new();
    let cannot = |error: serde_json::Error| Problem::new("cannot-write", error.to_string());
    let found = report.distributions.iter().map(serde_json::to_string);
    let answered = report.properties.iter().map(serde_json::to_string);
    for line in found.chain(answered) {
        output.push_str(&line.map_err(cannot)?);
        output.push('\n');
    }
    Ok(output)
}

/// The report for reading.
pub(super) fn text(report: &CheckReport) -> String {
    let mut output = match &report.interrupted {
        Some(how) if !report.is_built() => format!("{}: {how}\n", report.model),
        _ => built(&report.model, &report.built),
    };
    for distribution in &report.distributions {
        output.push_str(&self::distribution(distribution));
    }
    let mut further = report.further.iter().peekable();
    for property in &report.properties {
        // The properties of one valuation follow each other.
        if let Some(next) = further.next_if(|next| begins(next, property)) {
            output.push('\n');
            output.push_str(&built(&report.model, next));
        }
        let name = property
            .name
            .as_ref()
            .map_or(String::new(), |n| format!("\"{n}\": "));
        output.push_str(&format!("\nModel checking: {name}{}\n", property.property));
        if let Some(constants) = &property.constants {
            output.push_str(&format!("Constants: {constants}\n"));
        }
        for listed in &property.printed {
            output.push_str(&format!(
                "{}:{}={}\n",
                listed.state, listed.values, listed.result
            ));
        }
        match (&property.result, &property.error) {
            // One line for each part of the region.
            (Some(result), _) if property.parametric.is_some() => {
                output.push_str(&format!("Result: {result}\n"));
            }
            (Some(result), _) => {
                output.push_str(&format!("Result: {result}{}\n", in_brackets(property)));
            }
            (None, Some(why)) if property.unfinished.is_some() => {
                let bounds = match (property.low, property.high) {
                    (Some(low), Some(high)) => {
                        format!("between {} and {}, ", number(low), number(high))
                    }
                    _ => String::new(),
                };
                let capital = if bounds.is_empty() { "" } else { "Stopped: " };
                output.push_str(&format!("{capital}{bounds}{why}\n"));
            }
            (None, error) => {
                output.push_str(&format!(
                    "Error: {}\n",
                    error.as_deref().unwrap_or("no answer")
                ));
            }
        }
        if let Some(certificate) = &property.certificate {
            output.push_str(&self::certificate(certificate));
        }
        if let Some(path) = &property.witness {
            output.push_str(&witness(path));
        }
        for note in &property.notes {
            output.push_str(&format!("Note: {note}\n"));
        }
    }
    output
}

/// The probabilities of states, one line for each, as PRISM writes them.
fn distribution(found: &DistributionReport) -> String {
    let when = found.time.as_ref();
    let mut text = match when {
        Some(time) => format!("\nTransient probabilities (time = {time})"),
        None if found.kind == "transient" => "\nTransient probabilities".to_owned(),
        None => "\nSteady-state probabilities".to_owned(),
    };
    if let Some(constants) = &found.constants {
        text.push_str(&format!(" with {constants}"));
    }
    if let Some(error) = &found.error {
        text.push_str(&format!("\nError: {error}\n"));
        return text;
    }
    match &found.file {
        Some(file) => text.push_str(&format!(": written to {file}")),
        None => text.push(':'),
    }
    text.push_str(&format!(" (each within {:e})\n", found.widest));
    for state in &found.states {
        let line = format!("{}:{}={}\n", state.state, state.values, number(state.value));
        text.push_str(&line);
    }
    text
}

/// A path, one line for each state.
fn witness(path: &WitnessReport) -> String {
    let does = if path.violates {
        "violates"
    } else {
        "satisfies"
    };
    let mut text = format!(
        "Most probable path that {does} it ({}):\n",
        path.probability
    );
    for (place, state) in path.states.iter().enumerate() {
        let action = path.actions.get(place).and_then(Option::as_ref);
        let action = action.map_or(String::new(), |action| format!("  [{action}]"));
        text.push_str(&format!("  {state}{action}\n"));
    }
    text
}

fn in_brackets(property: &PropertyReport) -> String {
    let mut parts = Vec::new();
    match (property.guarantee.as_deref(), property.low, property.high) {
        (Some("exact"), ..) => parts.push("exact".to_owned()),
        (Some(_), Some(low), Some(high)) => {
            parts.push(format!("between {} and {}", number(low), number(high)))
        }
        (Some("estimated"), ..) => parts.push("estimated".to_owned()),
        _ => {}
    }
    if let Some(complement) = property.complement
        && complement > 0.0
        && complement < 1e-6
    {
        parts.push(format!("1 - {complement:.6e}"));
    }
    parts.push(format!("{:.3} s", property.check_secs));
    format!(" ({})", parts.join("; "))
}

/// The lines of a certificate, for reading.
fn certificate(certificate: &CertificateReport) -> String {
    let mut line = format!("Certificate: {}", certificate.status);
    if let (Some(low), Some(high)) = (certificate.low, certificate.high) {
        line.push_str(&format!(
            ", between {} and {} ({} inequalities in {} states)",
            number(low),
            number(high),
            certificate.inequalities,
            certificate.states
        ));
    }
    if let Some(why) = &certificate.why {
        line.push_str(&format!(": {why}"));
    }
    line.push('\n');
    line
}
