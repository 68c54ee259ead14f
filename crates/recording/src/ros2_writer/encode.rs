//! Messages in CDR, by a plan that is made once for each set of fields.

use super::definitions::{Count, FieldDefinition, FieldType, Primitive, fields_of};
use super::error::Ros2WriteError;

/// The header of a message: little endian, plain CDR, no options.
const HEADER: [u8; 4] = [0, 1, 0, 0];
/// The longest sequence that can be named, so that a slip of the pen takes no memory.
const MAX_INDEX: usize = 65_535;

/// A value for one field of a message.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Ros2Value<'a> {
    /// A number; for a field of integers it must be one.
    Number(f64),
    /// A truth value.
    Bool(bool),
    /// Text without zero bytes.
    Text(&'a str),
    /// A time in nanoseconds, for a field of type `builtin_interfaces/Time`; from 0 to 2038.
    Nanos(i64),
}

/// What is written where, in the order of a message.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Step {
    /// The length of a sequence.
    Length(u32),
    /// The value given at this place of the list of paths, or the default.
    Value {
        primitive: Primitive,
        given: Option<usize>,
    },
    /// A time, of which seconds and nanoseconds are two numbers.
    Time { given: usize },
}

/// How a message with certain fields is written.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Plan {
    steps: Vec<Step>,
    paths: Vec<String>,
}

impl Plan {
    /// A plan for messages of the type `short_name` with the fields at `paths`.
    pub fn new(short_name: &'static str, paths: &[&str]) -> Result<Self, Ros2WriteError> {
        let mut plan = Plan {
            steps: Vec::new(),
            paths: paths.iter().map(|path| (*path).to_owned()).collect(),
        };
        let given: Vec<Given> = paths
            .iter()
            .enumerate()
            .map(|(index, path)| Given { index, rest: path })
            .collect();
        plan.message(short_name, &given)
            .map_err(|(index, fault)| fault.error(short_name, paths[index]))?;
        Ok(plan)
    }

    fn message(&mut self, short_name: &'static str, given: &[Given]) -> Result<(), (usize, Fault)> {
        let fields = fields_of(short_name);
        for one in given {
            if !fields.iter().any(|field| one.name() == field.name) {
                return Err((one.index, Fault::UnknownField));
            }
        }
        for field in &fields {
            let below: Vec<Given> = given
                .iter()
                .filter(|one| one.name() == field.name)
                .map(|one| one.behind(field.name.len()))
                .collect();
            if field.count == Count::One {
                self.value(field.field_type, &below)?;
            } else {
                self.elements(field, &below)?;
            }
        }
        Ok(())
    }

    /// A sequence, as long as the highest index that is given, or an array of fixed length.
    fn elements(&mut self, field: &FieldDefinition, given: &[Given]) -> Result<(), (usize, Fault)> {
        let mut elements: Vec<(usize, Given)> = Vec::with_capacity(given.len());
        for one in given {
            elements.push(one.element().ok_or((one.index, Fault::Index))?);
        }
        let longest = elements.iter().map(|(place, _)| place + 1).max();
        let length = match field.count {
            Count::Exactly(length) => length,
            Count::One | Count::Any => longest.unwrap_or(0),
        };
        if let Some((_, one)) = elements.iter().find(|(place, _)| *place >= length) {
            return Err((one.index, Fault::UnknownField));
        }
        if field.count == Count::Any {
            self.steps.push(Step::Length(length as u32));
        }
        for place in 0..length {
            let here: Vec<Given> = elements
                .iter()
                .filter(|(index, _)| *index == place)
                .map(|(_, one)| *one)
                .collect();
            self.value(field.field_type, &here)?;
        }
        Ok(())
    }

