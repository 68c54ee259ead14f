//! The initial states: the one of the declarations, or all that satisfy `init ... endinit`.
//!
//! Definition: candidates are all valuations of the variables, in lexicographic order. Cost: one evaluation of
//! the predicate for each candidate, of which there may be [`MAX_CANDIDATES`].

use prism_lang::Expr;
use prism_lang::resolved::Init;

use super::ExploreError;
use super::code::Compiler;
use super::fault::no_value;

/// How many states `init ... endinit` may be tried on.
const MAX_CANDIDATES: u64 = 100_000_000;

/// The initial states, packed, one after the other. `go_on` is told how many there are, now and then.
pub(super) fn initial_states(
    init: &Init,
    compiler: Compiler<'_>,
    go_on: &dyn Fn(usize) -> bool,
) -> Result<Vec<u64>, ExploreError> {
    match init {
        Init::Single(values) => {
            let mut packed = vec![0; compiler.layout.words()];
            compiler.layout.pack(values, &mut packed);
            Ok(packed)
        }
        Init::Predicate(predicate) => satisfying_states(predicate, compiler, go_on),
    }
}

fn satisfying_states(
    predicate: &Expr,
    compiler: Compiler<'_>,
    go_on: &dyn Fn(usize) -> bool,
) -> Result<Vec<u64>, ExploreError> {
    let variables = compiler.variables.iter();
    let bounds: Vec<(i64, i64)> = variables.map(|v| v.kind.bounds()).collect();
    let candidates = bounds.iter().try_fold(1u64, |product, (low, high)| {
        let size = high.checked_sub(*low)?.checked_add(1)?;
        product
            .checked_mul(size as u64)
            .filter(|p| *p <= MAX_CANDIDATES)
    });
    let limit = MAX_CANDIDATES;
    let candidates = candidates.ok_or(ExploreError::TooManyCandidates { limit })?;
    let code = compiler.code(predicate);
    let mut values: Vec<i64> = bounds.iter().map(|(low, _)| *low).collect();
    let words = compiler.layout.words();
    let mut packed = vec![0; words];
    let mut found = Vec::new();
    for candidate in 0..candidates {
        if candidate.is_multiple_of(1 << 20) && !go_on(found.len() / words) {
            return Err(ExploreError::Cancelled);
        }
        compiler.layout.pack(&values, &mut packed);
        let holds = compiler.holds(&code, predicate, &packed);
        if holds.map_err(|error| no_value(error, &packed, compiler))? {
            found.extend_from_slice(&packed);
        }
        count_up(&mut values, &bounds);
    }
    if found.is_empty() {
        let span = predicate.span;
        return Err(ExploreError::NoInitialState { span });
    }
    Ok(found)
}

/// Goes to the next valuation; the last variable moves fastest.
fn count_up(values: &mut [i64], bounds: &[(i64, i64)]) {
    for (value, (low, high)) in values.iter_mut().zip(bounds).rev() {
        if *value < *high {
            *value += 1;
            return;
        }
        *value = *low;
    }
}
