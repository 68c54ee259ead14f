//! Where each variable lies in a packed state.
//!
//! A variable with range `low..=high` takes the bits that `high - low` needs, and never straddles two words of
//! 64 bits.

use prism_lang::VarIndex;
use prism_lang::resolved::Variable;

/// Where each variable lies in a packed state.
#[derive(Clone, Debug, Default)]
pub(crate) struct Layout {
    fields: Vec<Field>,
    words: usize,
}

/// The bits of one variable: its value less `low`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Field {
    pub(crate) word: usize,
    pub(crate) shift: u32,
    pub(crate) mask: u64,
    low: i64,
    high: i64,
}

impl Layout {
    pub(crate) fn new(variables: &[Variable]) -> Self {
        let (mut fields, mut word, mut used) = (Vec::with_capacity(variables.len()), 0, 0);
        for variable in variables {
            let (low, high) = variable.kind.bounds();
            let width = 64 - (high.wrapping_sub(low) as u64).leading_zeros();
            if used + width > 64 {
                (word, used) = (word + 1, 0);
            }
            fields.push(Field {
                word,
                shift: used % 64,
                mask: u64::MAX.checked_shr(64 - width).unwrap_or(0),
                low,
                high,
            });
            used += width;
        }
        Self {
            fields,
            words: word + 1,
        }
    }

    /// Words per state.
    pub(crate) fn words(&self) -> usize {
        self.words
    }

    /// Packs values that lie in their ranges.
    pub(crate) fn pack(&self, values: &[i64], packed: &mut [u64]) {
        packed.fill(0);
        for (field, value) in self.fields.iter().zip(values) {
            packed[field.word] |= (value.wrapping_sub(field.low) as u64) << field.shift;
        }
    }

    /// The number of variables.
    pub(crate) fn len(&self) -> usize {
        self.fields.len()
    }

    /// The bits of a variable.
    pub(crate) fn field(&self, variable: VarIndex) -> Field {
        self.fields[variable]
    }

    /// The value of one variable.
    pub(crate) fn value(&self, variable: VarIndex, packed: &[u64]) -> i64 {
        self.fields[variable].value(packed)
    }

    pub(crate) fn unpack(&self, packed: &[u64], values: &mut [i64]) {
        for (field, value) in self.fields.iter().zip(values) {
            *value = field.value(packed);
        }
    }
}

impl Field {
    /// The least and the greatest value.
    pub(crate) fn bounds(&self) -> (i64, i64) {
        (self.low, self.high)
    }

    /// The bits, at their place, of a value that lies in the range.
    pub(crate) fn bits(&self, value: i64) -> u64 {
        (value.wrapping_sub(self.low) as u64) << self.shift
    }

    /// The variable's value in a packed state.
    #[inline]
    pub(crate) fn value(&self, packed: &[u64]) -> i64 {
        self.low.wrapping_add(self.bits_of(packed) as i64)
    }

    /// The variable's value less its least one.
    #[inline]
    pub(crate) fn bits_of(&self, packed: &[u64]) -> u64 {
        (packed[self.word] >> self.shift) & self.mask
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use prism_lang::Span;
    use prism_lang::resolved::VariableKind;

    fn variable(name: &str, low: i64, high: i64) -> Variable {
        Variable {
            name: name.to_owned(),
            module: None,
            kind: VariableKind::Int { low, high },
            init: low,
            span: Span::default(),
        }
    }

    #[test]
    fn packing_keeps_values_at_the_ends_of_every_range() {
        let variables = [
            variable("fixed", 7, 7),
            variable("small", -3, 4),
            variable("wide", i64::MIN, i64::MAX),
            variable("half", 0, i64::MAX),
            variable("last", -1, 0),
        ];
        let layout = Layout::new(&variables);
        assert_eq!(layout.words(), 3);
        let lows: Vec<i64> = variables.iter().map(|v| v.kind.bounds().0).collect();
        let highs: Vec<i64> = variables.iter().map(|v| v.kind.bounds().1).collect();
        for values in [lows, highs, vec![7, 0, -1, 1, -1]] {
            let mut packed = vec![u64::MAX; layout.words()];
            layout.pack(&values, &mut packed);
            let mut unpacked = vec![0; values.len()];
            layout.unpack(&packed, &mut unpacked);
            assert_eq!(unpacked, values);
        }
    }
}
