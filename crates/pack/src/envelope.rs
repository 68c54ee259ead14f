//! The signed envelope: DSSE, the Dead Simple Signing Envelope, version 1.
//!
//! # Definition
//! Signed is not the payload but its *pre-authentication encoding*: `DSSEv1`, the length and text of the payload's type, the
//! length of the payload in bytes, and the payload, with a space between each. Source: secure-systems-lab, DSSE protocol 1.0.0.
//! The envelope is written with a field on each line, so that `sed` finds them.

use crate::key::{Key, PublicKey};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde::Deserialize;

/// The type of an in-toto statement.
pub(crate) const PAYLOAD_TYPE: &str = "application/vnd.in-toto+json";

/// An envelope as it is read.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "camelCase")]
struct Envelope {
    payload: String,
    payload_type: String,
    signatures: Vec<Signed>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Signed {
    keyid: String,
    sig: String,
}

fn encoding(payload: &[u8]) -> Vec<u8> {
    let (kind, size) = (PAYLOAD_TYPE.len(), payload.len());
    let mut bytes = format!("DSSEv1 {kind} {PAYLOAD_TYPE} {size} ").into_bytes();
    bytes.extend(payload);
    bytes
}

/// The envelope of a payload.
pub(crate) fn signed(payload: &[u8], key: &Key) -> String {
    text(payload, &key.public().id(), &key.sign(&encoding(payload)))
}

fn text(payload: &[u8], keyid: &str, signature: &[u8]) -> String {
    format!(
        "{{\n  \"payload\": \"{}\",\n  \"payloadType\": \"{PAYLOAD_TYPE}\",\n  \"signatures\": [\n    {{\n      \
         \"keyid\": \"{keyid}\",\n      \"sig\": \"{}\"\n    }}\n  ]\n}}\n",
        STANDARD.encode(payload),
        STANDARD.encode(signature)
    )
}

/// The key that an envelope of this payload names; it is as it was written if not even a space is another.
pub(crate) struct Read {
    pub keyid: String,
    signature: Vec<u8>,
}

impl Read {
    pub fn of(envelope: &[u8], payload: &[u8]) -> Result<Self, String> {
        let read: Envelope = serde_json::from_slice(envelope).map_err(|error| error.to_string())?;
        let [one] = read.signatures.as_slice() else {
            return Err(format!(
                "it has {} signatures, not one",
                read.signatures.len()
            ));
        };
        if read.payload_type != PAYLOAD_TYPE
            || STANDARD.decode(&read.payload).ok().as_deref() != Some(payload)
        {
            return Err("its payload is not the manifest beside it".into());
        }
        let signature = STANDARD
            .decode(&one.sig)
            .map_err(|error| error.to_string())?;
        let is_hash = one.keyid.len() == 64 && one.keyid.bytes().all(|c| c.is_ascii_hexdigit());
        if !is_hash {
            return Err("it names no key by its SHA-256".into());
        }
        if text(payload, &one.keyid, &signature).as_bytes() != envelope {
            return Err("it is not in the form in which it was written".into());
        }
        Ok(Self {
            keyid: one.keyid.clone(),
            signature,
        })
    }

    pub fn is_of(&self, key: &PublicKey, payload: &[u8]) -> bool {
        self.keyid == key.id() && key.verifies(&encoding(payload), &self.signature)
    }
}
