//! What expressions give: Python's arithmetic, comparisons and subscripts over the values that descriptions use.

use super::builtin;
use super::parse::Expr;
use super::value::{Kind, Value};
use std::cmp::Ordering;
use std::rc::Rc;

/// Elements of a list and characters of a text, at most.
pub(super) const MOST: usize = 1_000_000;

/// What expressions are evaluated in.
pub(super) trait Surroundings {
    /// The value of a property; `None` if there is none of that name.
    fn property(&mut self, name: &str) -> Result<Option<Value>, String>;
    /// That of a property in a namespace.
    fn member(&mut self, scope: usize, name: &str) -> Result<Option<Value>, String>;
    /// The value of an `xacro:arg`.
    fn argument(&mut self, name: &str) -> Result<Value, String>;
    /// What a YAML file holds.
    fn yaml(&mut self, file: &str) -> Result<Value, String>;
    /// Notes so much work; an error once it is too much.
    fn spend(&mut self, work: usize) -> Result<(), String>;
}

pub(super) type Evaluated = Result<Value, String>;

/// Names of a comprehension, the innermost last.
type Locals = Vec<(String, Value)>;

/// What an expression gives.
pub(super) fn evaluate(expr: &Expr, around: &mut dyn Surroundings) -> Evaluated {
    Evaluation {
        around,
        locals: Locals::new(),
    }
    .of(expr)
}

struct Evaluation<'a> {
    around: &'a mut dyn Surroundings,
    locals: Locals,
}

