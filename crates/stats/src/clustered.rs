//! The interval of a rate whose trials come in clusters (subjects, sessions), chosen by measured
//! coverage, and the sample with which such a rate is compared.
//!
//! # Definition
//! With two or more clusters, not all of a single trial: the profile-likelihood interval of the
//! beta-binomial model's mean ([`mod@crate::beta_binomial`]), widened to the rate of all trials where that lies outside. In comparisons the rate counts as `n*`
//! independent trials: as many as leave Wilson's interval of the same rate equally wide, at most `N`.
//! So intervals and comparisons rest on the same variance.
//!
//! Where all outcomes are the same (0 of n, n of n) it counts as one trial for each cluster, with
//! Wilson's interval: nothing is known of how clusters differ, and ten subjects without a failure in ten trials
//! each may be ten of whom one in four always fails. Where other counts of the same clusters tell it,
//! [`clustered_rate_among`] asks them.
//!
//! A single cluster, or a single trial in each: Wilson's, trials taken as independent. Of a single
//! subject it then speaks of that subject.
//!
//! # Coverage
//! Exact, by all outcomes that clusters of these sizes can have (`tests/integration/cluster_coverage.rs`): percent of 95 % intervals,
//! by the rate, from the least to the most of correlations 0, 0.05, 0.1, 0.2, 0.3, 0.5 and 0.7.
//!
//! | clusters x trials | 0.5 | 0.7 | 0.88 | 0.95 | 0.97 | 0.99 |
//! |---|---|---|---|---|---|---|
//! | 2 x 10 | 100.0–100.0 | 98.0–100.0 | 99.4–100.0 | 99.7–100.0 | 99.8–100.0 | 99.9–100.0 |
//! | 3 x 10 | 98.2–100.0 | 98.4–100.0 | 99.0–99.9 | 99.3–99.8 | 99.5–99.9 | 99.3–99.9 |
//! | 4 x 5 | 92.9–99.8 | 98.4–99.7 | 99.0–99.5 | 99.3–99.8 | 99.1–99.8 | 99.6–99.9 |
//! | 5 x 2 | 92.3–97.8 | 99.0–99.4 | 99.3–99.7 | 98.7–99.3 | 98.9–99.7 | 99.6–99.8 |
//! | 5 x 4 | 95.9–99.6 | 98.7–99.5 | 99.0–99.5 | 99.1–99.4 | 98.8–99.8 | 98.6–99.8 |
//! | 5 x 5 | 94.5–99.1 | 98.4–99.6 | 98.6–99.4 | 99.1–99.6 | 98.8–99.5 | 99.4–99.8 |
//! | 5 x 10 | 94.6–99.3 | 96.4–99.3 | 98.8–99.4 | 98.9–99.3 | 98.9–99.7 | 99.1–99.7 |
//! | 7 x 10 | 95.0–98.6 | 95.2–98.4 | 98.4–99.0 | 98.7–99.3 | 98.7–99.2 | 99.1–99.5 |
//! | 10 x 2 | 95.9–97.3 | 94.7–97.8 | 98.6–98.7 | 98.6–99.0 | 98.0–98.5 | 98.4–99.3 |
//! | 10 x 5 | 95.4–97.6 | 94.1–97.7 | 98.3–98.8 | 98.5–98.9 | 98.3–98.8 | 98.5–99.0 |
//! | 20 x 2 | 95.0–96.8 | 95.5–96.8 | 97.8–98.3 | 98.1–98.6 | 97.2–98.8 | 97.8–99.2 |
//! | 20 x 3 | 95.3–96.4 | 95.1–96.5 | 92.6–96.4 | 98.2–98.3 | 98.2–99.1 | 97.7–98.4 |
//! | 20 x 5 | 95.2–97.0 | 95.2–97.0 | 95.1–97.6 | 98.2–98.9 | 98.2–99.0 | 98.3–98.6 |
//! | 50 x 2 | 95.0–95.6 | 95.3–95.7 | 94.4–95.5 | 97.7–98.0 | 97.3–98.0 | 98.2–98.6 |
//!
//! So of these at least 94.1 % from five clusters of four trials on. Below, whole numbers decide: of five clusters of two that are
//! all alike Wilson's interval of five trials misses a rate of 0.5, and where 1 of 60 trials of twenty clusters fails,
//! nothing shows that clusters differ (92.3 and 92.6 %). A single trial each has the coverage of Wilson's interval.
//!
//! # Why this one
//! What other intervals cover, in percent, and, in brackets, their mean width, over 1000 draws of clusters for
//! each row. *Pooled*: Wilson's, clusters ignored. *ANOVA*:
//! Wilson's at the effective size by analysis of variance. *Robust* and *adjusted*:
//! [`mod@crate::cluster_robust`].
//!
//! | clusters x trials | rate | correlation | pooled | ANOVA | robust | adjusted |
//! |---|---|---|---|---|---|---|
//! | 5 x 10 | 0.5 | 0 | 92.2 (0.26) | 93.7 (0.29) | 93.0 (0.34) | 99.9 (0.44) |
//! | 5 x 10 | 0.5 | 0.1 | 81.0 (0.26) | 90.8 (0.34) | 94.8 (0.46) | 98.8 (0.53) |
//! | 5 x 10 | 0.5 | 0.3 | 63.6 (0.26) | 87.9 (0.43) | 96.2 (0.60) | 97.5 (0.68) |
//! | 5 x 10 | 0.88 | 0 | 95.3 (0.18) | 96.0 (0.20) | 96.4 (0.27) | 99.9 (0.32) |
//! | 5 x 10 | 0.88 | 0.1 | 86.0 (0.18) | 89.7 (0.23) | 98.1 (0.36) | 99.4 (0.38) |
//! | 5 x 10 | 0.88 | 0.3 | 68.5 (0.17) | 80.7 (0.28) | 99.2 (0.49) | 99.8 (0.48) |
//! | 5 x 10 | 0.97 | 0 | 93.4 (0.11) | 93.9 (0.11) | 98.1 (0.30) | 100.0 (0.28) |
//! | 5 x 10 | 0.97 | 0.1 | 88.3 (0.11) | 94.4 (0.13) | 99.3 (0.39) | 100.0 (0.36) |
//! | 5 x 10 | 0.97 | 0.3 | 84.3 (0.10) | 94.4 (0.14) | 99.3 (0.48) | 99.9 (0.45) |
//! | 10 x 10 | 0.5 | 0 | 94.7 (0.19) | 95.7 (0.20) | 95.1 (0.21) | 99.3 (0.25) |
//! | 10 x 10 | 0.5 | 0.1 | 83.3 (0.19) | 93.1 (0.25) | 95.5 (0.29) | 96.8 (0.32) |
//! | 10 x 10 | 0.5 | 0.3 | 65.6 (0.19) | 92.4 (0.34) | 95.9 (0.40) | 96.9 (0.45) |
//! | 10 x 10 | 0.88 | 0 | 95.9 (0.13) | 96.5 (0.14) | 96.1 (0.15) | 99.6 (0.17) |
//! | 10 x 10 | 0.88 | 0.1 | 85.8 (0.13) | 93.4 (0.17) | 96.4 (0.21) | 98.3 (0.22) |
//! | 10 x 10 | 0.88 | 0.3 | 70.0 (0.12) | 87.9 (0.22) | 94.5 (0.29) | 95.8 (0.30) |
//! | 10 x 10 | 0.97 | 0 | 96.4 (0.07) | 97.0 (0.08) | 96.6 (0.11) | 99.7 (0.11) |
//! | 10 x 10 | 0.97 | 0.1 | 91.0 (0.07) | 96.1 (0.09) | 97.5 (0.16) | 99.1 (0.15) |
//! | 10 x 10 | 0.97 | 0.3 | 84.3 (0.07) | 95.7 (0.11) | 98.0 (0.23) | 99.5 (0.22) |
//! | 20 x 10 | 0.5 | 0 | 95.8 (0.14) | 96.8 (0.14) | 96.4 (0.15) | 98.3 (0.16) |
//! | 20 x 10 | 0.5 | 0.1 | 81.4 (0.14) | 94.2 (0.19) | 96.6 (0.20) | 96.9 (0.21) |
//! | 20 x 10 | 0.5 | 0.3 | 68.3 (0.14) | 93.5 (0.25) | 95.7 (0.28) | 96.8 (0.30) |
//! | 20 x 10 | 0.88 | 0 | 96.6 (0.09) | 96.6 (0.10) | 96.2 (0.10) | 98.2 (0.11) |
//! | 20 x 10 | 0.88 | 0.1 | 86.6 (0.09) | 95.1 (0.12) | 96.4 (0.14) | 97.5 (0.14) |
//! | 20 x 10 | 0.88 | 0.3 | 69.8 (0.09) | 91.7 (0.17) | 94.4 (0.19) | 95.2 (0.20) |
//! | 20 x 10 | 0.97 | 0 | 93.7 (0.05) | 94.3 (0.05) | 95.7 (0.06) | 99.0 (0.06) |
//! | 20 x 10 | 0.97 | 0.1 | 83.9 (0.05) | 90.3 (0.07) | 97.6 (0.08) | 99.2 (0.08) |
//! | 20 x 10 | 0.97 | 0.3 | 65.8 (0.05) | 80.5 (0.09) | 97.6 (0.12) | 99.5 (0.12) |
//! | 50 x 10 | 0.5 | 0 | 95.2 (0.09) | 96.2 (0.09) | 96.4 (0.09) | 97.2 (0.10) |
//! | 50 x 10 | 0.5 | 0.1 | 83.5 (0.09) | 94.1 (0.12) | 94.8 (0.12) | 95.2 (0.13) |
//! | 50 x 10 | 0.5 | 0.3 | 65.5 (0.09) | 93.3 (0.17) | 94.2 (0.17) | 95.1 (0.18) |
//! | 50 x 10 | 0.88 | 0 | 95.5 (0.06) | 95.8 (0.06) | 94.9 (0.06) | 96.5 (0.06) |
//! | 50 x 10 | 0.88 | 0.1 | 84.8 (0.06) | 93.5 (0.08) | 94.2 (0.08) | 94.9 (0.08) |
//! | 50 x 10 | 0.88 | 0.3 | 69.5 (0.06) | 94.0 (0.11) | 94.5 (0.11) | 95.9 (0.12) |
//! | 50 x 10 | 0.97 | 0 | 95.2 (0.03) | 95.7 (0.03) | 95.5 (0.03) | 97.3 (0.03) |
//! | 50 x 10 | 0.97 | 0.1 | 84.1 (0.03) | 93.5 (0.04) | 94.2 (0.04) | 95.6 (0.05) |
//! | 50 x 10 | 0.97 | 0.3 | 69.7 (0.03) | 90.3 (0.06) | 92.3 (0.06) | 93.5 (0.06) |
//! | 10 x 50 | 0.5 | 0 | 94.5 (0.09) | 96.2 (0.09) | 94.5 (0.10) | 98.3 (0.11) |
//! | 10 x 50 | 0.5 | 0.1 | 57.6 (0.09) | 92.7 (0.20) | 95.1 (0.24) | 95.8 (0.25) |
//! | 10 x 50 | 0.5 | 0.3 | 37.4 (0.09) | 92.4 (0.32) | 95.9 (0.38) | 96.5 (0.41) |
//! | 10 x 50 | 0.88 | 0 | 95.1 (0.06) | 96.1 (0.06) | 94.9 (0.06) | 98.6 (0.07) |
//! | 10 x 50 | 0.88 | 0.1 | 59.3 (0.06) | 90.6 (0.13) | 94.9 (0.16) | 95.4 (0.16) |
//! | 10 x 50 | 0.88 | 0.3 | 37.7 (0.06) | 86.9 (0.21) | 92.9 (0.26) | 93.1 (0.27) |
//! | 10 x 50 | 0.97 | 0 | 95.0 (0.03) | 96.0 (0.03) | 96.2 (0.04) | 98.6 (0.04) |
//! | 10 x 50 | 0.97 | 0.1 | 58.5 (0.03) | 85.4 (0.07) | 90.1 (0.09) | 91.2 (0.09) |
//! | 10 x 50 | 0.97 | 0.3 | 34.2 (0.03) | 71.2 (0.10) | 86.2 (0.16) | 83.1 (0.15) |
//!
//! # Against a threshold
//! With `n*` independent trials the test that a rate lies towards the middle from the threshold is the
//! score test (its inversion is Wilson's interval), and that it lies towards the end is the exact
//! binomial one: clusters that all succeed hide how much they vary. But `n*` is that of a 95 % interval: at smaller levels
//! clusters that hardly ever fail are taken for surer than they are, and the score for less skew. So where the count tells
//! how alike its trials are, a claim needs the likelihood, too ([`crate::BetaBinomial::threshold_tests`]), in which the
//! correlation is the most likely one *at the threshold*; the likelihood alone claims too much where all of a few clusters
//! succeed. Its own tails are those of many clusters, so the third is the probability of a better count at that correlation,
//! which is a sum (`clustered_tail`).
//!
//! Wrong decisions at levels of 5, 2.5, 1.25 and 0.5 % when the rate is the threshold, in percent, exact by all outcomes:
//! the largest over rates 0.5, 0.7, 0.8, 0.9 and 0.95 and, *beta*, correlations 0, 0.05, 0.1, 0.2, 0.3, 0.5, 0.6, 0.7 and 0.85;
//! *two kinds*, for which nothing was made: all failures are of one kind of people, who always fail or fail half of the time.
//! (`cargo run -p corroborate-stats --release --example clustered_threshold`)
//!
//! | clusters x trials | law | claim | at `n*` | by the likelihood | by both | and a better count |
//! |---|---|---|---|---|---|---|
//! | 4 x 5 | beta | above | 2.1 0.9 0.0 0.0 | 6.1 2.1 0.0 0.0 | 2.1 0.9 0.0 0.0 | 2.1 0.9 0.0 0.0 |
//! | 4 x 5 | beta | below | 2.7 1.5 1.0 0.6 | 6.1 2.1 0.8 0.3 | 2.4 1.5 0.8 0.3 | 2.4 1.5 0.8 0.3 |
//! | 4 x 5 | two kinds | above | 0.1 0.1 0.0 0.0 | 6.3 0.1 0.0 0.0 | 0.1 0.1 0.0 0.0 | 0.1 0.1 0.0 0.0 |
//! | 4 x 5 | two kinds | below | 3.9 2.2 1.2 0.7 | 6.3 2.3 1.0 0.4 | 3.9 2.2 1.0 0.4 | 3.9 2.2 1.0 0.4 |
//! | 5 x 10 | beta | above | 3.7 1.8 1.2 0.8 | 7.0 3.0 1.0 0.4 | 3.7 1.8 1.0 0.4 | 2.8 1.5 0.6 0.0 |
//! | 5 x 10 | beta | below | 3.8 2.5 2.0 1.1 | 5.2 3.0 1.0 0.4 | 3.2 1.7 1.0 0.4 | 3.2 1.7 0.8 0.3 |
//! | 5 x 10 | two kinds | above | 3.1 0.2 0.1 0.0 | 3.1 3.1 0.1 0.0 | 3.1 0.2 0.1 0.0 | 3.1 0.2 0.0 0.0 |
//! | 5 x 10 | two kinds | below | 5.7 4.6 3.5 2.4 | 5.9 4.4 3.0 1.3 | 5.7 4.4 3.0 1.3 | 5.7 4.4 2.7 0.7 |
//! | 10 x 5 | beta | above | 4.4 4.1 2.1 1.0 | 10.5 4.2 2.7 1.0 | 4.4 4.1 2.1 1.0 | 4.4 2.1 0.8 0.4 |
//! | 10 x 5 | beta | below | 7.1 2.9 2.2 1.3 | 4.6 2.3 1.2 0.5 | 3.7 1.8 0.9 0.4 | 3.7 1.8 0.9 0.4 |
//! | 10 x 5 | two kinds | above | 2.8 1.2 0.6 0.1 | 10.7 2.8 2.8 0.1 | 2.8 1.2 0.6 0.1 | 2.8 1.1 0.2 0.1 |
//! | 10 x 5 | two kinds | below | 8.6 3.5 2.6 1.5 | 5.5 2.1 1.3 0.6 | 4.7 2.1 1.3 0.6 | 4.7 2.1 1.3 0.5 |
//! | 20 x 2 | beta | above | 4.9 2.2 2.2 0.9 | 9.0 9.0 2.2 1.4 | 4.9 2.2 2.2 0.9 | 4.9 2.2 1.4 0.5 |
//! | 20 x 2 | beta | below | 5.8 5.7 2.0 1.1 | 5.1 2.5 1.1 0.4 | 4.2 2.2 1.1 0.4 | 4.2 2.2 1.1 0.4 |
//! | 20 x 2 | two kinds | above | 6.9 1.8 1.8 0.8 | 12.2 12.2 1.8 1.2 | 6.9 1.8 1.8 0.8 | 6.9 1.8 1.2 0.8 |
//! | 20 x 2 | two kinds | below | 7.5 7.5 1.8 1.6 | 5.8 3.2 1.6 0.6 | 4.8 3.2 1.6 0.5 | 4.8 3.2 1.6 0.5 |
//! | 20 x 5 | beta | above | 5.1 5.1 4.8 1.0 | 11.3 9.6 1.9 1.1 | 5.1 5.1 1.9 0.9 | 4.3 2.6 1.4 0.4 |
//! | 20 x 5 | beta | below | 7.5 5.5 2.1 1.5 | 4.8 2.4 1.2 0.5 | 4.2 2.2 1.0 0.4 | 4.2 2.2 1.0 0.4 |
//! | 20 x 5 | two kinds | above | 6.9 1.5 1.5 0.8 | 12.2 12.2 1.2 1.2 | 6.9 1.5 1.2 0.8 | 6.9 1.2 1.2 0.8 |
//! | 20 x 5 | two kinds | below | 7.5 7.5 2.4 1.6 | 5.8 3.2 1.6 0.6 | 4.8 3.2 1.6 0.5 | 4.8 3.2 1.6 0.5 |
//! | 25 x 4 | beta | above | 5.2 4.4 3.8 3.2 | 9.8 6.1 3.8 0.7 | 5.2 4.4 3.8 0.7 | 4.4 2.2 1.1 0.6 |
//! | 25 x 4 | beta | below | 5.9 3.9 2.9 1.3 | 4.8 2.4 1.2 0.5 | 4.5 2.2 1.1 0.4 | 4.5 2.2 1.1 0.4 |
//! | 25 x 4 | two kinds | above | 3.4 2.7 1.8 1.5 | 7.2 7.2 2.7 0.9 | 3.4 2.7 1.8 0.4 | 3.4 2.7 0.9 0.4 |
//! | 25 x 4 | two kinds | below | 5.9 3.6 3.4 1.2 | 5.4 3.4 1.0 0.7 | 4.7 3.4 1.0 0.6 | 4.7 3.4 1.0 0.6 |
//! | 30 x 3 | beta | above | 6.0 4.0 2.9 1.6 | 15.2 4.5 4.2 0.7 | 6.0 4.0 2.9 0.7 | 6.0 2.1 1.3 0.4 |
//! | 30 x 3 | beta | below | 6.4 4.0 2.1 1.3 | 4.9 2.4 1.2 0.5 | 4.5 2.2 1.1 0.4 | 4.5 2.2 1.1 0.4 |
//! | 30 x 3 | two kinds | above | 4.7 2.9 2.0 1.1 | 21.5 4.4 4.2 1.1 | 4.7 2.9 2.0 1.1 | 4.7 1.7 1.1 0.3 |
//! | 30 x 3 | two kinds | below | 7.3 6.1 2.6 1.6 | 6.1 2.6 1.6 0.6 | 6.1 2.6 1.6 0.6 | 6.1 2.6 1.6 0.6 |
//! | 100 x 2 | beta | above | 4.4 2.5 1.9 1.0 | 7.0 4.4 1.9 1.1 | 4.4 2.5 1.9 1.0 | 4.4 2.5 1.3 0.6 |
//! | 100 x 2 | beta | below | 7.0 3.6 2.0 1.0 | 4.9 2.5 1.3 0.5 | 4.9 2.4 1.2 0.5 | 4.9 2.4 1.2 0.5 |
//! | 100 x 2 | two kinds | above | 5.8 3.7 1.9 0.8 | 7.0 4.0 1.9 0.9 | 5.8 3.7 1.9 0.8 | 5.8 3.7 1.3 0.8 |
//! | 100 x 2 | two kinds | below | 7.3 4.0 2.8 1.1 | 6.3 2.8 1.2 0.6 | 6.3 2.8 1.2 0.6 | 6.3 2.8 1.2 0.6 |
//!
//! Of unequal clusters another law errs more: where the failures of 12 people of three attempts and three of forty are those of a kind of whom
//! each fails half of the time, "below 0.6" comes out in 8.6 % at 5 % and 1.8 % at 1.25 % (15.0 and 5.1 by the likelihood), and where 20
//! people have 1 to 19, in 6.0 and 2.3 % (20 000 draws, the example with `unequal`).
//!
//! So of equal clusters with all three a claim of the larger levels is wrong at most 1.2 times as often as it may be under the model, and so is one of the
//! smaller (6.0, 2.6, 1.4 and 0.6 %; by both alone 6.0, 5.1, 3.8 and 1.0). Under the other law it is wrong in up to 6.9, 4.4, 2.7 and 0.8 %:
//! of five people of ten attempts a kind is easily not met. At `n*` alone it is wrong up to 6.4 times as often.
//! What the third test costs is the claim that nothing but a limit supports: of 25 people with four attempts of whom three in a hundred
//! fail, a rate above 0.9 is shown at 5 % in 79 % where attempts are independent (81 % by the likelihood), and at 1.25 % never, as all
//! of them succeed in 7 % of such cohorts if each person always or never does. `evidence` divides its level, so several quantities
//! need more people.
//!
//! # Not monotone
//! More subjects without a failure may make the lower limit fall (and in the mirror image, subjects without a success the
//! upper limit rise). Where subjects with many trials are alike, the most likely correlation is 0 and the limit near that of
//! independent trials; one more who never fails shows that subjects differ, and then so few of them tell little. Of 3 with
//! 45/50 the one-sided 95 % limit by both tests is 0.799; with a fourth of 50/50 it is 0.716, with one of 500/500 0.541. Of
//! 10 with 45/50 the third of 50/50 costs 0.002. In a scan of
//! 2 to 30 subjects, 1 to 8 failures of each, of every second or of every fifth, and up to 7 more subjects without a failure
//! it was seen from 20 trials each on, and where those added have ten times as many, from 5 each on.
//! The limit is valid with the subject as without it. It is not made monotone: the best limit over parts of the data would be
//! chosen for its value, and the worst one over all that might still be added is that with one subject of any number of
//! trials, which tells next to nothing. `evidence` says beside a verdict where a limit with a subject less would be better.
//!
//! # Source
//! D. A. Williams (1975); E. B. Wilson (1927) for the score test.
//!
//! # Assumes
//! As [`mod@crate::beta_binomial`]: people are independent draws of one population, as many as were fixed in advance, with
//! rates of a beta distribution, and trials of one are independent given the rate. What another law does is in the rows
//! *two kinds*, and what people of a kind that was not met would do in [`mod@crate::unmet_kind`]. Of a single cluster, or
//! of one trial each, trials are taken as independent.
//!
//! # Guarantee
//! Asymptotic in the number of clusters; the first table says how nearly with few of them. Cost: some thousands of likelihoods, a few milliseconds.

