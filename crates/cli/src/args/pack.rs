//! Arguments of `pack`.

use super::Format;
use clap::Args;
use std::path::PathBuf;

/// Arguments of `pack`.
#[derive(Debug, Args)]
#[command(after_help = "\
Puts what assessors ask for into one archive: requirements, traceability, strategy, log, evidence,
provenance, argument, the report, JUnit XML and SARIF, the names and hashes of recordings, and a
manifest that says what the pack does not show, signed with Ed25519. VERIFY.md in it says how to
check all of it with unzip, openssl and sha256sum. The same files give the same bytes, but for a
PDF that another release of Chromium prints (hand one in with --pdf).
The study has to be run, and its results have to follow from their evidence.

Examples:
  corroborate pack --new-key signer.pem         makes a key: signer.pem, signer.pub.pem
  corroborate pack my-study --key signer.pem --to my-study.zip
  corroborate pack my-study --key signer.pem --sbom robot.cdx.json --with-recordings
  corroborate verify my-study.zip --key signer.pub.pem")]
#[command(arg_required_else_help = true)]
pub struct Pack {
    /// The study's folder.
    #[arg(required_unless_present = "new_key")]
    pub study: Option<PathBuf>,
    /// The archive, instead of STUDY/results/evidence-pack.zip; of existing files only a pack is replaced.
    #[arg(long, value_name = "FILE")]
    pub to: Option<PathBuf>,
    /// Where the results are, if not in STUDY/results.
    #[arg(long, value_name = "FOLDER")]
    pub out: Option<PathBuf>,
    /// The secret Ed25519 key that signs, in PEM; without it the pack is not signed.
    #[arg(long, value_name = "FILE")]
    pub key: Option<PathBuf>,
    /// A bill of materials of the system under test, CycloneDX or SPDX in JSON (may be repeated).
    #[arg(long, value_name = "FILE")]
    pub sbom: Vec<PathBuf>,
    /// The report as PDF, instead of one that Chromium prints here.
    #[arg(long, value_name = "FILE")]
    pub pdf: Option<PathBuf>,
    /// Put recordings into the pack, too; it names them by their SHA-256 otherwise.
    #[arg(long)]
    pub with_recordings: bool,
    /// Make a new key: this file, and its public key beside it; neither may exist.
    #[arg(long, value_name = "FILE", exclusive = true)]
    pub new_key: Option<PathBuf>,
    /// How what was written is printed.
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
}
