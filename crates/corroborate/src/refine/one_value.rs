//! One value in one line of a text, replaced.

/// One value in one line of a text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OneValue {
    /// The line, from 1.
    pub line: u32,
    /// What stands there.
    pub old: String,
    /// What is to stand there.
    pub new: String,
}

impl OneValue {
    /// The text with the value replaced.
    ///
    /// # Errors
    /// Why it cannot be made: the line does not hold the value, or holds it more than once.
    pub fn make(&self, text: &str) -> Result<String, String> {
        let at = usize::try_from(self.line).unwrap_or(0).saturating_sub(1);
        let lines = text.split_inclusive('\n');
        let start: usize = lines.clone().take(at).map(str::len).sum();
        let line = lines.clone().nth(at).unwrap_or_default();
        let places = line.match_indices(&self.old).map(|(place, _)| place);
        let places: Vec<usize> = places.filter(|at| self.stands_alone(line, *at)).collect();
        match places.as_slice() {
            [place] => {
                let from = start + place;
                let mut changed = text.to_owned();
                changed.replace_range(from..from + self.old.len(), &self.new);
                Ok(changed)
            }
            [] => Err(format!("line {} does not hold `{}`", self.line, self.old)),
            _ => Err(format!(
                "line {} holds `{}` more than once",
                self.line, self.old
            )),
        }
    }

    /// Whether the value at this place of a line is no part of a longer word or number.
    fn stands_alone(&self, line: &str, at: usize) -> bool {
        let is_word =
            |c: Option<char>| c.is_some_and(|c| c.is_alphanumeric() || c == '_' || c == '.');
        let (before, after) = (&line[..at], &line[at + self.old.len()..]);
        let (first, last) = (self.old.chars().next(), self.old.chars().next_back());
        let continues_before = is_word(first) && is_word(before.chars().next_back());
        let continues_after = is_word(last) && is_word(after.chars().next());
        !(continues_before || continues_after)
    }
}

#[cfg(test)]
mod tests {
    use super::OneValue;

    #[test]
    fn a_value_is_replaced_where_it_stands_alone() {
        let text = "a = 125\nb = { within_secs = 25, x = 125 }\nc = 25 + 25\n";
        let of = |line: u32| OneValue {
            line,
            old: "25".into(),
            new: "60".into(),
        };
        let changed = text.replace("secs = 25,", "secs = 60,");
        assert_eq!(of(2).make(text), Ok(changed));
        assert!(
            of(1).make(text).is_err() && of(3).make(text).is_err() && of(9).make(text).is_err()
        );
    }
}
