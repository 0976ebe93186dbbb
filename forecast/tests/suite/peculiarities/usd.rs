//! Peculiar USD stages.

use super::Peculiar;

const HEAD: &str = "#usda 1.0\n(\n    defaultPrim = \"W\"\n    kilogramsPerUnit = 1\n    \
    metersPerUnit = 1\n    upAxis = \"Z\"\n)\ndef PhysicsScene \"scene\"\n{\n}\n";
const RANGE: &str = "float physics:lowerLimit = -30\nfloat physics:upperLimit = 30\n";

fn prim(kind: &str, name: &str, apis: &str, inner: &str) -> String {
    let apis = match apis {
        "" => String::new(),
        _ => {
            let quoted: Vec<_> = apis.split(' ').map(|a| format!("\"{a}\"")).collect();
            format!(" (\n    prepend apiSchemas = [{}]\n)", quoted.join(", "))
        }
    };
    format!("def {kind} \"{name}\"{apis}\n{{\n{inner}}}\n")
}

fn body(name: &str, height: f64, inner: &str) -> String {
    let apis = "PhysicsRigidBodyAPI PhysicsCollisionAPI PhysicsMassAPI";
    let inner = format!(
        "double size = 0.2\ndouble3 xformOp:translate = (0, 0, {height})\n\
         uniform token[] xformOpOrder = [\"xformOp:translate\"]\n{inner}"
    );
    prim("Cube", name, apis, &inner)
}

fn joint(kind: &str, apis: &str, inner: &str) -> String {
    let ends = "rel physics:body0 = </W/base>\nrel physics:body1 = </W/a>\n\
                point3f physics:localPos0 = (0, 0, 0.5)\nuniform token physics:axis = \"Z\"\n";
    prim(kind, "j", apis, &(ends.to_string() + inner))
}

fn stage(name: &'static str, inner: &str, rules: &'static str) -> Peculiar {
    let root = prim("PhysicsFixedJoint", "root", "", "rel physics:body1 = </W/base>\n");
    let inner = format!("{inner}{root}");
    let text = HEAD.to_string() + &prim("Xform", "W", "PhysicsArticulationRootAPI", &inner);
    Peculiar { name, extension: "usda", text, beside: Vec::new(), rules }
}

/// Two cubes of 1 kg and the joint between them.
fn jointed(name: &'static str, joint: &str, rules: &'static str) -> Peculiar {
    let mass = "float physics:mass = 1\n";
    stage(name, &(body("base", 0.0, mass) + &body("a", 0.5, mass) + joint), rules)
}

pub(crate) fn files() -> Vec<Peculiar> {
    let hinge = |apis: &str, inner: &str| joint("PhysicsRevoluteJoint", apis, inner);
    let lone = |name, inner: &str, rules| stage(name, &body("base", 0.0, inner), rules);
    let points = "point3f[] points = [(0,0,0), (.3,0,0), (0,.2,0), (0,0,.1)]\n\
        int[] faceVertexCounts = [3, 3, 3, 3]\nint[] faceVertexIndices = [0,2,1, 0,1,3, 0,3,2, 1,2,3]\n\
        uniform token subdivisionScheme = \"none\"\n";
    let mirror = "float3 xformOp:scale = (1, -1, 1)\n\
                  uniform token[] xformOpOrder = [\"xformOp:scale\"]\n";
    let mirrored =
        prim("Xform", "left", "", &(mirror.to_string() + &prim("Mesh", "seen", "", points)));
    let axes = ["transX", "transY", "transZ", "rotX", "rotY"];
    let apis = axes.map(|a| format!("PhysicsLimitAPI:{a}")).join(" ");
    let locked = axes
        .map(|a| format!("float limit:{a}:physics:low = 1\nfloat limit:{a}:physics:high = -1\n"))
        .concat();
    let off = prim(
        "Cube",
        "off",
        "PhysicsCollisionAPI",
        "double size = 0.2\nbool physics:collisionEnabled = 0\n",
    );
    vec![
        jointed("usd_plain", &hinge("", RANGE), ""),
        jointed(
            "usd_physx_joint",
            &hinge(
                "PhysxJointAPI",
                &format!(
                    "{RANGE}float physxJoint:jointFriction = 0.7\nfloat physxJoint:maxJointVelocity = 90\n"
                ),
            ),
            "newton.usd-physx-joint",
        ),
        jointed(
            "usd_excluded_joint",
            &hinge("", &format!("{RANGE}uniform bool physics:excludeFromArticulation = 1\n")),
            "newton.usd-excluded-joint",
        ),
        jointed("usd_free_axis", &joint("PhysicsJoint", &apis, &locked), "newton.usd-free-axis"),
        jointed(
            "usd_one_sided",
            &hinge("", "float physics:lowerLimit = -30\n"),
            "isaac.usd-one-sided-limit",
        ),
        lone(
            "usd_disabled_body",
            "float physics:mass = 1\nbool physics:rigidBodyEnabled = 0\n",
            "newton.usd-disabled-body",
        ),
        lone(
            "usd_centre_alone",
            "float physics:mass = 1\npoint3f physics:centerOfMass = (0.2, 0, 0)\n",
            "newton.usd-com-inertia",
        ),
        lone("usd_disabled_collider", &off, "isaac.usd-disabled-collider"),
        lone(
            "usd_mirrored",
            &("float physics:mass = 1\n".to_string() + &mirrored),
            "newton.usd-mirrored-visual",
        ),
    ]
}
