//! C3D files: labelled points in three dimensions, frame by frame.
//!
//! Read are the points of files in the order of bytes of Intel and MIPS processors, as floating-point or scaled whole numbers;
//! analogue channels are passed over. A point whose residual is negative was not seen in that frame. The unit of positions is what
//! the file says (`POINT:UNITS`).
//!
//! Source: Motion Lab Systems, "The C3D File Format" (2021).
//!
//! Deviation: the order of bytes of DEC processors, which nobody writes any more, is refused.

use super::{BadFile, Raw};

/// A block of the file.
const BLOCK: usize = 512;

/// Bytes in an order.
struct Bytes<'b> {
    all: &'b [u8],
    is_big_endian: bool,
}

impl Bytes<'_> {
    fn get<const N: usize>(&self, at: usize) -> Result<[u8; N], BadFile> {
        let found = self.all.get(at..at.saturating_add(N));
        let found = found.and_then(|it| it.try_into().ok());
        found.ok_or_else(|| {
            bad(
                at,
                "the file ends in the middle of what it announces".to_owned(),
            )
        })
    }

    fn byte(&self, at: usize) -> Result<u8, BadFile> {
        Ok(self.get::<1>(at)?[0])
    }

    fn whole(&self, at: usize) -> Result<u16, BadFile> {
        let bytes = self.get(at)?;
        Ok(match self.is_big_endian {
            true => u16::from_be_bytes(bytes),
            false => u16::from_le_bytes(bytes),
        })
    }

    fn float(&self, at: usize) -> Result<f64, BadFile> {
        let bytes = self.get(at)?;
        Ok(f64::from(match self.is_big_endian {
            true => f32::from_be_bytes(bytes),
            false => f32::from_le_bytes(bytes),
        }))
    }
}

/// A parameter: its type, dimensions and where its data are.
struct Parameter {
    kind: i8,
    dimensions: Vec<usize>,
    at: usize,
}

/// What the file says of its points.
#[derive(Default)]
struct Points {
    labels: Vec<String>,
    unit: Option<String>,
    rate_hz: Option<f64>,
}

fn bad(at: usize, what: String) -> BadFile {
    BadFile {
        place: format!("byte {at}"),
        what,
    }
}

/// Reads a file.
pub(super) fn read(all: &[u8]) -> Result<Raw, BadFile> {
    let bytes = Bytes {
        all,
        is_big_endian: false,
    };
    if bytes.byte(1)? != 0x50 {
        return Err(bad(
            1,
            "not a C3D file: its second byte is not 80".to_owned(),
        ));
    }
    let parameters = usize::from(bytes.byte(0)?).max(1).saturating_sub(1) * BLOCK;
    let processor = bytes.byte(parameters + 3)?;
    let bytes = match processor {
        84 => bytes,
        86 => Bytes {
            all,
            is_big_endian: true,
        },
        85 => {
            let what = "the order of bytes of DEC processors, which is not read; save it for Intel";
            return Err(bad(parameters + 3, what.to_owned()));
        }
        other => {
            let what = format!("the processor {other}, where 84 (Intel) or 86 (MIPS) is expected");
            return Err(bad(parameters + 3, what));
        }
    };
    let points = points_of(&bytes, parameters)?;
    frames(&bytes, points)
}

