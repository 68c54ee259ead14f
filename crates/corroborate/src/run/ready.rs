//! A study whose every entry was read, compiled and hashed: what a run and a plan begin with.

use super::counted::counted_constants;
use super::prepare::{Opened, all_assets, prepare, untils};
use crate::corroboration::{self, Piece};
use crate::technique::campaign::Until;
use crate::technique::{CountedConstant, Produced, Techniques};
use diagnostic::Problem;
use evidence::{Asset, Evidence, Look};
use host::Host;
use host::store::Inputs;
use std::collections::BTreeMap;
use study::{Entry, Study};

/// The file that keeps the result of comparing, with the hash of what it was compared from.
pub(crate) const COMPARISON: &str = "comparison.json";

/// The file that keeps what was produced for an entry.
pub(crate) fn evidence_file(id: &str) -> String {
    format!("evidence/{id}.json")
}

/// A study, ready to be run.
pub(crate) struct Ready<'a> {
    pub(crate) study: &'a Study,
    pub(crate) host: &'a Host,
    /// What each entry needs, in the order of the ledger.
    pub(super) prepared: Vec<Opened<'a>>,
    /// What each entry rests on.
    assets: BTreeMap<&'a str, Vec<Asset>>,
    /// The stopping rules of entries that have one.
    pub(super) untils: BTreeMap<&'a str, Until>,
}

impl<'a> Ready<'a> {
    /// Reads, compiles and hashes all that the study names.
    pub(crate) fn new(
        study: &'a Study,
        others: &Techniques,
        host: &'a Host,
    ) -> Result<Self, Problem> {
        let prepared = prepare(study, others, host)?;
        let untils = untils(study)?;
        // Hashed before anything runs, so that an edit meanwhile is not taken for what was run.
        let assets = all_assets(study, &prepared)?;
        Ok(Self {
            study,
            host,
            prepared,
            assets,
            untils,
        })
    }

    /// The entries with what they need.
    pub(crate) fn entries(&self) -> impl Iterator<Item = (&'a Entry, &Opened<'a>)> {
        self.study.ledger.iter().zip(&self.prepared)
    }

    /// Which program computes.
    pub(super) fn program(&self) -> &str {
        self.host.build.as_str()
    }

    /// What an entry rests on.
    pub(crate) fn assets(&self, entry: &Entry) -> &[Asset] {
        self.assets
            .get(entry.id.as_str())
            .map_or(&[], Vec::as_slice)
    }

    /// The constants of an entry's model whose counts are uncertain.
    pub(crate) fn counted(
        &self,
        entry: &Entry,
        prepared: &Opened<'_>,
        before: &[Piece],
    ) -> Result<Vec<CountedConstant>, Problem> {
        let value_of = |name: &str| prepared.work.constant(name);
        counted_constants(self.study, entry, before, &value_of)
    }

    /// The hash of everything that an entry's findings depend on.
    pub(crate) fn inputs(
        &self,
        entry: &Entry,
        prepared: &Opened<'_>,
        counted: &[CountedConstant],
    ) -> Result<String, Problem> {
        let mut inputs = Inputs::default();
        inputs
            .add("program", self.program().as_bytes())
            .add("evidence", entry.id.as_bytes())
            .add_json("confidence", &self.study.about.confidence)
            // Whatever a technique says or forgets to say of its own keys.
            .add_json("work", &entry.work);
        if entry.work.draws_at_random() {
            inputs.add("seed", &self.study.about.seed.to_le_bytes());
        }
        prepared.files.inputs(&mut inputs);
        prepared.work.settings(counted, &mut inputs)?;
        if entry.work.told().is_some() {
            self.all_that_it_may_use(&mut inputs);
        }
        Ok(inputs.hash())
    }

    /// What a technique that is not built in is given beside files: which of it is used is not known here.
    fn all_that_it_may_use(&self, inputs: &mut Inputs) {
        let study = self.study;
        inputs
            .add("requirements", study.forms.source.text.as_bytes())
            .add("vocabulary", study.vocabulary.source.text.as_bytes());
    }

    /// An entry with what was produced for it, after the pieces before it.
    pub(crate) fn piece(
        &self,
        entry: &Entry,
        prepared: &Opened<'_>,
        before: &[Piece],
        inputs: String,
        produced: Produced,
    ) -> Result<Piece, Problem> {
        let assets = self.assets(entry).to_vec();
        let mut piece = corroboration::piece(self.study, entry, assets, inputs, produced)?;
        let known = |id: &str| before.iter().map(|p| &p.evidence).find(|e| e.id == id);
        let constant = |name: &str| prepared.work.constant(name);
        piece.drifted = corroboration::drift(entry, constant, known);
        Ok(piece)
    }

    /// The hash of everything that comparing and concluding depend on.
    pub(crate) fn study_inputs(&self, pieces: &[Piece]) -> String {
        let mut inputs = Inputs::default();
        inputs.add("program", self.program().as_bytes());
        let now: Vec<Evidence> = pieces.iter().map(|p| p.evidence.clone()).collect();
        let looks = self.study.looks.clone();
        inputs.add_json("looks", &looks.map(|looks| looks.with(Look::of(&now))));
        for piece in pieces {
            inputs.add(&piece.evidence.id, piece.evidence.inputs.as_bytes());
            inputs.add_json("cost", &piece.cost);
        }
        // The texts that were loaded: the files may have been edited since.
        let study = self.study;
        for source in [
            &study.about_source,
            &study.forms.source,
            &study.vocabulary.source,
            &study.ledger_source,
        ] {
            inputs.add("file", source.text.as_bytes());
        }
        inputs.hash()
    }
}
