//! Quality of service that fits the publishers.
//!
//! A reader gets messages of a writer only if it asks for no more than the writer offers (OMG DDS 1.4, 2.2.3). So a
//! listener asks for what all present writers of a topic offer: reliable only if all are, transient local only if all
//! are. The same rule is used by the recorder of ROS 2.

use crate::{Durability, Qos, Reliability};
use rustdds::policy;
use rustdds::{Duration, QosPolicies, QosPolicyBuilder};

/// What a writer offers, by its announcement.
pub(crate) fn offered(
    reliability: Option<policy::Reliability>,
    durability: Option<policy::Durability>,
) -> Qos {
    // A writer that does not say is reliable and volatile: the defaults for writers in DDS.
    let reliability = match reliability {
        Some(policy::Reliability::BestEffort) => Reliability::BestEffort,
        Some(policy::Reliability::Reliable { .. }) | None => Reliability::Reliable,
    };
    let durability = match durability {
        Some(policy::Durability::Volatile) | None => Durability::Volatile,
        Some(_) => Durability::TransientLocal,
    };
    Qos {
        reliability,
        durability,
    }
}

/// The most that all of `offers` allow; reliable and volatile if there are none.
pub(crate) fn fitting(offers: impl IntoIterator<Item = Qos>) -> Qos {
    offers
        .into_iter()
        .reduce(|a, b| Qos {
            reliability: a.reliability.min(b.reliability),
            durability: a.durability.min(b.durability),
        })
        .unwrap_or(Qos {
            reliability: Reliability::Reliable,
            durability: Durability::Volatile,
        })
}

/// Whether a reader with `asked` gets messages from a writer with `offer`.
pub(crate) fn fits(asked: Qos, offer: Qos) -> bool {
    asked.reliability <= offer.reliability && asked.durability <= offer.durability
}

/// The stack's policies for a reader or writer that keeps up to `samples` messages.
pub(crate) fn policies(qos: Qos, exclusive: bool, samples: i32) -> QosPolicies {
    let reliability = match qos.reliability {
        Reliability::BestEffort => policy::Reliability::BestEffort,
        Reliability::Reliable => policy::Reliability::Reliable {
            max_blocking_time: Duration::from_millis(100),
        },
    };
    let durability = match qos.durability {
        Durability::Volatile => policy::Durability::Volatile,
        Durability::TransientLocal => policy::Durability::TransientLocal,
    };
    let ownership = if exclusive {
        policy::Ownership::Exclusive { strength: 0 }
    } else {
        policy::Ownership::Shared
    };
    QosPolicyBuilder::new()
        .reliability(reliability)
        .durability(durability)
        .ownership(ownership)
        .history(policy::History::KeepLast { depth: samples })
        .build()
}

/// How many messages the stack keeps of a topic before they are taken. It keeps them also after they were taken, so
/// few are kept of the types that are large.
pub(crate) fn samples_kept(type_name: &str) -> i32 {
    const LARGE: [&str; 5] = [
        "Image",
        "CompressedImage",
        "PointCloud2",
        "PointCloud",
        "OccupancyGrid",
    ];
    let last = type_name.rsplit('/').next().unwrap_or(type_name);
    if LARGE.contains(&last) { 16 } else { 1024 }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BEST: Qos = Qos {
        reliability: Reliability::Reliable,
        durability: Durability::TransientLocal,
    };
    const LEAST: Qos = Qos {
        reliability: Reliability::BestEffort,
        durability: Durability::Volatile,
    };

    #[test]
    fn what_is_asked_fits_every_offer() {
        let kinds = [Reliability::BestEffort, Reliability::Reliable];
        let durabilities = [Durability::Volatile, Durability::TransientLocal];
        let all: Vec<Qos> = kinds
            .into_iter()
            .flat_map(|reliability| {
                durabilities.map(|durability| Qos {
                    reliability,
                    durability,
                })
            })
            .collect();
        for &a in &all {
            assert_eq!(fitting([a]), a);
            for &b in &all {
                let asked = fitting([a, b]);
                assert!(fits(asked, a) && fits(asked, b));
            }
        }
        assert!(!fits(BEST, LEAST));
        assert!(fits(LEAST, BEST));
    }

    #[test]
    fn policies_that_are_not_announced_are_the_defaults_of_writers() {
        assert_eq!(offered(None, None), fitting([]));
        let best_effort = offered(Some(policy::Reliability::BestEffort), None);
        assert_eq!(best_effort, LEAST);
    }

    #[test]
    fn few_messages_of_large_types_are_kept() {
        assert_eq!(samples_kept("sensor_msgs/msg/Image"), 16);
        assert_eq!(samples_kept("sensor_msgs/msg/JointState"), 1024);
    }
}
