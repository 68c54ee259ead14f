//! Whatever is changed in a pack is noticed: every byte, and every part by somebody who forms the archive anew.

use crate::made::{about, archive, entries, formed, key, parts};
use pack::{Content, Key, Part, Role, Signature, check, write};

fn is_noticed(bytes: &[u8], key: Option<&Key>) -> bool {
    let found = check(&mut &bytes[..], key.map(Key::public).as_ref());
    !found.faults.is_empty()
}

#[test]
fn every_byte_that_is_changed_is_noticed() {
    for signer in [Some(key()), None] {
        let mut bytes = archive(signer.as_ref());
        assert!(!is_noticed(&bytes, signer.as_ref()));
        assert!(bytes.len() > 5_000);
        // What is not signed is read by the same code but for the envelope.
        let step = if signer.is_some() { 1 } else { 4 };
        for at in (0..bytes.len()).step_by(step) {
            let kept = bytes[at];
            // One bit, and what looks alike to programs that forgive.
            let changes = [kept ^ (1 << (at % 8)), kept.wrapping_add(1)];
            let few = if at % 5 == 0 { 2 } else { 1 };
            for changed in changes.into_iter().take(few) {
                bytes[at] = changed;
                assert!(is_noticed(&bytes, None), "byte {at}");
            }
            bytes[at] = kept;
        }
        for at in (0..bytes.len()).step_by(7) {
            assert!(is_noticed(&bytes[..at], None), "cut at byte {at}");
        }
        for tail in [&b"\0"[..], b"PK\x05\x06", &bytes.clone()] {
            assert!(is_noticed(&[&bytes, tail].concat(), None));
        }
        for at in (0..bytes.len()).step_by(13) {
            let mut longer = bytes.clone();
            longer.insert(at, b'x');
            assert!(is_noticed(&longer, None), "longer at byte {at}");
        }
    }
}

/// Checksums that hold again do not help: the signature is of the hashes.
#[test]
fn what_another_signs_or_forms_anew_is_not_the_signers() {
    let signed = archive(Some(&key()));
    let own = |parts: Vec<Part>, key: Option<&Key>| {
        let mut bytes = Vec::new();
        write(parts, about(), key, &mut bytes).expect("written");
        bytes
    };
    let mut changed = parts();
    changed[2].content = Content::text("1,1,1\n");
    let mut further = parts();
    further.push(Part::new("more", Role::Results, "", Content::text("x")));
    let mut fewer = parts();
    fewer.remove(1);
    for forged in [changed, further, fewer] {
        // Signed by another, or not at all, it is whole, but not the signer's.
        let other = Key::of_seed([1; 32]);
        let bytes = own(forged, Some(&other));
        let found = check(&mut bytes.as_slice(), Some(&key().public()));
        assert_eq!(
            (found.faults.len(), found.signature),
            (1, Signature::Invalid)
        );
        assert!(
            check(&mut bytes.as_slice(), Some(&other.public()))
                .faults
                .is_empty()
        );
        // With the envelope of the signer, the manifest is another one.
        let bytes = with_part_of(&bytes, &signed, pack::ENVELOPE);
        assert!(is_noticed(&bytes, Some(&key())));
        assert!(is_noticed(&bytes, None));
        // With the manifest, too, the parts are others.
        let bytes = with_part_of(&bytes, &signed, pack::MANIFEST);
        assert!(is_noticed(&bytes, Some(&key())));
        let bytes = with_part_of(&bytes, &signed, pack::SUMS);
        assert!(is_noticed(&bytes, Some(&key())));
    }
}

/// The archive with a part as another archive has it, in the same form, with checksums that hold.
fn with_part_of(archive: &[u8], other: &[u8], name: &str) -> Vec<u8> {
    let taken = entries(other)
        .into_iter()
        .find(|(it, _)| it == name)
        .expect("the part");
    let mut all = entries(archive);
    all.retain(|(it, _)| it != name);
    all.push(taken);
    all.sort();
    formed(&all)
}

#[test]
fn the_form_is_the_one_of_the_format() {
    let bytes = archive(Some(&key()));
    assert!(formed(&entries(&bytes)) == bytes);
}

#[test]
fn what_a_hostile_manifest_says_reaches_no_terminal() {
    for text in [
        "{\"\\u001b[2Jowned\u{202e}\": 1}".to_owned(),
        "{\"_type\": \"".to_owned() + &"x".repeat(100_000),
    ] {
        let entry = (pack::MANIFEST.to_owned(), text.into_bytes());
        let found = check(&mut formed(&[entry]).as_slice(), None);
        let said = &found.faults[0].what;
        assert!(
            said.starts_with("it cannot be read") && said.len() < 2_000,
            "{said}"
        );
        assert!(!said.contains(['\u{1b}', '\u{202e}']), "{said:?}");
    }
    let envelope = (pack::ENVELOPE.to_owned(), b"{\"payload\": \"e30=\", \"payloadType\": \"application/vnd.in-toto+json\", \"signatures\": [{\"keyid\": \"\\u001b[2J\", \"sig\": \"\"}]}".to_vec());
    let manifest = (pack::MANIFEST.to_owned(), b"{}".to_vec());
    let found = check(&mut formed(&[envelope, manifest]).as_slice(), None);
    assert_eq!(found.signature, Signature::Invalid);
}

#[test]
fn hostile_archives_end_in_a_fault() {
    let mut big = b"PK\x03\x04".to_vec();
    big.extend([0xff; 40]);
    for bytes in [&b""[..], b"PK", b"PK\x05\x06", b"\x7fELF", &big] {
        let found = check(&mut &bytes[..], None);
        assert_eq!(found.faults.len(), 1, "{:?}", found.faults);
    }
    let named = |name: &str| formed(&[(name.to_owned(), b"x".to_vec())]);
    for name in ["../x", "/x", "a/../../x", "a\\b", "\u{1b}[2J", "", "NUL"] {
        let found = check(&mut named(name).as_slice(), None);
        assert!(
            found.faults[0].what.contains("name of a part"),
            "{name}: {:?}",
            found.faults
        );
    }
    let twice = formed(&[("a".into(), b"x".to_vec()), ("a".into(), b"y".to_vec())]);
    assert!(
        check(&mut twice.as_slice(), None).faults[0]
            .what
            .contains("out of order")
    );
}
