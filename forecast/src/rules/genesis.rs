//! Rules about Genesis, read in its source: it needs PyTorch and a device, so no test asks it.

use crate::client::Client;
use crate::find::{joints, links, mass, meshes};
use crate::rule::Severity::{Behaves, Note, Refused};
use crate::rule::{Find, Rule, Severity, Source};

const VERSION: &str = "genesis-world 1.4.5";
/// How URDFs are taken in.
const READER: Source = Source::Read("genesis/utils/urdf.py");
/// What its copy of urdfpy refuses.
const PARSER: Source = Source::Read("genesis/ext/urdfpy/urdf.py");
/// How it finds meshes.
const PATHS: Source = Source::Read("genesis/ext/urdfpy/utils.py, get_filename");
/// What weighs a link that says nothing.
const DENSITY: Source = Source::Read("genesis/engine/materials/rigid.py, rho");
/// What `gs.morphs.URDF` has for defaults.
const MORPH: Source = Source::Read("genesis/options/morphs.py");

const fn rule(
    id: &'static str,
    severity: Severity,
    source: Source,
    find: Find,
    sentence: &'static str,
    remedy: &'static str,
) -> Rule {
    Rule { id, client: Client::Genesis, severity, version: VERSION, source, sentence, remedy, find }
}

pub(super) const RULES: &[Rule] = &[
    rule(
        "genesis.limit-missing",
        Refused,
        PARSER,
        Find::Urdf(joints::limit_missing),
        "Genesis refuses the file: a revolute or prismatic joint must have a <limit>.",
        "Write <limit lower upper effort velocity>.",
    ),
    rule(
        "genesis.joint-type",
        Refused,
        READER,
        Find::Urdf(joints::unknown_or_planar),
        "Genesis refuses the file: it builds no joint of this type.",
        "Use revolute, continuous, prismatic, fixed or floating.",
    ),
    rule(
        "genesis.link-twice",
        Refused,
        PARSER,
        Find::Urdf(links::twice),
        "Genesis refuses the file: two links have one name.",
        "Give each link a name of its own.",
    ),
    rule(
        "genesis.mesh-missing",
        Refused,
        PARSER,
        Find::Urdf(meshes::missing),
        "Genesis refuses the file: it cannot load this mesh.",
        "Put the mesh where the file says, relative to the URDF.",
    ),
    rule(
        "genesis.mesh-package",
        Refused,
        PATHS,
        Find::Urdf(meshes::by_package_elsewhere),
        "Genesis finds a package beside the file or among the folders above it; else it refuses the file.",
        "Write a path relative to the URDF.",
    ),
    rule(
        "genesis.mesh-file-uri",
        Refused,
        PATHS,
        Find::Urdf(meshes::by_file_uri),
        "Genesis takes file:// for a folder's name and refuses the file.",
        "Write a path relative to the URDF.",
    ),
    rule(
        "genesis.no-inertial",
        Behaves,
        DENSITY,
        Find::Urdf(mass::shaped_without_inertial),
        "Genesis weighs the link by its shapes at 1500 kg per cubic metre.",
        "Give the link an <inertial>, or set the material's rho.",
    ),
    rule(
        "genesis.fixed-merged",
        Behaves,
        MORPH,
        Find::Urdf(joints::fixed),
        "Genesis merges the child of a fixed joint into its parent: its name is gone.",
        "Name it in links_to_keep, or set merge_fixed_links=False.",
    ),
    rule(
        "genesis.faces-decimated",
        Behaves,
        MORPH,
        Find::Urdf(meshes::felt_of_many_faces),
        "Genesis thins a collision mesh out to about 500 faces.",
        "Set decimate=False.",
    ),
    rule(
        "genesis.concave",
        Behaves,
        MORPH,
        Find::Urdf(meshes::felt_concave),
        "Genesis collides with the convex hull of a robot's mesh: its hollows are filled.",
        "Set decompose_robot_error_threshold, or split the collision.",
    ),
    rule(
        "genesis.continuous-limit",
        Behaves,
        READER,
        Find::Urdf(joints::continuous_with_range),
        "Genesis drops the range of a continuous joint: it turns without end.",
        "Make the joint revolute if it has stops.",
    ),
    rule(
        "genesis.range-incomplete",
        Behaves,
        READER,
        Find::Urdf(joints::range_incomplete),
        "Genesis takes a missing end of a range for infinite.",
        "Write both lower and upper.",
    ),
    rule(
        "genesis.effort-zero",
        Behaves,
        READER,
        Find::Urdf(joints::effort_zero),
        "Genesis limits the joint's motor to a force of 0: it cannot be driven.",
        "Write the motor's real effort.",
    ),
    rule(
        "genesis.safety-gains",
        Behaves,
        READER,
        Find::Urdf(joints::safety),
        "Genesis takes the motor's gains from <safety_controller> and ignores its soft limits.",
        "Put the range into <limit>, and set gains from code.",
    ),
    rule(
        "genesis.armature",
        Note,
        MORPH,
        Find::Urdf(joints::movable),
        "Genesis adds a rotor inertia of 0.1 to every joint: light parts move slowly.",
        "Set default_armature=None.",
    ),
    rule(
        "genesis.gains",
        Note,
        READER,
        Find::Urdf(joints::movable),
        "Genesis gives each joint position gains of 100 and 10, whatever it carries.",
        "Call set_dofs_kp and set_dofs_kv.",
    ),
    rule(
        "genesis.velocity-dropped",
        Note,
        READER,
        Find::Urdf(joints::with_velocity),
        "Genesis drops the velocity limit: the joint may turn faster.",
        "Limit the speed in the controller.",
    ),
    rule(
        "genesis.base-free",
        Note,
        MORPH,
        Find::Urdf(links::roots),
        "Genesis lets the root link fall.",
        "Set fixed=True for what is mounted.",
    ),
];
