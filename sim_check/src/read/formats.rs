//! The same model in every format.

use crate::check;
use crate::options::{Asked, CheckOptions};
use crate::profile::Tier;
use crate::robot::{Format, Robot};
use crate::verdict::Status;

/// A folder of its own.
pub(super) struct Place(std::path::PathBuf);

impl Place {
    pub(super) fn new(name: &str) -> Self {
        let place =
            std::env::temp_dir().join(format!("kinfold-read-{name}-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&place);
        std::fs::create_dir_all(&place).unwrap();
        Self(place)
    }

    pub(super) fn write(&self, name: &str, text: &str) -> std::path::PathBuf {
        let file = self.0.join(name);
        std::fs::create_dir_all(file.parent().unwrap()).unwrap();
        std::fs::write(&file, text).unwrap();
        file
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// The same in USD: z up, or y up where a unit is less than a metre, the door ajar by 0.5 rad there.
fn usd(units: f64) -> String {
    let is_upright = units == 1.0;
    // Places, directions and sizes in the stage's frame.
    let v = |[x, y, z]: [f64; 3]| match is_upright {
        true => format!("({x}, {y}, {z})"),
        false => format!("({}, {}, {})", x * units, z * units, -y * units),
    };
    let s = |[x, y, z]: [f64; 3]| match is_upright {
        true => format!("({x}, {y}, {z})"),
        false => format!("({}, {}, {})", x * units, z * units, y * units),
    };
    let cube = |name: &str, at: [f64; 3], size: [f64; 3], more: &str| {
        format!(
            "def Cube \"{name}\" {more} {{ double size = 1\n double3 xformOp:translate = {}\n double3 xformOp:scale = {}\n \
             uniform token[] xformOpOrder = [\"xformOp:translate\", \"xformOp:scale\"] }}\n",
            v(at),
            s(size)
        )
    };
    let both = |at: [f64; 3], size: [f64; 3]| {
        cube("v", at, size, "")
            + &cube("c", at, size, "(prepend apiSchemas = [\"PhysicsCollisionAPI\"])")
                .replace("double size", "uniform token purpose = \"guide\"\n double size")
    };
    let [xx, yy, zz] = [0.02, 0.014, 0.008].map(|n| n * units * units);
    let triple = |[x, y, z]: [f64; 3]| format!("({x}, {y}, {z})");
    let moments = triple(if is_upright { [xx, yy, zz] } else { [xx, zz, yy] });
    let ([bx, bz], mass) = ([0.08, 0.06].map(|n| n * units * units), "float physics:mass");
    let boxed = triple(if is_upright { [bx, bx, bz] } else { [bx, bz, bx] });
    let (up, turn) = if is_upright { ("Z", 0.0) } else { ("Y", -0.5f64.to_degrees()) };
    let dof = "drive:angular:physics";
    let torque = 3.0 * units * units;
    let rub = 0.05 * units * units;
    let damping = (0.1 * units * units).to_radians();
    let apis = |more: &str| {
        format!("(prepend apiSchemas = [\"PhysicsRigidBodyAPI\", \"PhysicsMassAPI\"{more}])")
    };
    // About the file's up axis; the joint's own axis looks down.
    let (down, spin) = match is_upright {
        true => ("(0, 1, 0, 0)", "rotateZ"),
        false => ("(0.70710678118654757, 0.70710678118654757, 0, 0)", "rotateY"),
    };
    format!(
        "#usda 1.0\n(defaultPrim = \"m\" metersPerUnit = {} upAxis = \"{up}\")\ndef Xform \"m\" {{\n\
         def Xform \"box\" {} {{ {mass} = 4\n float3 physics:diagonalInertia = {boxed}\n point3f physics:centerOfMass = (0, 0, 0)\n {} }}\n\
         def Xform \"door\" {} {{ {mass} = 1\n float3 physics:diagonalInertia = {moments}\n point3f physics:centerOfMass = {}\n \
         double3 xformOp:translate = {}\n double xformOp:{spin} = {turn}\n uniform token[] xformOpOrder = [\"xformOp:translate\", \"xformOp:{spin}\"]\n {} }}\n\
         def PhysicsRevoluteJoint \"hinge\" (prepend apiSchemas = [\"PhysicsDriveAPI:angular\"]) {{ rel physics:body0 = </m/box>\n rel physics:body1 = </m/door>\n \
         uniform token physics:axis = \"Z\"\n point3f physics:localPos0 = {}\n quatf physics:localRot0 = {down}\n quatf physics:localRot1 = {down}\n \
         float physics:lowerLimit = 0\n float physics:upperLimit = {}\n float {dof}:maxForce = {torque}\n float {dof}:damping = {damping}\n \
         float physxJointAxis:angular:maxJointVelocity = {}\n float physxJointAxis:angular:staticFrictionEffort = {rub} }}\n}}\n",
        1.0 / units,
        apis(""),
        both([0.0; 3], [0.3, 0.3, 0.4]),
        apis(""),
        v([0.0, 0.15, 0.0]),
        v([0.161, -0.15, 0.0]),
        both([0.0, 0.15, 0.0], [0.02, 0.3, 0.4]),
        v([0.161, -0.15, 0.0]),
        1.5f64.to_degrees(),
        2f64.to_degrees(),
    )
}

/// A box with a door, in every format.
fn doors() -> [(&'static str, String); 5] {
    let urdf = r#"<robot name="m"><link name="box"><inertial><mass value="4"/><inertia ixx=".08" iyy=".08" izz=".06" ixy="0" ixz="0" iyz="0"/></inertial>
<visual><geometry><box size=".3 .3 .4"/></geometry></visual><collision><geometry><box size=".3 .3 .4"/></geometry></collision></link>
<link name="door"><inertial><origin xyz="0 .15 0"/><mass value="1"/><inertia ixx=".02" iyy=".014" izz=".008" ixy="0" ixz="0" iyz="0"/></inertial>
<visual><origin xyz="0 .15 0"/><geometry><box size=".02 .3 .4"/></geometry></visual><collision><origin xyz="0 .15 0"/><geometry><box size=".02 .3 .4"/></geometry></collision></link>
<joint name="hinge" type="revolute"><origin xyz=".161 -.15 0" rpy="0 0 0"/><parent link="box"/><child link="door"/><axis xyz="0 0 -1"/><limit lower="0" upper="1.5" effort="3" velocity="2"/><dynamics damping=".1" friction=".05"/></joint></robot>"#;
    let mjcf = r#"<mujoco model="m"><compiler angle="radian"/><worldbody><body name="box"><freejoint/><inertial pos="0 0 0" mass="4" diaginertia=".08 .08 .06"/>
<geom type="box" size=".15 .15 .2"/><body name="door" pos=".161 -.15 0"><joint name="hinge" axis="0 0 -1" range="0 1.5" actuatorfrcrange="-3 3" damping=".1" frictionloss=".05"/>
<inertial pos="0 .15 0" mass="1" diaginertia=".02 .014 .008"/><geom type="box" size=".01 .15 .2" pos="0 .15 0"/></body></body></worldbody></mujoco>"#;
    let inertial = |pose: &str, mass: &str, [x, y, z]: [&str; 3]| {
        format!(
            "<inertial><pose>{pose} 0 0 0</pose><mass>{mass}</mass><inertia><ixx>{x}</ixx><iyy>{y}</iyy><izz>{z}</izz></inertia></inertial>"
        )
    };
    let both = |pose: &str, size: &str| {
        let shape = format!("<geometry><box><size>{size}</size></box></geometry>");
        format!(
            "<visual name='v'><pose>{pose} 0 0 0</pose>{shape}</visual><collision name='c'><pose>{pose} 0 0 0</pose>{shape}</collision>"
        )
    };
    let sdf = format!(
        "<sdf version='1.9'><model name='m'><link name='box'>{}{}</link>\n<link name='door'><pose>.161 -.15 0 0 0 0</pose>{}{}</link>\n\
         <joint name='hinge' type='revolute'><parent>box</parent><child>door</child><axis><xyz>0 0 -1</xyz><limit><lower>0</lower><upper>1.5</upper>\
         <effort>3</effort><velocity>2</velocity></limit><dynamics><damping>.1</damping><friction>.05</friction></dynamics></axis></joint></model></sdf>",
        inertial("0 0 0", "4", [".08", ".08", ".06"]),
        both("0 0 0", ".3 .3 .4"),
        inertial("0 .15 0", "1", [".02", ".014", ".008"]),
        both("0 .15 0", ".02 .3 .4"),
    );
    [
        ("m.urdf", urdf.into()),
        ("m.xml", mjcf.into()),
        ("m.sdf", sdf),
        ("m.usda", usd(1.0)),
        ("y.usda", usd(100.0)),
    ]
}

#[test]
fn one_model_in_every_format_gets_one_verdict() {
    let place = Place::new("one");
    let options =
        CheckOptions { up_to: Tier::Dynamic, subject: Asked::Found, ..CheckOptions::default() };
    let files = doors().map(|(name, text)| place.write(name, &text));
    let verdicts = files.each_ref().map(|file| check(file, &options));
    let [urdf, others @ ..] = &verdicts;
    assert_eq!(urdf.tier, Tier::Dynamic, "{:?}", urdf.failures().collect::<Vec<_>>());
    for (k, other) in others.iter().enumerate() {
        let name = doors()[k + 1].0;
        assert_eq!(
            (other.tier, other.links),
            (urdf.tier, urdf.links),
            "{name}: {:#?}",
            other.failures().collect::<Vec<_>>()
        );
        for check in &urdf.checks {
            let found = other.check(&check.id).unwrap();
            // MJCF has no word for velocity.
            if (check.id.as_str(), name) == ("J4", "m.xml") {
                continue;
            }
            assert_eq!(found.status, check.status, "{name}: {found:?}");
            // What is measured at rest is another where the file has its door ajar.
            let values = check.value.zip(found.value).filter(|_| name != "y.usda");
            if let Some((a, b)) = values {
                assert!(
                    (a - b).abs() <= 1e-6 * a.abs().max(1e-3),
                    "{name} {}: {a} and {b}",
                    check.id
                );
            }
        }
    }
    let robots =
        files.each_ref().map(|file| crate::read::load::read(file, &options).robot.unwrap());
    let [urdf, .., ajar] = &robots;
    let masses = |robot: &Robot| -> Vec<f64> {
        robot
            .links
            .iter()
            .filter_map(|l| l.inertial)
            .flat_map(|i| [i.mass, i.inertia.determinant()])
            .collect()
    };
    for robot in &robots {
        for (a, b) in masses(urdf).iter().zip(masses(robot)) {
            assert!((a / b - 1.0).abs() < 1e-6, "{:?}: {a} and {b}", robot.format);
        }
    }
    assert_eq!((ajar.format, ajar.joints[0].name.as_str()), (Format::Usd, "hinge"));
    assert!((ajar.joints[0].rest - 0.5).abs() < 1e-6, "{}", ajar.joints[0].rest);
    let limits = ajar.joints[0].limits_as_written().unwrap();
    assert!(limits.0.abs() < 1e-6 && (limits.1 - 1.5).abs() < 1e-6, "{limits:?}");
    assert_eq!(verdicts[3].check("J4").map(|c| c.status), Some(Status::Pass));
}
