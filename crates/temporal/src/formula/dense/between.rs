//! What the atoms are between two samples.
//!
//! Held, an atom keeps what it was at the earlier sample. Linear, its value v goes in a straight line
//! from v_0 to v_1: its truth changes where the line crosses zero, at t_0 + (t_1 - t_0) v_0 / (v_0 -
//! v_1), rounded to a nanosecond; and of its robustness only the bounds min(v_0, v_1) and max(v_0,
//! v_1) are used for the open interval between the samples, so the robustness of a formula has
//! bounds, too. (Of `always p` and `eventually p` with windows that begin and end at samples they are
//! equal, since a line takes its extremes at its ends.) Between values one of which is infinite an
//! atom is held, as there is no line; if one is unknown, so is what is between.

use crate::formula::report::RobustnessBounds;

/// One atom from one sample to the next.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::formula) struct Between {
    /// The place, within the open interval or at its end, at which it changes.
    pub(in crate::formula) middle: i64,
    /// Before that place.
    pub(in crate::formula) first: RobustnessBounds,
    /// From that place on.
    pub(in crate::formula) then: RobustnessBounds,
}

impl Between {
    /// This, up to the sample at `place`.
    pub(in crate::formula) fn held(bounds: RobustnessBounds, place: i64) -> Self {
        Between {
            middle: place,
            first: bounds,
            then: bounds,
        }
    }
}

/// The two ends of a line: places and values.
#[derive(Debug, Clone, Copy)]
pub(super) struct Line {
    pub(super) places: [i64; 2],
    pub(super) values: [f64; 2],
}

impl Line {
    /// The truth along the line, where it is `held` if there is no line.
    pub(super) fn truth(self, held: RobustnessBounds) -> Between {
        let [from, to] = self.places;
        let [first, last] = self.values;
        if first.is_nan() || last.is_nan() {
            return Between::held(RobustnessBounds::UNKNOWN, to);
        }
        if first.is_infinite() || last.is_infinite() {
            return Between::held(held, to);
        }
        let truth =
            |value: f64| RobustnessBounds::of_truth(RobustnessBounds::exactly(value).truth());
        if first * last < 0.0 {
            // A share of the way, so the place is within or at the ends.
            let ticks = (to - from) as f64 / 2.0 * (first / (first - last));
            return Between {
                middle: (from + 2 * ticks.round() as i64).min(to),
                first: truth(first),
                then: truth(last),
            };
        }
        // One end may be zero; what is between is not.
        match (first == 0.0, last == 0.0) {
            (true, true) => Between::held(held, to),
            (true, false) => Between::held(truth(last), to),
            (false, _) => Between::held(truth(first), to),
        }
    }

    /// The robustness along the line, where it is `held` if there is no line.
    pub(super) fn robustness(self, held: RobustnessBounds) -> Between {
        let [first, last] = self.values;
        let bounds = if first.is_nan() || last.is_nan() {
            RobustnessBounds::UNKNOWN
        } else if first.is_infinite() || last.is_infinite() {
            held
        } else {
            RobustnessBounds {
                low: first.min(last),
                high: first.max(last),
            }
        };
        Between::held(bounds, self.places[1])
    }
}
