//! The commands of `VERIFY.md`, run as somebody runs them who does not have this tool.

use crate::made::{archive, entries, formed, key};
use std::path::Path;
use std::process::Command;

/// The blocks of commands of the page, one after the other.
fn commands(page: &str) -> String {
    let blocks = page.split("```sh\n").skip(1);
    let blocks = blocks.filter_map(|it| it.split_once("```\n").map(|(block, _)| block));
    blocks.collect()
}

/// The page of a pack, as it stands in it.
fn page(archive: &[u8]) -> String {
    let text = String::from_utf8_lossy(archive);
    let (_, page) = text.split_once("VERIFY.md# How").expect("the page");
    let (page, _) = page.split_once("PK\u{3}\u{4}").expect("the next part");
    page.to_owned()
}

/// Whether the commands end well in a folder with this archive and the signer's key; and what they say.
fn run(folder: &Path, commands: &str, archive: &[u8]) -> (bool, String) {
    let _ = std::fs::remove_dir_all(folder.join("unpacked"));
    std::fs::write(folder.join("pack.zip"), archive).expect("written");
    std::fs::write(folder.join("signer.pub.pem"), key().public().pem()).expect("written");
    let output = Command::new("sh")
        .args(["-c", commands])
        .current_dir(folder)
        .output()
        .expect("a shell");
    let said = [output.stdout, output.stderr].concat();
    (
        output.status.success(),
        String::from_utf8_lossy(&said).into_owned(),
    )
}

/// Whether the programs are here that the page asks for.
fn has_programs() -> bool {
    let has = |program: &str| {
        let found = Command::new("sh")
            .args(["-c", &format!("command -v {program}")])
            .output();
        found.is_ok_and(|it| it.status.success())
    };
    let missing: Vec<&str> = ["unzip", "openssl", "sha256sum", "diff", "python3", "cmp"]
        .into_iter()
        .filter(|it| !has(it))
        .collect();
    if !missing.is_empty() {
        eprintln!("skipped: {missing:?} are not here, which the page asks for");
    }
    missing.is_empty()
}

/// Changes each `step`th byte, and asks the page; with one that it does not notice, the test fails.
fn changed_bytes(step: usize) {
    if !has_programs() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    for signer in [Some(key()), None] {
        let whole = archive(signer.as_ref());
        let commands = commands(&page(&whole));
        let (is_good, said) = run(folder.path(), &commands, &whole);
        assert!(is_good, "{said}");
        assert_eq!(
            said.contains("Signature Verified Successfully"),
            signer.is_some(),
            "{said}"
        );
        let places = (step / 2..whole.len()).step_by(step);
        eprintln!("{} of {} bytes are changed", places.len(), whole.len());
        for at in places {
            let mut bytes = whole.clone();
            bytes[at] ^= 1 << (at % 8);
            let (is_good, said) = run(folder.path(), &commands, &bytes);
            assert!(
                !is_good,
                "byte {at} is changed, and nothing noticed it: {said}"
            );
        }
    }
}

#[test]
fn the_page_accepts_a_pack_and_notices_changed_bytes() {
    changed_bytes(601);
}

#[test]
#[ignore = "runs ten programs for each of 4,000 bytes"]
fn the_page_notices_every_third_byte() {
    changed_bytes(3);
}

/// The same parts in another order, with a name twice, and with the manifest's hash of one part beside another's name: the tool
/// refuses them, so the page has to.
#[test]
fn the_page_notices_parts_out_of_order() {
    if !has_programs() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    for signer in [Some(key()), None] {
        let whole = archive(signer.as_ref());
        let commands = commands(&page(&whole));
        let parts = entries(&whole);
        let mut swapped = parts.clone();
        swapped.swap(0, 1);
        let mut reversed = parts.clone();
        reversed.reverse();
        let mut rotated = parts.clone();
        rotated.rotate_left(1);
        let mut twice = parts.clone();
        twice.insert(1, parts[0].clone());
        for forged in [swapped, reversed, rotated, twice] {
            let bytes = formed(&forged);
            assert!(!pack::check(&mut bytes.as_slice(), None).faults.is_empty());
            let (is_good, said) = run(folder.path(), &commands, &bytes);
            assert!(!is_good, "nothing noticed it: {said}");
        }
        assert!(run(folder.path(), &commands, &formed(&parts)).0);
    }
}

