//! The passes of shrinking, each of which only ever replaces the best by something smaller.

use std::collections::BTreeMap;

use stimulus::{Action, Distribution, Setting, Stimulus, Verb};

use super::Shrinking;
use super::size::{PLAIN_DIGITS, digits, is_constant, rounded};

/// Every pass once.
pub(super) fn all(search: &mut Shrinking<'_>) {
    fewer_actions(search);
    fewer_values(search);
    fewer_settings(search);
    shorter_delays(search);
    rounder_numbers(search);
    nearer_numbers(search);
}

fn fewer_actions(search: &mut Shrinking<'_>) {
    let actions = search.best.test.actions.clone();
    minimise(search, &actions, &|stimulus, kept: &[Action]| {
        stimulus.test.actions = kept.to_vec();
    });
}

fn fewer_values(search: &mut Shrinking<'_>) {
    for index in 0..search.best.test.actions.len() {
        let Some(values) = values_of(&search.best, index).cloned() else {
            continue;
        };
        let entries: Vec<(String, Setting)> = values.into_iter().collect();
        minimise(search, &entries, &|stimulus, kept: &[(String, Setting)]| {
            if let Some(values) = values_of_mut(stimulus, index) {
                *values = kept.iter().cloned().collect();
            }
        });
    }
}

fn fewer_settings(search: &mut Shrinking<'_>) {
    let settings: Vec<(String, Setting)> = search.best.settings.clone().into_iter().collect();
    let all = search.best.settings.clone();
    let (nominal, drawn) = (&search.options.nominal, &search.options.drawn);
    let left_out = |stimulus: &mut Stimulus, kept: &[(String, Setting)]| {
        stimulus.settings = kept.iter().cloned().collect();
        for key in drawn.iter().filter(|key| all.contains_key(*key)) {
            let value = nominal.get(key).cloned();
            if let (Some(value), false) = (value, stimulus.settings.contains_key(key)) {
                stimulus.settings.insert(key.clone(), value);
            }
        }
    };
    one_alone(search, &settings, &left_out);
    // Left to the bench altogether, then those that stay back at their nominal values.
    let settings: Vec<(String, Setting)> = search.best.settings.clone().into_iter().collect();
    minimise(search, &settings, &left_out);
    let kept: Vec<(String, Setting)> = search.best.settings.clone().into_iter().collect();
    minimise(search, &kept, &|stimulus, kept: &[(String, Setting)]| {
        stimulus.settings = kept.iter().cloned().collect();
        for key in all
            .keys()
            .filter(|key| !stimulus.settings.contains_key(*key))
            .cloned()
            .collect::<Vec<_>>()
        {
            if let Some(value) = nominal.get(&key) {
                stimulus.settings.insert(key, value.clone());
            }
        }
    });
}

/// Whether it takes none of the settings, or only one: delta debugging can end at several that
/// together do the same.
fn one_alone<T>(search: &mut Shrinking<'_>, settings: &[T], keep: &dyn Fn(&mut Stimulus, &[T])) {
    for kept in std::iter::once(&[][..]).chain(settings.chunks(1)) {
        let mut candidate = search.best.clone();
        keep(&mut candidate, kept);
        if search.accept(candidate) {
            return;
        }
    }
}

fn values_of(stimulus: &Stimulus, action: usize) -> Option<&BTreeMap<String, Setting>> {
    match &stimulus.test.actions.get(action)?.verb {
        Verb::Set(values) => Some(values),
        _ => None,
    }
}

fn values_of_mut(stimulus: &mut Stimulus, action: usize) -> Option<&mut BTreeMap<String, Setting>> {
    match &mut stimulus.test.actions.get_mut(action)?.verb {
        Verb::Set(values) => Some(values),
        _ => None,
    }
}

/// Delta debugging: leaves out as many items as possible, so that no single one can be left out.
fn minimise<T: Clone>(search: &mut Shrinking<'_>, items: &[T], keep: &dyn Fn(&mut Stimulus, &[T])) {
    let mut items = items.to_vec();
    let mut parts = 1;
    while !items.is_empty() && !search.exhausted {
        let length = items.len().div_ceil(parts);
        let step = (0..items.len()).step_by(length).find_map(|start| {
            let end = (start + length).min(items.len());
            let without = [&items[..start], &items[end..]].concat();
            let mut candidate = search.best.clone();
            keep(&mut candidate, &without);
            search.accept(candidate).then_some(without)
        });
        match step {
            Some(fewer) => {
                items = fewer;
                parts = (parts - 1).max(2).min(items.len().max(1));
            }
            None if parts >= items.len() => break,
            None => parts = (2 * parts).min(items.len()),
        }
    }
}