impl Evaluation<'_> {
    fn of(&mut self, expr: &Expr) -> Evaluated {
        let value = self.unbounded(expr)?;
        let size = value.size(MOST);
        if size > MOST {
            return Err(format!("it holds more than {MOST} values"));
        }
        self.around.spend(size)?;
        Ok(value)
    }

    fn all(&mut self, all: &[Expr]) -> Result<Vec<Value>, String> {
        all.iter().map(|it| self.of(it)).collect()
    }

    fn unbounded(&mut self, expr: &Expr) -> Evaluated {
        match expr {
            Expr::Value(value) => Ok(value.clone()),
            Expr::Name(name) => self.name(name),
            Expr::List(all) => Ok(Value::list(self.all(all)?)),
            Expr::Tuple(all) => Ok(Value::tuple(self.all(all)?)),
            Expr::Dict(entries) => {
                let mut dict: Vec<(Value, Value)> = Vec::new();
                for (key, value) in entries {
                    let entry = (self.of(key)?, self.of(value)?);
                    dict.retain(|(key, _)| *key != entry.0);
                    dict.push(entry);
                }
                Ok(Value::Dict(Rc::new(dict)))
            }
            Expr::Comprehension(element, names, over, conditions) => {
                self.comprehension(element, names, over, conditions)
            }
            Expr::Unary(operator, of) => {
                let of = self.of(of)?;
                unary(operator, &of)
            }
            Expr::Binary(operator, a, b) => {
                let (a, b) = (self.of(a)?, self.of(b)?);
                binary(operator, &a, &b)
            }
            Expr::Compare(first, rest) => self.compare(first, rest),
            Expr::And(a, b) => match self.of(a)? {
                a if a.truth() => self.of(b),
                a => Ok(a),
            },
            Expr::Or(a, b) => match self.of(a)? {
                a if a.truth() => Ok(a),
                _ => self.of(b),
            },
            Expr::If(parts) => match self.of(&parts[0])?.truth() {
                true => self.of(&parts[1]),
                false => self.of(&parts[2]),
            },
            Expr::Call(function, arguments, named) => self.call(function, arguments, named),
            Expr::Index(of, index) => {
                let (of, index) = (self.of(of)?, self.of(index)?);
                self.index(&of, &index)
            }
            Expr::Slice(of, parts) => self.slice(of, parts),
            Expr::Attribute(of, name) => {
                let of = self.of(of)?;
                self.attribute(&of, name)
            }
        }
    }

    fn call(&mut self, function: &Expr, arguments: &[Expr], named: &[(String, Expr)]) -> Evaluated {
        let function = self.of(function)?;
        let arguments = self.all(arguments)?;
        let mut by_name = Vec::new();
        for (name, value) in named {
            by_name.push((name.clone(), self.of(value)?));
        }
        builtin::call(&function, arguments, by_name, self.around)
    }

    fn slice(&mut self, of: &Expr, parts: &[Option<Expr>; 3]) -> Evaluated {
        let of = self.of(of)?;
        let mut part = |place: usize| match &parts[place] {
            Some(expr) => self.of(expr).map(Some),
            None => Ok(None),
        };
        let parts = [part(0)?, part(1)?, part(2)?];
        slice(&of, &parts)
    }

    fn name(&mut self, name: &str) -> Evaluated {
        let local = self.locals.iter().rev().find(|(known, _)| known == name);
        if let Some((_, value)) = local {
            return Ok(value.clone());
        }
        if let Some(value) = self.around.property(name)? {
            return Ok(value);
        }
        builtin::global(name).ok_or_else(|| format!("there is no property `{name}`"))
    }

    fn comprehension(
        &mut self,
        element: &Expr,
        names: &[String],
        over: &Expr,
        conditions: &[Expr],
    ) -> Evaluated {
        let over = elements(&self.of(over)?)?;
        let mut found = Vec::new();
        let depth = self.locals.len();
        for value in over {
            match names {
                [name] => self.locals.push((name.clone(), value)),
                names => {
                    let parts = elements(&value)?;
                    if parts.len() != names.len() {
                        return Err(format!(
                            "{} values are given to {} names",
                            parts.len(),
                            names.len()
                        ));
                    }
                    self.locals.extend(names.iter().cloned().zip(parts));
                }
            }
            let mut holds = true;
            for condition in conditions {
                holds = holds && self.of(condition)?.truth();
            }
            if holds {
                found.push(self.of(element)?);
            }
            self.locals.truncate(depth);
        }
        Ok(Value::list(found))
    }

    fn compare(&mut self, first: &Expr, rest: &[(&'static str, Expr)]) -> Evaluated {
        let mut left = self.of(first)?;
        for (operator, right) in rest {
            let right = self.of(right)?;
            if !compared(operator, &left, &right)? {
                return Ok(Value::Bool(false));
            }
            left = right;
        }
        Ok(Value::Bool(true))
    }

    fn index(&mut self, of: &Value, index: &Value) -> Evaluated {
        match of {
            Value::Dict(entries) => {
                let found = entries.iter().find(|(key, _)| key == index);
                found
                    .map(|(_, value)| value.clone())
                    .ok_or_else(|| format!("the dictionary has no key {}", index.repr()))
            }
            Value::List(values, _) => {
                let place = place_in(index, values.len())?;
                Ok(values[place].clone())
            }
            Value::Text(text) => {
                let characters: Vec<char> = text.chars().collect();
                let place = place_in(index, characters.len())?;
                Ok(Value::text(characters[place].to_string()))
            }
            Value::Namespace(scope) => {
                let found = self.around.member(*scope, &index.to_string())?;
                found.ok_or_else(|| format!("the namespace has no property {}", index.repr()))
            }
            other => Err(format!("{} has no elements", other.kind())),
        }
    }

    fn attribute(&mut self, of: &Value, name: &str) -> Evaluated {
        match of {
            Value::Namespace(scope) => {
                let found = self.around.member(*scope, name)?;
                found.ok_or_else(|| format!("the namespace has no property `{name}`"))
            }
            Value::Builtin(module) => {
                builtin::member(module, name).ok_or_else(|| format!("`{module}` has no `{name}`"))
            }
            Value::Dict(entries) => {
                let found = entries.iter().find(|(key, _)| *key == Value::text(name));
                match found {
                    Some((_, value)) => Ok(value.clone()),
                    None if matches!(name, "get" | "keys" | "values" | "items") => {
                        Ok(Value::Method(Rc::new(of.clone()), Rc::from(name)))
                    }
                    None => Err(format!("the dictionary has no key `{name}`")),
                }
            }
            Value::Text(_) | Value::List(..) => {
                Ok(Value::Method(Rc::new(of.clone()), Rc::from(name)))
            }
            other => Err(format!("{} has no `{name}`", other.kind())),
        }
    }
}

/// The elements that are gone through: of a list, the characters of a text, the keys of a dictionary.
pub(super) fn elements(of: &Value) -> Result<Vec<Value>, String> {
    match of {
        Value::List(values, _) => Ok(values.to_vec()),
        Value::Text(text) => Ok(text.chars().map(|it| Value::text(it.to_string())).collect()),
        Value::Dict(entries) => Ok(entries.iter().map(|(key, _)| key.clone()).collect()),
        other => Err(format!("{} cannot be gone through", other.kind())),
    }
}

fn place_in(index: &Value, length: usize) -> Result<usize, String> {
    let index = index
        .whole()
        .ok_or_else(|| format!("an index is a whole number, and this is {}", index.kind()))?;
    let from_end = i64::try_from(length).unwrap_or(i64::MAX);
    let place = if index < 0 { index + from_end } else { index };
    let place = usize::try_from(place).ok().filter(|it| *it < length);
    place.ok_or_else(|| format!("there is no element {index} among {length}"))
}

fn slice(of: &Value, parts: &[Option<Value>; 3]) -> Evaluated {
    let all = elements(of)?;
    let length = i64::try_from(all.len()).unwrap_or(i64::MAX);
    let whole = |part: &Option<Value>| match part {
        None | Some(Value::Nothing) => Ok(None),
        Some(value) => {
            let whole = value.whole();
            whole
                .map(Some)
                .ok_or_else(|| "a slice has whole numbers".to_owned())
        }
    };
    let [from, to, step] = [whole(&parts[0])?, whole(&parts[1])?, whole(&parts[2])?];
    let step = step.unwrap_or(1);
    if step == 0 {
        return Err("the step of a slice is not 0".to_owned());
    }
    let (least, most) = if step > 0 {
        (0, length)
    } else {
        (-1, length - 1)
    };
    let bound = |at: Option<i64>, default: i64| match at {
        None => default,
        Some(at) if at < 0 => (at.saturating_add(length)).clamp(least, most),
        Some(at) => at.clamp(least, most),
    };
    let (mut at, end) = match step > 0 {
        true => (bound(from, 0), bound(to, length)),
        false => (bound(from, length - 1), bound(to, -1)),
    };
    let mut found = Vec::new();
    while if step > 0 { at < end } else { at > end } {
        found.extend(usize::try_from(at).ok().and_then(|it| all.get(it).cloned()));
        at = at.saturating_add(step);
    }
    Ok(match of {
        Value::Text(_) => Value::text(found.iter().map(ToString::to_string).collect::<String>()),
        Value::List(_, Kind::Tuple) => Value::tuple(found),
        _ => Value::list(found),
    })
}

fn unary(operator: &str, of: &Value) -> Evaluated {
    let wrong = || Err(format!("`{operator}` cannot be put before {}", of.kind()));
    match (operator, of) {
        ("not", of) => Ok(Value::Bool(!of.truth())),
        ("-", Value::Float(value)) => Ok(Value::Float(-value)),
        ("+", Value::Float(value)) => Ok(Value::Float(*value)),
        (operator, of) => {
            let Some(value) = of.whole() else {
                return wrong();
            };
            match operator {
                "-" => value.checked_neg().map(Value::Int).ok_or_else(too_large),
                "+" => Ok(Value::Int(value)),
                "~" => Ok(Value::Int(!value)),
                _ => wrong(),
            }
        }
    }
}

fn too_large() -> String {
    "a whole number becomes too large".to_owned()
}

fn compared(operator: &str, a: &Value, b: &Value) -> Result<bool, String> {
    let ordered = |holds: fn(Ordering) -> bool| match a.compare(b) {
        Some(order) => Ok(holds(order)),
        None if a.number().is_some() && b.number().is_some() => Ok(false),
        None => Err(format!("{} and {} have no order", a.kind(), b.kind())),
    };
    match operator {
        "==" => Ok(a == b),
        "!=" => Ok(a != b),
        "<" => ordered(Ordering::is_lt),
        "<=" => ordered(Ordering::is_le),
        ">" => ordered(Ordering::is_gt),
        ">=" => ordered(Ordering::is_ge),
        "in" => contains(b, a),
        "not in" => contains(b, a).map(|it| !it),
        // What is the same object is of the same kind, too.
        "is" => Ok(a == b && a.kind() == b.kind()),
        "is not" => Ok(!(a == b && a.kind() == b.kind())),
        other => Err(format!("`{other}` compares nothing")),
    }
}

fn contains(all: &Value, one: &Value) -> Result<bool, String> {
    match (all, one) {
        (Value::Text(text), Value::Text(part)) => Ok(text.contains(&**part)),
        (Value::Text(_), other) => Err(format!("a text does not contain {}", other.kind())),
        _ => Ok(elements(all)?.contains(one)),
    }
}

pub(super) fn binary(operator: &str, a: &Value, b: &Value) -> Evaluated {
    match (operator, a, b) {
        ("+", Value::Text(a), Value::Text(b)) => Ok(Value::text(bounded(format!("{a}{b}"))?)),
        ("+", Value::List(a, one), Value::List(b, two)) if one == two => {
            let all: Vec<Value> = a.iter().chain(b.iter()).cloned().collect();
            Ok(Value::List(Rc::new(all), *one))
        }
        ("*", Value::Text(text), times) | ("*", times, Value::Text(text)) => {
            let times = repeated(times, text.len())?;
            Ok(Value::text(text.repeat(times)))
        }
        ("*", Value::List(values, kind), times) | ("*", times, Value::List(values, kind)) => {
            let times = repeated(times, values.len())?;
            let all = std::iter::repeat_n(values.iter().cloned(), times).flatten();
            Ok(Value::List(Rc::new(all.collect()), *kind))
        }
        ("%", Value::Text(text), values) => builtin::percent(text, values),
        _ => arithmetic(operator, a, b),
    }
}

pub(super) fn bounded(text: String) -> Result<String, String> {
    match text.len() <= MOST {
        true => Ok(text),
        false => Err(format!("a text becomes longer than {MOST} characters")),
    }
}

fn repeated(times: &Value, length: usize) -> Result<usize, String> {
    let times = times
        .whole()
        .ok_or_else(|| format!("a text or list is not multiplied by {}", times.kind()))?;
    let times = usize::try_from(times).unwrap_or(0);
    match times.saturating_mul(length.max(1)) <= MOST {
        true => Ok(times),
        false => Err(format!("it becomes longer than {MOST}")),
    }
}

fn arithmetic(operator: &str, a: &Value, b: &Value) -> Evaluated {
    let wrong = || format!("`{operator}` does not join {} and {}", a.kind(), b.kind());
    if let (Some(x), Some(y)) = (a.whole(), b.whole())
        && let Some(found) = of_whole(operator, x, y)?
    {
        return Ok(match (a, b, found) {
            // Of truth values these give truth values.
            (Value::Bool(_), Value::Bool(_), Value::Int(value))
                if matches!(operator, "&" | "|" | "^") =>
            {
                Value::Bool(value != 0)
            }
            (.., found) => found,
        });
    }
    let (x, y) = a.number().zip(b.number()).ok_or_else(wrong)?;
    let by_zero = || Err("a number is divided by 0".to_owned());
    Ok(Value::Float(match operator {
        "+" => x + y,
        "-" => x - y,
        "*" => x * y,
        "/" | "//" | "%" if y == 0.0 => return by_zero(),
        "/" => x / y,
        "//" => ((x - modulo(x, y)) / y).round(),
        "%" => modulo(x, y),
        "**" => power(x, y)?,
        _ => return Err(wrong()),
    }))
}

/// What two whole numbers give, where that is a whole number; `None` where it is another number.
fn of_whole(operator: &str, x: i64, y: i64) -> Result<Option<Value>, String> {
    let shift = || u32::try_from(y).ok().filter(|it| *it < 63);
    let found = match operator {
        "+" => x.checked_add(y),
        "-" => x.checked_sub(y),
        "*" => x.checked_mul(y),
        "//" | "%" if y == 0 => return Err("a number is divided by 0".to_owned()),
        "//" => x.checked_div_euclid(y).map(|it| floored(it, x, y)),
        "%" => x
            .checked_rem(y)
            .map(|rest| match rest != 0 && (rest < 0) != (y < 0) {
                true => rest + y,
                false => rest,
            }),
        "**" if y >= 0 => u32::try_from(y).ok().and_then(|y| x.checked_pow(y)),
        "&" => Some(x & y),
        "|" => Some(x | y),
        "^" => Some(x ^ y),
        "<<" => shift().and_then(|by| x.checked_mul(1 << by)),
        ">>" => shift().map(|by| x >> by),
        _ => return Ok(None),
    };
    found.map(|it| Some(Value::Int(it))).ok_or_else(too_large)
}

/// Rounded down, from what is rounded so that the rest is not negative.
fn floored(euclidean: i64, x: i64, y: i64) -> i64 {
    let rest = x.rem_euclid(y);
    euclidean - i64::from(y < 0 && rest != 0)
}

/// The rest, with the sign of the divisor.
fn modulo(x: f64, y: f64) -> f64 {
    let rest = x % y;
    match rest != 0.0 && (rest < 0.0) != (y < 0.0) {
        true => rest + y,
        false => rest,
    }
}

fn power(x: f64, y: f64) -> Result<f64, String> {
    if x == 0.0 && y < 0.0 {
        return Err("0 has no negative power".to_owned());
    }
    if x < 0.0 && y.fract() != 0.0 {
        return Err("a negative number has no such power".to_owned());
    }
    Ok(x.powf(y))
}
