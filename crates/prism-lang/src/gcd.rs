//! Greatest common divisors of large integers.
//!
//! *Definition.* Euclid's algorithm; while the leading 62 bits of two numbers decide its quotients, the steps are taken on these
//! bits alone, and what they add up to (a matrix of two by two one-word integers) is applied to the whole numbers at once.
//!
//! Source: Lehmer 1938, "Euclid's algorithm for large numbers"; Knuth, The Art of Computer Programming 2, section 4.5.2,
//! algorithm L. Cost: quadratic in the words, some thirty bits of progress for each pass. Guarantee: exact.

use num_bigint::BigUint;
use num_integer::Integer;
use num_traits::{ToPrimitive, Zero};

/// Bits of the leading parts: sums with cofactors stay within a signed word.
const LEADING: u64 = 62;

/// The greatest common divisor; that of 0 and a number is the number.
pub(crate) fn gcd(a: &BigUint, b: &BigUint) -> BigUint {
    let (long, short) = if a < b { (b, a) } else { (a, b) };
    if short.is_zero() {
        return long.clone();
    }
    if let Some(short) = short.to_u64() {
        return BigUint::from(of_words(long, short));
    }
    let mut long = long.to_u64_digits();
    let mut short = short.to_u64_digits();
    while short.len() > 1 {
        let Some(step) = Cofactors::of(&long, &short) else {
            // The quotient is large, or the leading bits do not decide it.
            let rest = number(&long) % number(&short);
            long = std::mem::replace(&mut short, rest.to_u64_digits());
            continue;
        };
        step.apply(&mut long, &mut short);
    }
    match short.first() {
        None => number(&long),
        Some(short) => BigUint::from(of_words(&number(&long), *short)),
    }
}

/// The divisor of a number and a word other than 0.
fn of_words(long: &BigUint, short: u64) -> u64 {
    let rest = (long % short).to_u64();
    rest.map_or(short, |rest| rest.gcd(&short))
}

fn number(words: &[u64]) -> BigUint {
    let halves = words
        .iter()
        .flat_map(|word| [*word as u32, (word >> 32) as u32]);
    BigUint::new(halves.collect())
}

/// Several steps of Euclid's algorithm: `long` becomes `a long + b short`, and `short` becomes `c long + d short`.
struct Cofactors {
    a: i64,
    b: i64,
    c: i64,
    d: i64,
}

impl Cofactors {
    /// As many steps as the leading bits decide; none if that is no step.
    fn of(long: &[u64], short: &[u64]) -> Option<Self> {
        if long.len() > short.len() + 1 {
            return None;
        }
        let unused = long
            .last()
            .map_or(0, |word| u64::from(word.leading_zeros()));
        let shift = (64 * long.len() as u64 - unused).saturating_sub(LEADING);
        let (mut high, mut low) = (leading(long, shift), leading(short, shift));
        let (mut a, mut b, mut c, mut d) = (1i64, 0i64, 0i64, 1i64);
        // The true quotient lies between these two.
        while low + c != 0 && low + d != 0 && (high + a) / (low + c) == (high + b) / (low + d) {
            let quotient = (high + a) / (low + c);
            (a, c) = (c, a - quotient * c);
            (b, d) = (d, b - quotient * d);
            (high, low) = (low, high - quotient * low);
        }
        (b != 0).then_some(Self { a, b, c, d })
    }

    fn apply(&self, long: &mut Vec<u64>, short: &mut Vec<u64>) {
        short.resize(long.len(), 0);
        // Signs alternate: of the cofactors of a sum one is negative, and after an odd number of steps it is that of `long`.
        let (mut kept, mut taken) = ([self.a, self.d], [self.b, self.c]);
        if self.a <= 0 && self.b > 0 {
            std::mem::swap(long, short);
            (kept, taken) = ([self.b, self.c], [self.a, self.d]);
        }
        let [kept, taken] = [kept, taken].map(|pair| pair.map(i64::unsigned_abs));
        let (mut next_long, mut next_short) = (Difference::default(), Difference::default());
        for (x, y) in long.iter_mut().zip(short.iter_mut()) {
            (*x, *y) = (
                next_long.word((kept[0], *x), (taken[0], *y)),
                next_short.word((kept[1], *y), (taken[1], *x)),
            );
        }
        debug_assert!(next_long.is_complete() && next_short.is_complete());
        trim(long);
        trim(short);
    }
}

/// A multiple of a number less a multiple of a smaller one, word by word from the lowest.
#[derive(Default)]
struct Difference {
    carried: [u64; 2],
    borrowed: bool,
}

impl Difference {
    fn word(&mut self, plus: (u64, u64), minus: (u64, u64)) -> u64 {
        let word = |(factor, word): (u64, u64), carried: &mut u64| {
            let product = u128::from(factor) * u128::from(word) + u128::from(*carried);
            *carried = (product >> 64) as u64;
            product as u64
        };
        let (plus, minus) = (
            word(plus, &mut self.carried[0]),
            word(minus, &mut self.carried[1]),
        );
        let (found, under) = plus.overflowing_sub(minus);
        let (found, again) = found.overflowing_sub(u64::from(self.borrowed));
        self.borrowed = under || again;
        found
    }

    fn is_complete(&self) -> bool {
        self.carried[0] == self.carried[1] + u64::from(self.borrowed)
    }
}

fn trim(words: &mut Vec<u64>) {
    while words.last() == Some(&0) {
        words.pop();
    }
}

/// The bits of a number from this place on, of which there are at most [`LEADING`].
fn leading(words: &[u64], shift: u64) -> i64 {
    let (word, bit) = ((shift / 64) as usize, shift % 64);
    let at = |place: usize| u128::from(words.get(place).copied().unwrap_or(0));
    ((at(word) | at(word + 1) << 64) >> bit) as i64
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::collection::vec;
    use proptest::prelude::*;

    /// Words that are often at their ends.
    fn words(most: usize) -> impl Strategy<Value = Vec<u32>> {
        let word = prop_oneof![4 => any::<u32>(), 1 => Just(0), 1 => Just(u32::MAX), 1 => 0u32..3];
        vec(word, 0..most)
    }

    proptest! {
        #[test]
        fn divisors_are_those_of_the_library(a in words(60), b in words(60), c in words(20)) {
            let [a, b, c] = [a, b, c].map(BigUint::new);
            for (a, b) in [(&a * &c, &b * &c), (&a * &b, &a * &b + &c), (&a * &c + 1u32, a.clone()), (a, b)] {
                prop_assert_eq!(gcd(&a, &b), a.gcd(&b));
            }
        }
    }

    /// All quotients are 1, or all but the last.
    #[test]
    fn neighbours_among_fibonacci_numbers_have_none_in_common() {
        let (mut a, mut b) = (BigUint::from(1u32), BigUint::from(1u32));
        for _ in 0..2000 {
            (a, b) = (&a + &b, a);
            assert_eq!(gcd(&a, &b), BigUint::from(1u32));
            assert_eq!(
                gcd(&(&a * 12u32), &(&b * 18u32)),
                (&a * 12u32).gcd(&(&b * 18u32))
            );
        }
    }
}
