//! How to read the report, for someone new to it.

use maud::{Markup, html};

use crate::view::{View, chip, section};
use crate::words;
use evidence::{Outcome, Verdict};

/// The section.
pub fn render(view: View) -> Markup {
    let lead = html! { "The words of this report in plain language." };
    let body = html! {
        h3 { "Verdicts on a requirement" }
        dl class="glossary" {
            (verdict_term(Verdict::Satisfied, "Evidence supports that the requirement holds, and none says otherwise."))
            (verdict_term(Verdict::Violated, "Evidence shows that it does not hold. For a requirement that asks for “always”, one violation is enough."))
            (verdict_term(Verdict::Conflicting, "Pieces of evidence contradict each other, so at least one of their models is wrong."))
            (verdict_term(Verdict::Undecided, "The evidence does not decide."))
            (verdict_term(Verdict::NotCovered, "No evidence covers it."))
            (term("At least, below, open", "In the matrix: the one-sided limit of this piece shows that what is required is met, that it is not, or neither. This is one piece's view; the conclusion weighs them all."))
        }
        h3 { "The three techniques" }
        dl class="glossary" {
            (term("Model checking", "A computer explores every possible behaviour of a simplified, formal model and computes the probability that the requirement holds. Complete, but only as true as the model."))
            (term("Simulation", "The robot's control code runs many times in a simulated physical world; monitors judge each run. More realistic, but a sample."))
            (term("Experiments", "People use the real robot. The most real, and the fewest trials."))
        }
        h3 { "Numbers and their uncertainty" }
        dl class="glossary" {
            (term("Interval", &format!("The range of rates with which the observed counts are compatible, {}. Few trials give a wide interval. Where trials by the same person resemble each other, it is widened to allow for that. A verdict has limits of one side, at the level that its requirement has in the study, which hold at every look where they say so.", words::intervals(view.study))))
            (term("Credible interval", "A formal model gives one exact number, but some of its constants were estimated from counts. Their uncertainty, carried through the model, gives this range. It is drawn as a band; each thin line in it is equally probable."))
            (term("Guarantee", "How far a computed number can be trusted. Exact: no rounding. Bounded: the true value lies within stated bounds. Statistical: it lies within them with a stated confidence. Estimated: the iteration stopped without an error bound."))
            (term("1 − 1.1×10⁻⁵³", "A probability so near to one that its digits would all be nines: one minus the number shown."))
            (term("Covered", "The situation about which the requirement speaks did arise. A run in which it did not is not counted. Not covered is not the same as not expressible, which means that the model cannot even say it."))
            (term("Opportunity", "A moment at which a failure mode could have occurred. Its rate is occurrences by opportunities: a sensor that was never asked cannot be wrong."))
        }
        h3 { "Comparing two pieces of evidence" }
        dl class="glossary" {
            (term("Margin", "The largest difference of two rates that still counts as agreement. It is declared before comparing."))
            (outcome_term(Outcome::Corroborates, "The difference is shown to be smaller than the margin. Merely not finding a difference is not enough."))
            (outcome_term(Outcome::Conflicts, "The difference is beyond chance, allowing for the number of comparisons made, and its estimate is the margin or more; or one computes to be impossible what the other counted."))
            (outcome_term(Outcome::Inconclusive, "Neither is shown, or a difference whose estimate lies within the margin. The report says how many further trials would probably decide."))
            (outcome_term(Outcome::NotComparable, "The two measure different things: other conditions, or one of them never saw the situation."))
            (term("Fit", "One side was tuned to the other, so their agreement is a fit. It shows that tuning worked and is not confirmation."))
            (term("p-value", "How often chance alone would produce a difference at least this large (“no difference”), or a difference this small although the true one exceeds the margin (“beyond margin”). Corrected: allowing for the number of comparisons."))
        }
        h3 { "Why evidence disagrees" }
        dl class="glossary" {
            (term("System model inaccuracy", "The formal model or the simulation behaves otherwise than the robot."))
            (term("Requirement model inaccuracy", "The logical property or the monitor says something else than the requirement's text."))
            (term("Tool inaccuracy", "The solver or the simulator computed something else than it was asked to."))
        }
    };
    section("reading", "How to read this report", lead, body)
}

fn term(name: &str, meaning: &str) -> Markup {
    html! { div { dt { (name) } dd { (meaning) } } }
}

fn verdict_term(verdict: Verdict, meaning: &str) -> Markup {
    html! { div { dt { (chip(&words::verdict(verdict))) } dd { (meaning) } } }
}

fn outcome_term(outcome: Outcome, meaning: &str) -> Markup {
    html! { div { dt { (chip(&words::outcome(outcome))) } dd { (meaning) } } }
}
