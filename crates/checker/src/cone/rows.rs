//! The choices of the states of a cone in few bytes, as they are read again and again.
//!
//! In most decision processes nearly all choices lead to one state for sure and earn nothing: such a choice is the place of that state,
//! the value of which is its own. All others are kept as they are. Cost: 4 bytes for each choice of the first kind, where a row
//! takes 28. Guarantee: the same values, as nothing else is computed.

/// Marks the number of a choice of the second kind.
const OTHER: u32 = 1 << 31;

/// Choices of states, each with its place in some values.
#[derive(Debug)]
pub(super) struct Rows<const W: usize> {
    /// Where the choices of each state start.
    start: Vec<usize>,
    /// The place to which a choice leads, or the number of another choice.
    choice: Vec<u32>,
    /// Where the entries of the others start, and what these earn; nothing if empty.
    entries: Vec<usize>,
    reward: Vec<[f64; W]>,
    column: Vec<u32>,
    weight: Vec<f64>,
}

impl<const W: usize> Rows<W> {
    /// From rows with the given entries and rewards (none if empty); `None` if fewer than three in four are of the first kind, or there
    /// are too many places or rows for marked numbers.
    pub fn new(
        start: &[usize],
        row_start: &[usize],
        column: &[u32],
        weight: &[f64],
        reward: &[[f64; W]],
    ) -> Option<Self> {
        let is_small = |number: usize| number < OTHER as usize;
        if !is_small(row_start.len()) || column.iter().any(|place| *place >= OTHER) {
            return None;
        }
        let is_certain = |row: usize| {
            let earns = reward.get(row).is_some_and(|earned| *earned != [0.0; W]);
            !earns && weight[row_start[row]..row_start[row + 1]] == [1.0]
        };
        let all = row_start.len() - 1;
        if (0..all).filter(|row| is_certain(*row)).count() * 4 < all * 3 {
            return None;
        }
        let mut rows = Self {
            start: start.to_vec(),
            choice: Vec::with_capacity(row_start.len() - 1),
            entries: vec![0],
            reward: Vec::new(),
            column: Vec::new(),
            weight: Vec::new(),
        };
        for (row, ends) in row_start.windows(2).enumerate() {
            let range = ends[0]..ends[1];
            if is_certain(row) {
                rows.choice.push(column[range.start]);
                continue;
            }
            rows.choice.push(OTHER | (rows.entries.len() - 1) as u32);
            rows.column.extend_from_slice(&column[range.clone()]);
            rows.weight.extend_from_slice(&weight[range]);
            rows.entries.push(rows.column.len());
            rows.reward.extend(reward.get(row));
        }
        Some(rows)
    }

    /// The best of a state's choices, in each problem; nothing if it has none.
    #[inline]
    pub fn best(&self, at: usize, values: &[[f64; W]], maximise: [bool; W]) -> Option<[f64; W]> {
        let choices = &self.choice[self.start[at]..self.start[at + 1]];
        let value = |choice: &u32| match choice & OTHER {
            0 => values[*choice as usize],
            _ => self.sum((choice & !OTHER) as usize, values),
        };
        let (first, others) = choices.split_first()?;
        let mut best = value(first);
        for choice in others {
            let value = value(choice);
            for lane in 0..W {
                if (value[lane] > best[lane]) == maximise[lane] {
                    best[lane] = value[lane];
                }
            }
        }
        Some(best)
    }

    fn sum(&self, other: usize, values: &[[f64; W]]) -> [f64; W] {
        let range = self.entries[other]..self.entries[other + 1];
        let mut sum = self.reward.get(other).copied().unwrap_or([0.0; W]);
        for (column, weight) in self.column[range.clone()].iter().zip(&self.weight[range]) {
            let target = values[*column as usize];
            for (sum, target) in sum.iter_mut().zip(target) {
                *sum += weight * target;
            }
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn certain_choices_and_others_have_the_values_of_their_rows() {
        // Place 0 has two choices, place 1 nine, place 2 none. Choice 1 leads to two places, choice 3 to
        // one at times, choice 4 earns something.
        let start = [0, 2, 11, 11];
        let row_start = [0, 1, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12];
        let mut column = [3; 12];
        (column[1], column[4]) = (1, 2);
        let mut weight = [1.0; 12];
        weight[1..3].copy_from_slice(&[0.5, 0.25]);
        weight[4] = 0.5;
        let mut reward = [[0.0]; 11];
        (reward[1], reward[4]) = ([1.0], [2.0]);
        assert!(Rows::new(&start, &row_start, &column, &weight, &[[1.0]; 11]).is_none());
        let rows = Rows::new(&start, &row_start, &column, &weight, &reward);
        assert!(rows.is_none(), "three of eleven are more than one in four");
        weight[4] = 1.0;
        let rows = Rows::new(&start, &row_start, &column, &weight, &reward).unwrap();
        assert_eq!(rows.choice[..5], [3, OTHER, 3, 2, OTHER | 1]);
        let values = [[9.0], [8.0], [7.0], [4.0]];
        assert_eq!(rows.best(0, &values, [true]), Some([6.0]));
        assert_eq!(rows.best(0, &values, [false]), Some([4.0]));
        assert_eq!(rows.best(1, &values, [true]), Some([7.0]));
        assert_eq!(rows.best(1, &values, [false]), Some([4.0]));
        assert_eq!(rows.best(2, &values, [true]), None);
    }
}
