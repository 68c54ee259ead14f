//! The functions that expressions may call: Python's own that xacro knows, those of `math`, and those of texts, lists and
//! dictionaries.

use super::eval::{Evaluated, MOST, Surroundings, bounded, elements};
use super::value::{Kind, Value, number, whole};
use std::rc::Rc;

/// Modules.
const MODULES: [&str; 3] = ["math", "python", "xacro"];

const FUNCTIONS: [&str; 25] = [
    "list",
    "dict",
    "tuple",
    "len",
    "str",
    "float",
    "int",
    "bool",
    "min",
    "max",
    "round",
    "sorted",
    "range",
    "abs",
    "all",
    "any",
    "sum",
    "enumerate",
    "zip",
    "reversed",
    "repr",
    "divmod",
    "ord",
    "set",
    "isinstance",
];

const OF_XACRO: [&str; 9] = [
    "load_yaml",
    "abs_filename",
    "dotify",
    "arg",
    "tokenize",
    "fatal",
    "message",
    "warning",
    "error",
];

/// A function of one number.
type OfOne = fn(f64) -> f64;

/// Those of `math` that take one number and give one.
const ONE: [(&str, OfOne); 24] = [
    ("sin", f64::sin),
    ("cos", f64::cos),
    ("tan", f64::tan),
    ("asin", f64::asin),
    ("acos", f64::acos),
    ("atan", f64::atan),
    ("sinh", f64::sinh),
    ("cosh", f64::cosh),
    ("tanh", f64::tanh),
    ("asinh", f64::asinh),
    ("acosh", f64::acosh),
    ("atanh", f64::atanh),
    ("exp", f64::exp),
    ("exp2", f64::exp2),
    ("expm1", f64::exp_m1),
    ("log10", f64::log10),
    ("log2", f64::log2),
    ("log1p", f64::ln_1p),
    ("sqrt", f64::sqrt),
    ("cbrt", f64::cbrt),
    ("fabs", f64::abs),
    // As Python computes them: by one rounded factor.
    ("radians", |it| it * (std::f64::consts::PI / 180.0)),
    ("degrees", |it| it * (180.0 / std::f64::consts::PI)),
    ("trunc", f64::trunc),
];

/// Those that take others.
const OTHERS: [&str; 14] = [
    "atan2",
    "pow",
    "hypot",
    "log",
    "floor",
    "ceil",
    "fmod",
    "copysign",
    "isnan",
    "isinf",
    "isfinite",
    "gcd",
    "factorial",
    "isclose",
];

const CONSTANTS: [(&str, f64); 5] = [
    ("pi", std::f64::consts::PI),
    ("e", std::f64::consts::E),
    ("tau", std::f64::consts::TAU),
    ("inf", f64::INFINITY),
    ("nan", f64::NAN),
];

/// What a name means where no property has it.
pub(super) fn global(name: &str) -> Option<Value> {
    let known = MODULES.iter().chain(&FUNCTIONS).chain(&OF_XACRO);
    let known = known.copied().find(|it| *it == name);
    known.map(Value::Builtin).or_else(|| of_math(name))
}

/// What a module has.
pub(super) fn member(module: &str, name: &str) -> Option<Value> {
    let find = |names: &[&'static str]| {
        let found = names.iter().find(|it| **it == name);
        found.map(|it| Value::Builtin(it))
    };
    match module {
        "math" => of_math(name),
        "python" => find(&FUNCTIONS),
        "xacro" => find(&OF_XACRO),
        _ => None,
    }
}

fn of_math(name: &str) -> Option<Value> {
    let constant = CONSTANTS.iter().find(|(known, _)| *known == name);
    if let Some((_, value)) = constant {
        return Some(Value::Float(*value));
    }
    let functions = ONE.iter().map(|(known, _)| *known).chain(OTHERS);
    let mut functions = functions.filter(|known| *known == name);
    functions.next().map(Value::Builtin)
}

type Named = Vec<(String, Value)>;