use crate::beta_binomial::BetaBinomial;
use crate::binomial::{binomial_test_above, binomial_test_below};
use crate::common_correlation::CommonCorrelation;
use crate::counts::{Confidence, EffectiveSample, Interval, Sample, StatsError};
use crate::heterogeneity::pool;
use crate::interval::wilson;
use crate::special::normal_cdf;

/// How the interval of a clustered rate was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ClusterMethod {
    /// By the profile likelihood of the beta-binomial model.
    Profile,
    /// Allowing for the correlation that all columns of the clusters have in common, because the count itself
    /// cannot tell it ([`CommonCorrelation`]).
    Common,
    /// One trial for each cluster, because nothing tells how alike those of one are.
    OneEach,
    /// As independent trials: a single cluster, or a single trial in each.
    Independent,
}

/// A rate of clustered trials with its interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClusteredRate {
    /// All trials together.
    pub total: Sample,
    /// Number of clusters that have trials.
    pub clusters: usize,
    /// How the interval was found.
    pub method: ClusterMethod,
    /// The interval.
    pub interval: Interval,
    /// The rate at the number of independent trials that it is worth in comparisons.
    pub worth: EffectiveSample,
}

/// The rate of clusters, one sample each; those without trials are skipped.
///
/// # Errors
/// [`StatsError::MoreSuccessesThanTrials`] for a contradictory count, [`StatsError::NoTrials`] without
/// any trial.
///
/// ```
/// use stats::{Confidence, Sample, clustered_rate};
/// let subjects = [9, 10, 8, 7, 9, 10, 10, 6, 9, 10].map(|successes| Sample { successes, trials: 10 });
/// let rate = clustered_rate(&subjects, Confidence::P95)?;
/// // Independent trials would give [0.802, 0.930].
/// assert!((rate.interval.low - 0.7388).abs() < 1e-4 && (rate.interval.high - 0.9508).abs() < 1e-4);
/// assert!((rate.worth.trials - 36.91).abs() < 0.01);
/// # Ok::<(), stats::StatsError>(())
/// ```
pub fn clustered_rate(
    clusters: &[Sample],
    confidence: Confidence,
) -> Result<ClusteredRate, StatsError> {
    let total = pool(clusters)?;
    if total.trials == 0 {
        return Err(StatsError::NoTrials);
    }
    let counted = || clusters.iter().filter(|cluster| cluster.trials > 0);
    let found = counted().count();
    let rate = |method, interval, worth| ClusteredRate {
        total,
        clusters: found,
        method,
        interval,
        worth,
    };
    if found < 2 || counted().all(|cluster| cluster.trials == 1) {
        let interval = wilson(total, confidence);
        return Ok(rate(ClusterMethod::Independent, interval, total.into()));
    }
    if total.successes == 0 || total.failures() == 0 {
        let worth = EffectiveSample::at_size(total, found as f64)?;
        return Ok(rate(
            ClusterMethod::OneEach,
            wilson(worth, confidence),
            worth,
        ));
    }
    let profile = BetaBinomial::fit(clusters)?.interval(confidence);
    let pooled = total.successes as f64 / total.trials as f64;
    let interval = Interval {
        low: profile.low.min(pooled),
        high: profile.high.max(pooled),
    };
    let worth = as_wide_as(interval, total, confidence)?;
    Ok(rate(ClusterMethod::Profile, interval, worth))
}

