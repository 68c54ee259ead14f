//! The arguments of `merge`, and how a shard is named.

use super::{Format, study_folder};
use clap::Args;
use std::path::PathBuf;

/// Arguments of `merge`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  corroborate run my-study --shard 1/2 --out shard-1      on one machine
  corroborate run my-study --shard 2/2 --out shard-2      on another
  corroborate merge my-study shard-1 shard-2 && corroborate run my-study

The shards' episodes are taken over into the study's results in the order of
their numbers, after which `run` simulates none of them again: the evidence is
that of one machine, byte for byte. Shards may come in any order, overlap, and
be merged again; episodes that two of them have must be the same. A shard of
other files, another seed or another build of the program is refused.

Exit codes:
  0 all episodes are there that are needed   2 error in the call or the input
  3 some are in no shard, or a shard's data are not what they say")]
pub struct Merge {
    /// The study's folder, or its study.toml.
    #[arg(value_parser = study_folder())]
    pub study: PathBuf,
    /// Folders that `run --shard` wrote.
    #[arg(required = true)]
    pub shards: Vec<PathBuf>,
    /// Where the study's results are, if not in STUDY/results.
    #[arg(long, value_name = "FOLDER")]
    pub out: Option<PathBuf>,
    /// How what was merged is printed.
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
}

/// Reads `2/8`: the second of eight.
pub fn shard_of(text: &str) -> Result<(u64, u64), String> {
    let read = |part: &str| part.trim().parse::<u64>().ok();
    let parts = text.split_once('/');
    parts
        .and_then(|(shard, of)| Some((read(shard)?, read(of)?)))
        .filter(|(shard, of)| (1..=*of).contains(shard) && *of <= corroborate::shard::MOST_SHARDS)
        .ok_or_else(|| "must be one of 1/N to N/N, for example 2/8".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shard_is_one_of_so_many() {
        assert_eq!(shard_of("2/8"), Ok((2, 8)));
        assert_eq!(shard_of("1/1"), Ok((1, 1)));
        for bad in [
            "",
            "2",
            "0/8",
            "9/8",
            "-1/8",
            "a/b",
            "1/0",
            "1/2/3",
            "1/1000001",
        ] {
            assert!(shard_of(bad).is_err(), "{bad}");
        }
    }
}
