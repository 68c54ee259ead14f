//! Protective stops, enabling devices, loss of communication.

use super::{
    Declaration, ROBOT_SPEED, STANDSTILL_SPEED, STOPPING_TIME, Template, parameter, proposition,
    quantity, quantity_in,
};

const STOP_REQUESTED: super::Need = proposition(
    "stop_requested",
    "a protective stop is requested, by a sensor, a person or the control",
);

const HEARTBEAT_TIMEOUT: Declaration = parameter(
    "heartbeat_timeout",
    "0.2 s",
    ["1 ms", "5 s"],
    "age of the last message from which on communication counts as lost",
);

pub(super) const TEMPLATES: &[Template] = &[
    Template {
        id: "stop-within-time",
        title: "Protective stop within a time",
        standard: "ISO 10218-1:2011, 5.5.3 (protective stop) and annex B (stopping time)",
        notes: "The time is that at the greatest load, speed and extension, or that of the situation tested.",
        sentence: "When stop_requested, the robot shall within stopping_time satisfy \
                   robot_speed <= standstill_speed",
        parameters: &[STOPPING_TIME, STANDSTILL_SPEED],
        needs: &[STOP_REQUESTED, ROBOT_SPEED],
    },
    Template {
        id: "stop-within-distance",
        title: "Protective stop within a distance",
        standard: "ISO 10218-1:2011, 5.5.3 (protective stop) and annex B (stopping distance)",
        notes: "Until the stop is reset the robot may not have moved further than this.",
        sentence: "When stop_requested, the robot shall until stop_reset satisfy \
                   distance_since_stop_request <= stopping_distance",
        parameters: &[parameter(
            "stopping_distance",
            "0.2 m",
            ["0 m", "10 m"],
            "longest way from the request to standstill; from the robot's stopping data",
        )],
        needs: &[
            STOP_REQUESTED,
            proposition("stop_reset", "the stop has been reset by a person"),
            quantity_in(
                "distance_since_stop_request",
                "m",
                "the robot's base, or the world if the base moves",
                "length of the way of the fastest part since the last request of a stop",
            ),
        ],
    },
    Template {
        id: "no-unexpected-restart",
        title: "Stop, and standstill until the restart is commanded",
        standard: "ISO 10218-1:2011, 5.5.3 and ISO 14118:2017 (prevention of unexpected start-up)",
        notes: "Two stages: the robot comes to rest in time, then it rests until a person restarts it.",
        sentence: "When stop_requested, the robot shall within stopping_time satisfy \
                   robot_speed <= standstill_speed, then until restart_commanded satisfy \
                   robot_speed <= standstill_speed",
        parameters: &[STOPPING_TIME, STANDSTILL_SPEED],
        needs: &[
            STOP_REQUESTED,
            proposition(
                "restart_commanded",
                "a person has commanded the robot to go on",
            ),
            ROBOT_SPEED,
        ],
    },
    Template {
        id: "monitored-stop",
        title: "Standstill while a person is in the collaborative workspace",
        standard: "ISO/TS 15066:2016, 5.5.2 (safety-rated monitored stop)",
        notes: "For robots that do not move at all in the presence of people.",
        sentence: "While person_in_workspace, the robot shall within stopping_time satisfy \
                   robot_speed <= standstill_speed, then always satisfy robot_speed <= standstill_speed",
        parameters: &[STOPPING_TIME, STANDSTILL_SPEED],
        needs: &[
            proposition(
                "person_in_workspace",
                "some part of a person is in the collaborative workspace",
            ),
            ROBOT_SPEED,
        ],
    },
    Template {
        id: "hold-to-run",
        title: "Standstill unless the enabling device is held",
        standard: "ISO 10218-1:2011, 5.8.3 (enabling device)",
        notes: "Also for hold-to-run control; released and fully pressed both count as not held.",
        sentence: "When not in enabling_device_held, the robot shall within stopping_time satisfy \
                   robot_speed <= standstill_speed, then always satisfy robot_speed <= standstill_speed",
        parameters: &[STOPPING_TIME, STANDSTILL_SPEED],
        needs: &[
            proposition(
                "enabling_device_held",
                "the enabling device is in its middle position",
            ),
            ROBOT_SPEED,
        ],
    },
    Template {
        id: "stop-on-communication-loss",
        title: "Stop when communication is lost",
        standard: "ISO 10218-1:2011, 5.8 (pendant controls: loss of communication stops the robot)",
        notes: "The age of the last message has to be recorded on the robot's side of the connection.",
        sentence: "When heartbeat_age > heartbeat_timeout, the robot shall within stopping_time satisfy \
                   robot_speed <= standstill_speed",
        parameters: &[HEARTBEAT_TIMEOUT, STOPPING_TIME, STANDSTILL_SPEED],
        needs: &[
            quantity(
                "heartbeat_age",
                "s",
                "time since the last message from the other side",
            ),
            ROBOT_SPEED,
        ],
    },
];
