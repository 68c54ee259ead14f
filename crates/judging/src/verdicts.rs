//! The verdicts of all runs of an entry, by which a diagnosis compares forms without judging any run again.
//!
//! A run is kept as a text with a letter for each verdict: those of the study's monitors, `/`, those of the forms that
//! are held against each other (`s` satisfied, `v` violated, `i` inconclusive, `n` not covered).

use serde::{Deserialize, Serialize};
use temporal::monitor::Verdict;

/// The verdicts of runs, in the runs' order.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "Vec<String>", into = "Vec<String>")]
pub struct RunVerdicts {
    /// By run, one for each main monitor and reading.
    pub main: Vec<Vec<Verdict>>,
    /// By run, one for each form that is held against another.
    pub forms: Vec<Vec<Verdict>>,
}

impl RunVerdicts {
    /// Adds a run.
    pub fn add(&mut self, main: Vec<Verdict>, forms: Vec<Verdict>) {
        self.main.push(main);
        self.forms.push(forms);
    }
}

impl From<RunVerdicts> for Vec<String> {
    fn from(verdicts: RunVerdicts) -> Self {
        let text = |of: Vec<Verdict>| of.into_iter().map(letter).collect::<String>();
        let runs = verdicts.main.into_iter().zip(verdicts.forms);
        runs.map(|(main, forms)| format!("{}/{}", text(main), text(forms)))
            .collect()
    }
}

impl TryFrom<Vec<String>> for RunVerdicts {
    type Error = String;

    fn try_from(texts: Vec<String>) -> Result<Self, String> {
        let wrong = |text: &str| format!("`{text}` does not tell verdicts");
        let read = |text: &str| text.chars().map(verdict).collect::<Option<Vec<Verdict>>>();
        let mut verdicts = Self::default();
        for text in texts {
            let both = text.split_once('/');
            let both = both.and_then(|(main, forms)| Some((read(main)?, read(forms)?)));
            let (main, forms) = both.ok_or_else(|| wrong(&text))?;
            verdicts.add(main, forms);
        }
        Ok(verdicts)
    }
}

fn letter(verdict: Verdict) -> char {
    match verdict {
        Verdict::Satisfied => 's',
        Verdict::Violated => 'v',
        Verdict::Inconclusive => 'i',
        Verdict::NotCovered => 'n',
    }
}

fn verdict(letter: char) -> Option<Verdict> {
    Some(match letter {
        's' => Verdict::Satisfied,
        'v' => Verdict::Violated,
        'i' => Verdict::Inconclusive,
        'n' => Verdict::NotCovered,
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_kept_is_read_again_and_nothing_else() {
        let mut verdicts = RunVerdicts::default();
        let all = [
            Verdict::Satisfied,
            Verdict::Violated,
            Verdict::Inconclusive,
            Verdict::NotCovered,
        ];
        verdicts.add(all.to_vec(), vec![]);
        verdicts.add(vec![], vec![Verdict::Violated]);
        let text = serde_json::to_string(&verdicts).expect("text");
        assert_eq!(text, r#"["svin/","/v"]"#);
        assert_eq!(
            serde_json::from_str::<RunVerdicts>(&text).expect("read"),
            verdicts
        );
        for wrong in [r#"["s"]"#, r#"["x/"]"#] {
            assert!(serde_json::from_str::<RunVerdicts>(wrong).is_err());
        }
    }
}
