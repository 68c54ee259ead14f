//! The units by symbol and name. Sources: see [`super`].

use super::dimension::Dimension;
use super::factor::Factor;
use crate::suggest::nearest;

/// A unit: its spellings (symbols first), dimension, factor as (numerator, denominator, power of
/// pi), and whether SI prefixes may stand before its first spelling.
struct Entry {
    spellings: &'static [&'static str],
    dimension: Dimension,
    factor: (u128, u128, i8),
    prefixes: bool,
}

const fn entry(
    spellings: &'static [&'static str],
    dimension: Dimension,
    factor: (u128, u128, i8),
    prefixes: bool,
) -> Entry {
    Entry {
        spellings,
        dimension,
        factor,
        prefixes,
    }
}

const ONE: (u128, u128, i8) = (1, 1, 0);
const FORCE: Dimension = Dimension::of(1, 1, -2);
const ENERGY: Dimension = Dimension::of(2, 1, -2);
const POWER: Dimension = Dimension::of(2, 1, -3);
const PRESSURE: Dimension = Dimension::of(-1, 1, -2);
const FREQUENCY: Dimension = Dimension::of(0, 0, -1);
const SPEED: Dimension = Dimension::of(1, 0, -1);
const VOLUME: Dimension = Dimension::of(3, 0, 0);
const ANGULAR_SPEED: Dimension = Dimension::from_exponents([0, 0, -1, 0, 0, 0, 0, 1]);
const CHARGE: Dimension = Dimension::from_exponents([0, 0, 1, 1, 0, 0, 0, 0]);
const VOLTAGE: Dimension = Dimension::from_exponents([2, 1, -3, -1, 0, 0, 0, 0]);
const RESISTANCE: Dimension = Dimension::from_exponents([2, 1, -3, -2, 0, 0, 0, 0]);
const FLUX_DENSITY: Dimension = Dimension::from_exponents([0, 1, -2, -1, 0, 0, 0, 0]);
const AMOUNT: Dimension = Dimension::from_exponents([0, 0, 0, 0, 0, 1, 0, 0]);
const LUMINOUS: Dimension = Dimension::from_exponents([0, 0, 0, 0, 0, 0, 1, 0]);
const SOLID_ANGLE: Dimension = Dimension::from_exponents([0, 0, 0, 0, 0, 0, 0, 2]);

/// All units without their prefixed forms.
const UNITS: [Entry; 52] = [
    entry(
        &["m", "meter", "meters", "metre", "metres"],
        Dimension::LENGTH,
        ONE,
        true,
    ),
    entry(&["g", "gram", "grams"], Dimension::MASS, (1, 1000, 0), true),
    entry(
        &["s", "sec", "secs", "second", "seconds"],
        Dimension::TIME,
        ONE,
        true,
    ),
    entry(&["A", "ampere", "amperes"], Dimension::CURRENT, ONE, true),
    entry(&["K", "kelvin"], Dimension::TEMPERATURE, ONE, true),
    entry(&["mol"], AMOUNT, ONE, true),
    entry(&["cd"], LUMINOUS, ONE, true),
    entry(&["rad", "radian", "radians"], Dimension::ANGLE, ONE, true),
    entry(&["sr"], SOLID_ANGLE, ONE, false),
    entry(&["Hz", "hertz"], FREQUENCY, ONE, true),
    entry(&["N", "newton", "newtons"], FORCE, ONE, true),
    entry(&["Nm"], ENERGY, ONE, true),
    entry(&["Ns"], Dimension::of(1, 1, -1), ONE, true),
    entry(&["Pa", "pascal", "pascals"], PRESSURE, ONE, true),
    entry(&["J", "joule", "joules"], ENERGY, ONE, true),
    entry(&["W", "watt", "watts"], POWER, ONE, true),
    entry(&["Wh"], ENERGY, (3600, 1, 0), true),
    entry(&["C", "coulomb"], CHARGE, ONE, true),
    entry(&["Ah"], CHARGE, (3600, 1, 0), true),
    entry(&["V", "volt", "volts"], VOLTAGE, ONE, true),
    entry(
        &["Ohm", "ohm", "\u{3a9}", "\u{2126}"],
        RESISTANCE,
        ONE,
        true,
    ),
    entry(&["T", "tesla"], FLUX_DENSITY, ONE, true),
    entry(&["L"], VOLUME, (1, 1000, 0), true),
    entry(
        &["l", "litre", "litres", "liter", "liters"],
        VOLUME,
        (1, 1000, 0),
        true,
    ),
    entry(&["bar"], PRESSURE, (100_000, 1, 0), true),
    entry(
        &["t", "tonne", "tonnes"],
        Dimension::MASS,
        (1000, 1, 0),
        false,
    ),
    entry(
        &["min", "minute", "minutes"],
        Dimension::TIME,
        (60, 1, 0),
        false,
    ),
    entry(
        &["h", "hour", "hours"],
        Dimension::TIME,
        (3600, 1, 0),
        false,
    ),
    entry(&["day", "days"], Dimension::TIME, (86_400, 1, 0), false),
    entry(
        &["deg", "\u{b0}", "degree", "degrees"],
        Dimension::ANGLE,
        (1, 180, 1),
        false,
    ),
    entry(
        &["rev", "turn", "revolution", "revolutions"],
        Dimension::ANGLE,
        (2, 1, 1),
        false,
    ),
    entry(&["rpm"], ANGULAR_SPEED, (1, 30, 1), false),
    entry(
        &["in", "inch", "inches"],
        Dimension::LENGTH,
        (127, 5000, 0),
        false,
    ),
    entry(
        &["ft", "foot", "feet"],
        Dimension::LENGTH,
        (381, 1250, 0),
        false,
    ),
    entry(
        &["mi", "mile", "miles"],
        Dimension::LENGTH,
        (201_168, 125, 0),
        false,
    ),
    entry(&["mph"], SPEED, (1397, 3125, 0), false),
    entry(&["kph", "kmh"], SPEED, (5, 18, 0), false),
    entry(&["knot", "knots"], SPEED, (463, 900, 0), false),
    entry(
        &["lb", "lbs", "pound", "pounds"],
        Dimension::MASS,
        (45_359_237, 100_000_000, 0),
        false,
    ),
    entry(
        &["gn"],
        Dimension::of(1, 0, -2),
        (980_665, 100_000, 0),
        false,
    ),
    entry(&["kgf"], FORCE, (980_665, 100_000, 0), false),
    entry(
        &["lbf"],
        FORCE,
        (45_359_237 * 980_665, 100_000_000 * 100_000, 0),
        false,
    ),
    entry(
        &["psi"],
        PRESSURE,
        (
            45_359_237 * 980_665 * 25_000_000,
            100_000_000 * 100_000 * 16_129,
            0,
        ),
        false,
    ),
    entry(&["percent"], Dimension::NONE, (1, 100, 0), false),
    entry(&["%"], Dimension::NONE, (1, 100, 0), false),
    entry(&["ppm"], Dimension::NONE, (1, 1_000_000, 0), false),
    entry(
        &["kilogram", "kilograms", "kilo"],
        Dimension::MASS,
        ONE,
        false,
    ),
    entry(
        &["millimeter", "millimeters", "millimetre", "millimetres"],
        Dimension::LENGTH,
        (1, 1000, 0),
        false,
    ),
    entry(
        &["centimeter", "centimeters", "centimetre", "centimetres"],
        Dimension::LENGTH,
        (1, 100, 0),
        false,
    ),
    entry(
        &["kilometer", "kilometers", "kilometre", "kilometres"],
        Dimension::LENGTH,
        (1000, 1, 0),
        false,
    ),
    entry(
        &["millisecond", "milliseconds", "msec", "msecs"],
        Dimension::TIME,
        (1, 1000, 0),
        false,
    ),
    entry(
        &["nanosecond", "nanoseconds", "nsec", "nsecs"],
        Dimension::TIME,
        (1, 1_000_000_000, 0),
        false,
    ),
];

