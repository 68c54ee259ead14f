//! Mutation: small changes of tests that were interesting.
//!
//! Insert an action of the grammar, leave one out, swap two, replace one, change a value, stretch
//! or squeeze a delay, or go over into another interesting test. Source: M. Zalewski, "american
//! fuzzy lop" (2013), for the cycle of mutating what showed something new; B. Miller, L.
//! Fredriksen and B. So (1990) before it. Deviation: operators know actions instead of bytes.
//! Cost: linear in the test's length. Guarantee: results keep the grammar's rules and differ from
//! the test in content.

use stimulus::{AbstractTest, Action, Distribution, Setting, Stimulus, Verb};

use super::grammar::Grammar;
use crate::error::CampaignError;
use crate::random::Random;

const TRIES: usize = 500;

impl Grammar {
    /// A test that differs from `test` by one to three small changes, or goes over into one of
    /// `others` at some action.
    ///
    /// # Errors
    /// [`CampaignError::TooTight`] when 500 changes in a row broke a rule.
    pub fn mutate(
        &self,
        test: &AbstractTest,
        others: &[AbstractTest],
        random: &mut Random,
    ) -> Result<AbstractTest, CampaignError> {
        let content = Stimulus::of(test.clone()).content_hash();
        for _ in 0..TRIES {
            let mut mutant = test.clone();
            for _ in 0..=random.index(3) {
                self.change(&mut mutant, others, random);
            }
            let differs = Stimulus::of(mutant.clone()).content_hash() != content;
            if differs && self.allows(&mutant) && mutant.check().is_ok() {
                return Ok(mutant);
            }
        }
        Err(CampaignError::TooTight { tried: TRIES })
    }

    /// One change; none where it makes no sense.
    fn change(&self, test: &mut AbstractTest, others: &[AbstractTest], random: &mut Random) {
        let count = test.actions.len();
        let place = random.index(count);
        match random.index(7) {
            0 => test
                .actions
                .insert(random.index(count + 1), self.any_action(random)),
            _ if count == 0 => {}
            1 => {
                test.actions.remove(place);
            }
            2 => test.actions.swap(place, random.index(count)),
            3 => test.actions[place] = self.any_action(random),
            4 => self.change_value(&mut test.actions[place], random),
            5 => change_delay(&mut test.actions[place], random),
            _ => go_over(test, others, random),
        }
    }

    fn any_action(&self, random: &mut Random) -> Action {
        let weights = self.alternatives.iter().map(|a| a.weight.unwrap_or(1.0));
        let weights: Vec<f64> = weights.collect();
        let index = random.weighted(&weights).unwrap_or(0);
        // `check` refuses a grammar without alternatives.
        match self.alternatives.get(index) {
            Some(alternative) => alternative.draw(None, random),
            None => Action::new(Verb::Set(std::collections::BTreeMap::new())),
        }
    }

    /// Another value for one parameter of a `set` action, if the grammar knows it.
    fn change_value(&self, action: &mut Action, random: &mut Random) {
        let Verb::Set(values) = &mut action.verb else {
            return;
        };
        let index = random.index(values.len());
        let Some((name, value)) = values.iter_mut().nth(index) else {
            return;
        };
        let known = self
            .alternatives
            .iter()
            .filter_map(|a| a.set_param.as_ref()?.get(name));
        if let Some(known) = known.into_iter().next() {
            *value = known.draw(random);
        } else if let Setting::Bool(yes) = value {
            *yes = !*yes;
        }
    }
}

/// A shorter or longer delay; a random one becomes the one or the other end of what it can be.
fn change_delay(action: &mut Action, random: &mut Random) {
    let factor = [0.0, 0.5, 2.0, 5.0][random.index(4)];
    let secs = match &action.after_secs {
        Distribution::Constant(secs) if *secs == 0.0 => factor * 0.5,
        Distribution::Constant(secs) => factor * secs,
        other => other.quantile(if random.chance(0.5) { 1e-3 } else { 0.999 }),
    };
    action.after_secs = Distribution::Constant(secs.max(0.0));
}

/// The beginning of this test and the end of another one.
fn go_over(test: &mut AbstractTest, others: &[AbstractTest], random: &mut Random) {
    let Some(other) = others.get(random.index(others.len())) else {
        return;
    };
    test.actions.truncate(random.index(test.actions.len() + 1));
    let from = random.index(other.actions.len() + 1);
    test.actions.extend_from_slice(&other.actions[from..]);
}
