//! Names the build by what it computes: the sources of the crates whose numbers end up in results, and what they depend on.
//! Comments and layout count, too, which costs a repetition of work now and then and can never keep a stale result. In a
//! published package, where the other crates' sources are elsewhere, the versions name it.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Crates that only show what others computed.
const FACES: [&str; 3] = ["cli", "report", "corroborate-bench"];

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let own = PathBuf::from(std::env::var_os("CARGO_MANIFEST_DIR").expect("cargo sets it"));
    let version = std::env::var("CARGO_PKG_VERSION").expect("cargo sets it");
    let name = match own.join("../../Cargo.lock").canonicalize() {
        Ok(lock) if own.ends_with("crates/corroborate") => {
            format!("{version}+{:016x}", hash_of_sources(&own, &lock))
        }
        _ => version,
    };
    println!("cargo::rustc-env=CORROBORATE_BUILD={name}");
    // On what kind of machine it computes: bits could differ between them.
    let target = std::env::var("TARGET").expect("cargo sets it");
    println!("cargo::rustc-env=CORROBORATE_TARGET={target}");
}

fn hash_of_sources(own: &Path, lock: &Path) -> u64 {
    let crates = own.parent().expect("it is in crates/");
    let mut files = BTreeSet::from([lock.to_owned()]);
    for entry in std::fs::read_dir(crates)
        .expect("the workspace's crates")
        .flatten()
    {
        let is_face = FACES.iter().any(|face| entry.file_name() == *face);
        if !is_face {
            let source = entry.path().join("src");
            println!("cargo::rerun-if-changed={}", source.display());
            add_files(&source, &mut files);
        }
    }
    println!("cargo::rerun-if-changed={}", lock.display());
    let mut hash = FNV_OFFSET;
    for file in files {
        let place = file.strip_prefix(crates).unwrap_or(Path::new("Cargo.lock"));
        hash = with(hash, place.to_string_lossy().as_bytes());
        hash = with(hash, &std::fs::read(&file).unwrap_or_default());
    }
    hash
}

fn add_files(folder: &Path, files: &mut BTreeSet<PathBuf>) {
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        match path.is_dir() {
            true => add_files(&path, files),
            false => {
                files.insert(path);
            }
        }
    }
}

/// FNV-1a with 64 bits (G. Fowler, L. C. Noll, K.-P. Vo): it tells sources apart that nobody made to collide.
const FNV_OFFSET: u64 = 0xcbf2_9ce4_8422_2325;
const FNV_PRIME: u64 = 0x0000_0100_0000_01b3;

fn with(hash: u64, bytes: &[u8]) -> u64 {
    let length = (bytes.len() as u64).to_le_bytes();
    let all = length.iter().chain(bytes);
    all.fold(hash, |hash, byte| {
        (hash ^ u64::from(*byte)).wrapping_mul(FNV_PRIME)
    })
}
