//! Answers as tables, in the forms of PRISM's `-exportresults`.
//!
//! ```text
//! (none)      columns separated by tabs, one table for each property
//! csv         the same separated by commas
//! matrix      the last two constants as rows and columns
//! dataframe   one table for all properties, separated by commas
//! comment     lines `// RESULT (N=1): 0.5`, as test files have them
//! ```

use crate::export::Output;
use crate::report::{CheckReport, PropertyReport};
use diagnostic::Problem;
use std::path::Path;

/// How a table is written.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Shape {
    List,
    Matrix,
    DataFrame,
    Comment,
}

/// A property with all its answers, each with the values of constants.
struct Table<'a> {
    heading: String,
    name: String,
    constants: Vec<&'a str>,
    rows: Vec<(Vec<&'a str>, String)>,
}

/// Writes the answers to `FILE[:form]`.
pub(crate) fn write(file: &str, report: &CheckReport, output: Output<'_>) -> Result<(), Problem> {
    let (path, options) = file.rsplit_once(':').unwrap_or((file, ""));
    let (mut shape, mut separator) = (Shape::List, "\t");
    for option in options.split(',').filter(|o| !o.is_empty()) {
        match option {
            "csv" => separator = ",",
            "matrix" => shape = Shape::Matrix,
            "dataframe" => (shape, separator) = (Shape::DataFrame, ","),
            "comment" => shape = Shape::Comment,
            other => {
                let message = format!("results cannot be written in the form `{other}`");
                return Err(Problem::new("bad-form", message)
                    .remedy("the forms are csv, matrix, dataframe and comment"));
            }
        }
    }
    let tables = tables(report);
    let text = match shape {
        Shape::DataFrame => data_frame(&tables),
        _ => {
            let alone = tables.len() == 1;
            let each = tables
                .iter()
                .map(|table| table.text(shape, separator, alone));
            each.collect::<Vec<_>>().join("\n")
        }
    };
    output.write(Path::new(path), text.as_bytes())
}

fn tables(report: &CheckReport) -> Vec<Table<'_>> {
    let mut tables: Vec<(usize, Table<'_>)> = Vec::new();
    for property in &report.properties {
        let pairs: Vec<(&str, &str)> = (property.constants.iter())
            .flat_map(|values| values.split(','))
            .filter_map(|pair| pair.split_once('='))
            .collect();
        let row = (
            pairs.iter().map(|(_, value)| *value).collect(),
            result(property),
        );
        match tables
            .iter_mut()
            .find(|(place, _)| *place == property.prop_idx)
        {
            Some((_, table)) => table.rows.push(row),
            None => tables.push((
                property.prop_idx,
                Table {
                    heading: match &property.name {
                        Some(name) => format!("\"{name}\": {}", property.property),
                        None => property.property.clone(),
                    },
                    name: (property.name.clone())
                        .unwrap_or_else(|| format!("Property_{}", property.prop_idx)),
                    constants: pairs.iter().map(|(name, _)| *name).collect(),
                    rows: vec![row],
                },
            )),
        }
    }
    tables.into_iter().map(|(_, table)| table).collect()
}

fn result(property: &PropertyReport) -> String {
    match (&property.result, &property.error) {
        (Some(result), _) => result.clone(),
        (None, error) => format!("Error: {}", error.as_deref().unwrap_or("no answer")),
    }
}