    fn value(&mut self, field_type: FieldType, given: &[Given]) -> Result<(), (usize, Fault)> {
        if let [_, second, ..] = given
            && given.iter().any(|one| one.rest.is_empty())
        {
            return Err((second.index, Fault::Twice));
        }
        match (field_type, given) {
            (FieldType::Message("builtin_interfaces/Time"), [one]) if one.rest.is_empty() => {
                self.steps.push(Step::Time { given: one.index });
            }
            (FieldType::Message(name), _) => {
                let mut below = Vec::with_capacity(given.len());
                for one in given {
                    let rest = one.rest.strip_prefix('.');
                    let rest = rest.ok_or((one.index, Fault::NotAValue))?;
                    below.push(Given { rest, ..*one });
                }
                self.message(name, &below)?;
            }
            (FieldType::Primitive(primitive), _) => {
                if let Some(one) = given.iter().find(|one| !one.rest.is_empty()) {
                    return Err((one.index, Fault::UnknownField));
                }
                let given = given.first().map(|one| one.index);
                self.steps.push(Step::Value { primitive, given });
            }
        }
        Ok(())
    }

    /// Writes the message with `values`, one for each path, to `out`, replacing what is there.
    pub fn encode(
        &self,
        values: &[Ros2Value<'_>],
        out: &mut Vec<u8>,
    ) -> Result<(), Ros2WriteError> {
        out.clear();
        out.extend(HEADER);
        for step in &self.steps {
            match step {
                Step::Length(length) => push(out, &length.to_le_bytes()),
                Step::Time { given } => self.push_time(*given, values.get(*given), out)?,
                Step::Value { primitive, given } => {
                    let value = given.and_then(|index| values.get(index));
                    let fits = push_value(*primitive, value.copied(), out);
                    if let (Err(expected), Some(index)) = (fits, *given) {
                        return Err(self.bad_value(index, value.copied(), expected));
                    }
                }
            }
        }
        Ok(())
    }

    /// What the field of path `index` holds, if it is one value.
    pub fn primitive_of(&self, index: usize) -> Option<Primitive> {
        self.steps.iter().find_map(|step| match step {
            Step::Value { primitive, given } if *given == Some(index) => Some(*primitive),
            _ => None,
        })
    }

    fn push_time(
        &self,
        index: usize,
        value: Option<&Ros2Value<'_>>,
        out: &mut Vec<u8>,
    ) -> Result<(), Ros2WriteError> {
        let nanos = match value {
            Some(Ros2Value::Nanos(nanos)) => *nanos,
            other => {
                let expected = "a time in nanoseconds";
                return Err(self.bad_value(index, other.copied(), expected));
            }
        };
        let secs = i32::try_from(nanos.div_euclid(1_000_000_000)).map_err(|_| {
            let expected = "a time before 2038, counted from 1970 or from the start";
            self.bad_value(index, value.copied(), expected)
        })?;
        push(out, &secs.to_le_bytes());
        push(out, &(nanos.rem_euclid(1_000_000_000) as u32).to_le_bytes());
        Ok(())
    }

    fn bad_value(
        &self,
        index: usize,
        value: Option<Ros2Value<'_>>,
        expected: &'static str,
    ) -> Ros2WriteError {
        Ros2WriteError::BadValue {
            path: self.paths.get(index).cloned().unwrap_or_default(),
            value: value.map_or_else(|| "nothing".to_owned(), |value| format!("{value:?}")),
            expected,
        }
    }
}

/// A path that was given, and what of it is still to be followed.
#[derive(Debug, Clone, Copy)]
struct Given<'a> {
    index: usize,
    rest: &'a str,
}

impl<'a> Given<'a> {
    /// The name at the front.
    fn name(&self) -> &'a str {
        let end = self.rest.find(['.', '[']).unwrap_or(self.rest.len());
        &self.rest[..end]
    }

    fn behind(&self, length: usize) -> Self {
        Given {
            rest: &self.rest[length..],
            ..*self
        }
    }

    /// The index in brackets at the front, and what is behind it.
    fn element(&self) -> Option<(usize, Self)> {
        let (index, rest) = self.rest.strip_prefix('[')?.split_once(']')?;
        let index: usize = index.parse().ok()?;
        (index <= MAX_INDEX).then_some((index, Given { rest, ..*self }))
    }
}

