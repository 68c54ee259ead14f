//! Messages in a stream of bytes: a header with the length, a blank line, JSON.

use lsp_server::Message;
use std::io::{self, BufRead, Read, Write};

/// Longer messages are not read: no text that people write is so long.
const MOST_BYTES: u64 = 256 << 20;
/// Longer lines of a header are not read.
const LONGEST_HEADER: u64 = 4096;

/// What was read.
#[derive(Debug)]
pub enum Frame {
    /// A message.
    Message(Box<Message>),
    /// A body that is no message, with the reason; what follows can be read.
    Unreadable(String),
}

/// Reads the next message; `None` where the stream ends.
///
/// # Errors
/// A header that says no length: nobody knows where the next message begins.
pub fn read(stream: &mut impl BufRead) -> io::Result<Option<Frame>> {
    let Some(length) = length(stream)? else {
        return Ok(None);
    };
    if length > MOST_BYTES {
        let skipped = io::copy(&mut stream.by_ref().take(length), &mut io::sink())?;
        let reason = format!("a message of {skipped} bytes is longer than {MOST_BYTES}");
        return Ok(Some(Frame::Unreadable(reason)));
    }
    let mut body = Vec::new();
    stream.by_ref().take(length).read_to_end(&mut body)?;
    if (body.len() as u64) < length {
        return Ok(None);
    }
    Ok(Some(match serde_json::from_slice(&body) {
        Ok(message) => Frame::Message(Box::new(message)),
        Err(error) => Frame::Unreadable(error.to_string()),
    }))
}

/// The length that the header says; `None` where the stream ends.
fn length(stream: &mut impl BufRead) -> io::Result<Option<u64>> {
    let mut length = None;
    loop {
        let mut line = Vec::new();
        let read = stream
            .by_ref()
            .take(LONGEST_HEADER)
            .read_until(b'\n', &mut line)?;
        if read == 0 {
            return Ok(None);
        }
        let line = String::from_utf8_lossy(&line);
        let line = line.trim_end();
        if line.is_empty() {
            break;
        }
        if let Some((name, value)) = line.split_once(':')
            && name.eq_ignore_ascii_case("content-length")
        {
            length = value.trim().parse().ok();
        }
    }
    let no_length = || {
        io::Error::new(
            io::ErrorKind::InvalidData,
            "a header without Content-Length",
        )
    };
    length.ok_or_else(no_length).map(Some)
}

/// Writes a message.
///
/// # Errors
/// Those of the stream.
pub fn write(stream: &mut impl Write, message: &Message) -> io::Result<()> {
    message.write(stream)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(bytes: &[u8]) -> Vec<String> {
        let mut stream = bytes;
        let mut found = Vec::new();
        loop {
            match read(&mut stream) {
                Ok(None) => return found,
                Ok(Some(Frame::Message(message))) => found.push(format!("{message:?}")),
                Ok(Some(Frame::Unreadable(_))) => found.push("unreadable".into()),
                Err(_) => {
                    found.push("lost".into());
                    return found;
                }
            }
        }
    }

    #[test]
    fn what_is_no_message_is_told_and_the_next_is_read() {
        let body = r#"{"jsonrpc":"2.0","method":"exit"}"#;
        let good = format!("Content-Length: {}\r\n\r\n{body}", body.len());
        let bytes =
            format!("Content-Length: 2\r\n\r\n{{]{good}content-length:3\r\nX: y\r\n\r\nnul{good}");
        let found = all(bytes.as_bytes());
        assert_eq!(found.len(), 4);
        assert_eq!(
            (found[0].as_str(), found[2].as_str()),
            ("unreadable", "unreadable")
        );
        assert!(found[1].contains("exit") && found[3].contains("exit"));
        assert_eq!(all(b"no header\r\n\r\n"), ["lost"]);
        assert!(all(b"Content-Length: 99\r\n\r\n{}").is_empty());
        assert!(all(b"").is_empty());
    }

    #[test]
    fn a_length_that_nobody_could_hold_is_no_allocation() {
        assert_eq!(
            all(b"Content-Length: 18446744073709551615\r\n\r\nx"),
            ["unreadable"]
        );
    }
}
