//! Which tables a database has, where they begin, and their columns.

use super::record::{HeaderError, locate};
use super::{Damage, Pager, TableScan, Value};

/// A table with the names of its columns.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Table {
    pub(crate) name: String,
    /// The page at which it begins.
    pub(crate) root: u32,
    /// In the order of a row; in lower case, since SQL ignores it.
    pub(crate) columns: Vec<String>,
    /// The column that is the row's id and is stored as NULL.
    pub(crate) id_column: Option<usize>,
}

impl Table {
    /// The place of a column.
    pub(crate) fn column(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|column| column == name)
    }
}

/// A value that outlives its page.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Owned {
    Null,
    Integer(i64),
    Text(String),
    Other,
}

impl Owned {
    /// The text.
    pub(crate) fn text(&self) -> Option<&str> {
        match self {
            Owned::Text(text) => Some(text),
            _ => None,
        }
    }

    /// The whole number.
    pub(crate) fn integer(&self) -> Option<i64> {
        match self {
            Owned::Integer(value) => Some(*value),
            _ => None,
        }
    }
}

/// Small tables are read whole, up to this many bytes.
const MAX_TABLE_BYTES: u64 = 64 << 20;

/// The tables of the database.
pub(crate) fn tables(pager: &mut Pager, damages: &mut Vec<Damage>) -> Vec<Table> {
    rows(pager, 1, None, damages)
        .iter()
        .filter_map(|row| table(row))
        .collect()
}

/// A row of the schema: type, name, name of the table, first page, text in SQL.
fn table(row: &[Owned]) -> Option<Table> {
    let [kind, name, _, root, sql, ..] = row else {
        return None;
    };
    let root = u32::try_from(root.integer()?).ok()?;
    if kind.text()? != "table" {
        return None;
    }
    let (columns, id_column) = columns(sql.text()?)?;
    let name = name.text()?.to_ascii_lowercase();
    Some(Table {
        name,
        root,
        columns,
        id_column,
    })
}

/// All rows of a small table; the column `id_column` gets the row's id.
pub(crate) fn rows(
    pager: &mut Pager,
    root: u32,
    id_column: Option<usize>,
    damages: &mut Vec<Damage>,
) -> Vec<Vec<Owned>> {
    let mut scan = TableScan::new(root);
    let (mut all, mut bytes, mut total) = (Vec::new(), Vec::new(), 0);
    loop {
        let row = match scan.next(pager) {
            Ok(Some(row)) => row,
            Ok(None) => return all,
            Err(damage) => {
                damages.push(damage);
                continue;
            }
        };
        total += row.len;
        if total > MAX_TABLE_BYTES {
            let message = "a table of names and types is larger than 64 MiB; the rest is ignored";
            damages.push(Damage::new(row.offset, message));
            return all;
        }
        match scan
            .whole(&row, pager, &mut bytes)
            .and_then(|()| values(&bytes, pager, row.offset))
        {
            Ok(mut values) => {
                if let Some(value) = id_column.and_then(|column| values.get_mut(column)) {
                    *value = Owned::Integer(row.id);
                }
                all.push(values);
            }
            Err(damage) => damages.push(damage),
        }
    }
}

fn values(row: &[u8], pager: &Pager, offset: u64) -> Result<Vec<Owned>, Damage> {
    let mut fields = Vec::new();
    let wrong =
        |_: HeaderError| Damage::new(offset, "a row contradicts its own header and is lost");
    locate(row, row.len() as u64, &mut fields).map_err(wrong)?;
    let owned = |value: Option<Value<'_>>| match value {
        None | Some(Value::Null) => Owned::Null,
        Some(Value::Integer(value)) => Owned::Integer(value),
        Some(Value::Text(bytes)) => Owned::Text(pager.encoding().decode(bytes)),
        Some(Value::Real(_) | Value::Blob(_)) => Owned::Other,
    };
    Ok(fields.iter().map(|field| owned(field.value(row))).collect())
}