/// SI prefixes as powers of ten; `da` stands before `d` so that it is found first.
const PREFIXES: [(&str, i8); 15] = [
    ("da", 1),
    ("T", 12),
    ("G", 9),
    ("M", 6),
    ("k", 3),
    ("h", 2),
    ("d", -1),
    ("c", -2),
    ("m", -3),
    ("u", -6),
    ("\u{b5}", -6),
    ("\u{3bc}", -6),
    ("n", -9),
    ("p", -12),
    ("f", -15),
];

/// What is suggested for units that there are not.
const COMMON: [&str; 30] = [
    "m", "mm", "cm", "km", "s", "ms", "us", "ns", "min", "h", "kg", "g", "N", "kN", "Nm", "J", "W",
    "Pa", "kPa", "MPa", "rad", "mrad", "deg", "rev", "rpm", "Hz", "kHz", "V", "A", "K",
];

/// Scales whose zero is not that of the SI's unit.
const OFFSET: [&str; 7] = [
    "degC",
    "degF",
    "\u{b0}C",
    "\u{b0}F",
    "celsius",
    "Celsius",
    "fahrenheit",
];

/// Dimension and factor of the unit called `name`, with or without a prefix.
pub(super) fn lookup(name: &str) -> Option<(Dimension, Factor)> {
    let plain = UNITS.iter().find(|unit| unit.spellings.contains(&name));
    if let Some(unit) = plain {
        return Some((unit.dimension, factor(unit)?));
    }
    for (prefix, exponent) in PREFIXES {
        let Some(symbol) = name.strip_prefix(prefix) else {
            continue;
        };
        let fits = |unit: &&Entry| {
            unit.prefixes
                && unit
                    .spellings
                    .iter()
                    .any(|it| *it == symbol && it.len() <= 3)
        };
        if let Some(unit) = UNITS.iter().find(fits) {
            let prefix = Factor::new(10, 1, 0)?.power(exponent)?;
            return Some((unit.dimension, factor(unit)?.times(prefix)?));
        }
    }
    None
}

fn factor(unit: &Entry) -> Option<Factor> {
    let (numerator, denominator, pi_power) = unit.factor;
    Factor::new(numerator, denominator, pi_power)
}

/// Whether `name` is a scale with an offset.
pub(super) fn has_offset(name: &str) -> bool {
    OFFSET.contains(&name)
}

/// A unit that is written like `name`.
pub(super) fn similar(name: &str) -> Option<String> {
    nearest(name, COMMON)
}
