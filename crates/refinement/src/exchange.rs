//! Two things of a text that change places: what was written down as each other.
//!
//! # Definition
//! * *Names*: two rows of a table `mode,...` get each other's name;
//! * *Occurrences*: two rows of a table `mode,occurrences,...` get each other's occurrences, and keep all else;
//! * *Headers*: two columns of a table get each other's header;
//! * *Codes*: in one column of a table two codes get each other's place;
//! * *Columns*: two propositions of a vocabulary count each other's column;
//! * *Entries*: two entries of a ledger get each other's files ([`FILES`]).
//!
//! # Assumes
//! Nothing of the data.
//!
//! # Guarantee
//! All else of the text stays as it is written. Made twice, an exchange gives the text that was there before.

use crate::toml_text::{Table, get, span_of, table_of, with_id};
use prism_lang::edit::{self, Edit};
use toml::de::{DeTable, DeValue};

/// The keys of an entry that name what it is made of.
const FILES: [&str; 9] = [
    "model",
    "tree",
    "events",
    "scenario",
    "parameters",
    "scene",
    "stimulus",
    "recordings",
    "tables",
];

/// What of a text changes places.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Exchange {
    /// The names of two rows.
    Names {
        /// The names.
        modes: [String; 2],
    },
    /// The occurrences of two rows.
    Occurrences {
        /// The rows' names.
        modes: [String; 2],
    },
    /// The headers of two columns.
    Headers {
        /// The headers.
        headers: [String; 2],
    },
    /// The cells of two columns, in some rows.
    InRows {
        /// The headers of the columns.
        headers: [String; 2],
        /// What stands in the first cell of the rows.
        rows: Vec<String>,
    },
    /// Two codes in a column.
    Codes {
        /// The column's header.
        header: String,
        /// The codes.
        codes: [String; 2],
    },
    /// The columns that two propositions count.
    Columns {
        /// The propositions.
        propositions: [String; 2],
    },
    /// The files of two entries of a ledger.
    Entries {
        /// The entries' identifiers.
        ids: [String; 2],
    },
}

impl Exchange {
    /// The text after the exchange.
    ///
    /// # Errors
    /// Why it cannot be made, in one sentence.
    pub fn make(&self, text: &str) -> Result<String, String> {
        let is_table = !matches!(self, Self::Columns { .. } | Self::Entries { .. });
        let (before, text) = match is_table {
            true => text.split_at(header_of(text)),
            false => ("", text),
        };
        Ok(before.to_owned() + &self.make_behind(text)?)
    }

    /// The text after the exchange, of a table from its header on.
    fn make_behind(&self, text: &str) -> Result<String, String> {
        match self {
            Self::Names { modes } => cells(text, modes, 0),
            Self::Occurrences { modes } => {
                let place = place_of(text, "occurrences")?;
                cells(text, modes, place)
            }
            Self::Headers { headers } => {
                let places = [place_of(text, &headers[0])?, place_of(text, &headers[1])?];
                // Without its end, which may be CR LF.
                let (first, rest) = text.split_at(text.lines().next().map_or(0, str::len));
                let mut all: Vec<&str> = first.split(',').collect();
                all.swap(places[0], places[1]);
                Ok(all.join(",") + rest)
            }
            Self::InRows { headers, rows } => in_rows(text, headers, rows),
            Self::Codes { header, codes } => self::codes(text, header, codes),
            Self::Columns { propositions } => columns(text, propositions),
            Self::Entries { ids } => entries(text, ids),
        }
    }
}

/// Where the header of a table begins, behind comments and empty lines.
fn header_of(text: &str) -> usize {
    let mut at = 0;
    for line in text.split_inclusive('\n') {
        let is_before = line.trim().is_empty() || line.trim_start().starts_with('#');
        if !is_before {
            return at;
        }
        at += line.len();
    }
    0
}

/// The place of a header in the first line.
fn place_of(text: &str, header: &str) -> Result<usize, String> {
    if text.contains('"') {
        return Err("the table has quoted cells".into());
    }
    let mut headers = text.lines().next().unwrap_or_default().split(',');
    headers
        .position(|own| own.trim() == header)
        .ok_or_else(|| format!("the table has no column `{header}`"))
}

/// The cells at a place of the rows of two names change places.
fn cells(text: &str, modes: &[String; 2], place: usize) -> Result<String, String> {
    let own = |line: &str, place: usize| line.split(',').nth(place).map(|it| it.trim().to_owned());
    let value = |mode: &String| {
        let mut rows = text.lines().skip(1);
        let row = rows.find(|line| own(line, 0).as_ref() == Some(mode));
        row.and_then(|line| own(line, place))
    };
    let (Some(first), Some(second)) = (value(&modes[0]), value(&modes[1])) else {
        let [one, other] = modes;
        return Err(format!("the table has no rows `{one}` and `{other}`"));
    };
    let mut changed = String::with_capacity(text.len());
    for (number, line) in text.split_inclusive('\n').enumerate() {
        let name = own(line, 0).filter(|_| number > 0);
        let new = match name {
            Some(name) if name == modes[0] => [&first, &second],
            Some(name) if name == modes[1] => [&second, &first],
            _ => {
                changed.push_str(line);
                continue;
            }
        };
        let mut all: Vec<String> = line.split(',').map(str::to_owned).collect();
        all[place] = all[place].replacen(new[0].as_str(), new[1], 1);
        changed.push_str(&all.join(","));
    }
    Ok(changed)
}

