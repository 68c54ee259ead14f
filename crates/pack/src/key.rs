//! Ed25519 keys in PEM, as `openssl genpkey -algorithm ed25519` writes them.
//!
//! # Definition
//! A secret key is PKCS #8 (RFC 8410: `PrivateKeyInfo` with the 32 bytes of the seed), a public key `SubjectPublicKeyInfo`. Both
//! have a fixed length, so that everything before the key itself is a constant. Signatures are RFC 8032's, without a hash before;
//! they are deterministic. They are verified strictly: keys of small order and other encodings of one signature are refused.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use diagnostic::Problem;
use ed25519_dalek::{Signature, Signer, SigningKey, VerifyingKey};
use sha2::{Digest, Sha256};

/// PKCS #8, version 1, before the seed.
const SECRET: [u8; 16] = [
    0x30, 0x2e, 0x02, 0x01, 0x00, 0x30, 0x05, 0x06, 0x03, 0x2b, 0x65, 0x70, 0x04, 0x22, 0x04, 0x20,
];
/// The same in version 2, in which the public key follows.
const SECRET_2: [u8; 16] = [
    0x30, 0x51, 0x02, 0x01, 0x01, 0x30, 0x05, 0x06, 0x03, 0x2b, 0x65, 0x70, 0x04, 0x22, 0x04, 0x20,
];
/// What stands before the public key.
const PUBLIC: [u8; 12] = [
    0x30, 0x2a, 0x30, 0x05, 0x06, 0x03, 0x2b, 0x65, 0x70, 0x03, 0x21, 0x00,
];

/// A key that signs.
pub struct Key(SigningKey);

/// A key that verifies.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PublicKey(VerifyingKey);

impl Key {
    /// The key of a seed, which has to be random and secret.
    pub fn of_seed(seed: [u8; 32]) -> Self {
        Self(SigningKey::from_bytes(&seed))
    }

    /// Reads a secret key in PEM.
    ///
    /// # Errors
    /// `bad-key`.
    pub fn of_pem(name: &str, text: &str) -> Result<Self, Problem> {
        let bytes = of_pem(name, text, "PRIVATE KEY")?;
        let seed = [SECRET, SECRET_2]
            .iter()
            .find_map(|it| bytes.strip_prefix(it));
        let seed = seed.filter(|it| it.len() == 32 || bytes.starts_with(&SECRET_2));
        let seed = seed.and_then(|it| it.first_chunk::<32>());
        let seed = seed.ok_or_else(|| other_kind(name))?;
        Ok(Self::of_seed(*seed))
    }

    /// The key in PEM.
    pub fn pem(&self) -> String {
        let bytes = [SECRET.as_slice(), self.0.as_bytes()].concat();
        pem("PRIVATE KEY", &bytes)
    }

    /// The key by which its signatures are verified.
    pub fn public(&self) -> PublicKey {
        PublicKey(self.0.verifying_key())
    }

    pub(crate) fn sign(&self, message: &[u8]) -> [u8; 64] {
        self.0.sign(message).to_bytes()
    }
}

impl PublicKey {
    /// Reads a public key in PEM.
    ///
    /// # Errors
    /// `bad-key`.
    pub fn of_pem(name: &str, text: &str) -> Result<Self, Problem> {
        if text.contains("PRIVATE KEY-----") {
            let message =
                format!("{name} is a secret key; a signature is verified by the public key");
            return Err(Problem::new("bad-key", message)
                .remedy("name the public key, which was written beside it (`.pub.pem`)"));
        }
        let bytes = of_pem(name, text, "PUBLIC KEY")?;
        let key = bytes
            .strip_prefix(&PUBLIC)
            .and_then(|it| <[u8; 32]>::try_from(it).ok());
        let key = key.and_then(|it| VerifyingKey::from_bytes(&it).ok());
        key.map(Self).ok_or_else(|| other_kind(name))
    }

    /// The key in PEM.
    pub fn pem(&self) -> String {
        pem("PUBLIC KEY", &self.der())
    }

    /// The SHA-256 of the key in DER, in hexadecimal: by it a signature names its key.
    pub fn id(&self) -> String {
        crate::hex(&Sha256::digest(self.der()))
    }

    fn der(&self) -> Vec<u8> {
        [PUBLIC.as_slice(), self.0.as_bytes()].concat()
    }

