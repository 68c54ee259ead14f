//! Products of powers of parameters, packed into two machine words.
//!
//! *Definition.* `p_0^e_0 p_1^e_1 ...` with 16 bits for each exponent; the order is lexicographic, the first
//! parameter counting most. Sums of exponents must stay below 2^16: [`super::polynomial::Polynomial`] looks at
//! total degrees before it multiplies, so that no exponent runs into its neighbour.

/// How many parameters there can be.
pub const MOST_PARAMETERS: usize = 16;

/// Greater total degrees are given up.
pub(super) const MOST_DEGREE: u64 = u16::MAX as u64;

const BITS: u32 = 16;
const IN_A_WORD: usize = 8;

/// A product of powers of parameters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) struct Monomial([u128; 2]);

fn place(parameter: usize) -> (usize, u32) {
    let shift = BITS * (IN_A_WORD - 1 - parameter % IN_A_WORD) as u32;
    (parameter / IN_A_WORD, shift)
}

impl Monomial {
    /// The empty product.
    pub const ONE: Self = Self([0; 2]);

    /// `parameter^exponent`
    pub fn power(parameter: usize, exponent: u16) -> Self {
        let (word, shift) = place(parameter);
        let mut words = [0; 2];
        words[word] = u128::from(exponent) << shift;
        Self(words)
    }

    pub fn exponent(self, parameter: usize) -> u16 {
        let (word, shift) = place(parameter);
        (self.0[word] >> shift) as u16
    }

    /// The sum of the exponents.
    pub fn degree(self) -> u64 {
        (0..MOST_PARAMETERS)
            .map(|p| u64::from(self.exponent(p)))
            .sum()
    }

    pub fn times(self, other: Self) -> Self {
        Self([self.0[0] + other.0[0], self.0[1] + other.0[1]])
    }

    /// The quotient, if it is one.
    pub fn over(self, other: Self) -> Option<Self> {
        let fits = |p| self.exponent(p) >= other.exponent(p);
        let divides = (0..MOST_PARAMETERS).all(fits);
        divides.then(|| Self([self.0[0] - other.0[0], self.0[1] - other.0[1]]))
    }

    /// The greatest product that divides both.
    pub fn common(self, other: Self) -> Self {
        (0..MOST_PARAMETERS).fold(Self::ONE, |common, p| {
            let least = self.exponent(p).min(other.exponent(p));
            common.times(Self::power(p, least))
        })
    }

    /// The same without a parameter.
    pub fn without(self, parameter: usize) -> Self {
        let (word, shift) = place(parameter);
        let mut words = self.0;
        words[word] &= !(u128::from(u16::MAX) << shift);
        Self(words)
    }

    /// The parameters that occur, as bits.
    pub fn parameters(self) -> u32 {
        let occurs = |p: &usize| self.exponent(*p) > 0;
        (0..MOST_PARAMETERS)
            .filter(occurs)
            .fold(0, |set, p| set | 1 << p)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponents_are_kept_apart_and_the_first_parameter_counts_most() {
        let x = Monomial::power(0, 3).times(Monomial::power(9, 5));
        assert_eq!((x.exponent(0), x.exponent(9), x.exponent(8)), (3, 5, 0));
        assert_eq!((x.degree(), x.parameters()), (8, 0b10_0000_0001));
        assert!(Monomial::power(0, 1) > Monomial::power(1, 9));
        assert!(Monomial::power(7, 1) > Monomial::power(8, 9));
        assert_eq!(x.over(Monomial::power(9, 6)), None);
        assert_eq!(x.over(Monomial::power(9, 5)), Some(Monomial::power(0, 3)));
        assert_eq!(x.without(0), Monomial::power(9, 5));
        assert_eq!(x.common(Monomial::power(0, 7)), Monomial::power(0, 3));
    }
}