/// What a call gives.
pub(super) fn call(
    function: &Value,
    arguments: Vec<Value>,
    named: Named,
    around: &mut dyn Surroundings,
) -> Evaluated {
    match function {
        Value::Builtin(name) if OF_XACRO.contains(name) => of_xacro(name, &arguments, around),
        Value::Builtin("dict") if arguments.is_empty() => {
            let entries = named
                .into_iter()
                .map(|(key, value)| (Value::text(key), value));
            Ok(Value::Dict(Rc::new(entries.collect())))
        }
        Value::Builtin(name) => match ONE.iter().find(|(known, _)| known == name) {
            Some((_, compute)) => {
                one_number(name, &arguments).and_then(|it| computed(name, *compute, it))
            }
            None if OTHERS.contains(name) => other_of_math(name, &arguments),
            None => of_python(name, &arguments, &named),
        },
        Value::Method(of, name) => method(of, name, &arguments),
        other => Err(format!("{} is not a function", other.kind())),
    }
}

fn wrong(name: &str) -> String {
    format!("`{name}` does not take these arguments")
}

fn one_number(name: &str, arguments: &[Value]) -> Result<f64, String> {
    match arguments {
        [value] => value.number().ok_or_else(|| wrong(name)),
        _ => Err(wrong(name)),
    }
}

fn computed(name: &str, compute: OfOne, of: f64) -> Evaluated {
    let value = compute(of);
    if value.is_nan() && !of.is_nan() || value.is_infinite() && of.is_finite() {
        return Err(format!("`{name}` has no value at {of}"));
    }
    Ok(match name {
        "trunc" => whole_of(value)?,
        _ => Value::Float(value),
    })
}

/// A number without a fraction as a whole number.
fn whole_of(value: f64) -> Evaluated {
    match value.is_finite() && value.abs() < 9.2e18 {
        true => Ok(Value::Int(value as i64)),
        false => Err(format!("{value} is not a whole number")),
    }
}

fn other_of_math(name: &str, arguments: &[Value]) -> Evaluated {
    let numbers: Option<Vec<f64>> = arguments.iter().map(Value::number).collect();
    let numbers = numbers.ok_or_else(|| wrong(name))?;
    match (name, numbers[..].as_ref()) {
        ("atan2", [y, x]) => Ok(Value::Float(y.atan2(*x))),
        ("pow", [x, y]) => Ok(Value::Float(x.powf(*y))),
        ("hypot", all) => Ok(Value::Float(
            all.iter().map(|it| it * it).sum::<f64>().sqrt(),
        )),
        ("log", [x]) if *x > 0.0 => Ok(Value::Float(x.ln())),
        ("log", [x, base]) if *x > 0.0 && *base > 0.0 => Ok(Value::Float(x.ln() / base.ln())),
        ("floor", [x]) => whole_of(x.floor()),
        ("ceil", [x]) => whole_of(x.ceil()),
        ("fmod", [x, y]) if *y != 0.0 => Ok(Value::Float(x % y)),
        ("copysign", [x, y]) => Ok(Value::Float(x.copysign(*y))),
        ("isnan", [x]) => Ok(Value::Bool(x.is_nan())),
        ("isinf", [x]) => Ok(Value::Bool(x.is_infinite())),
        ("isfinite", [x]) => Ok(Value::Bool(x.is_finite())),
        ("isclose", [x, y]) => {
            let largest = x.abs().max(y.abs());
            Ok(Value::Bool((x - y).abs() <= 1e-9 * largest))
        }
        ("factorial", [x]) if x.fract() == 0.0 && (0.0..=20.0).contains(x) => {
            Ok(Value::Int((1..=*x as i64).product()))
        }
        ("gcd", [x, y]) if x.fract() == 0.0 && y.fract() == 0.0 => {
            let (mut a, mut b) = (x.abs() as i64, y.abs() as i64);
            while b != 0 {
                (a, b) = (b, a % b);
            }
            Ok(Value::Int(a))
        }
        _ => Err(wrong(name)),
    }
}