/// The cells of two columns change places in the rows of these names.
fn in_rows(text: &str, headers: &[String; 2], rows: &[String]) -> Result<String, String> {
    let places = [place_of(text, &headers[0])?, place_of(text, &headers[1])?];
    let mut missing: Vec<&String> = rows.iter().collect();
    let mut changed = String::with_capacity(text.len());
    for (number, line) in text.split_inclusive('\n').enumerate() {
        let body = line.trim_end_matches(['\n', '\r']);
        let mut cells: Vec<&str> = body.split(',').collect();
        let name = cells.first().map_or("", |it| it.trim());
        let is_wanted = number > 0 && rows.iter().any(|row| row == name);
        if !is_wanted || places.iter().any(|place| *place >= cells.len()) {
            changed.push_str(line);
            continue;
        }
        missing.retain(|row| *row != name);
        cells.swap(places[0], places[1]);
        changed.push_str(&cells.join(","));
        changed.push_str(&line[body.len()..]);
    }
    match missing.first() {
        Some(row) => Err(format!("the table has no row `{row}`")),
        None => Ok(changed),
    }
}

/// Two codes in the cells of a column change places.
fn codes(text: &str, header: &str, codes: &[String; 2]) -> Result<String, String> {
    let place = place_of(text, header)?;
    let other = |word: &str| match word {
        it if it == codes[0] => codes[1].clone(),
        it if it == codes[1] => codes[0].clone(),
        it => it.to_owned(),
    };
    let mut changed = String::with_capacity(text.len());
    for (number, line) in text.split_inclusive('\n').enumerate() {
        let ending = &line[line.trim_end_matches(['\r', '\n']).len()..];
        let mut all: Vec<String> = line
            .trim_end_matches(['\r', '\n'])
            .split(',')
            .map(str::to_owned)
            .collect();
        if let Some(cell) = all.get_mut(place).filter(|_| number > 0) {
            let words: Vec<String> = cell.split(' ').map(other).collect();
            *cell = words.join(" ");
        }
        changed.push_str(&all.join(","));
        changed.push_str(ending);
    }
    Ok(changed)
}

/// The columns of two propositions of a vocabulary change places.
fn columns(text: &str, propositions: &[String; 2]) -> Result<String, String> {
    let document = DeTable::parse(text).map_err(|error| error.to_string())?;
    let place = |name: &String| {
        let table = table_of(document.get_ref(), name);
        let value = table.and_then(|table| get(table, "column"));
        value
            .map(span_of)
            .ok_or_else(|| format!("`{name}` of the vocabulary has no column"))
    };
    let [one, other] = [place(&propositions[0])?, place(&propositions[1])?];
    let written = |at: prism_lang::Span| text[at.start..at.end].to_owned();
    let edits = [
        Edit::replace(one, written(other)),
        Edit::replace(other, written(one)),
    ];
    edit::apply(text, &edits).map_err(|error| error.to_string())
}

/// Two entries of a ledger get each other's files, key by key.
fn entries(text: &str, ids: &[String; 2]) -> Result<String, String> {
    let document = DeTable::parse(text).map_err(|error| error.to_string())?;
    let files = |id: &String| {
        let entry = with_id(document.get_ref(), &["evidence"], id);
        let entry = entry.ok_or_else(|| format!("the ledger has no entry `{id}`"))?;
        let mut found = Vec::new();
        for key in FILES {
            if let Some(value) = get(entry, key) {
                leaves(key, value, &mut found);
            }
        }
        Ok::<_, String>(found)
    };
    let [one, other] = [files(&ids[0])?, files(&ids[1])?];
    let keys = |of: &[(String, prism_lang::Span)]| -> Vec<String> {
        of.iter().map(|(key, _)| key.clone()).collect()
    };
    if keys(&one) != keys(&other) || one.is_empty() {
        let [one, other] = ids;
        return Err(format!(
            "`{one}` and `{other}` do not name their files by the same keys"
        ));
    }
    let mut edits = Vec::new();
    for ((_, of_one), (_, of_other)) in one.into_iter().zip(other) {
        let written = |at: prism_lang::Span| text[at.start..at.end].to_owned();
        edits.push(Edit::replace(of_one, written(of_other)));
        edits.push(Edit::replace(of_other, written(of_one)));
    }
    edit::apply(text, &edits).map_err(|error| error.to_string())
}

/// The values below a key, each with its own key and its place, in the order of the keys.
fn leaves(
    key: &str,
    value: &toml::Spanned<DeValue<'_>>,
    found: &mut Vec<(String, prism_lang::Span)>,
) {
    match value.get_ref() {
        DeValue::Table(table) => {
            let table: &Table<'_> = table;
            for (name, value) in table.iter() {
                leaves(&format!("{key}.{}", name.get_ref()), value, found);
            }
        }
        _ => found.push((key.to_owned(), span_of(value))),
    }
}

