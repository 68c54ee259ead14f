//! Archives of ReqIF (`.reqifz`): ZIP files with one or more texts of ReqIF and what they refer to.
//!
//! Everything but the texts that change is copied as it is packed.

use super::{of_sources, write};
use crate::mistakes::bad;
use crate::{Change, Columns, Document, File, Format, MOST_BYTES};
use diagnostic::{Problem, Source};
use std::io::{Cursor, Read, Write};
use zip::write::SimpleFileOptions;
use zip::{ZipArchive, ZipWriter};

/// The most files of an archive.
const MOST_FILES: usize = 10_000;

/// An archive of one text without requirements.
pub(crate) fn empty(title: &str) -> Result<Vec<u8>, Problem> {
    let mut writer = ZipWriter::new(Cursor::new(Vec::new()));
    let made = writer
        .start_file("requirements.reqif", SimpleFileOptions::default())
        .and_then(|()| Ok(writer.write_all(super::empty(title).as_bytes())?))
        .and_then(|()| writer.finish());
    made.map(Cursor::into_inner)
        .map_err(|error| bad(format!("the archive cannot be made: {error}")))
}

pub(crate) fn read(files: &[File], columns: &Columns) -> Result<Document, Problem> {
    let [file] = files else {
        return Err(bad("one archive was expected"));
    };
    let not_read = |error: zip::result::ZipError| {
        bad(format!(
            "{} is not an archive that can be read: {error}",
            file.name
        ))
        .remedy("export it again, or unpack it and name the `.reqif` file in it")
    };
    let mut archive = ZipArchive::new(Cursor::new(&file.bytes)).map_err(not_read)?;
    if archive.len() > MOST_FILES {
        return Err(bad(format!(
            "{} has more than {MOST_FILES} files",
            file.name
        )));
    }
    let (mut sources, mut members) = (Vec::new(), Vec::new());
    let mut left = MOST_BYTES as u64;
    for at in 0..archive.len() {
        let member = archive.by_index(at).map_err(not_read)?;
        let name = member.name().map_err(not_read)?.into_owned();
        if !name.to_ascii_lowercase().ends_with(".reqif") {
            continue;
        }
        let mut bytes = Vec::new();
        // What it says of its size may be wrong.
        let read = member.take(left + 1).read_to_end(&mut bytes);
        read.map_err(|error| not_read(error.into()))?;
        if bytes.len() as u64 > left {
            return Err(crate::too_large(&format!("{} ({name})", file.name)));
        }
        left -= bytes.len() as u64;
        let text = String::from_utf8(bytes).map_err(|_| {
            bad(format!("{name} in {} is not UTF-8 text", file.name))
                .remedy("export it again as UTF-8")
        })?;
        let shown: String = name.chars().filter(|it| !it.is_control()).collect();
        sources.push(Source::new(format!("{} ({shown})", file.name), text));
        members.push(name);
    }
    if sources.is_empty() {
        return Err(bad(format!("{} has no `.reqif` file in it", file.name))
            .remedy("check that it is the archive you mean"));
    }
    let mut document = of_sources(Format::ReqIfArchive, sources, columns)?;
    document.archive.clone_from(&file.bytes);
    document.members = members;
    // The archive is what is written.
    document.columns = columns.clone();
    document.archive_name.clone_from(&file.name);
    Ok(document)
}

pub(crate) fn with(document: &Document, changes: &[Change]) -> Result<Vec<File>, Problem> {
    let texts = write::texts(document, changes)?;
    let failed =
        |error: zip::result::ZipError| bad(format!("the archive cannot be written: {error}"));
    let mut archive = ZipArchive::new(Cursor::new(&document.archive)).map_err(failed)?;
    let mut writer = ZipWriter::new(Cursor::new(Vec::new()));
    for at in 0..archive.len() {
        let member = archive.by_index_raw(at).map_err(failed)?;
        let own = member.name().map_err(failed)?.into_owned();
        let known = document.members.iter().position(|name| *name == own);
        let changed = known.and_then(|source| texts.iter().find(|(it, _)| *it == source));
        match changed {
            None => writer.raw_copy_file(member).map_err(failed)?,
            Some((_, text)) => {
                writer
                    .start_file(own, SimpleFileOptions::default())
                    .map_err(failed)?;
                writer
                    .write_all(text.as_bytes())
                    .map_err(|error| failed(error.into()))?;
            }
        }
    }
    let bytes = writer.finish().map_err(failed)?.into_inner();
    Ok(vec![File {
        name: document.archive_name.clone(),
        bytes,
    }])
}
