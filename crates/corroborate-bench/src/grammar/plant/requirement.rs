//! Faults of requirement models: limits, clauses, bindings of words, units.

use super::{Plant, Planted, culprit, share, worth};
use crate::grammar::draft::Draft;
use crate::grammar::files::{ids, names};
use crate::random::Random;
use crate::theory::{Side, power, seen};

pub(super) fn judged_runs(draft: &Draft) -> usize {
    draft.sizes.episodes + draft.sizes.recordings
}

pub(super) fn bound(draft: &mut Draft, planted: &mut Planted, random: &mut Random) -> Option<()> {
    let factor = match random.below(4) {
        // Seconds taken for the model's units, or the other way round; as a limit in tenths.
        0 if (draft.truth.step_secs - 1.0).abs() > 0.1 => draft.truth.step_secs,
        1 => 10.0,
        _ => random.one_of(&[0.6, 0.75, 0.85, 1.3, 1.6, 2.5]),
    };
    let limit = draft.forms.limit_secs;
    let wrong = (limit * factor * 100.0).round() / 100.0;
    let is_property = planted.plant == Plant::PropertyBound;
    if is_property {
        draft.forms.property_limit = draft.in_model_time(wrong);
        planted.culprits = vec![culprit("property", ids::IN_TIME)];
    } else {
        draft.forms.monitor_secs = wrong;
        planted.culprits = vec![culprit("monitor", ids::IN_TIME)];
    }
    let done = draft.truth.done;
    let by = |limit: f64| {
        share(draft, &|run, _| {
            run.entered(done).is_some_and(|at| at <= limit + 1e-9)
        })
    };
    let (right, judged) = (by(limit), by(wrong));
    planted.power = if is_property {
        let trials = worth(draft, (draft.cohort.rows * draft.cohort.attempts) as f64);
        let others = [trials, draft.sizes.episodes as f64]
            .map(|n| power(Side::computed(judged), Side::independent(right, n), 0.05));
        others[0].max(others[1])
    } else {
        let episodes = Side::independent(judged, draft.sizes.episodes as f64);
        power(episodes, Side::computed(right), 0.05)
    };
    if draft.forms.has_sentences && (right - judged).abs() > 0.0 {
        // Forms are held against their sentence: the limits differ in the text itself.
        planted.power = 1.0;
    }
    planted.subjects = vec![ids::IN_TIME.into()];
    planted.mended_in = vec![names::REQUIREMENTS];
    planted.words = format!("a limit of {wrong} s instead of {limit} s");
    Some(())
}

pub(super) fn clause(draft: &mut Draft, planted: &mut Planted) -> Option<()> {
    let success = draft.truth.reaches(draft.truth.done);
    if planted.plant == Plant::PropertyClause {
        draft.forms.property_goal = "ended".into();
        planted.culprits = vec![culprit("property", ids::DONE)];
    } else {
        draft.forms.monitor_goal = "ended".into();
        planted.culprits = vec![culprit("monitor", ids::DONE)];
    }
    planted.power = seen(1.0 - success, judged_runs(draft));
    planted.subjects = vec![ids::DONE.into()];
    planted.mended_in = vec![names::REQUIREMENTS];
    planted.words = "a form waits for the end of the run".into();
    Some(())
}

pub(super) fn binding(draft: &mut Draft, planted: &mut Planted) -> Option<()> {
    let near = draft.truth.near?;
    // The state before: not all that come near have been completed, by the clock; or the wrong end.
    let worst = draft.truth.modes.iter().max_by(|one, other| {
        draft
            .truth
            .reaches(one.failed)
            .total_cmp(&draft.truth.reaches(other.failed))
    })?;
    let (failed, is_model) = (worst.failed, planted.plant == Plant::ModelBinding);
    let _ = near;
    let word = draft.truth.locations[draft.truth.done].clone();
    if is_model {
        draft.bindings.done_in_model = Some(failed);
    } else {
        draft.bindings.done_in_traces = Some(failed);
    }
    planted.culprits = vec![culprit("vocabulary", &word), culprit("vocabulary", "")];
    planted.power = 1.0;
    planted.subjects = [ids::DONE, ids::IN_TIME, ids::RESPONSE]
        .map(str::to_owned)
        .into();
    planted.mended_in = vec![names::VOCABULARY];
    planted.mended_by = if is_model {
        "model".into()
    } else {
        "trace".into()
    };
    planted.words = format!(
        "the word {word} means the end {} to {}",
        draft.truth.locations[failed],
        if is_model { "the model" } else { "traces" }
    );
    Some(())
}

pub(super) fn unit(draft: &mut Draft, planted: &mut Planted) -> Option<()> {
    planted.subjects = vec![ids::SLOW.into()];
    if planted.plant == Plant::SpeedUnit {
        draft.forms.speed_text = format!("{} m/s", (draft.forms.speed_limit * 1000.0).round());
        planted.culprits = vec![culprit("vocabulary", ""), culprit("monitor", ids::SLOW)];
        planted.mended_in = vec![names::VOCABULARY, names::REQUIREMENTS];
        planted.words = format!("slow means {}", draft.forms.speed_text);
    } else {
        // Gaps of 0.4 and 3 seem to be millimetres: somebody is near all the time.
        draft.bindings.gap_unit = Some(if draft.columns.gap > 1.0 { "m" } else { "mm" });
        planted.culprits = vec![
            culprit("vocabulary", ""),
            culprit("data", ""),
            culprit("monitor", ids::SLOW),
        ];
        planted.mended_in = vec![names::TOPICS];
        planted.words = "the map of topics has another unit of length".into();
    }
    // Both that could tell read the same words: no difference between pieces of evidence shows it.
    planted.power = 0.0;
    Some(())
}