/// The names of the columns in `CREATE TABLE name (...)`, and which of them is the row's id.
/// `None` for what is no ordinary table.
fn columns(sql: &str) -> Option<(Vec<String>, Option<usize>)> {
    let tokens = tokens(sql);
    let (mut names, mut id_column) = (Vec::new(), None);
    for words in definitions(&tokens)? {
        let is = |index: usize, word: &str| {
            let other = words.get(index);
            other.is_some_and(|other| other.eq_ignore_ascii_case(word))
        };
        let constraints = ["constraint", "primary", "unique", "check", "foreign"];
        if words.is_empty() || constraints.iter().any(|word| is(0, word)) {
            continue;
        }
        if is(1, "integer") && is(2, "primary") && is(3, "key") && !is(4, "desc") {
            id_column = Some(names.len());
        }
        names.push(unquoted(words[0]).to_ascii_lowercase());
    }
    Some((names, id_column))
}

/// The words of each definition in the parentheses of `CREATE TABLE`, without those in inner ones.
/// `None` if they do not close, or the table has no row ids.
fn definitions(tokens: &[String]) -> Option<Vec<Vec<&str>>> {
    let open = tokens.iter().position(|token| token == "(")?;
    let mut definitions: Vec<Vec<&str>> = vec![Vec::new()];
    let mut depth = 1;
    let mut rest = &tokens[open + 1..];
    while depth > 0 {
        let (token, behind) = rest.split_first()?;
        rest = behind;
        match token.as_str() {
            "(" => depth += 1,
            ")" => depth -= 1,
            "," if depth == 1 => definitions.push(Vec::new()),
            word if depth == 1 => definitions.last_mut()?.push(word),
            _ => {}
        }
    }
    let has_ids = !rest.iter().any(|word| word.eq_ignore_ascii_case("without"));
    has_ids.then_some(definitions)
}

/// Words, quoted names with their quotes, and single signs; comments are dropped.
fn tokens(sql: &str) -> Vec<String> {
    let mut tokens = Vec::new();
    let mut rest = sql;
    while let Some(first) = rest.chars().next() {
        let len = match first {
            '"' | '`' | '\'' => quoted_len(rest, first),
            '[' => rest.find(']').map_or(rest.len(), |end| end + 1),
            '-' if rest.starts_with("--") => rest.find('\n').unwrap_or(rest.len()),
            '/' if rest.starts_with("/*") => rest.find("*/").map_or(rest.len(), |end| end + 2),
            c if is_word(c) => rest.find(|c| !is_word(c)).unwrap_or(rest.len()),
            c => c.len_utf8(),
        };
        let (token, behind) = rest.split_at(len);
        let is_comment = token.starts_with("--") || token.starts_with("/*");
        if !is_comment && !first.is_whitespace() {
            tokens.push(token.to_owned());
        }
        rest = behind;
    }
    tokens
}

fn is_word(c: char) -> bool {
    c.is_alphanumeric() || matches!(c, '_' | '$' | '.')
}

/// The length of a quoted name; a doubled quote stands for itself.
fn quoted_len(text: &str, quote: char) -> usize {
    let mut at = 1;
    loop {
        match text[at..].find(quote) {
            None => return text.len(),
            Some(found) if text[at + found + 1..].starts_with(quote) => at += found + 2,
            Some(found) => return at + found + 1,
        }
    }
}

fn unquoted(word: &str) -> String {
    let inside = |quote: char| {
        let inner = word.strip_prefix(quote)?.strip_suffix(quote)?;
        Some(inner.replace(&format!("{quote}{quote}"), &quote.to_string()))
    };
    let bracketed = || Some(word.strip_prefix('[')?.strip_suffix(']')?.to_owned());
    inside('"')
        .or_else(|| inside('`'))
        .or_else(bracketed)
        .unwrap_or_else(|| word.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_found_in_any_spelling() {
        let find = |sql| columns(sql).unwrap();
        let names = |names: &[&str]| {
            names
                .iter()
                .map(|name| (*name).to_owned())
                .collect::<Vec<_>>()
        };
        assert_eq!(
            find(
                "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL,timestamp INTEGER NOT NULL, data BLOB NOT NULL)"
            ),
            (names(&["id", "topic_id", "timestamp", "data"]), Some(0))
        );
        assert_eq!(
            find(
                "create table \"a,b\" (\"x y\" TEXT DEFAULT ',', -- a, b\n [Z] decimal(3,4), PRIMARY KEY (z))"
            ),
            (names(&["x y", "z"]), None)
        );
        assert_eq!(
            columns("CREATE TABLE t(a INT PRIMARY KEY) WITHOUT ROWID"),
            None
        );
        assert_eq!(columns("CREATE VIRTUAL TABLE t USING fts5"), None);
        assert_eq!(columns("CREATE TABLE t(a"), None);
    }
}
