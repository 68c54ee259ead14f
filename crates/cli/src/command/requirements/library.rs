//! Ready requirements, as text for people.

use corroborate::requirements::LibraryReport;
use std::fmt::Write;

/// The templates, with what each needs.
pub fn text(report: &LibraryReport) -> String {
    let mut out = String::new();
    for template in &report.templates {
        // Writing to a String cannot fail.
        let _ = writeln!(
            out,
            "{}\n  {} ({})\n  {}",
            template.id, template.title, template.standard, template.sentence
        );
        for parameter in &template.parameters {
            let value = parameter.default.as_deref().unwrap_or("to be given");
            let _ = writeln!(
                out,
                "    {} = {value} ({} to {}): {}",
                parameter.name, parameter.least, parameter.most, parameter.meaning
            );
        }
        for need in &template.needs {
            let unit = need
                .unit
                .as_ref()
                .map_or(String::new(), |u| format!(" [{u}]"));
            let frame = need
                .frame
                .as_ref()
                .map_or(String::new(), |f| format!(", in {f}"));
            let _ = writeln!(
                out,
                "    binds {}{unit}{frame}: {}",
                need.name, need.meaning
            );
        }
        out.push('\n');
    }
    out.push_str(
        "Use one with `template = \"ID\"` in requirements.toml; declare its parameters in \
         parameters.toml and bind its names in vocabulary.toml.\n",
    );
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_committed_schema_is_the_form_that_is_printed() {
        let schema: serde_json::Value = schemars::schema_for!(LibraryReport).into();
        crate::command::tests::assert_schema_is_committed("library.schema.json", &schema);
    }
}