/// The parameters of the group `POINT`.
fn points_of(bytes: &Bytes<'_>, section: usize) -> Result<Points, BadFile> {
    let mut groups: Vec<(u8, String)> = Vec::new();
    let mut found: Vec<(u8, String, Parameter)> = Vec::new();
    let mut at = section + 4;
    loop {
        let length = usize::from((bytes.byte(at)? as i8).unsigned_abs());
        if length == 0 {
            break;
        }
        let id = bytes.byte(at + 1)? as i8;
        let name = text(bytes, at + 2, length)?.to_ascii_uppercase();
        let next_at = at + 2 + length;
        let next = usize::from(bytes.whole(next_at)?);
        if id < 0 {
            groups.push((id.unsigned_abs(), name));
        } else if id > 0 {
            let kind = bytes.byte(next_at + 2)? as i8;
            let count = usize::from(bytes.byte(next_at + 3)?);
            let dimensions = (0..count).map(|it| bytes.byte(next_at + 4 + it).map(usize::from));
            let parameter = Parameter {
                kind,
                dimensions: dimensions.collect::<Result<_, _>>()?,
                at: next_at + 4 + count,
            };
            found.push((id.unsigned_abs(), name, parameter));
        }
        if next == 0 {
            break;
        }
        at = next_at + next;
    }
    let group = groups
        .iter()
        .find(|(_, name)| name == "POINT")
        .map(|(id, _)| *id);
    let mut points = Points::default();
    // `LABELS2`, `LABELS3`, ... go on where 255 labels are not enough.
    for (id, name, parameter) in &found {
        if Some(*id) != group {
            continue;
        }
        match name.as_str() {
            "UNITS" => points.unit = texts(bytes, parameter)?.into_iter().next(),
            "RATE" if parameter.kind == 4 => points.rate_hz = Some(bytes.float(parameter.at)?),
            _ if name.starts_with("LABELS") => points.labels.extend(texts(bytes, parameter)?),
            _ => {}
        }
    }
    Ok(points)
}

fn text(bytes: &Bytes<'_>, at: usize, length: usize) -> Result<String, BadFile> {
    let found = bytes.all.get(at..at.saturating_add(length));
    let found = found.ok_or_else(|| bad(at, "the file ends in the middle of a name".to_owned()))?;
    let text = String::from_utf8_lossy(found);
    Ok(text.trim_end_matches([' ', '\0']).trim_start().to_owned())
}

/// The texts of a parameter: one of all its characters, or as many as its second dimension says.
fn texts(bytes: &Bytes<'_>, parameter: &Parameter) -> Result<Vec<String>, BadFile> {
    if parameter.kind != -1 {
        return Ok(Vec::new());
    }
    let length = parameter.dimensions.first().copied().unwrap_or(1);
    let count = parameter.dimensions.get(1).copied().unwrap_or(1);
    (0..count)
        .map(|it| text(bytes, parameter.at + it * length, length))
        .collect()
}

/// The frames of a file with these points.
fn frames(bytes: &Bytes<'_>, points: Points) -> Result<Raw, BadFile> {
    let count = usize::from(bytes.whole(2)?);
    let analogue = usize::from(bytes.whole(4)?);
    let [first, last] = [usize::from(bytes.whole(6)?), usize::from(bytes.whole(8)?)];
    if last < first {
        return Err(bad(
            8,
            format!("the last frame, {last}, is before the first, {first}"),
        ));
    }
    let scale = bytes.float(12)?;
    let start = usize::from(bytes.whole(16)?).saturating_sub(1) * BLOCK;
    let rate_hz = points.rate_hz.filter(|it| *it > 0.0);
    let rate_hz = match rate_hz {
        Some(rate_hz) => rate_hz,
        None => bytes.float(20)?,
    };
    if !(rate_hz > 0.0 && rate_hz.is_finite()) {
        return Err(bad(
            20,
            format!("{rate_hz} frames in a second; it must be above 0"),
        ));
    }
    if points.labels.len() < count {
        let what = format!(
            "{count} points, of which {} have labels",
            points.labels.len()
        );
        return Err(bad(2, what));
    }
    let is_float = scale < 0.0;
    let size = if is_float { 4 } else { 2 };
    let of_frame = size * (4 * count + analogue);
    let mut raw = Raw {
        names: points.labels.into_iter().take(count).collect(),
        places: vec![Vec::new(); count],
        unit: points.unit,
        ..Raw::default()
    };
    for frame in 0..=last - first {
        raw.times_secs.push(frame as f64 / rate_hz);
        for (point, kept) in raw.places.iter_mut().enumerate() {
            let at = start + frame * of_frame + point * 4 * size;
            let number = |part: usize| match is_float {
                true => bytes.float(at + part * size),
                false => Ok(f64::from(bytes.whole(at + part * size)? as i16)),
            };
            let factor = if is_float { 1.0 } else { scale };
            let place = [
                number(0)? * factor,
                number(1)? * factor,
                number(2)? * factor,
            ];
            let is_seen = number(3)? >= 0.0 && place.iter().all(|it| it.is_finite());
            kept.push(is_seen.then_some(place));
        }
    }
    Ok(raw)
}
