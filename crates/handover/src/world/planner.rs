//! The motion planner as the robot's code meets it: it answers after a while, or never.
//!
//! A run fails at a declared rate. In a failing run one of the requests, drawn uniformly from
//! those of a complete handover, is never answered. This is a modelled fault: nothing in the
//! physics causes it.

use testbench::{Distribution, Stream};

use crate::robot::PlannerStatus;
use crate::scenario::PlannerParameters;

/// Requests in a complete handover: prepare, above, pickup, lift, serve.
const REQUESTS_PER_RUN: usize = 5;

/// The planner in one episode.
#[derive(Debug, Clone)]
pub(crate) struct Planner {
    answer_secs: Distribution,
    stream: Stream,
    unanswered_request: Option<u32>,
    handled_requests: u32,
    answer_at_secs: f64,
}

impl Planner {
    pub(crate) fn new(parameters: &PlannerParameters, mut stream: Stream) -> Self {
        let fails = stream.chance(parameters.failure_rate_per_run);
        let which = stream.index(REQUESTS_PER_RUN) as u32 + 1;
        Self {
            answer_secs: parameters.answer_secs,
            stream,
            unanswered_request: fails.then_some(which),
            handled_requests: 0,
            answer_at_secs: f64::NEG_INFINITY,
        }
    }

    /// Draws what is still open from another stream: answer times, and which request goes
    /// unanswered, given that those handled so far were answered. With failure rate p and k of n
    /// requests answered, that is one of the others with probability
    /// `p (n - k)/n / (1 - p k/n)`.
    pub(crate) fn draw_anew(&mut self, parameters: &PlannerParameters, mut stream: Stream) {
        let handled = self.handled_requests as usize;
        let has_failed = (self.unanswered_request).is_some_and(|which| which <= handled as u32);
        let open = REQUESTS_PER_RUN.saturating_sub(handled);
        if !has_failed {
            let rate = parameters.failure_rate_per_run;
            let share = |requests: usize| rate * requests as f64 / REQUESTS_PER_RUN as f64;
            let so_far = 1.0 - share(REQUESTS_PER_RUN - open);
            let fails = open > 0 && stream.unit() * so_far < share(open);
            let which = handled + stream.index(open) + 1;
            self.unanswered_request = fails.then_some(which as u32);
        }
        self.stream = stream;
    }

    /// Takes the robot's count of requests and says how the last one stands.
    pub(crate) fn update(&mut self, requests: u32, now_secs: f64) -> PlannerStatus {
        if requests == 0 {
            return PlannerStatus::Idle;
        }
        if requests > self.handled_requests {
            self.handled_requests = requests;
            let takes_secs = self.answer_secs.draw(&mut self.stream);
            let fails = self.unanswered_request == Some(requests);
            self.answer_at_secs = if fails {
                f64::INFINITY
            } else {
                now_secs + takes_secs
            };
        }
        if now_secs + 1e-9 >= self.answer_at_secs {
            PlannerStatus::Answered
        } else {
            PlannerStatus::Working
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::purpose::Purpose;

    fn planner(failure_rate_per_run: f64, seed: u64) -> Planner {
        let answer_secs = Distribution::Constant(0.3);
        let parameters = PlannerParameters {
            failure_rate_per_run,
            answer_secs,
        };
        Planner::new(&parameters, Stream::new(seed, Purpose::Planner))
    }

    #[test]
    fn an_answer_comes_after_its_time() {
        let mut planner = planner(0.0, 1);
        assert_eq!(planner.update(0, 0.9), PlannerStatus::Idle);
        assert_eq!(planner.update(1, 1.0), PlannerStatus::Working);
        assert_eq!(planner.update(1, 1.28), PlannerStatus::Working);
        assert_eq!(planner.update(1, 1.3), PlannerStatus::Answered);
        assert_eq!(planner.update(2, 1.32), PlannerStatus::Working);
    }

    #[test]
    fn drawn_anew_after_answers_the_rest_fails_at_its_conditional_rate() {
        let parameters = PlannerParameters {
            failure_rate_per_run: 0.5,
            answer_secs: Distribution::Constant(0.3),
        };
        // Three of five answered: (0.5 * 2/5) / (1 - 0.5 * 3/5) = 2/7, requests 4 and 5 alike.
        let (mut fourth, mut fifth) = (0, 0);
        for seed in 0..7000 {
            let mut planner = planner(0.0, seed);
            for request in 1..=3 {
                planner.update(request, 0.0);
            }
            planner.draw_anew(&parameters, Stream::new(seed, Purpose::Planner));
            fourth += u32::from(planner.unanswered_request == Some(4));
            fifth += u32::from(planner.unanswered_request == Some(5));
        }
        // 1000 each in the mean with a standard deviation of 29.
        assert!((850..1150).contains(&fourth) && (850..1150).contains(&fifth));
        let mut failed = planner(1.0, 1);
        let which = failed.unanswered_request;
        failed.update(5, 0.0);
        failed.draw_anew(&parameters, Stream::new(9, Purpose::Planner));
        assert_eq!(failed.unanswered_request, which, "what has happened stays");
    }

    #[test]
    fn a_failing_run_leaves_exactly_one_of_the_five_requests_unanswered() {
        let mut seen = [0; 6];
        for seed in 0..200 {
            let mut planner = planner(1.0, seed);
            let unanswered: Vec<u32> = (1..=5)
                .filter(|request| {
                    planner.update(*request, 0.0);
                    planner.update(*request, 1e6) != PlannerStatus::Answered
                })
                .collect();
            assert_eq!(unanswered.len(), 1);
            seen[unanswered[0] as usize] += 1;
        }
        // 40 each in the mean with a standard deviation of 5.7.
        assert!(
            seen[1..].iter().all(|count| (15..65).contains(count)),
            "{seen:?}"
        );
    }
}