#[cfg(test)]
mod tests {
    use super::Exchange;

    fn pair(one: &str, other: &str) -> [String; 2] {
        [one.to_owned(), other.to_owned()]
    }

    /// Made once it is this, made twice the text itself.
    fn gives(exchange: &Exchange, text: &str, wanted: &str) {
        let made = exchange.make(text).expect("it can be made");
        assert_eq!(made, wanted);
        assert_eq!(exchange.make(&made).as_deref(), Ok(text));
    }

    #[test]
    fn cells_change_places_in_the_rows_that_are_named() {
        let text = "requirement,covered,passed,failed\na,9,8,1\r\nb,9, 2,7\n";
        let wanted = "requirement,covered,passed,failed\na,9,8,1\r\nb,9,7, 2\n";
        let of = |row: &str| Exchange::InRows {
            headers: pair("passed", "failed"),
            rows: vec![row.to_owned()],
        };
        gives(&of("b"), text, wanted);
        assert!(of("c").make(text).is_err());
    }

    #[test]
    fn rows_get_each_others_name_or_each_others_occurrences() {
        let text = "mode,occurrences,opportunities\nslip,7,98\ngaze, 3,90\nslip_late,1,9\n";
        let modes = pair("slip", "gaze");
        let swapped = "mode,occurrences,opportunities\ngaze,7,98\nslip, 3,90\nslip_late,1,9\n";
        gives(
            &Exchange::Names {
                modes: modes.clone(),
            },
            text,
            swapped,
        );
        let swapped = "mode,occurrences,opportunities\nslip,3,98\ngaze, 7,90\nslip_late,1,9\n";
        gives(&Exchange::Occurrences { modes }, text, swapped);
        let missing = Exchange::Names {
            modes: pair("slip", "none"),
        };
        assert!(missing.make(text).is_err());
    }

    #[test]
    fn columns_get_each_others_header_and_codes_each_others_place() {
        let text = "person,ok,attempts,n_slip,n_gaze\n1,6,10,3,1\n";
        let headers = pair("n_slip", "n_gaze");
        let swapped = "person,ok,attempts,n_gaze,n_slip\n1,6,10,3,1\n";
        let cr_lf = |text: &str| text.replace('\n', "\r\n");
        let exchange = Exchange::Headers { headers };
        gives(&exchange, text, swapped);
        gives(&exchange, &cr_lf(text), &cr_lf(swapped));
        // Comments and empty lines may stand before the header.
        let commented = |text: &str| format!("# by day, \"as it was\"\n\n{text}");
        gives(&exchange, &commented(text), &commented(swapped));
        let text = "person,codes,attempts\n1,G2 S0 G2,10\n2,,10\n3,S0,9\n";
        let exchange = Exchange::Codes {
            header: "codes".into(),
            codes: pair("G2", "S0"),
        };
        let swapped = "person,codes,attempts\n1,S0 G2 S0,10\n2,,10\n3,G2,9\n";
        gives(&exchange, text, swapped);
        // A cell with a comma of its own could not be told from two cells.
        assert!(exchange.make("a,codes\n\"x,y\",G2\n").is_err());
    }

    #[test]
    fn propositions_count_each_others_column() {
        let text = "[a]\nmeaning = \"A.\"\ncolumn = \"n_b\"\n\n[b]\ncolumn = 'codes: A'\n[c]\nmodel = \"s=1\"\n";
        let swapped = "[a]\nmeaning = \"A.\"\ncolumn = 'codes: A'\n\n[b]\ncolumn = \"n_b\"\n[c]\nmodel = \"s=1\"\n";
        let exchange = |one, other| Exchange::Columns {
            propositions: pair(one, other),
        };
        gives(&exchange("a", "b"), text, swapped);
        assert!(exchange("a", "c").make(text).is_err());
    }
    #[test]
    fn entries_get_each_others_files() {
        let text = "[[evidence]]\nid = \"T1\"\nconditions = \"calm\"\ntables = { cohort = \"a.csv\", requirements = 'b.csv' }\n\n\
                    [[evidence]]\nid = \"T2\"\ntables.cohort = \"c.csv\"\ntables.requirements = \"d.csv\"\n";
        let swapped = "[[evidence]]\nid = \"T1\"\nconditions = \"calm\"\ntables = { cohort = \"c.csv\", requirements = \"d.csv\" }\n\n\
                       [[evidence]]\nid = \"T2\"\ntables.cohort = \"a.csv\"\ntables.requirements = 'b.csv'\n";
        let exchange = |one, other| Exchange::Entries {
            ids: pair(one, other),
        };
        gives(&exchange("T1", "T2"), text, swapped);
        assert!(exchange("T1", "T3").make(text).is_err());
        let other = format!("{text}\n[[evidence]]\nid = \"T3\"\ntables.cohort = \"e.csv\"\n");
        assert!(exchange("T1", "T3").make(&other).is_err());
    }
}