    pub(crate) fn verifies(&self, message: &[u8], signature: &[u8]) -> bool {
        let signature = Signature::from_slice(signature);
        signature.is_ok_and(|it| self.0.verify_strict(message, &it).is_ok())
    }
}

fn pem(kind: &str, bytes: &[u8]) -> String {
    let body = STANDARD.encode(bytes);
    let mut text = format!("-----BEGIN {kind}-----\n");
    for line in body.as_bytes().chunks(64) {
        text.extend(line.iter().copied().map(char::from));
        text.push('\n');
    }
    text + &format!("-----END {kind}-----\n")
}

/// The bytes between the lines of this kind.
fn of_pem(name: &str, text: &str, kind: &str) -> Result<Vec<u8>, Problem> {
    let (begin, end) = (
        format!("-----BEGIN {kind}-----"),
        format!("-----END {kind}-----"),
    );
    let body = text
        .split_once(&begin)
        .and_then(|(_, rest)| rest.split_once(&end));
    let Some((body, _)) = body else {
        let encrypted = text.contains("ENCRYPTED PRIVATE KEY");
        let (what, remedy) = match encrypted {
            true => (
                "is encrypted",
                "decrypt it first: openssl pkey -in KEY -out PLAIN",
            ),
            false => (
                "is not a key in PEM",
                "name an Ed25519 key in PEM; `corroborate pack --new-key FILE` makes one, and so does openssl genpkey -algorithm ed25519",
            ),
        };
        let message = format!("{name} {what}: `{begin}` was expected");
        return Err(Problem::new("bad-key", message).remedy(remedy));
    };
    let body: String = body.split_whitespace().collect();
    STANDARD.decode(body).map_err(|error| {
        Problem::new("bad-key", format!("{name} is not valid base64: {error}"))
            .remedy("take the key's file again from where it was made")
    })
}

fn other_kind(name: &str) -> Problem {
    let message = format!("{name} is not an Ed25519 key");
    Problem::new("bad-key", message)
        .remedy("packs are signed with Ed25519: `corroborate pack --new-key FILE` makes a key")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// RFC 8032, 7.1, test 2.
    #[test]
    fn signatures_are_those_of_the_standard() {
        let byte = |at: usize, text: &str| {
            u8::from_str_radix(&text[2 * at..2 * at + 2], 16).expect("hexadecimal")
        };
        let seed = "4ccd089b28ff96da9db6c346ec114e0f5b8a319f35aba624da8cf6ed4fb8a6fb";
        let key = Key::of_seed(std::array::from_fn(|at| byte(at, seed)));
        let signature = key.sign(&[0x72]);
        let expected = "92a009a9f0d4cab8720e820b5f642540a2b27b5416503f8fb3762223ebdb69da085ac1e43e15996e458f3613d0f11d8c387b2eaeb4302aeeb00d291612bb0c00";
        assert_eq!(crate::hex(&signature), expected);
        assert!(key.public().verifies(&[0x72], &signature));
        assert!(!key.public().verifies(&[0x73], &signature));
    }

    #[test]
    fn keys_are_written_and_read() {
        let key = Key::of_seed([9; 32]);
        let again = Key::of_pem("k", &key.pem()).expect("a key");
        assert_eq!(again.pem(), key.pem());
        let public = PublicKey::of_pem("p", &key.public().pem()).expect("a key");
        assert_eq!(public, key.public());
        for (text, said) in [
            ("", "not a key in PEM"),
            ("ssh-ed25519 AAAA", "not a key in PEM"),
            ("-----BEGIN ENCRYPTED PRIVATE KEY-----", "encrypted"),
            (
                "-----BEGIN PRIVATE KEY-----\n!!\n-----END PRIVATE KEY-----",
                "base64",
            ),
            (
                "-----BEGIN PRIVATE KEY-----\nMAA=\n-----END PRIVATE KEY-----",
                "not an Ed25519",
            ),
        ] {
            let problem = Key::of_pem("k", text).err().expect("no key");
            assert!(problem.message().contains(said), "{problem:?}");
        }
        let secret = PublicKey::of_pem("p", &key.pem()).expect_err("it is secret");
        assert!(secret.message().contains("secret key"), "{secret:?}");
    }
}