fn of_python(name: &str, arguments: &[Value], named: &Named) -> Evaluated {
    match (name, arguments) {
        ("list", []) => Ok(Value::list(vec![])),
        ("list", [of]) => Ok(Value::list(elements(of)?)),
        ("set", [of]) => {
            let mut all: Vec<Value> = Vec::new();
            for value in elements(of)? {
                if !all.contains(&value) {
                    all.push(value);
                }
            }
            Ok(Value::list(all))
        }
        ("tuple", [of]) => Ok(Value::tuple(elements(of)?)),
        ("dict", [of @ Value::Dict(_)]) => Ok(of.clone()),
        ("dict", [pairs]) => dict_of(pairs),
        ("len", [of]) => Ok(Value::Int(elements(of)?.len() as i64)),
        ("str", []) => Ok(Value::text("")),
        ("str", [of]) => Ok(Value::text(of.to_string())),
        ("repr", [of]) => Ok(Value::text(of.repr())),
        ("float", [of]) => float_of(of).ok_or_else(|| format!("{} is not a number", of.repr())),
        ("int", [of]) => int_of(of),
        ("bool", [of]) => Ok(Value::Bool(of.truth())),
        ("abs" | "round", _) => of_numbers(name, arguments),
        ("min" | "max", _) => extreme(name, arguments),
        ("sorted", [of]) => sorted(of, named),
        ("reversed", [of]) => Ok(Value::list(elements(of)?.into_iter().rev().collect())),
        ("range", _) => range(arguments),
        ("all", [of]) => Ok(Value::Bool(elements(of)?.iter().all(Value::truth))),
        ("any", [of]) => Ok(Value::Bool(elements(of)?.iter().any(Value::truth))),
        ("sum" | "enumerate" | "zip", _) => of_lists(name, arguments),
        ("divmod", [a, b]) => Ok(Value::tuple(vec![
            super::eval::binary("//", a, b)?,
            super::eval::binary("%", a, b)?,
        ])),
        ("ord", [Value::Text(text)]) if text.chars().count() == 1 => Ok(Value::Int(
            text.chars().next().map_or(0, |it| i64::from(u32::from(it))),
        )),
        ("isinstance", [of, Value::Builtin(kind)]) => Ok(Value::Bool(matches!(
            (of, *kind),
            (Value::Bool(_), "bool" | "int")
                | (Value::Int(_), "int")
                | (Value::Float(_), "float")
                | (Value::Text(_), "str")
                | (Value::List(_, Kind::List), "list")
                | (Value::List(_, Kind::Tuple), "tuple")
                | (Value::Dict(_), "dict")
        ))),
        _ => Err(wrong(name)),
    }
}

fn of_numbers(name: &str, arguments: &[Value]) -> Evaluated {
    match (name, arguments) {
        ("abs", [Value::Float(value)]) => Ok(Value::Float(value.abs())),
        ("abs", [of]) => {
            let value = of.whole().and_then(i64::checked_abs);
            value.map(Value::Int).ok_or_else(|| wrong(name))
        }
        ("round", [of]) => match of.whole() {
            Some(value) => Ok(Value::Int(value)),
            None => whole_of(one_number(name, arguments)?.round_ties_even()),
        },
        ("round", [of, Value::Nothing]) => of_numbers(name, std::slice::from_ref(of)),
        ("round", [of, digits]) => rounded(of, digits),
        _ => Err(wrong(name)),
    }
}

fn of_lists(name: &str, arguments: &[Value]) -> Evaluated {
    match (name, arguments) {
        ("sum", [of]) => {
            let mut sum = Value::Int(0);
            for value in elements(of)? {
                sum = super::eval::binary("+", &sum, &value)?;
            }
            Ok(sum)
        }
        ("enumerate", [of]) => {
            let numbered = (0..).zip(elements(of)?);
            let pairs = numbered.map(|(place, value)| Value::tuple(vec![Value::Int(place), value]));
            Ok(Value::list(pairs.collect()))
        }
        ("zip", lists) => {
            let lists: Vec<Vec<Value>> = lists.iter().map(elements).collect::<Result<_, _>>()?;
            let length = lists.iter().map(Vec::len).min().unwrap_or(0);
            let row =
                |place: usize| Value::tuple(lists.iter().map(|it| it[place].clone()).collect());
            Ok(Value::list((0..length).map(row).collect()))
        }
        _ => Err(wrong(name)),
    }
}

