//! The rules of what stands still: files, tree, units, geometry, mass.

use super::text::Text;
use crate::profile::bounds::*;
use crate::profile::words::{grown, mm, percent, shrunk, thousands};

/// F1 to F4, T1 to T4, U1 to U3, G1 to G4, M1 to M7.
pub(super) const TEXTS: [Text; 22] = [
    Text {
        id: "F1",
        why: "A simulator that cannot read a file refuses it, or reads half of it. A number that is not finite spreads through every step of a simulation.",
        how: || {
            "The file is parsed as XML, in UTF-8, with caps on its size and depth. Every number is read and must be finite.".into()
        },
        mend: &[
            ("not finite", "write a finite number in that line"),
            ("is no number", "write a number in that line, with a point and without a unit"),
            ("UTF-8", "save the file as UTF-8"),
            ("", "mend the line that is named; `xmllint --noout FILE` shows the place, too"),
        ],
    },
    Text {
        id: "F2",
        why: "A model whose meshes lie elsewhere breaks as soon as it is moved to another machine.",
        how: || {
            "Every mesh that is named is looked for beside the file, read, and must not lead out of its folder.".into()
        },
        mend: &[
            ("package://", "write the path relative to the file, such as meshes/door.obj"),
            ("..", "move the mesh below the file's folder, or allow it with --allow-outside"),
            ("outside", "move the mesh below the file's folder, or allow it with --allow-outside"),
            ("", "put the mesh beside the file as STL, OBJ or DAE, and name it by a relative path"),
        ],
    },
    Text {
        id: "F3",
        why: "Joints, sensors and controllers find links by name. Two of one name, or odd characters, are read differently by each program.",
        how: || {
            "Names of links and joints are compared, and must be [A-Za-z_][A-Za-z0-9_]*.".into()
        },
        mend: &[
            (
                "called",
                "give each of them a name of its own, and rename it where it is referred to",
            ),
            ("", "rename it with letters, digits and `_` alone, and wherever it is referred to"),
        ],
    },
    Text {
        id: "F4",
        why: "What was changed after it was made is not what was checked.",
        how: || {
            "The BLAKE3 hash of every file that asset.json lists is computed and compared. The model and its meshes must be listed.".into()
        },
        mend: &[
            (
                "there is no",
                "only assets with an asset.json beside them can be audited; `kinfold make` writes one",
            ),
            ("", "make the asset again, or put back the files as they were"),
        ],
    },
    Text {
        id: "T1",
        why: "Simulators build a model from its root downwards. With two roots, a cycle or a missing link there is nothing to build.",
        how: || {
            "Parents and children of all joints are followed; one link must have no parent, and every other be reached from it.".into()
        },
        mend: &[
            (
                "root link",
                "hang every other link below one root, by a fixed joint where nothing moves",
            ),
            (
                "does not exist",
                "add the link, or name one that exists; names are read as they are written",
            ),
            ("child of joints", "leave one joint for each child: a tree has no loops"),
            ("", "mend parents and children so that one root reaches every link"),
        ],
    },
    Text {
        id: "T2",
        why: "A joint of unknown type is dropped or welded. A mimic that follows nothing or itself stops the model from loading.",
        how: || {
            "Types are compared with those of URDF, MJCF, SDFormat or UsdPhysics. Every mimic is followed to its leader."
                .into()
        },
        mend: &[
            ("mimic", "let it mimic another joint that exists and does not follow it"),
            ("", "use fixed, revolute, continuous or prismatic"),
        ],
    },
    Text {
        id: "T3",
        why: "A body that moves without mass and shape makes equations of motion singular. Simulators crash, or weld it.",
        how: || {
            "Every link that a joint moves is looked at for an inertial, a visual or a collision, its fixed children included.".into()
        },
        mend: &[(
            "",
            "give the link its <inertial> and geometry, or make the joint above it fixed",
        )],
    },
    Text {
        id: "T4",
        why: "A model with fewer parts or joints than were asked for is another object.",
        how: || {
            "Links with geometry and joints that move are counted and compared with the kinematic condition.".into()
        },
        mend: &[("", "look which part got no faces, and give it points in the condition")],
    },
    Text {
        id: "U1",
        why: "A mesh scale is applied by some programs to visuals alone, and by some not at all. Then what is seen and what collides differ.",
        how: || format!("Every mesh's scale is compared with 1, within {SCALE:e}."),
        mend: &[("", "write the scale into the vertices of the mesh, and leave scale=\"1 1 1\"")],
    },
    Text {
        id: "U2",
        why: "A kettle of 30 metres, because millimetres were read as metres, breaks every grasp and every contact.",
        how: || {
            format!(
                "The diagonal of the whole object at rest must be {} to {} m.",
                SIZES.start(),
                SIZES.end()
            )
        },
        mend: &[(
            "",
            "scale the object to its true size in metres; CAD files often are in millimetres",
        )],
    },
    Text {
        id: "U3",
        why: "Who places an object at z = 0 expects it to stand there. One that floats or is sunk falls or jumps at the first step.",
        how: || {
            format!(
                "The lowest point at rest must lie within {} of z = 0. The centre of the base must lie within {} of the z axis.",
                mm(PLACED.least),
                grown(PLACED, "its width")
            )
        },
        mend: &[("", "shift the root's geometry so that it stands on z = 0, centred on x = y = 0")],
    },
    Text {
        id: "G1",
        why: "Faces wound the wrong way are not drawn, and volumes and masses computed from them come out wrong. Too many faces slow everything.",
        how: || {
            format!(
                "Degenerate faces may be {} of all, edges wound against each other {}. Closed surfaces must have positive volume; all visuals together {} faces.",
                percent(DEGENERATE),
                percent(CLASHING),
                thousands(FACES as f64)
            )
        },
        mend: &[
            ("inward", "turn its faces round (Blender: Mesh > Normals > Recalculate Outside)"),
            (
                "wound against",
                "make normals consistent (Blender: Mesh > Normals > Recalculate Outside)",
            ),
            ("degenerate", "merge vertices by distance and delete degenerate faces"),
            ("together have", "decimate the visual meshes"),
            ("", "mend the surface in a mesh editor, and export it again"),
        ],
    },
    Text {
        id: "G2",
        why: "Engines collide convex pieces fast and exactly. A piece that is not convex is replaced by its hull, which fills openings; a thin one is tunnelled through.",
        how: || {
            format!(
                "Of each piece, dents below its hull may be {} of its diagonal, and its thickness must be {} or more. It may have {VERTICES} vertices, a link {PIECES} pieces.",
                percent(DENT),
                shrunk(THIN)
            )
        },
        mend: &[
            (
                "not convex",
                "split it into convex pieces, with CoACD or V-HACD for instance, a <collision> each",
            ),
            ("thin", "thicken it, or merge it with the piece beside it"),
            ("vertices", "take the convex hull of a decimated mesh"),
            ("pieces", "split it into fewer pieces: a higher threshold of CoACD"),
            ("is open", "close its holes, or take its convex hull"),
            ("inward", "turn its faces round"),
            (
                "no link has",
                "give every link that is seen a <collision>, such as its convex pieces",
            ),
            ("", "replace it by closed convex pieces, such as those of CoACD"),
        ],
    },
    Text {
        id: "G3",
        why: "A hand closes on what it sees. Where collision geometry stands off or fills a cavity, it grasps air, or cannot reach in.",
        how: || {
            format!(
                "Points of what is seen may lie {} from the pieces, and the other way. Pieces may fill empty space with {} of their volume.",
                grown(COVER, "the diagonal"),
                percent(FILLED)
            )
        },
        mend: &[
            ("empty", "split the pieces more finely, so that they leave the cavity free"),
            ("cavity", "split the pieces more finely, so that they leave the cavity free"),
            ("no link has visual", "give the links a <visual>, or check another file"),
            ("", "make the collision pieces from the visual mesh, and more finely"),
        ],
    },
    Text {
        id: "G4",
        why: "A knob that hangs in the air beside its door is a part that was lost, or that belongs to another link.",
        how: || {
            format!(
                "Pieces of surface above {} of area or volume must come within {} of the rest, or lie in something solid.",
                percent(LOOSE),
                grown(BESIDE, "the diagonal")
            )
        },
        mend: &[(
            "",
            "move the piece to where it belongs, delete it, or give it to the link that carries it",
        )],
    },
    Text {
        id: "M1",
        why: "A body without mass cannot be accelerated. Simulators invent a mass, each another, or refuse the model.",
        how: || "Every link that moves must have an <inertial> with a mass above 0.".into(),
        mend: &[(
            "",
            "add <inertial> with mass, centre and inertia to the link, from its shape and density",
        )],
    },
    Text {
        id: "M2",
        why: "A door as light as foam or as heavy as lead is moved by other forces than the real one.",
        how: || {
            format!(
                "Mass is divided by the volume of the closed surface, else of the pieces. {} to {} kg/m³ are possible, {} to {} likely.",
                thousands(DENSITY.0),
                thousands(DENSITY.1),
                thousands(LIKELY.0),
                thousands(LIKELY.1)
            )
        },
        mend: &[(
            "",
            "set the mass to volume times density of its material: wood 600, plastic 1,000, steel 7,800 kg/m³",
        )],
    },
    Text {
        id: "M3",
        why: "No body in the world has an inertia that breaks the triangle inequality. Engines become unstable with one, or refuse it.",
        how: || {
            format!(
                "The principal moments must be positive, and the largest no more than the sum of the others, within {TRIANGLE:e}."
            )
        },
        mend: &[("", "compute the inertia anew from the shape; at the centre of mass, in kg·m²")],
    },
    Text {
        id: "M4",
        why: "With the inertia of another body a door swings too slowly or too fast, whatever its mass.",
        how: || {
            format!(
                "Principal moments must be within {} and {MOMENTS} times those of its shape, as a solid or a shell, of that mass.",
                1.0 / MOMENTS
            )
        },
        mend: &[(
            "",
            "compute the inertia from the shape with that mass; look for millimetres taken as metres",
        )],
    },
    Text {
        id: "M5",
        why: "A centre of mass outside of its part makes it tip over, or lifts it where it should hang.",
        how: || {
            format!(
                "Its distance from the convex hull of the part may be {}.",
                grown(OUTSIDE, "the diagonal")
            )
        },
        mend: &[(
            "",
            "put the origin of <inertial> at the shape's centre of mass, in the link's frame",
        )],
    },
    Text {
        id: "M6",
        why: "Solvers shake where something heavy hangs on something light.",
        how: || {
            format!(
                "Of every joint that moves, the mass of the body above is divided by that below, what is welded to them included: {} times at most.",
                thousands(RATIO)
            )
        },
        mend: &[("", "look for a mass in grams; else give the light part more mass, or weld it")],
    },
    Text {
        id: "M7",
        why: "Whoever trusts a mass must know whether it was measured or is a guess.",
        how: || {
            "asset.json must list every mass with its origin, and with the model's value.".into()
        },
        mend: &[(
            "",
            "list each link's mass with its origin in asset.json, as `kinfold make` does",
        )],
    },
];
