//! The rules of what moves, and of where an asset comes from.

use std::f64::consts::PI;

use super::text::Text;
use crate::profile::bounds::*;
use crate::profile::words::{grown, moved, percent};

/// J1 to J7, L1, L2, C1 to C5, S1 to S5, P1 to P3.
pub(super) const TEXTS: [Text; 22] = [
    Text {
        id: "J1",
        why: "An axis that is not of length 1 is scaled by some programs and taken as it is by others. One of length 0 has no direction.",
        how: || format!("The length of each axis as it is written must be 1 within {AXIS:e}."),
        mend: &[("", "divide the axis by its length, such as xyz=\"0 0 1\"")],
    },
    Text {
        id: "J2",
        why: "Between limits that are missing or out of order no motion is possible. If rest lies outside, the model jumps at the first step.",
        how: || {
            "Of each joint that turns or slides within limits: lower < upper, and lower <= 0 <= upper.".into()
        },
        mend: &[
            (
                "no <limit>",
                "add <limit lower=\"…\" upper=\"…\" effort=\"…\" velocity=\"…\"/>, or make the joint continuous",
            ),
            ("not ordered", "swap lower and upper"),
            ("leave out the rest", "move the joint's origin, so that 0 lies within its limits"),
            ("", "give it limits with lower <= 0 <= upper"),
        ],
    },
    Text {
        id: "J3",
        why: "A range of 90 radians is one of 90 degrees that was written wrongly. A drawer that slides twice its length falls out.",
        how: || {
            format!(
                "A hinge may turn {} pi, a slide {SLIDE} of its part's extent along the axis.",
                TURN / PI
            )
        },
        mend: &[
            ("degrees", "write the limits in radians: degrees times pi / 180"),
            ("", "shorten the range to what the part can do, in radians or metres"),
        ],
    },
    Text {
        id: "J4",
        why: "A drive of effort 0 moves nothing. Without damping and friction a joint swings for ever.",
        how: || {
            "Effort and velocity must be above 0 and finite. Damping and friction should be given and not be negative.".into()
        },
        mend: &[
            (
                "has no effort",
                "add effort=\"…\" velocity=\"…\" to its <limit>, in N·m or N and rad/s or m/s",
            ),
            ("has no velocity", "add velocity=\"…\" to its <limit>, in rad/s or m/s"),
            ("negative", "give damping and friction of 0 or more"),
            ("has no", "add <dynamics damping=\"…\" friction=\"…\"/> to the joint"),
            ("", "give effort and velocity above 0"),
        ],
    },
    Text {
        id: "J5",
        why: "A door turns about its hinge, which is where it touches its frame. A pivot far away swings it through the air.",
        how: || {
            format!(
                "The axis must pass both parts within {} of the object's diagonal. For a slide the gap between its parts counts.",
                percent(PIVOT)
            )
        },
        mend: &[("", "move the joint's origin to the hinge; look for an origin left at 0 0 0")],
    },
    Text {
        id: "J6",
        why: "Hinges and rails follow edges and symmetries of what they carry. An oblique axis is mostly an error.",
        how: || {
            format!(
                "The angle between axis and the nearest edge, normal or symmetry of either part may be {PARALLEL} degrees."
            )
        },
        mend: &[(
            "",
            "turn the axis to the edge it is meant to follow, or waive it where it is oblique on purpose",
        )],
    },
    Text {
        id: "J7",
        why: "A door that opens by itself as soon as the simulation runs spoils every episode.",
        how: || {
            format!(
                "Gravity acts on what the joint carries, against its friction and limits. It may move by {} in {HELD_FOR} s.",
                moved(OPENED)
            )
        },
        mend: &[
            ("no mass", "give every link below the joint a mass"),
            ("", "raise the joint's friction, or let its rest pose lie at the lower limit"),
        ],
    },
    Text {
        id: "L1",
        why: "Whoever asks for `the handle` must find it by its words.",
        how: || "Every link with geometry must have a text in asset.json.".into(),
        mend: &[("", "write a label for each link into asset.json, as `kinfold make` does")],
    },
    Text {
        id: "L2",
        why: "A planner can use what is marked as meant for hands; nothing fails without.",
        how: || {
            "It is looked for `graspable` of the links in asset.json; one that says so is enough."
                .into()
        },
        mend: &[("", "nothing must be done; mark handles with \"graspable\": true in asset.json")],
    },
    Text {
        id: "C1",
        why: "Parts that overlap at rest are flung apart by the first step of a simulation. Nothing that follows means anything.",
        how: || {
            format!(
                "The collision pieces of every two links, neighbours too, may overlap by {} at rest.",
                grown(OVERLAP, "the diagonal")
            )
        },
        mend: &[(
            "",
            "shrink or move the collision pieces of the two links that are named, or waive a pin that sits in its hole",
        )],
    },
    Text {
        id: "C2",
        why: "A door that passes through its frame jams in a simulator, or tears the model apart.",
        how: || {
            format!(
                "Each joint is moved alone through its whole range in small steps. Overlaps may be {} deep.",
                grown(OVERLAP, "the diagonal")
            )
        },
        mend: &[(
            "",
            "end the range before the pose that is named, move the pivot, or cut away the piece in the way",
        )],
    },
    Text {
        id: "C3",
        why: "Two joints that are each free alone may meet when both move, as a drawer behind a closed door.",
        how: || {
            format!(
                "The corners of every two joints' ranges and random poses of all joints are looked at. Overlaps may be {} deep.",
                grown(OVERLAP, "the diagonal")
            )
        },
        mend: &[(
            "",
            "shorten the range of one of the two, or waive it where the object really is like that",
        )],
    },
    Text {
        id: "C4",
        why: "A door that leaves its hinge on the way, or a drawer that leaves its guide, is not held by anything one sees.",
        how: || {
            format!(
                "Along its range a hinge's gap to its parent may grow by {}. A slide must keep {} of itself in its guide.",
                grown(HINGE_GAP, "the diagonal"),
                percent(SLIDE_KEEPS)
            )
        },
        mend: &[
            ("in its guide", "shorten the range, so that a part of it stays in its guide"),
            ("gap", "move the pivot and the axis to the hinge"),
            ("no colliders", "give both sides of the joint a <collision>"),
            ("", "move the pivot to the hinge, or shorten the range"),
        ],
    },
    Text {
        id: "C5",
        why: "A door whose axis points the wrong way opens into its own cabinet.",
        how: || {
            "Each joint is moved the way it is declared to open, and the other way. It fails if it soon collides and the other way is free. A joint whose two sides have no colliders meets nothing, and is unknown.".into()
        },
        mend: &[
            ("no colliders", "give both sides of the joint a <collision>"),
            ("", "turn the axis round, or swap the limits' signs: lower = -upper"),
        ],
    },
    Text {
        id: "S1",
        why: "A model that gains energy by itself explodes sooner or later.",
        how: || {
            format!(
                "It is swung, dropped and driven. Every state must be finite, and energy may grow by {}.",
                percent(GAIN)
            )
        },
        mend: &[(
            "",
            "look at masses and inertias first (M1 to M6), then at overlaps at rest (C1)",
        )],
    },
    Text {
        id: "S2",
        why: "An object that tips over or creeps away where it is put cannot be used in a scene.",
        how: || {
            format!(
                "Dropped from a small height it must settle within {SETTLE} s, drift less than {} and lean less than {TIPPED} degrees.",
                grown(DRIFT, "the diagonal")
            )
        },
        mend: &[
            ("lean", "widen its base, or lower its centre of mass"),
            ("tip", "widen its base, or lower its centre of mass"),
            ("drift", "give it flat collision geometry to stand on"),
            ("", "let its collision geometry stand flat on z = 0, and raise the joints' friction"),
        ],
    },
    Text {
        id: "S3",
        why: "A joint that jams half-way cannot be used, whatever its limits say.",
        how: || {
            format!(
                "Every joint is driven to both ends, the others held. It must cover {} of its range and overshoot by less than {}.",
                percent(REACHED),
                percent(OVERSHOOT)
            )
        },
        mend: &[(
            "",
            "find what it meets on its way (C2), shorten the range or free the way; look at masses (M1 to M4)",
        )],
    },
    Text {
        id: "S4",
        why: "A limit that gives way lets a door pass through its frame under a strong hand.",
        how: || {
            format!(
                "Every joint is pushed against its limits with twice its effort. It may give way by {} of its range, or {}.",
                percent(PUSHED),
                moved(PUSHED_LEAST)
            )
        },
        mend: &[("", "lower the effort to what the mass of the part needs")],
    },
    Text {
        id: "S5",
        why: "If it swings in another time than its inertia says, the engine sees other masses than the file has.",
        how: || {
            format!(
                "Each joint moves alone, as a pendulum or a weight. The time must be that of the closed form within {}.",
                percent(CLOSED_FORM)
            )
        },
        mend: &[
            ("no sound mass", "give every link below the joint a mass and an inertia"),
            ("", "compute masses and inertias anew; look for an <inertial> whose origin is turned"),
        ],
    },
    Text {
        id: "P1",
        why: "Without a trace nobody can say how an asset came to be.",
        how: || {
            "`kinfold audit` and `kinfold trace verify` read the trace; every file must follow from it.".into()
        },
        mend: &[(
            "",
            "keep trace.mcap beside the asset, and ask `kinfold trace verify DIR`; `kinfold audit` asks of a batch",
        )],
    },
    Text {
        id: "P2",
        why: "An asset made with a model whose licence forbids it may not be used.",
        how: || "Every licence that asset.json lists must be one that the policy allows.".into(),
        mend: &[(
            "",
            "say a policy, or make the asset with providers that it allows (`kinfold providers`)",
        )],
    },
    Text {
        id: "P3",
        why: "A default that looks like a measurement misleads whoever relies on it.",
        how: || {
            "Every number of asset.json needs an origin, and every default must stand in its list of defaults.".into()
        },
        mend: &[("", "list the numbers with their origins in asset.json, as `kinfold make` does")],
    },
];