fn dict_of(pairs: &Value) -> Evaluated {
    let mut entries: Vec<(Value, Value)> = Vec::new();
    for pair in elements(pairs)? {
        let [key, value] = &elements(&pair)?[..] else {
            return Err("a dictionary is made of pairs".to_owned());
        };
        entries.retain(|(known, _)| known != key);
        entries.push((key.clone(), value.clone()));
    }
    Ok(Value::Dict(Rc::new(entries)))
}

fn float_of(of: &Value) -> Option<Value> {
    match of {
        Value::Text(text) => number(text).map(Value::Float),
        other => other.number().map(Value::Float),
    }
}

fn int_of(of: &Value) -> Evaluated {
    match of {
        Value::Text(text) => {
            let value = whole(text).map(Value::Int);
            value.ok_or_else(|| format!("{} is not a whole number", of.repr()))
        }
        other => match (other.whole(), other.number()) {
            (Some(value), _) => Ok(Value::Int(value)),
            (None, Some(value)) => whole_of(value.trunc()),
            (None, None) => Err(format!("{} is not a whole number", of.kind())),
        },
    }
}

fn rounded(of: &Value, digits: &Value) -> Evaluated {
    let digits = digits.whole().ok_or_else(|| wrong("round"))?;
    match (of.whole(), of.number()) {
        (Some(value), _) if digits >= 0 => Ok(Value::Int(value)),
        (_, Some(value)) if (0..=300).contains(&digits) => {
            // By digits and not by a factor, which would round twice.
            let digits = usize::try_from(digits).unwrap_or(0);
            let text = format!("{value:.digits$}");
            Ok(Value::Float(text.parse().unwrap_or(value)))
        }
        _ => Err(wrong("round")),
    }
}

fn extreme(name: &str, arguments: &[Value]) -> Evaluated {
    let all = match arguments {
        [of] => elements(of)?,
        several => several.to_vec(),
    };
    let mut all = all.into_iter();
    let mut best = all.next().ok_or_else(|| format!("`{name}` of nothing"))?;
    for value in all {
        let order = value.compare(&best).ok_or_else(|| wrong(name))?;
        if order.is_lt() && name == "min" || order.is_gt() && name == "max" {
            best = value;
        }
    }
    Ok(best)
}

fn sorted(of: &Value, named: &Named) -> Evaluated {
    let mut all = elements(of)?;
    let comparable = all
        .windows(2)
        .all(|pair| pair[0].compare(&pair[1]).is_some());
    if !comparable {
        return Err("its elements have no order".to_owned());
    }
    all.sort_by(|a, b| a.compare(b).unwrap_or(std::cmp::Ordering::Equal));
    match named.iter().find(|(name, _)| name == "reverse") {
        Some((_, value)) if value.truth() => all.reverse(),
        _ => {}
    }
    Ok(Value::list(all))
}

fn range(arguments: &[Value]) -> Evaluated {
    let numbers: Option<Vec<i64>> = arguments.iter().map(Value::whole).collect();
    let (from, to, step) = match numbers.as_deref() {
        Some([to]) => (0, *to, 1),
        Some([from, to]) => (*from, *to, 1),
        Some([from, to, step]) if *step != 0 => (*from, *to, *step),
        _ => return Err(wrong("range")),
    };
    let mut all = Vec::new();
    let mut at = from;
    while if step > 0 { at < to } else { at > to } {
        if all.len() >= MOST {
            return Err(format!("a range has more than {MOST} numbers"));
        }
        all.push(Value::Int(at));
        at = at.saturating_add(step);
    }
    Ok(Value::list(all))
}

