//! The columns of a table, and where their values stand.

use super::Damage;
use super::thrift::Item;

/// How deep a column may lie.
const DEEPEST: usize = 64;

/// A column that holds values.
#[derive(Debug, Clone)]
pub(super) struct Leaf {
    /// Names from the outermost on.
    pub(super) path: Vec<String>,
    /// Its physical type's number.
    pub(super) kind: i64,
    /// The level at which a value is there.
    pub(super) defined: u16,
    /// How many lists it lies in.
    pub(super) repeated: u16,
}

/// Where a column's values of one row group stand.
#[derive(Debug, Clone)]
pub(super) struct Chunk {
    pub(super) start: usize,
    pub(super) end: usize,
    pub(super) codec: i64,
    pub(super) values: usize,
}

/// Rows of a table that are stored together.
#[derive(Debug, Clone)]
pub(super) struct Group {
    pub(super) rows: usize,
    /// One for each leaf, in their order.
    pub(super) chunks: Vec<Chunk>,
}

fn lacks(what: &str) -> Damage {
    Damage::new(format!("the footer lacks {what}"))
}

/// The columns out of the footer's flat list, in which each element says how many children follow.
pub(super) fn leaves(footer: &Item<'_>) -> Result<Vec<Leaf>, Damage> {
    let elements = footer.list(2).ok_or_else(|| lacks("the schema"))?;
    let mut leaves = Vec::new();
    // For each open group: its children that are to come, its name, its levels.
    let mut open: Vec<(usize, String, u16, u16)> = Vec::new();
    for (at, element) in elements.iter().enumerate() {
        while open.last().is_some_and(|it| it.0 == 0) {
            open.pop();
        }
        let name = element.text(4).ok_or_else(|| lacks("a column's name"))?;
        let (_, _, mut defined, mut repeated) = open.last().cloned().unwrap_or_default();
        if at > 0 {
            let parent = open
                .last_mut()
                .ok_or_else(|| lacks("the parent of a column"))?;
            parent.0 -= 1;
            let repetition = element.int(3).unwrap_or(0);
            defined += u16::from(repetition != 0);
            repeated += u16::from(repetition == 2);
        }
        match element.int(1) {
            Some(kind) if at > 0 => {
                let mut path: Vec<String> = open.iter().skip(1).map(|it| it.1.clone()).collect();
                path.push(name);
                leaves.push(Leaf {
                    path,
                    kind,
                    defined,
                    repeated,
                });
            }
            _ => {
                let children = element.count(5).unwrap_or(0);
                if open.len() > DEEPEST {
                    return Err(Damage::new("columns lie too deep within each other"));
                }
                open.push((children, name, defined, repeated));
            }
        }
    }
    match open.iter().all(|it| it.0 == 0) {
        true => Ok(leaves),
        false => Err(lacks("columns that the schema announces")),
    }
}

/// The row groups, each chunk within the file.
pub(super) fn groups(
    footer: &Item<'_>,
    leaves: &[Leaf],
    file: usize,
) -> Result<Vec<Group>, Damage> {
    let listed = footer.list(4).ok_or_else(|| lacks("the row groups"))?;
    let group = |group: &Item<'_>| {
        let rows = group
            .count(3)
            .ok_or_else(|| lacks("the number of rows of a group"))?;
        let columns = group.list(1).unwrap_or_default();
        if columns.len() != leaves.len() {
            let (has, wanted) = (columns.len(), leaves.len());
            return Err(Damage::new(format!(
                "a row group has {has} columns, and the schema has {wanted}"
            )));
        }
        let chunks = columns
            .iter()
            .zip(leaves)
            .map(|(column, leaf)| chunk(column, leaf, file));
        Ok(Group {
            rows,
            chunks: chunks.collect::<Result<_, _>>()?,
        })
    };
    listed.iter().map(group).collect()
}

fn chunk(column: &Item<'_>, leaf: &Leaf, file: usize) -> Result<Chunk, Damage> {
    if column.field(1).is_some() {
        return Err(Damage::new("a column's values are in another file").of(leaf));
    }
    let meta = column
        .field(3)
        .ok_or_else(|| lacks("what is said of a column's values"))?;
    let number = |at: i16, what: &str| meta.count(at).ok_or_else(|| lacks(what).of(leaf));
    let data = number(9, "the place of a column's values")?;
    // Some writers say 0 where there is none.
    let dictionary = meta.count(11).filter(|it| *it > 0);
    let start = dictionary.map_or(data, |it| it.min(data));
    let end = start.saturating_add(number(7, "the size of a column's values")?);
    if end > file {
        let message = format!("its values end at byte {end}, and the file at byte {file}");
        return Err(Damage::new(message).of(leaf));
    }
    Ok(Chunk {
        start,
        end,
        codec: meta.int(4).unwrap_or(0),
        values: number(5, "the number of a column's values")?,
    })
}