/// What is wrong with a path.
enum Fault {
    UnknownField,
    Index,
    NotAValue,
    Twice,
}

impl Fault {
    fn error(self, type_name: &str, path: &str) -> Ros2WriteError {
        let (type_name, path) = (type_name.to_owned(), path.to_owned());
        let problem = match self {
            Fault::UnknownField => return Ros2WriteError::UnknownField { type_name, path },
            Fault::Index => "names a sequence; say which element, as in name[0]",
            Fault::NotAValue => "names a part that has fields of its own; name one of these",
            Fault::Twice => "is given twice; leave one out",
        };
        Ros2WriteError::BadPath {
            type_name,
            path,
            problem,
        }
    }
}

/// Appends a number, aligned to its size within what follows the header.
fn push(out: &mut Vec<u8>, bytes: &[u8]) {
    while !(out.len() - HEADER.len()).is_multiple_of(bytes.len()) {
        out.push(0);
    }
    out.extend(bytes);
}

/// Appends `value`, or the default; the error says what the field takes.
fn push_value(
    primitive: Primitive,
    value: Option<Ros2Value<'_>>,
    out: &mut Vec<u8>,
) -> Result<(), &'static str> {
    match (primitive, value) {
        (Primitive::Bool, None) => out.push(0),
        (Primitive::Bool, Some(Ros2Value::Bool(value))) => out.push(u8::from(value)),
        (Primitive::Bool, _) => return Err("true or false"),
        (Primitive::Float32, None) => push(out, &0_f32.to_le_bytes()),
        (Primitive::Float32, Some(Ros2Value::Number(value))) => {
            // To the nearest number of 32 bits, as a driver would send it.
            push(out, &(value as f32).to_le_bytes());
        }
        (Primitive::Float64, None) => push(out, &0_f64.to_le_bytes()),
        (Primitive::Float64, Some(Ros2Value::Number(value))) => push(out, &value.to_le_bytes()),
        (Primitive::Float32 | Primitive::Float64, _) => return Err("a number"),
        (Primitive::Uint8, _) => {
            let number = whole(value, 0.0, 255.0).ok_or("a whole number from 0 to 255")?;
            push(out, &[number as u8]);
        }
        (Primitive::Int32, _) => {
            let expected = "a whole number of 32 bits";
            let number = whole(value, f64::from(i32::MIN), f64::from(i32::MAX)).ok_or(expected)?;
            push(out, &(number as i32).to_le_bytes());
        }
        (Primitive::Uint32, _) => {
            let expected = "a whole number of 32 bits, not negative";
            let number = whole(value, 0.0, f64::from(u32::MAX)).ok_or(expected)?;
            push(out, &(number as u32).to_le_bytes());
        }
        (Primitive::Text, None) => push_text("", out),
        (Primitive::Text, Some(Ros2Value::Text(text))) if !text.contains('\0') => {
            push_text(text, out);
        }
        (Primitive::Text, _) => return Err("text without zero bytes"),
    }
    Ok(())
}

fn whole(value: Option<Ros2Value<'_>>, low: f64, high: f64) -> Option<f64> {
    match value {
        None => Some(0.0),
        Some(Ros2Value::Number(number)) => {
            (number.fract() == 0.0 && (low..=high).contains(&number)).then_some(number)
        }
        Some(_) => None,
    }
}