fn of_xacro(name: &str, arguments: &[Value], around: &mut dyn Surroundings) -> Evaluated {
    match (name, arguments) {
        ("load_yaml", [Value::Text(file)]) => around.yaml(file),
        ("abs_filename", [of @ Value::Text(_)]) | ("dotify", [of @ Value::Dict(_)]) => {
            Ok(of.clone())
        }
        ("arg", [Value::Text(name)]) => around.argument(name),
        ("tokenize", [Value::Text(text)]) => {
            let parts = text.split([',', ';', ' ']).filter(|it| !it.is_empty());
            Ok(Value::list(parts.map(Value::text).collect()))
        }
        ("fatal", said) => {
            let said: Vec<String> = said.iter().map(ToString::to_string).collect();
            Err(said.join(" "))
        }
        ("message" | "warning" | "error", _) => Ok(Value::text("")),
        _ => Err(wrong(name)),
    }
}

fn method(of: &Value, name: &str, arguments: &[Value]) -> Evaluated {
    match of {
        Value::Text(text) => of_text(text, name, arguments),
        Value::List(values, _) => match (name, arguments) {
            ("index", [value]) => {
                let place = values.iter().position(|it| it == value);
                let place = place.map(|it| Value::Int(it as i64));
                place.ok_or_else(|| format!("{} is not in the list", value.repr()))
            }
            ("count", [value]) => Ok(Value::Int(
                values.iter().filter(|it| *it == value).count() as i64
            )),
            _ => Err(format!("a list has no `{name}` with these arguments")),
        },
        Value::Dict(entries) => match (name, arguments) {
            ("keys", []) => Ok(Value::list(
                entries.iter().map(|(key, _)| key.clone()).collect(),
            )),
            ("values", []) => Ok(Value::list(
                entries.iter().map(|(_, value)| value.clone()).collect(),
            )),
            ("items", []) => {
                let pair =
                    |(key, value): &(Value, Value)| Value::tuple(vec![key.clone(), value.clone()]);
                Ok(Value::list(entries.iter().map(pair).collect()))
            }
            ("get", [key, rest @ ..]) if rest.len() < 2 => {
                let found = entries.iter().find(|(known, _)| known == key);
                let default = || rest.first().cloned().unwrap_or(Value::Nothing);
                Ok(found.map_or_else(default, |(_, value)| value.clone()))
            }
            _ => Err(format!("a dictionary has no `{name}` with these arguments")),
        },
        other => Err(format!("{} has no `{name}`", other.kind())),
    }
}

fn of_text(text: &str, name: &str, arguments: &[Value]) -> Evaluated {
    let texts: Option<Vec<&str>> = arguments
        .iter()
        .map(|it| match it {
            Value::Text(text) => Some(&**text),
            _ => None,
        })
        .collect();
    let list = |parts: Vec<&str>| Value::list(parts.into_iter().map(Value::text).collect());
    match (name, texts.as_deref()) {
        ("lower", Some([])) => Ok(Value::text(text.to_lowercase())),
        ("upper", Some([])) => Ok(Value::text(text.to_uppercase())),
        ("strip", Some([])) => Ok(Value::text(text.trim())),
        ("lstrip", Some([])) => Ok(Value::text(text.trim_start())),
        ("rstrip", Some([])) => Ok(Value::text(text.trim_end())),
        ("strip", Some([of])) => Ok(Value::text(text.trim_matches(|it| of.contains(it)))),
        ("lstrip", Some([of])) => Ok(Value::text(text.trim_start_matches(|it| of.contains(it)))),
        ("rstrip", Some([of])) => Ok(Value::text(text.trim_end_matches(|it| of.contains(it)))),
        ("split", Some([])) => Ok(list(text.split_whitespace().collect())),
        ("split", Some([by])) if !by.is_empty() => Ok(list(text.split(by).collect())),
        ("replace", Some([old, new])) if !old.is_empty() => {
            let times = text.matches(old).count();
            bounded_product(times, new.len())?;
            Ok(Value::text(bounded(text.replace(old, new))?))
        }
        ("startswith", Some([of])) => Ok(Value::Bool(text.starts_with(of))),
        ("endswith", Some([of])) => Ok(Value::Bool(text.ends_with(of))),
        ("count", Some([of])) if !of.is_empty() => Ok(Value::Int(text.matches(of).count() as i64)),
        ("find", Some([of])) => {
            let at = text.find(of).map(|at| text[..at].chars().count() as i64);
            Ok(Value::Int(at.unwrap_or(-1)))
        }
        ("isdigit", Some([])) => Ok(Value::Bool(
            !text.is_empty() && text.chars().all(|it| it.is_ascii_digit()),
        )),
        ("capitalize", Some([])) => {
            let mut characters = text.chars();
            let first = characters.next().map(|it| it.to_uppercase().to_string());
            Ok(Value::text(
                first.unwrap_or_default() + &characters.as_str().to_lowercase(),
            ))
        }
        ("join", None | Some([])) | ("join", Some([_])) => match arguments {
            [parts] => {
                let parts: Vec<String> = elements(parts)?.iter().map(ToString::to_string).collect();
                bounded_product(parts.len(), text.len())?;
                Ok(Value::text(bounded(parts.join(text))?))
            }
            _ => Err(wrong(name)),
        },
        _ => Err(format!("a text has no `{name}` with these arguments")),
    }
}