/// The rate of clusters of which more was counted: where this count cannot tell how alike its trials are, by the
/// correlation that is common to all that was counted.
///
/// # Errors
/// Those of [`clustered_rate`].
pub fn clustered_rate_among(
    common: &CommonCorrelation,
    clusters: &[Sample],
    confidence: Confidence,
) -> Result<ClusteredRate, StatsError> {
    let alone = clustered_rate(clusters, confidence)?;
    if alone.method != ClusterMethod::OneEach {
        return Ok(alone);
    }
    let sizes: Vec<u64> = clusters.iter().map(|cluster| cluster.trials).collect();
    common.rate(alone.total, &sizes, confidence)
}

/// P-value of the rate being at least the threshold, where trials are alike: a small value is
/// evidence that it is below. `worth` is [`ClusteredRate::worth`].
///
/// ```
/// use stats::{EffectiveSample, clustered_test_below};
/// let ten_people = EffectiveSample { successes: 34.8, trials: 39.54 };
/// assert!((clustered_test_below(ten_people, 0.95) - 0.0217).abs() < 1e-3);
/// ```
#[must_use]
pub fn clustered_test_below(worth: EffectiveSample, threshold: f64) -> f64 {
    let exact = || binomial_test_below(worth, threshold);
    if worth.is_informative() && threshold > 0.5 && threshold < 1.0 {
        let by_score = normal_cdf(score(worth, threshold));
        match has_one_outcome(worth) {
            true => by_score.max(exact()),
            false => by_score,
        }
    } else {
        exact()
    }
}

