//! Speed near people, restricted space, and what the hand may do.

use super::{
    Declaration, HAND_SPEED, PERSON_DISTANCE, ROBOT_SPEED, STANDSTILL_SPEED, Template, parameter,
    proposition, quantity,
};

const REDUCED_SPEED: Declaration = parameter(
    "reduced_speed",
    "250 mm/s",
    ["1 mm/s", "250 mm/s"],
    "greatest speed of the tool centre point; 250 mm/s is the limit of reduced speed in ISO 10218-1",
);

pub(super) const TEMPLATES: &[Template] = &[
    Template {
        id: "reduced-speed-near-person",
        title: "Reduced speed near a person",
        standard: "ISO 10218-1:2011, 5.6.2 (reduced speed control), applied near people",
        notes: "The near distance comes from the risk assessment; the standard gives the speed only.",
        sentence: "Whenever person_distance < near_distance, the robot shall immediately satisfy \
                   hand_speed <= reduced_speed",
        parameters: &[
            parameter(
                "near_distance",
                "0.5 m",
                ["1 cm", "10 m"],
                "distance below which the robot counts as near; from the risk assessment",
            ),
            REDUCED_SPEED,
        ],
        needs: &[PERSON_DISTANCE, HAND_SPEED],
    },
    Template {
        id: "reduced-speed-in-mode",
        title: "Reduced speed in manual mode",
        standard: "ISO 10218-1:2011, 5.7.3 (manual reduced speed)",
        notes: "Holds from the moment the mode is entered, so the robot has to be slow before it is selected.",
        sentence: "While manual_mode, the robot shall always satisfy hand_speed <= reduced_speed",
        parameters: &[REDUCED_SPEED],
        needs: &[
            proposition(
                "manual_mode",
                "the robot is in the mode of manual reduced speed",
            ),
            HAND_SPEED,
        ],
    },
    Template {
        id: "start-in-reduced-speed",
        title: "Reduced speed until the start is over",
        standard: "ISO 10218-1:2011, 5.6.2 (reduced speed control), applied to starting up",
        notes: "From the beginning of the run until the robot has reached the pose where its task begins.",
        sentence: "Before start_completed, the robot shall always satisfy hand_speed <= reduced_speed",
        parameters: &[REDUCED_SPEED],
        needs: &[
            proposition(
                "start_completed",
                "the robot has reached the pose where its task begins",
            ),
            HAND_SPEED,
        ],
    },
    Template {
        id: "no-unexpected-start",
        title: "No motion before the start command",
        standard: "ISO 10218-1:2011, 5.3 and ISO 14118:2017 (prevention of unexpected start-up)",
        notes: "For restarts within a run use no-unexpected-restart.",
        sentence: "Before start_commanded, the robot shall always satisfy robot_speed <= standstill_speed",
        parameters: &[STANDSTILL_SPEED],
        needs: &[
            proposition(
                "start_commanded",
                "a person has commanded the robot to start",
            ),
            ROBOT_SPEED,
        ],
    },
    Template {
        id: "restricted-zone",
        title: "Restricted zone kept clear",
        standard: "ISO 10218-1:2011, 5.12 (limiting robot motion)",
        notes: "Measure to the surface of the robot with its tool and load, not to a point of it.",
        sentence: "The robot shall always satisfy zone_distance >= zone_margin",
        parameters: &[parameter(
            "zone_margin",
            "0 m",
            ["0 m", "10 m"],
            "distance to be kept from the restricted zone",
        )],
        needs: &[quantity(
            "zone_distance",
            "m",
            "least distance between any part of the robot and the restricted zone; 0 or less inside",
        )],
    },
    Template {
        id: "hand-closes-away-from-person",
        title: "The hand closes only away from the person",
        standard: "ISO/TS 15066:2016, 5.5.5 (power and force limiting: no clamping)",
        notes: "Judged at the moment at which the hand begins to close.",
        sentence: "When hand_closes, the robot shall immediately satisfy person_distance > clamping_distance",
        parameters: &[parameter(
            "clamping_distance",
            "5 cm",
            ["0 cm", "1 m"],
            "distance within which a body part could be clamped; from the hand's shape",
        )],
        needs: &[
            proposition("hand_closes", "the hand has been commanded to close"),
            PERSON_DISTANCE,
        ],
    },
    Template {
        id: "holds-until-released",
        title: "The object is held until its release is permitted",
        standard: "ISO 10218-2:2011, 5.3 (end-effectors: no hazard from dropped loads)",
        notes: "If the release is never permitted, the object has to be held to the end.",
        sentence: "When grasped, the robot shall until release_permitted satisfy object_in_hand",
        parameters: &[],
        needs: &[
            proposition(
                "grasped",
                "the hand has closed around the object and bears its weight",
            ),
            proposition(
                "release_permitted",
                "the person is ready to take the object, or it is set down",
            ),
            proposition("object_in_hand", "the object is in the hand"),
        ],
    },
    Template {
        id: "release-in-time",
        title: "The hand opens in time after the decision",
        standard: "ISO 13482:2014, 5.12 (hazards due to incorrect autonomous decisions and actions)",
        notes: "A person who pulls at an object that is not let go may lose balance.",
        sentence: "When release_decided, the robot shall within release_time satisfy hand_open",
        parameters: &[parameter(
            "release_time",
            "2 s",
            ["10 ms", "30 s"],
            "longest time from the decision to the open hand",
        )],
        needs: &[
            proposition("release_decided", "the robot has decided to let go"),
            proposition(
                "hand_open",
                "the hand is open, so that the object can be taken",
            ),
        ],
    },
];