fn bounded_product(a: usize, b: usize) -> Result<(), String> {
    match a.saturating_mul(b) <= MOST {
        true => Ok(()),
        false => Err(format!("a text becomes longer than {MOST} characters")),
    }
}

/// What `%` makes of a text with `%s`, `%d`, `%f` and their like.
pub(super) fn percent(text: &str, values: &Value) -> Evaluated {
    let mut values = match values {
        Value::List(values, Kind::Tuple) => values.to_vec(),
        one => vec![one.clone()],
    }
    .into_iter();
    let mut written = String::new();
    let mut rest = text;
    while let Some(at) = rest.find('%') {
        written.push_str(&rest[..at]);
        rest = &rest[at + 1..];
        let end = rest.find(|it: char| it.is_ascii_alphabetic() || it == '%');
        let end = end.ok_or("a `%` has no letter behind it")?;
        let (form, kind) = (&rest[..end], &rest[end..=end]);
        rest = &rest[end + 1..];
        if kind == "%" {
            written.push('%');
            continue;
        }
        let value = values.next().ok_or("there are more `%` than values")?;
        written.push_str(&one_percent(form, kind, &value)?);
    }
    written.push_str(rest);
    match values.next() {
        None => Ok(Value::text(bounded(written)?)),
        Some(_) => Err("there are more values than `%`".to_owned()),
    }
}

fn one_percent(form: &str, kind: &str, value: &Value) -> Result<String, String> {
    let (width, digits) = match form.split_once('.') {
        Some((width, digits)) => (width, Some(digits)),
        None => (form, None),
    };
    let unknown = || format!("`%{form}{kind}` is not known here");
    let digits: Option<usize> = digits.map(str::parse).transpose().map_err(|_| unknown())?;
    let fills = width.starts_with('0');
    let width: usize = match width {
        "" => 0,
        width => width.parse().map_err(|_| unknown())?,
    };
    if width > 1000 || digits.is_some_and(|it| it > 300) {
        return Err(unknown());
    }
    let text = match (kind, value.number()) {
        ("s", _) => value.to_string(),
        ("r", _) => value.repr(),
        ("d" | "i", Some(number)) => whole_of(number.trunc())?.to_string(),
        ("f", Some(number)) => format!("{number:.*}", digits.unwrap_or(6)),
        _ => return Err(unknown()),
    };
    let missing = width.saturating_sub(text.chars().count());
    Ok(match (fills, text.strip_prefix('-')) {
        (true, Some(plain)) => format!("-{}{plain}", "0".repeat(missing)),
        (true, None) => "0".repeat(missing) + &text,
        (false, _) => " ".repeat(missing) + &text,
    })
}