/// Without a signature a list of hashes can be written anew; it still has to be what the manifest names.
#[test]
fn the_page_notices_a_part_under_another_name() {
    if !has_programs() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let whole = archive(None);
    let commands = commands(&page(&whole));
    let mut parts = entries(&whole);
    let at = |name: &str, parts: &[(String, Vec<u8>)]| {
        parts.iter().position(|(it, _)| it == name).expect("a part")
    };
    // The table goes by a name of its own, and the list says so.
    let table = at("study/table.csv", &parts);
    parts[table].0 = "study/other.csv".to_owned();
    parts.sort();
    let sums = at("SHA256SUMS", &parts);
    let list = String::from_utf8(parts[sums].1.clone()).expect("a list");
    let mut lines: Vec<String> = list
        .lines()
        .map(|line| line.replace("study/table.csv", "study/other.csv"))
        .collect();
    lines.sort_by(|a, b| a[66..].cmp(&b[66..]));
    let list = lines.join("\n") + "\n";
    // The manifest names the new list by its hash, but the table by its old name.
    let hash = |bytes: &[u8]| {
        use sha2::Digest as _;
        let digest = sha2::Sha256::digest(bytes);
        digest
            .iter()
            .map(|it| format!("{it:02x}"))
            .collect::<String>()
    };
    let manifest = at("manifest.json", &parts);
    let text = String::from_utf8(parts[manifest].1.clone()).expect("a manifest");
    let text = text.replace(&hash(&parts[sums].1), &hash(list.as_bytes()));
    parts[manifest].1 = text.into_bytes();
    parts[sums].1 = list.into_bytes();
    let (is_good, said) = run(folder.path(), &commands, &formed(&parts));
    assert!(
        !is_good && said.contains("the manifest names other parts"),
        "{said}"
    );
}

/// Somebody who forms the archive anew, with checksums and hashes that hold, lacks the key.
#[test]
fn the_page_notices_a_pack_that_another_made() {
    if !has_programs() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let commands = commands(&page(&archive(Some(&key()))));
    let other = archive(Some(&pack::Key::of_seed([1; 32])));
    let (is_good, said) = run(folder.path(), &commands, &other);
    assert!(!is_good && !said.contains("Successfully"), "{said}");
    let unsigned = archive(None);
    assert!(!run(folder.path(), &commands, &unsigned).0);
}

/// Keys are those of OpenSSL.
#[test]
fn openssl_reads_our_keys_and_we_read_its() {
    if !has_programs() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let openssl = |arguments: &str| {
        let mut command = Command::new("openssl");
        let output = command
            .args(arguments.split(' '))
            .current_dir(folder.path())
            .output();
        let output = output.expect("it starts");
        assert!(output.status.success(), "{output:?}");
        String::from_utf8(output.stdout).expect("a text")
    };
    std::fs::write(folder.path().join("ours.pem"), key().pem()).expect("written");
    assert_eq!(openssl("pkey -in ours.pem -pubout"), key().public().pem());
    openssl("genpkey -algorithm ed25519 -out theirs.pem");
    let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).expect("a file");
    let theirs = pack::Key::of_pem("theirs.pem", &read("theirs.pem")).expect("a key");
    assert_eq!(
        openssl("pkey -in theirs.pem -pubout"),
        theirs.public().pem()
    );
    openssl("genpkey -algorithm x25519 -out another.pem");
    assert!(pack::Key::of_pem("another.pem", &read("another.pem")).is_err());
}
