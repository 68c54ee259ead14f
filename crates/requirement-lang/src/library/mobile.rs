//! Mobile robots among people.

use super::{Need, PERSON_DISTANCE, STANDSTILL_SPEED, Template, parameter, quantity, quantity_in};

const BASE_SPEED: Need = quantity_in(
    "base_speed",
    "m/s",
    "world",
    "speed of the robot's base over the ground, magnitude",
);

pub(super) const TEMPLATES: &[Template] = &[
    Template {
        id: "mobile-speed-near-person",
        title: "Speed of a mobile robot near a person",
        standard: "ISO 13482:2014, 6.4 (safety-related speed control)",
        notes: "Speed and distance come from the risk assessment of the robot's mass, shape and brakes.",
        sentence: "Whenever person_distance < near_distance, the robot shall immediately satisfy \
                   base_speed <= near_speed",
        parameters: &[
            parameter(
                "near_distance",
                "1.5 m",
                ["5 cm", "20 m"],
                "distance below which the robot counts as near; from the risk assessment",
            ),
            parameter(
                "near_speed",
                "0.3 m/s",
                ["1 mm/s", "5.6 m/s"],
                "greatest speed near a person; from the risk assessment (the standard covers robots of up to \
                 20 km/h)",
            ),
        ],
        needs: &[PERSON_DISTANCE, BASE_SPEED],
    },
    Template {
        id: "obstacle-clearance",
        title: "Clearance from obstacles while driving",
        standard: "ISO 13482:2014, 5.10 and 6.5 (robot motion, safety-related environmental sensing)",
        notes: "Measure between surfaces. Docking and the like need a scope of their own.",
        sentence: "Whenever base_speed > standstill_speed, the robot shall immediately satisfy \
                   obstacle_distance >= clearance",
        parameters: &[
            parameter(
                "clearance",
                "0.1 m",
                ["0 m", "10 m"],
                "least distance to be kept while driving",
            ),
            STANDSTILL_SPEED,
        ],
        needs: &[
            BASE_SPEED,
            quantity(
                "obstacle_distance",
                "m",
                "least distance between any part of the robot and any obstacle or person",
            ),
        ],
    },
    Template {
        id: "mobile-stops-before-person",
        title: "A mobile robot stops for a person in its way",
        standard: "ISO 13482:2014, 6.2 (robot stopping)",
        notes: "After the time the robot is at rest, or the person is no longer so close.",
        sentence: "When person_distance < stop_distance, the robot shall within stopping_time satisfy \
                   base_speed <= standstill_speed or person_distance >= stop_distance",
        parameters: &[
            parameter(
                "stop_distance",
                "0.5 m",
                ["1 cm", "10 m"],
                "distance below which the robot has to stop",
            ),
            super::STOPPING_TIME,
            STANDSTILL_SPEED,
        ],
        needs: &[PERSON_DISTANCE, BASE_SPEED],
    },
];
