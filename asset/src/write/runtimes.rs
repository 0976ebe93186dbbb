//! What single engines read of a USD beside UsdPhysics: PhysX's, Newton's and MuJoCo's own schemas.
//!
//! UsdPhysics has no words for a joint's dry friction, its largest velocity and damping that no drive
//! makes. Each engine has its own, and passes over the others'.

use crate::asset::Motion;
use crate::write::usda::float;

/// An engine with schemas of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Runtime {
    /// PhysX, in Isaac Sim and Isaac Lab.
    Physx,
    /// Newton.
    Newton,
    /// MuJoCo; Newton's solver of that name reads these, too.
    Mujoco,
}

/// Schemas that a prim applies, and its properties.
#[derive(Debug, Default)]
pub(crate) struct Words {
    pub(crate) schemas: Vec<String>,
    pub(crate) values: Vec<(String, String)>,
}

impl Words {
    /// Those of several engines.
    pub(crate) fn of(runtimes: &[Runtime], each: impl Fn(Runtime) -> Self) -> Self {
        let mut all = Self::default();
        for words in runtimes.iter().map(|r| each(*r)) {
            all.schemas.extend(words.schemas);
            all.values.extend(words.values);
        }
        all
    }
}

/// How firmly dry friction holds in MuJoCo: with its own setting, soft on purpose, a pedal of 30 g that
/// should stay sinks by 10° in a second.
pub(crate) const FIRM: [f64; 3] = [0.9999, 0.9999, 0.001];
/// How firmly a joint's limits hold in MuJoCo: with its own setting, 12 of 89 joints of 30 development
/// cases go more than a hundredth of their range past a limit under their whole effort; with this, none.
pub(crate) const FIRM_LIMIT: [f64; 3] = [0.99, 0.999, 0.0001];
/// How soon both act, s, and how damped: two steps of MuJoCo's own length are the least it allows.
pub(crate) const SOON: [f64; 2] = [0.004, 1.0];

/// Share of its range by which a joint in Newton goes past its limit under its whole effort: limits are
/// springs there. Its word for a hard limit, `inf`, is softer (Newton 1.8.0, measured).
const GIVES: f64 = 0.002;

impl Runtime {
    /// Each of them.
    pub(crate) const ALL: [Self; 3] = [Self::Physx, Self::Newton, Self::Mujoco];

    /// Its name as SimReady spells it.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Physx => "PhysX",
            Self::Newton => "Newton",
            Self::Mujoco => "MuJoCo",
        }
    }

    /// What it reads of a joint that moves `inertia` (kg m² or kg); `drive` is `angular` or `linear`. PhysX
    /// and Newton count a turn in degrees, MuJoCo in radians.
    pub(crate) fn joint(self, drive: &str, motion: &Motion, inertia: f64) -> Words {
        let degrees = if drive == "angular" { 1.0_f64.to_degrees() } else { 1.0 };
        let friction = float(motion.friction.value);
        let speed = float(motion.velocity.value * degrees);
        let line = |name: String, value: &String| (name, value.clone());
        match self {
            Self::Physx => {
                let of = |name: &str| format!("float physxJointAxis:{drive}:{name}");
                let values = vec![
                    line(of("dynamicFrictionEffort"), &friction),
                    line(of("maxJointVelocity"), &speed),
                    line(of("staticFrictionEffort"), &friction),
                ];
                Words { schemas: vec![format!("PhysxJointAxisAPI:{drive}")], values }
            }
            Self::Newton => {
                let mut values = vec![
                    line("float newton:friction".into(), &friction),
                    line("float newton:velocityLimit".into(), &speed),
                ];
                if let Some([lower, upper]) = &motion.limits {
                    let give = GIVES * (upper.value - lower.value).max(1e-9);
                    let stiffness = motion.effort.value / give;
                    let damping = 2.0 * (stiffness * inertia).sqrt();
                    let of = |value: f64| float(value / degrees);
                    values.push(line("float newton:limitDamping".into(), &of(damping)));
                    values.push(line("float newton:limitStiffness".into(), &of(stiffness)));
                }
                Words { schemas: vec!["NewtonJointAPI".into()], values }
            }
            Self::Mujoco => {
                let firm = |[low, high, width]: [f64; 3]| {
                    format!("[{}, {}, {}, 0.5, 2]", float(low), float(high), float(width))
                };
                let soon = format!("[{}]", SOON.map(float).join(", "));
                let values = vec![
                    line("uniform double mjc:frictionloss".into(), &friction),
                    line("uniform double[] mjc:solimpfriction".into(), &firm(FIRM)),
                    line("uniform double[] mjc:solimplimit".into(), &firm(FIRM_LIMIT)),
                    line("uniform double[] mjc:solreffriction".into(), &soon),
                    line("uniform double[] mjc:solreflimit".into(), &soon),
                ];
                Words { schemas: vec!["MjcJointAPI".into()], values }
            }
        }
    }

    /// What it reads of a convex piece to collide with.
    pub(crate) fn collider(self) -> Words {
        let schemas = match self {
            Self::Physx => vec![],
            Self::Newton => vec!["NewtonCollisionAPI".into(), "NewtonMeshCollisionAPI".into()],
            Self::Mujoco => vec!["MjcCollisionAPI".into()],
        };
        Words { schemas, values: vec![] }
    }
}