/// Brings each setting as near to its nominal value as still shows it, by bisection over numbers of
/// [`PLAIN_DIGITS`] digits. Where that depends on the number in some other way than by a limit, what
/// is found is a limit all the same, and not the only one.
fn nearer_numbers(search: &mut Shrinking<'_>) {
    for key in search.best.settings.keys().cloned().collect::<Vec<_>>() {
        let (Some(Setting::Number(nominal)), Some(Setting::Number(start))) = (
            search.options.nominal.get(&key).cloned(),
            search.best.settings.get(&key).cloned(),
        ) else {
            continue;
        };
        let largest = nominal.abs().max(start.abs());
        if nominal == start || largest == 0.0 {
            continue;
        }
        let unit = 10_f64.powi(largest.log10().floor() as i32 + 1 - PLAIN_DIGITS as i32);
        // Whole units from the nominal value: at `far` it shows, at `near` it does not.
        let (mut near, mut far) = (0.0, ((start - nominal) / unit).abs().ceil());
        let direction = (start - nominal).signum();
        while far - near > 1.0 && !search.exhausted {
            let middle = ((near + far) / 2.0).floor();
            let value = rounded(nominal + direction * middle * unit, PLAIN_DIGITS);
            let mut candidate = search.best.clone();
            candidate
                .settings
                .insert(key.clone(), Setting::Number(value));
            match search.accept(candidate) {
                true => far = middle,
                false => near = middle,
            }
        }
    }
}

fn shorter_delays(search: &mut Shrinking<'_>) {
    for index in 0..search.best.test.actions.len() {
        let delay = |search: &Shrinking<'_>| search.best.test.actions[index].after_secs.clone();
        if set_delay(search, index, 0.0) {
            continue;
        }
        let middle = delay(search).quantile(0.5);
        if !is_constant(&delay(search)) && !set_delay(search, index, rounded(middle, 2)) {
            // A constant of the random delay's very middle can be longer by rounding.
            set_delay(search, index, middle);
        }
        while let Distribution::Constant(secs) = delay(search) {
            let half = rounded(0.5 * secs, 1);
            // Below a millisecond a shorter time is no simpler one.
            if secs <= 1e-3 || half >= secs || !set_delay(search, index, half) {
                break;
            }
        }
    }
}

fn set_delay(search: &mut Shrinking<'_>, index: usize, secs: f64) -> bool {
    let mut candidate = search.best.clone();
    candidate.test.actions[index].after_secs = Distribution::Constant(secs);
    search.accept(candidate)
}

fn rounder_numbers(search: &mut Shrinking<'_>) {
    for key in search.best.settings.keys().cloned().collect::<Vec<_>>() {
        if search.options.nominal.get(&key) == search.best.settings.get(&key) {
            continue;
        }
        round(search, &|stimulus| stimulus.settings.get_mut(&key));
    }
    for index in 0..search.best.test.actions.len() {
        let names: Vec<String> = values_of(&search.best, index)
            .map(|v| v.keys().cloned().collect())
            .unwrap_or_default();
        for name in names {
            round(search, &|stimulus| {
                values_of_mut(stimulus, index)?.get_mut(&name)
            });
        }
        round_delay(search, index);
    }
}

/// Gives the number at a place as few digits as possible: zero, then one digit, then two, ...
fn round(search: &mut Shrinking<'_>, place: &dyn Fn(&mut Stimulus) -> Option<&mut Setting>) {
    let Some(Setting::Number(number)) = place(&mut search.best.clone()).cloned() else {
        return;
    };
    for candidate_digits in 0..digits(number) {
        for value in roundings(number, candidate_digits) {
            let mut candidate = search.best.clone();
            if let Some(setting) = place(&mut candidate) {
                *setting = Setting::Number(value);
            }
            if search.accept(candidate) {
                return;
            }
        }
    }
}

fn round_delay(search: &mut Shrinking<'_>, index: usize) {
    let Distribution::Constant(secs) = search.best.test.actions[index].after_secs else {
        return;
    };
    for candidate_digits in 1..digits(secs) {
        let found = roundings(secs, candidate_digits)
            .into_iter()
            .any(|value| value <= secs && set_delay(search, index, value));
        if found {
            return;
        }
    }
}

/// The nearest number with so many digits, and its neighbours on either side.
fn roundings(number: f64, digits: usize) -> Vec<f64> {
    if digits == 0 {
        return vec![0.0];
    }
    let nearest = rounded(number, digits);
    let exponent = number.abs().log10().floor() as i32 + 1 - digits as i32;
    let unit = 10.0_f64.powi(exponent);
    let other = if nearest > number {
        nearest - unit
    } else {
        nearest + unit
    };
    let other = rounded(other, digits);
    if other == nearest || !other.is_finite() || other.signum() != number.signum() {
        return vec![nearest];
    }
    vec![nearest, other]
}
