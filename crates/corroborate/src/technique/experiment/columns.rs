//! Which columns a cohort may lack.
//!
//! # Definition
//! The tables of one study may count different things: one campaign what was dropped, another how long people waited. A column by
//! which something is counted is *left to others* where this cohort lacks it, has another one by which something is counted, and
//! another cohort of the ledger has it. What is counted by it is then not covered here.
//!
//! A column is *unread* if it may count something, since it has whole numbers that are nowhere more than the attempts, and no word of the
//! vocabulary is bound to it. It is said, since it changes nothing.
//!
//! # Assumes
//! That a table without a column did not count it, where another table of the study has it.
//!
//! # Guarantee
//! A column that no cohort of the study has is a mistake, of the table or of the vocabulary, and so is a cohort that counts nothing: a
//! misspelt header never turns trials into silence.

use std::collections::BTreeSet;
use study::Study;
use trace::Table;

/// The bindings by which experiments count something, each once.
pub(super) fn bindings(study: &Study) -> BTreeSet<&str> {
    let propositions = study.forms.subjects.iter().filter_map(|form| {
        let proposition = study
            .vocabulary
            .propositions
            .get(form.experiment.as_ref()?)?;
        Some(proposition.column.as_ref()?.text.as_str())
    });
    propositions.collect()
}

/// The bindings whose columns this cohort leaves to others.
pub(super) fn left_to_others(study: &Study, table: &Table) -> BTreeSet<String> {
    let has = |headers: &[String], binding: &str| {
        let wanted = header(binding);
        headers.iter().any(|header| header == wanted)
    };
    let (own, lacking): (Vec<&str>, Vec<&str>) = bindings(study)
        .into_iter()
        .partition(|binding| has(table.headers(), binding));
    if own.is_empty() || lacking.is_empty() {
        return BTreeSet::new();
    }
    // A table that cannot be read is the mistake of its own entry.
    let cohorts = super::repeated::tables(study).unwrap_or_default();
    let elsewhere = |binding: &&str| cohorts.iter().any(|it| has(it.table.headers(), binding));
    let left = lacking.into_iter().filter(elsewhere);
    left.map(str::to_owned).collect()
}

impl super::Tables {
    /// The columns of the table by person or session that may count something and that no word is bound to.
    pub(crate) fn unread_columns(&self, study: &Study) -> Vec<String> {
        let Some(cohort) = self.cohort.as_ref().filter(|_| self.speaks_of.is_none()) else {
            return Vec::new();
        };
        let words = study.vocabulary.propositions.values();
        let bound: BTreeSet<&str> = words
            .filter_map(|word| Some(header(&word.column.as_ref()?.text)))
            .collect();
        // The first names the people.
        let columns = cohort
            .table
            .columns()
            .skip(1)
            .filter(|column| column.header() != "attempts" && !bound.contains(column.header()));
        let may_count = |column: &trace::Column<'_>| {
            column.as_counts().is_ok_and(|counts| {
                let mut both = counts.iter().zip(&cohort.attempts);
                both.all(|(count, attempts)| count <= attempts) && counts.iter().any(|it| *it > 0)
            })
        };
        columns
            .filter(may_count)
            .map(|column| column.header().to_owned())
            .collect()
    }
}

/// The header of the column that a binding names: `failures` of `failures: drop`.
pub(super) fn header(binding: &str) -> &str {
    binding.split_once(':').map_or(binding, |it| it.0).trim()
}
