//! How clearly a scenario has to show what it is kept for.
//!
//! # Definition
//! A requirement is violated *by* minus its space-time robustness ([`judging::SpaceTime`]): a share of what is allowed, of a
//! limit or of a time. What is kept has to be violated by at least a margin. If none is asked for it is
//! [`DEFAULT`], or half of what the finding itself is violated by, if that is less: so a finding that is only just one
//! can be made smaller, too.
//!
//! Without it shrinking ends where the scenario only just shows it, and the least change of the robot, of the physics or of the
//! compiler fixes it for show.
//!
//! Of what no number grades there is no margin: of truth values alone in a formula, of a program that fails, of steps that a
//! formal model does not have.

use diagnostic::Problem;
use judging::SpaceTime;
use study::{Shows, Study};
use testbench::Recorded;

/// The margin if none is asked for: a tenth of what is allowed.
pub const DEFAULT: f64 = 0.1;

/// What grades a violation, and the margin that is asked for.
pub struct Clarity<'a> {
    space_time: Option<SpaceTime<'a>>,
    asked: Option<f64>,
}

/// What is demanded of all scenarios of a finding.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Margin {
    /// By how much the finding itself is violated.
    pub own: f64,
    /// By how much what is kept has to be.
    pub least: f64,
}

impl<'a> Clarity<'a> {
    /// Prepares to grade what a finding shows.
    pub fn new(study: &'a Study, shows: &Shows, asked: Option<f64>) -> Result<Self, Problem> {
        let space_time = match shows {
            Shows::Violated(id) | Shows::FailureMode(id) => SpaceTime::new(study, id, None)?,
            Shows::Failed(_) | Shows::Unknown(_) => None,
        };
        Ok(Self { space_time, asked })
    }

    /// By how much an episode that shows it violates it; `None` if no number says so.
    pub fn violated_by(&self, recorded: &Recorded) -> Result<Option<f64>, Problem> {
        let Some(space_time) = &self.space_time else {
            return Ok(None);
        };
        let robustness = space_time.of(&recorded.trace)?;
        Ok(robustness.filter(|it| it.is_finite()).map(|it| -it))
    }

    /// What is demanded, given by how much the finding itself is violated.
    pub fn margin(&self, own: Option<f64>) -> Result<Option<Margin>, Problem> {
        let Some(own) = own.filter(|own| *own > 0.0) else {
            return match self.asked {
                Some(asked) if asked > 0.0 => {
                    let message =
                        "no number says how clearly the finding is shown, so no margin can be kept";
                    Err(Problem::new("no-margin", message).remedy(
                        "leave out the margin (--margin on the command line), or give a word of the requirement `graded` in the vocabulary",
                    ))
                }
                _ => Ok(None),
            };
        };
        let least = match self.asked {
            None => DEFAULT.min(own / 2.0),
            Some(asked) if asked <= own => asked,
            Some(asked) => {
                let message = format!(
                    "the finding is violated by {own:.3} of what is allowed, less than the margin of {asked}"
                );
                return Err(Problem::new("no-margin", message).remedy(format!(
                    "ask for at most {:.3} (--margin on the command line), or shrink an episode that violates it more clearly",
                    (own * 1000.0).floor() / 1000.0
                )));
            }
        };
        Ok(Some(Margin { own, least }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn asked(asked: Option<f64>) -> Clarity<'static> {
        Clarity {
            space_time: None,
            asked,
        }
    }

    #[test]
    fn the_default_is_a_tenth_or_half_of_what_the_finding_has() {
        let least = |own: f64| asked(None).margin(Some(own)).unwrap().unwrap().least;
        assert_eq!([least(0.8), least(0.2), least(0.1)], [0.1, 0.1, 0.05]);
        assert_eq!(asked(None).margin(None), Ok(None));
        assert_eq!(asked(Some(0.0)).margin(None), Ok(None));
        assert_eq!(
            asked(Some(0.0)).margin(Some(0.3)).unwrap().unwrap().least,
            0.0
        );
    }

    #[test]
    fn a_margin_that_the_finding_itself_does_not_keep_is_refused() {
        let margin = asked(Some(0.3)).margin(Some(0.4)).unwrap();
        assert_eq!(
            margin,
            Some(Margin {
                own: 0.4,
                least: 0.3
            })
        );
        for (own, word) in [(Some(0.2), "by 0.200"), (None, "no number")] {
            let problem = asked(Some(0.3)).margin(own).unwrap_err();
            assert_eq!(problem.code, "no-margin");
            assert!(problem.to_string().contains(word), "{problem}");
        }
    }
}