impl Table<'_> {
    fn text(&self, shape: Shape, separator: &str, alone: bool) -> String {
        let csv = separator == ",";
        if shape == Shape::Comment {
            return self.comment(alone);
        }
        let mut text = String::new();
        if !alone {
            let heading = if csv {
                quoted(&self.heading)
            } else {
                format!("{}:", self.heading)
            };
            text.push_str(&format!("{heading}\n"));
        }
        text.push_str(&match shape {
            Shape::Matrix => self.matrix(separator),
            _ => self.list(separator),
        });
        text
    }

    fn list(&self, separator: &str) -> String {
        let cell = |text: &str| {
            if separator == "," {
                quoted(text)
            } else {
                text.to_owned()
            }
        };
        let mut head: Vec<&str> = self.constants.clone();
        head.push("Result");
        let mut text = format!("{}\n", head.join(separator));
        for (values, result) in &self.rows {
            let mut cells: Vec<String> = values.iter().map(|value| (*value).to_owned()).collect();
            cells.push(cell(result));
            text.push_str(&format!("{}\n", cells.join(separator)));
        }
        text
    }

    fn comment(&self, alone: bool) -> String {
        let mut text = String::new();
        for (values, result) in &self.rows {
            let pairs = self.constants.iter().zip(values);
            let pairs: Vec<String> = pairs
                .map(|(name, value)| format!("{name}={value}"))
                .collect();
            let of = match pairs.is_empty() {
                true => String::new(),
                false => format!(" ({})", pairs.join(",")),
            };
            text.push_str(&format!("// RESULT{of}: {result}\n"));
        }
        if !alone {
            text.push_str(&format!("{}\n", self.heading));
        }
        text
    }

    /// The last constant along the columns, the one before along the rows, a block for each value of the others.
    fn matrix(&self, separator: &str) -> String {
        let depth = self.constants.len();
        let Some(last) = depth.checked_sub(1) else {
            return self
                .rows
                .iter()
                .map(|(_, result)| format!("{result}\n"))
                .collect();
        };
        let outer = depth.saturating_sub(2);
        let mut text = String::new();
        for block in self.rows.chunk_by(|a, b| a.0[..outer] == b.0[..outer]) {
            if !text.is_empty() {
                text.push('\n');
            }
            let fixed = self.constants[..outer].iter().zip(&block[0].0);
            let fixed: Vec<String> = fixed
                .map(|(name, value)| format!("{name}={value}"))
                .collect();
            let mut heading = fixed.join(", ");
            if !heading.is_empty() {
                heading.push_str(", ");
            }
            heading.push_str(&self.constants[outer..].join("\\"));
            text.push_str(&match separator {
                "," => format!("\"{heading}\"\n"),
                _ => format!("{heading}:\n"),
            });
            text.push_str(&grid(block, last, separator));
        }
        text
    }
}

fn grid(block: &[(Vec<&str>, String)], last: usize, separator: &str) -> String {
    let by_row =
        |(values, _): &(Vec<&str>, String)| last.checked_sub(1).map(|at| values[at].to_owned());
    let lines: Vec<_> = block.chunk_by(|a, b| by_row(a) == by_row(b)).collect();
    let mut text = String::new();
    if last > 0 {
        text.push_str(separator);
    }
    let columns: Vec<&str> = lines[0].iter().map(|(values, _)| values[last]).collect();
    text.push_str(&format!("{}\n", columns.join(separator)));
    for line in lines {
        if let Some(head) = by_row(&line[0]) {
            text.push_str(&format!("{head}{separator}"));
        }
        let cells: Vec<&str> = line.iter().map(|(_, result)| result.as_str()).collect();
        text.push_str(&format!("{}\n", cells.join(separator)));
    }
    text
}

fn data_frame(tables: &[Table<'_>]) -> String {
    let mut names: Vec<&str> = Vec::new();
    for name in tables.iter().flat_map(|table| &table.constants) {
        if !names.contains(name) {
            names.push(name);
        }
    }
    let mut head = vec!["Property"];
    head.extend(&names);
    head.push("Result");
    let mut text = format!("{}\n", head.join(","));
    for table in tables {
        for (values, result) in &table.rows {
            let value = |name: &&str| {
                let place = table.constants.iter().position(|own| own == name);
                place.map_or("", |place| values[place])
            };
            let mut cells = vec![table.name.clone()];
            cells.extend(names.iter().map(|name| value(name).to_owned()));
            cells.push(quoted(result));
            text.push_str(&format!("{}\n", cells.join(",")));
        }
    }
    text
}

/// A cell of a table with commas, in quotes where it needs them.
fn quoted(text: &str) -> String {
    match text.contains([',', '"', '\n']) {
        true => format!("\"{}\"", text.replace('"', "\"\"")),
        false => text.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows() -> Table<'static> {
        let row = |a, b, r: &str| (vec![a, b], r.to_owned());
        Table {
            heading: "\"p\": P=? [ F s=x ]".into(),
            name: "p".into(),
            constants: vec!["N", "x"],
            rows: vec![
                row("1", "5", "a"),
                row("1", "6", "b"),
                row("2", "5", "c"),
                row("2", "6", "d"),
            ],
        }
    }

    #[test]
    fn tables_have_the_forms_of_prism() {
        let table = rows();
        assert_eq!(
            table.text(Shape::List, ",", true),
            "N,x,Result\n1,5,a\n1,6,b\n2,5,c\n2,6,d\n"
        );
        assert_eq!(
            table.text(Shape::Matrix, "\t", true),
            "N\\x:\n\t5\t6\n1\ta\tb\n2\tc\td\n"
        );
        let comments = "// RESULT (N=1,x=5): a\n// RESULT (N=1,x=6): b\n// RESULT (N=2,x=5): c\n// RESULT (N=2,x=6): d\n";
        assert_eq!(table.text(Shape::Comment, "\t", true), comments);
        let frame = data_frame(&[table]);
        assert!(
            frame.starts_with("Property,N,x,Result\np,1,5,a\n"),
            "{frame}"
        );
        assert_eq!(quoted("\"p\": a"), "\"\"\"p\"\": a\"");
    }
}
