//! Power and force limiting: what a contact between robot and person may do.
//!
//! Choose the limits by the body region that can be touched ([`super::BODY_REGIONS`]). The defaults
//! are those of hands and fingers, since handing over is what the templates were first written for.

use super::{Declaration, Template, parameter, quantity};

const CONTACT_FORCE: super::Need = quantity(
    "contact_force",
    "N",
    "force between robot and person, magnitude; 0 without contact",
);
const CONTACT_PRESSURE: super::Need = quantity(
    "contact_pressure",
    "N/cm^2",
    "greatest pressure between robot and person anywhere in the contact; 0 without contact",
);
const QUASI_STATIC_FORCE: Declaration = parameter(
    "quasi_static_force",
    "140 N",
    ["1 N", "220 N"],
    "greatest permissible force on a clamped body part; 140 N for hands and fingers in ISO/TS 15066:2016, \
     table A.2",
);
const TRANSIENT_FORCE: Declaration = parameter(
    "transient_force",
    "280 N",
    ["1 N", "440 N"],
    "greatest permissible force of a short contact; twice the quasi-static one, but not for skull and face, \
     where no such contact is permissible",
);
const TRANSIENT_TIME: Declaration = parameter(
    "transient_time",
    "0.5 s",
    ["1 ms", "0.5 s"],
    "how long a contact may last and count as transient; half a second in ISO/TS 15066",
);

const fn pressure(name: &'static str, meaning: &'static str) -> Declaration {
    Declaration {
        name,
        default: None,
        least: "1 N/cm^2",
        most: "600 N/cm^2",
        meaning,
    }
}

pub(super) const TEMPLATES: &[Template] = &[
    Template {
        id: "transient-force",
        title: "Force of any contact",
        standard: "ISO/TS 15066:2016, 5.5.5 and annex A (power and force limiting, transient contact)",
        notes: "Holds at all times; together with quasi-static-force it bounds both kinds of contact.",
        sentence: "The robot shall always satisfy contact_force <= transient_force",
        parameters: &[TRANSIENT_FORCE],
        needs: &[CONTACT_FORCE],
    },
    Template {
        id: "quasi-static-force",
        title: "Force of a lasting contact",
        standard: "ISO/TS 15066:2016, 5.5.5 and annex A (power and force limiting, quasi-static contact)",
        notes: "What exceeds the limit for lasting contacts has to be over before it is one.",
        sentence: "When contact_force > quasi_static_force, the robot shall within transient_time satisfy \
                   contact_force <= quasi_static_force",
        parameters: &[QUASI_STATIC_FORCE, TRANSIENT_TIME],
        needs: &[CONTACT_FORCE],
    },
    Template {
        id: "transient-pressure",
        title: "Pressure of any contact",
        standard: "ISO/TS 15066:2016, 5.5.5 and annex A (power and force limiting, transient contact)",
        notes: "The limit depends on the place that can be touched and has to be given.",
        sentence: "The robot shall always satisfy contact_pressure <= transient_pressure",
        parameters: &[pressure(
            "transient_pressure",
            "greatest permissible pressure of a short contact at the place that can be touched",
        )],
        needs: &[CONTACT_PRESSURE],
    },
    Template {
        id: "quasi-static-pressure",
        title: "Pressure of a lasting contact",
        standard: "ISO/TS 15066:2016, 5.5.5 and annex A (power and force limiting, quasi-static contact)",
        notes: "The limit depends on the place that can be touched and has to be given.",
        sentence: "When contact_pressure > quasi_static_pressure, the robot shall within transient_time \
                   satisfy contact_pressure <= quasi_static_pressure",
        parameters: &[
            pressure(
                "quasi_static_pressure",
                "greatest permissible pressure on a clamped body part at the place that can be touched",
            ),
            TRANSIENT_TIME,
        ],
        needs: &[CONTACT_PRESSURE],
    },
    Template {
        id: "contact-released",
        title: "A contact is released",
        standard: "ISO/TS 15066:2016, 5.5.5 (a person who is clamped can be freed)",
        notes: "The force has to fall to almost nothing in time, and then stay there until the robot is restarted.",
        sentence: "When contact_force > contact_threshold, the robot shall within freeing_time satisfy \
                   contact_force <= free_force, then until restart_commanded satisfy \
                   contact_force <= contact_threshold",
        parameters: &[
            parameter(
                "contact_threshold",
                "20 N",
                ["1 N", "220 N"],
                "force from which on a contact counts; above the noise and what the task needs",
            ),
            parameter(
                "freeing_time",
                "1 s",
                ["10 ms", "10 s"],
                "longest time until the person is free",
            ),
            parameter(
                "free_force",
                "5 N",
                ["0 N", "50 N"],
                "force at which the person counts as free",
            ),
        ],
        needs: &[
            CONTACT_FORCE,
            super::proposition(
                "restart_commanded",
                "a person has commanded the robot to go on",
            ),
        ],
    },
];
