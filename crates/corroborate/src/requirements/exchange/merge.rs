//! Which side was edited, field by field.

use super::record::{self, hash};
use requirement_files::{Document, Field, Item};
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};

/// Whose value counts where both sides were edited.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Take {
    /// The study's.
    Study,
    /// The file's.
    File,
}

/// Where to values are carried.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Direction {
    /// To the study.
    Import,
    /// To the file.
    Export,
}

impl Direction {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Import => "import",
            Self::Export => "export",
        }
    }
}

/// A field whose values differ, or did.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Edited {
    /// The requirement.
    pub id: String,
    /// The field: `text`, `rationale`, `status` or `parents`.
    pub field: String,
    /// Its value in the study.
    pub in_study: String,
    /// Its value in the file.
    pub in_file: String,
}

/// What comes of both sides.
#[derive(Debug, Default)]
pub(super) struct Merged {
    pub(super) added: Vec<Item>,
    pub(super) changed: Vec<Edited>,
    pub(super) waiting: Vec<Edited>,
    pub(super) conflicts: Vec<Edited>,
    pub(super) removed_from_file: Vec<String>,
    pub(super) removed_from_study: Vec<String>,
    pub(super) only_in_target: Vec<String>,
    pub(super) kept_elsewhere: Vec<String>,
    pub(super) same: usize,
    /// What both agree on afterwards: of each requirement, the hashes of its fields.
    pub(super) agreed: BTreeMap<String, BTreeMap<String, String>>,
}

impl Merged {
    /// The fields that are carried over, by requirement.
    pub(super) fn fields_by_id(&self) -> Vec<(&str, Vec<Field>)> {
        let mut by_id: Vec<(&str, Vec<Field>)> = Vec::new();
        for edited in &self.changed {
            let Some(field) = Field::ALL.into_iter().find(|it| it.name() == edited.field) else {
                continue;
            };
            match by_id.iter_mut().find(|(id, _)| *id == edited.id) {
                Some((_, fields)) => fields.push(field),
                None => by_id.push((&edited.id, vec![field])),
            }
        }
        by_id
    }
}

/// Compares both sides with what they agreed on last.
pub(super) fn merged(
    direction: Direction,
    own: &[Item],
    document: &Document,
    last: Option<&record::File>,
    elsewhere: &BTreeSet<String>,
    take: Option<Take>,
    only: &[String],
) -> Merged {
    let mut merged = Merged::default();
    let is_meant = |id: &str| only.is_empty() || only.iter().any(|it| it == id);
    let theirs = |id: &str| document.item(id).map(|placed| &placed.item);
    if let Some(last) = last {
        merged.agreed.clone_from(&last.requirements);
    }
    for item in own.iter().filter(|item| is_meant(&item.id)) {
        match theirs(&item.id) {
            Some(other) => {
                let before = last.and_then(|it| it.requirements.get(&item.id));
                merged.both(direction, item, other, &document.fields, before, take);
            }
            None if merged.agreed.contains_key(&item.id) => {
                merged.removed_from_file.push(item.id.clone());
            }
            None if direction == Direction::Import => merged.only_in_target.push(item.id.clone()),
            None if elsewhere.contains(&item.id) && only.is_empty() => {
                merged.kept_elsewhere.push(item.id.clone());
            }
            None => merged.add(item, &document.fields),
        }
    }
    let placed = document.items.iter().map(|placed| &placed.item);
    for item in placed.filter(|item| is_meant(&item.id)) {
        if own.iter().any(|it| it.id == item.id) {
            continue;
        }
        if merged.agreed.contains_key(&item.id) {
            merged.removed_from_study.push(item.id.clone());
        } else if direction == Direction::Export {
            merged.only_in_target.push(item.id.clone());
        } else {
            merged.add(item, &document.fields);
        }
    }
    merged
}

impl Merged {
    fn add(&mut self, item: &Item, fields: &[Field]) {
        let hashes = fields
            .iter()
            .map(|field| (field.name().to_owned(), hash(&item.value(*field))));
        self.agreed.insert(item.id.clone(), hashes.collect());
        self.added.push(item.clone());
    }

    /// A requirement that both sides have.
    fn both(
        &mut self,
        direction: Direction,
        own: &Item,
        other: &Item,
        fields: &[Field],
        before: Option<&BTreeMap<String, String>>,
        take: Option<Take>,
    ) {
        let mut agreed = before.cloned().unwrap_or_default();
        let mut is_same = true;
        for field in fields {
            let (in_study, in_file) = (own.value(*field), other.value(*field));
            let name = field.name().to_owned();
            if in_study == in_file {
                agreed.insert(name, hash(&in_study));
                continue;
            }
            is_same = false;
            let (study_hash, file_hash) = (hash(&in_study), hash(&in_file));
            let last = agreed.get(&name);
            // A field that is empty where both never agreed on it was not edited.
            let study_edited = match last {
                Some(last) => *last != study_hash,
                None => !in_study.is_empty(),
            };
            let file_edited = match last {
                Some(last) => *last != file_hash,
                None => !in_file.is_empty(),
            };
            let edited = Edited {
                id: own.id.clone(),
                field: name.clone(),
                in_study,
                in_file,
            };
            let goes_to_study = match (study_edited, file_edited, take) {
                (false, true, _) | (true, true, Some(Take::File)) => true,
                (true, false, _) | (true, true, Some(Take::Study)) => false,
                _ => {
                    self.conflicts.push(edited);
                    continue;
                }
            };
            if goes_to_study == (direction == Direction::Import) {
                agreed.insert(name, if goes_to_study { file_hash } else { study_hash });
                self.changed.push(edited);
            } else {
                // The side that is left counts as the one on which both agreed, so that the other direction carries it over.
                agreed.insert(name, if goes_to_study { study_hash } else { file_hash });
                self.waiting.push(edited);
            }
        }
        self.same += usize::from(is_same);
        self.agreed.insert(own.id.clone(), agreed);
    }
}
