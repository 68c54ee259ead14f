//! What is measured: exponents of the base quantities.

use std::fmt;

/// Number of base quantities.
const COUNT: usize = 8;

/// Their coherent units, in the order of the exponents.
const BASE_UNITS: [&str; COUNT] = ["m", "kg", "s", "A", "K", "mol", "cd", "rad"];

/// The dimension of a quantity: integral exponents of length, mass, time, electric current,
/// temperature, amount of substance, luminous intensity and plane angle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct Dimension([i8; COUNT]);

/// Dimensions with a name and their coherent unit; of several with one dimension, the first counts.
const NAMED: [(Dimension, &str, &str); 24] = [
    (Dimension::NONE, "plain number", "1"),
    (Dimension::LENGTH, "length", "m"),
    (Dimension::MASS, "mass", "kg"),
    (Dimension::TIME, "time", "s"),
    (Dimension::CURRENT, "electric current", "A"),
    (Dimension::TEMPERATURE, "temperature", "K"),
    (Dimension::ANGLE, "angle", "rad"),
    (Dimension::of(1, 0, -1), "speed", "m/s"),
    (Dimension::of(1, 0, -2), "acceleration", "m/s^2"),
    (Dimension::of(1, 0, -3), "jerk", "m/s^3"),
    (Dimension::of(2, 0, 0), "area", "m^2"),
    (Dimension::of(3, 0, 0), "volume", "m^3"),
    (Dimension::of(0, 0, -1), "frequency", "Hz"),
    (Dimension::of(1, 1, -2), "force", "N"),
    (Dimension::of(2, 1, -2), "energy or torque", "N*m"),
    (Dimension::of(2, 1, -3), "power", "W"),
    (Dimension::of(-1, 1, -2), "pressure", "Pa"),
    (Dimension::of(1, 1, -1), "momentum", "N*s"),
    (Dimension::of(0, 1, -2), "stiffness", "N/m"),
    (Dimension::of(2, 1, 0), "moment of inertia", "kg*m^2"),
    (
        Dimension([0, 0, -1, 0, 0, 0, 0, 1]),
        "angular speed",
        "rad/s",
    ),
    (
        Dimension([0, 0, -2, 0, 0, 0, 0, 1]),
        "angular acceleration",
        "rad/s^2",
    ),
    (Dimension([2, 1, -3, -1, 0, 0, 0, 0]), "voltage", "V"),
    (Dimension([0, 0, 1, 1, 0, 0, 0, 0]), "electric charge", "C"),
];

impl Dimension {
    /// That of plain numbers.
    pub const NONE: Dimension = Dimension::of(0, 0, 0);
    /// Length.
    pub const LENGTH: Dimension = Dimension::of(1, 0, 0);
    /// Mass.
    pub const MASS: Dimension = Dimension::of(0, 1, 0);
    /// Time.
    pub const TIME: Dimension = Dimension::of(0, 0, 1);
    /// Electric current.
    pub const CURRENT: Dimension = Dimension([0, 0, 0, 1, 0, 0, 0, 0]);
    /// Temperature.
    pub const TEMPERATURE: Dimension = Dimension([0, 0, 0, 0, 1, 0, 0, 0]);
    /// Plane angle.
    pub const ANGLE: Dimension = Dimension([0, 0, 0, 0, 0, 0, 0, 1]);

    /// That of length^`length` mass^`mass` time^`time`, for example speed with (1, 0, -1).
    #[must_use]
    pub const fn of(length: i8, mass: i8, time: i8) -> Self {
        Dimension([length, mass, time, 0, 0, 0, 0, 0])
    }

    /// That with these exponents, in the order of the type's description.
    #[must_use]
    pub const fn from_exponents(exponents: [i8; COUNT]) -> Self {
        Dimension(exponents)
    }

    /// The exponents, in the order of the type's description.
    #[must_use]
    pub const fn exponents(self) -> [i8; COUNT] {
        self.0
    }

    /// The dimension of a product; `None` if an exponent is out of range.
    #[must_use]
    pub fn times(self, other: Dimension) -> Option<Dimension> {
        self.combined(other, i8::checked_add)
    }

    /// The dimension of a quotient; `None` if an exponent is out of range.
    #[must_use]
    pub fn divided_by(self, other: Dimension) -> Option<Dimension> {
        self.combined(other, i8::checked_sub)
    }

    fn combined(self, other: Self, combine: fn(i8, i8) -> Option<i8>) -> Option<Self> {
        let mut exponents = self.0;
        for (exponent, &other) in exponents.iter_mut().zip(&other.0) {
            *exponent = combine(*exponent, other)?;
        }
        Some(Dimension(exponents))
    }

    /// The coherent SI unit, for example `m/s`.
    #[must_use]
    pub fn si_unit(self) -> String {
        let named = NAMED.iter().find(|(dimension, ..)| *dimension == self);
        if let Some((_, _, unit)) = named {
            return (*unit).to_owned();
        }
        let written = |sign: i8| {
            let parts = BASE_UNITS.iter().zip(self.0);
            let parts = parts.filter(move |(_, exponent)| exponent.signum() == sign);
            let parts = parts.map(|(unit, exponent)| match exponent.unsigned_abs() {
                1 => (*unit).to_owned(),
                power => format!("{unit}^{power}"),
            });
            parts.collect::<Vec<String>>()
        };
        let (above, below) = (written(1), written(-1));
        let above = if above.is_empty() {
            "1".to_owned()
        } else {
            above.join("*")
        };
        match &below[..] {
            [] => above,
            [one] => format!("{above}/{one}"),
            _ => format!("{above}/({})", below.join("*")),
        }
    }
}

/// The name of the dimension, for example `speed`; where it has none, its coherent SI unit.
impl fmt::Display for Dimension {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match NAMED.iter().find(|(dimension, ..)| dimension == self) {
            Some((_, name, _)) => out.write_str(name),
            None => out.write_str(&self.si_unit()),
        }
    }
}
