//! The sections of the page, one file each, in the order of reading.

pub mod answers;
pub mod assurance;
pub mod comparisons;
pub mod cost;
pub mod coverage;
pub mod fitted;
pub mod forest;
pub mod found;
pub mod further;
pub mod glossary;
pub mod ledger;
pub mod lineage;
pub mod matrix;
pub mod modes;
pub mod parting;
pub mod provenance;
pub mod published;
pub mod suspects;
pub mod verdict;