fn push_text(text: &str, out: &mut Vec<u8>) {
    push(out, &(text.len() as u32 + 1).to_le_bytes());
    out.extend(text.as_bytes());
    out.push(0);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn encoded(type_name: &'static str, fields: &[(&str, Ros2Value<'_>)]) -> Vec<u8> {
        let (paths, values): (Vec<&str>, Vec<Ros2Value<'_>>) = fields.iter().copied().unzip();
        let mut out = Vec::new();
        Plan::new(type_name, &paths)
            .unwrap()
            .encode(&values, &mut out)
            .unwrap();
        out
    }

    #[test]
    fn numbers_are_aligned_behind_the_header() {
        // Worked out by hand from the rules of CDR: stamp 4 + 4, length 4, "ab\0" 3, one byte of
        // padding to 16, then three doubles.
        let bytes = encoded(
            "geometry_msgs/PointStamped",
            &[
                ("header.stamp", Ros2Value::Nanos(-500_000_000)),
                ("header.frame_id", Ros2Value::Text("ab")),
                ("point.y", Ros2Value::Number(1.0)),
            ],
        );
        let mut expected = vec![0, 1, 0, 0];
        expected.extend((-1_i32).to_le_bytes());
        expected.extend(500_000_000_u32.to_le_bytes());
        expected.extend([3, 0, 0, 0, b'a', b'b', 0, 0]);
        for value in [0.0_f64, 1.0, 0.0] {
            expected.extend(value.to_le_bytes());
        }
        assert_eq!(bytes, expected);
    }

    #[test]
    fn sequences_are_as_long_as_the_highest_index() {
        let bytes = encoded(
            "sensor_msgs/JointState",
            &[("position[1]", Ros2Value::Number(2.0))],
        );
        // Stamp 8, empty text 4 + 1 and 3 of padding, no names 4, two positions 4 + 16, 4, 4.
        assert_eq!(bytes.len(), 4 + 8 + 8 + 4 + 4 + 16 + 4 + 4);
        assert_eq!(bytes[4 + 16..4 + 24], [0, 0, 0, 0, 2, 0, 0, 0]);
    }

    #[test]
    fn numbers_of_32_bits_are_rounded_and_arrays_have_no_length() {
        let bytes = encoded(
            "sensor_msgs/LaserScan",
            &[
                ("ranges[1]", Ros2Value::Number(0.1)),
                ("ranges[0]", Ros2Value::Number(f64::INFINITY)),
            ],
        );
        // Stamp 8, empty text 5 and 3 of padding, seven numbers, then the sequence.
        let ranges = 4 + 16 + 28;
        assert_eq!(bytes[ranges..ranges + 4], [2, 0, 0, 0]);
        assert_eq!(bytes[ranges + 4..ranges + 8], f32::INFINITY.to_le_bytes());
        assert_eq!(bytes[ranges + 8..ranges + 12], 0.1_f32.to_le_bytes());
        let bytes = encoded(
            "geometry_msgs/PoseWithCovariance",
            &[("covariance[35]", Ros2Value::Number(2.0))],
        );
        assert_eq!(bytes.len(), 4 + 8 * (7 + 36));
        assert_eq!(bytes[bytes.len() - 8..], 2.0_f64.to_le_bytes());
        let error = Plan::new("geometry_msgs/PoseWithCovariance", &["covariance[36]"]);
        assert!(error.unwrap_err().to_string().contains("covariance[36]"));
    }

    #[test]
    fn wrong_paths_and_values_are_refused() {
        let plan = |paths: &[&str]| {
            Plan::new("sensor_msgs/JointState", paths)
                .unwrap_err()
                .to_string()
        };
        assert!(plan(&["positions[0]"]).contains("have no field positions[0]"));
        assert!(plan(&["position"]).contains("say which element"));
        assert!(plan(&["position[99999999999]"]).contains("say which element"));
        assert!(plan(&["header.stamp.secs"]).contains("have no field"));
        assert!(plan(&["header"]).contains("has fields of its own"));
        assert!(plan(&["name[0]", "name[0]"]).contains("given twice"));
        assert!(plan(&["header.stamp", "header.stamp.sec"]).contains("given twice"));
        let plan = Plan::new("std_msgs/Int32", &["data"]).unwrap();
        for bad in [
            Ros2Value::Number(0.5),
            Ros2Value::Number(3e9),
            Ros2Value::Text("1"),
            Ros2Value::Number(f64::NAN),
        ] {
            assert!(plan.encode(&[bad], &mut Vec::new()).is_err(), "{bad:?}");
        }
        let plan = Plan::new("std_msgs/Header", &["stamp"]).unwrap();
        assert!(
            plan.encode(&[Ros2Value::Nanos(i64::MAX)], &mut Vec::new())
                .is_err()
        );
    }
}