/// P-value of the rate being at most the threshold, where trials are alike: a small value is
/// evidence that it is above. `worth` is [`ClusteredRate::worth`].
#[must_use]
pub fn clustered_test_above(worth: EffectiveSample, threshold: f64) -> f64 {
    let exact = || binomial_test_above(worth, threshold);
    if worth.is_informative() && threshold < 0.5 && threshold > 0.0 {
        let by_score = normal_cdf(-score(worth, threshold));
        match has_one_outcome(worth) {
            true => by_score.max(exact()),
            false => by_score,
        }
    } else {
        exact()
    }
}

/// Whether all trials came out alike. Then no likelihood of the subjects' counts is there to know how alike they are, and the
/// tail of a few independent trials is far from normal: of two who always succeed it is the threshold squared.
fn has_one_outcome(worth: EffectiveSample) -> bool {
    worth.successes <= 0.0 || worth.successes >= worth.trials
}

/// By how many standard deviations under the threshold the rate differs from it.
fn score(worth: EffectiveSample, threshold: f64) -> f64 {
    let expected = worth.trials * threshold;
    (worth.successes - expected) / (expected * (1.0 - threshold)).sqrt()
}

/// The rate at the number of trials, at most all, at which Wilson's interval is as wide as this one.
pub(crate) fn as_wide_as(
    interval: Interval,
    total: Sample,
    confidence: Confidence,
) -> Result<EffectiveSample, StatsError> {
    let (mut few, mut many) = (1e-3, total.trials as f64);
    let is_wider = |size: f64| {
        let sample = EffectiveSample::at_size(total, size)?;
        Ok::<bool, StatsError>(wilson(sample, confidence).width() > interval.width())
    };
    if is_wider(many)? {
        return Ok(total.into());
    }
    while many - few > 1e-9 * many {
        let middle = (few * many).sqrt();
        if middle <= few || middle >= many {
            break;
        }
        if is_wider(middle)? {
            few = middle;
        } else {
            many = middle;
        }
    }
    EffectiveSample::at_size(total, many)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of subjects who always succeed, each as one trial, the p-value is at least that of so many trials, at any threshold.
    #[test]
    fn of_one_outcome_the_tail_is_at_least_exact() {
        for subjects in [2.0, 3.0, 5.0, 12.0] {
            for threshold in [0.1, 0.3, 0.45, 0.5, 0.7, 0.95, 0.99] {
                let (all, none) = (
                    EffectiveSample {
                        successes: subjects,
                        trials: subjects,
                    },
                    EffectiveSample {
                        successes: 0.0,
                        trials: subjects,
                    },
                );
                let exact = f64::powf(threshold, subjects);
                let above = clustered_test_above(all, threshold);
                assert!(
                    above >= exact * (1.0 - 1e-9),
                    "{subjects} {threshold}: {above}"
                );
                let below = clustered_test_below(none, threshold);
                let exact = f64::powf(1.0 - threshold, subjects);
                assert!(
                    below >= exact * (1.0 - 1e-9),
                    "{subjects} {threshold}: {below}"
                );
            }
        }
    }

    fn samples(counts: &[(u64, u64)]) -> Vec<Sample> {
        counts
            .iter()
            .map(|&(successes, trials)| Sample { successes, trials })
            .collect()
    }

    fn found(counts: &[(u64, u64)]) -> ClusteredRate {
        clustered_rate(&samples(counts), Confidence::P95).unwrap()
    }

    #[test]
    fn ends_count_once_for_each_cluster_from_five_trials_to_a_hundred_million() {
        for each in [1_u64, 2, 100, 20_000_000] {
            for successes in [0, each] {
                let mut counts = vec![(successes, each); 5];
                counts.push((0, 0));
                let rate = found(&counts);
                assert_eq!(rate.clusters, 5);
                let Interval { low, high } = rate.interval;
                // Wilson's of five trials: z^2/(5 + z^2).
                let expected = 0.4344824767;
                assert!((high - low - expected).abs() < 1e-6, "{low} {high}");
                assert!(if successes == 0 {
                    low == 0.0
                } else {
                    high == 1.0
                });
                assert_eq!(rate.worth.trials, 5.0);
            }
        }
    }

    #[test]
    fn the_worth_leaves_intervals_as_wide() {
        for counts in [
            vec![
                (60_000_000, 100_000_000),
                (40_000_000, 100_000_000),
                (50_000_000, 100_000_000),
            ],
            vec![(9, 10), (10, 10), (3, 10), (8, 10)],
            vec![(0, 5), (1, 5), (0, 5), (0, 5), (0, 5), (0, 5)],
        ] {
            let rate = found(&counts);
            assert_eq!(rate.method, ClusterMethod::Profile);
            let same = wilson(rate.worth, Confidence::P95).width();
            assert!((same - rate.interval.width()).abs() < 1e-6, "{rate:?}");
            assert!(rate.worth.trials < 0.9 * rate.total.trials as f64);
        }
        // Clusters that scatter as little as independent trials are worth nearly all of them.
        let plain: Vec<(u64, u64)> = (0..100).map(|i| (50 + (i % 7) - 3, 100)).collect();
        assert!(found(&plain).worth.trials > 8_000.0);
    }

    #[test]
    fn the_score_test_agrees_with_wilsons_interval_and_falls_with_the_rate() {
        for (successes, trials) in [(34.8, 39.54), (3.2, 7.7), (880.0, 1000.0)] {
            let worth = EffectiveSample { successes, trials };
            let interval = wilson(worth, Confidence::P95);
            if interval.high > 0.5 {
                let tail = clustered_test_below(worth, interval.high);
                assert!((tail - 0.025).abs() < 1e-9, "{tail}");
            }
            let failed = EffectiveSample {
                successes: trials - successes,
                trials,
            };
            let mirrored = clustered_test_above(failed, 0.1);
            assert!((mirrored - clustered_test_below(worth, 0.9)).abs() < 1e-12);
        }
        let at = |successes| {
            clustered_test_below(
                EffectiveSample {
                    successes,
                    trials: 20.0,
                },
                0.9,
            )
        };
        assert!(at(12.0) < at(15.5) && at(15.5) < at(18.0) && at(20.0) > 0.9);
        // At certainty a single failure is enough; without trials nothing is.
        let failure = EffectiveSample {
            successes: 19.0,
            trials: 20.0,
        };
        assert_eq!(clustered_test_below(failure, 1.0), 0.0);
        let none = EffectiveSample {
            successes: 0.0,
            trials: 0.0,
        };
        assert_eq!(clustered_test_below(none, 0.9), 1.0);
    }

    /// The header says so, and `evidence` tells where a study shows it.
    #[test]
    fn a_subject_without_a_failure_may_make_the_lower_limit_fall() {
        let alike = [(45, 50); 3];
        let with = |one: (u64, u64)| {
            let all: Vec<(u64, u64)> = alike.iter().copied().chain([one]).collect();
            found(&all).interval.low
        };
        let limit = found(&alike).interval.low;
        assert!(with((50, 50)) < limit - 0.01 && with((500, 500)) < with((50, 50)) - 0.01);
        // A few trials show little of how subjects differ, and help.
        assert!(with((5, 5)) > limit, "{} {limit}", with((5, 5)));
    }

    #[test]
    fn one_subject_and_one_trial_each_are_independent_trials() {
        let one = found(&[(3, 4)]);
        assert_eq!(
            (one.method, one.worth.trials),
            (ClusterMethod::Independent, 4.0)
        );
        let each = found(&[(1, 1), (0, 1), (1, 1)]);
        assert_eq!(
            (each.method, each.worth.trials),
            (ClusterMethod::Independent, 3.0)
        );
        assert!(clustered_rate(&[], Confidence::P95).is_err());
        assert!(clustered_rate(&samples(&[(0, 0)]), Confidence::P95).is_err());
        assert!(clustered_rate(&samples(&[(5, 4)]), Confidence::P95).is_err());
    }
}
