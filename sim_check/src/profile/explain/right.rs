//! The rules of what an asset says of how sure it is.

use super::text::Text;
use crate::profile::bounds::*;
use crate::profile::words::percent;

/// R1 to R7.
pub(super) const TEXTS: [Text; 7] = [
    Text {
        id: "R1",
        why: "An asset can pass every other check and be cut in the wrong place: a rack that takes the oven's wall along.",
        how: || {
            format!(
                "The probabilities that asset.json gives for the surface of each link must be at least {SURE}."
            )
        },
        mend: &[
            ("does not say", "make the asset with an articulator that says how sure it is"),
            (
                "",
                "look at the link that is named in `kinfold studio`, and click what it lacks or has too much of",
            ),
        ],
    },
    Text {
        id: "R2",
        why: "A joint about the wrong axis moves smoothly and means nothing.",
        how: || {
            format!(
                "The probabilities that asset.json gives for each joint's axis and line must be at least {SURE}."
            )
        },
        mend: &[
            ("does not say", "make the asset with an articulator that says how sure it is"),
            (
                "",
                "choose another axis in `kinfold studio`, or give `axis` and `pivot` in the condition file",
            ),
        ],
    },
    Text {
        id: "R3",
        why: "A door that opens into its cabinet may touch nothing there, and pass.",
        how: || {
            format!(
                "The probability that asset.json gives for the way each joint opens must be at least {SURE}."
            )
        },
        mend: &[
            ("does not say", "make the asset with an articulator that says how sure it is"),
            (
                "",
                "turn the joint round in `kinfold studio`, or give its `range` in the condition file",
            ),
        ],
    },
    Text {
        id: "R4",
        why: "A front that stays behind, or a panel that goes along, looks right until the joint moves.",
        how: || {
            format!(
                "asset.json names the piece of each link that may be another link's. Where the link is less likely right than {UNSURE}, one of {} of it or more must have a class probability below {STRAY}.",
                percent(PIECE)
            )
        },
        mend: &[
            ("does not say", "make the asset with an articulator that says how sure it is"),
            ("", "put a point on the piece that is named, for the part that it is of"),
        ],
    },
    Text {
        id: "R5",
        why: "What was shown half open gets a range that may not lead back to shut.",
        how: || {
            format!(
                "The pose shown is compared with the range of each joint. Between {} and {} of the range from its nearer end it is neither shut nor in the middle.",
                percent(AJAR.0),
                percent(AJAR.1)
            )
        },
        mend: &[(
            "",
            "say how far it is shown open, as `rest` in the condition file, or give its `range`",
        )],
    },
    Text {
        id: "R6",
        why: "A drawer's box that stays in the cabinet while its front comes out touches nothing there that holds it.",
        how: || {
            format!(
                "What each link shows is put together where it comes within {} of the diagonal. Looked at is each piece but the largest that is {} of its link and of all. No more than {TWICE} times as much of it may lie within {} of the diagonal along another link as along its own. What merely slides along the other does not count.",
                percent(TOUCH),
                percent(LOOSE_PIECE),
                percent(ALONG)
            )
        },
        mend: &[("", "put a point on the piece that is named, for the part that it is of")],
    },
    Text {
        id: "R7",
        why: "A door that is shown open and can only open further never shuts; a leaf that goes into its desk is never pulled out.",
        how: || {
            format!(
                "A joint that is shown at an end of its range is moved beyond that end, as far as it is free, up to {FARTHEST} times the range. Where a turn is free {} of the range or more, it is asked how much of the part lies within {} of the diagonal from the rest. That must not be {} more there than as shown. A slide of {} of the diagonal or more, of which {} is so near, must not go deeper where {} of it comes free.",
                percent(BACK),
                percent(LIES),
                percent(CLOSER),
                percent(STROKE),
                percent(INSIDE),
                percent(OUT)
            )
        },
        mend: &[
            ("has no", "mend what the checks of group J say of the joint first"),
            (
                "",
                "say how far it is shown open, as `rest` in the condition file, or give its `range`",
            ),
        ],
    },
];
