//! The report as PDF, printed by Chromium where that is installed.
//!
//! A browser writes the time into what it prints; both dates are set to the one that every pack has, so that the same page
//! gives the same bytes.

use super::Host;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// The names under which Chromium is installed.
const NAMES: [&str; 5] = [
    "chromium",
    "chromium-browser",
    "google-chrome",
    "google-chrome-stable",
    "chrome",
];

/// How long a browser may take for a page.
const LONGEST: Duration = Duration::from_secs(120);

/// The page as PDF, or why there is none.
pub fn printed(page: &str, host: &Host) -> Result<Vec<u8>, String> {
    let browser = find().ok_or(
        "Chromium is not installed here; `--pdf FILE` takes a PDF that was made elsewhere",
    )?;
    let folder = Folder::new(&host.scratch)?;
    let (html, pdf) = (folder.0.join("report.html"), folder.0.join("report.pdf"));
    std::fs::write(&html, page).map_err(|error| format!("the page cannot be written: {error}"))?;
    let mut command = Command::new(&browser);
    command
        .args([
            "--headless",
            "--disable-gpu",
            "--no-pdf-header-footer",
            "--disable-dev-shm-usage",
        ])
        .arg(format!(
            "--user-data-dir={}",
            folder.0.join("profile").display()
        ))
        .arg(format!("--print-to-pdf={}", pdf.display()))
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null());
    // Chromium refuses to isolate its processes for the superuser; the page is our own and runs no foreign script.
    if is_superuser() {
        command.arg("--no-sandbox");
    }
    command.arg(format!("file://{}", html.display()));
    run(command, host)?;
    let bytes = std::fs::read(&pdf).map_err(|_| format!("{} printed no PDF", browser.display()))?;
    Ok(without_times(bytes))
}

/// Runs it to its end, or ends it when somebody asks to stop or it takes too long.
fn run(mut command: Command, host: &Host) -> Result<(), String> {
    let mut child = command
        .spawn()
        .map_err(|error| format!("the browser does not start: {error}"))?;
    let began = Instant::now();
    loop {
        match child.try_wait() {
            Ok(Some(status)) if status.success() => return Ok(()),
            Ok(Some(status)) => return Err(format!("the browser ended with {status}")),
            Ok(None) if began.elapsed() < LONGEST && !host.cancel.is_cancelled() => {
                std::thread::sleep(Duration::from_millis(20));
            }
            _ => {
                let _ = child.kill();
                let _ = child.wait();
                return Err(
                    "the browser was ended: it took too long, or somebody asked to stop".into(),
                );
            }
        }
    }
}

#[cfg(unix)]
fn is_superuser() -> bool {
    rustix::process::geteuid().is_root()
}

/// Elsewhere Chromium isolates its processes for everybody.
#[cfg(not(unix))]
fn is_superuser() -> bool {
    false
}

fn find() -> Option<PathBuf> {
    let path = std::env::var_os("PATH")?;
    let folders: Vec<PathBuf> = std::env::split_paths(&path).collect();
    let mut all = NAMES
        .iter()
        .flat_map(|name| folders.iter().map(move |it| it.join(name)));
    all.find(|it| it.is_file())
}

/// A folder of our own that goes when it is done with.
struct Folder(PathBuf);

impl Folder {
    fn new(scratch: &Path) -> Result<Self, String> {
        let path = scratch.join(format!("corroborate-pdf-{}", std::process::id()));
        let made = std::fs::create_dir(&path);
        made.map_err(|error| format!("{} cannot be made: {error}", path.display()))?;
        Ok(Self(path))
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// The dates of a PDF (`D:YYYYMMDDhhmmss`) as those of every pack; nothing becomes longer or shorter, so that places in it stay.
fn without_times(mut bytes: Vec<u8>) -> Vec<u8> {
    for key in [&b"/CreationDate (D:"[..], b"/ModDate (D:"] {
        let mut from = 0;
        while let Some(at) = find_in(&bytes[from..], key) {
            let begin = from + at + key.len();
            let digits = bytes[begin..]
                .iter()
                .take(14)
                .take_while(|it| it.is_ascii_digit());
            if digits.count() == 14 {
                bytes[begin..begin + 14].copy_from_slice(b"19800101000000");
            }
            from = begin;
        }
    }
    bytes
}

fn find_in(bytes: &[u8], key: &[u8]) -> Option<usize> {
    bytes.windows(key.len()).position(|it| it == key)
}

#[cfg(test)]
mod tests {
    use super::without_times;

    #[test]
    fn dates_are_set_and_nothing_moves() {
        let one = b"<</CreationDate (D:20260131235959+00'00') /ModDate (D:20260201000000+00'00')>> /CreationDate (D:20";
        let two = without_times(one.to_vec());
        assert_eq!(two.len(), one.len());
        let expected = b"<</CreationDate (D:19800101000000+00'00') /ModDate (D:19800101000000+00'00')>> /CreationDate (D:20";
        assert_eq!(two, expected);
    }
}
