//! A USD stage of several files, prim by prim.
//!
//! Layers in other files come from the caller, who alone knows which may be read: the library is told bytes
//! and names, says which it lacks, and is asked again until nothing is missing. It works behind the same fence
//! as everything of USD ([`super::apart`]).

use std::collections::BTreeSet;

use super::error::UsdError;
use super::prims::{Bundle, Stage, Told};
use super::{apart, archive};

/// Most rounds in which layers that others name are fetched; how deep files may name each other.
const ROUNDS: usize = 16;
/// Most files of one stage, and most bytes of all of them. Guesses with room.
const MOST_FILES: usize = 256;
const MOST_BYTES: usize = 512 << 20;

/// Reads a USD file of any form prim by prim. `fetch` gives the bytes of a layer that another names, told from
/// the file's own folder, or says why there are none.
///
/// # Errors
/// [`UsdError`], the first broken rule. A layer that cannot be had is no error: it stands in [`Stage::missing`].
pub fn read_prims(
    bytes: Vec<u8>,
    fetch: &mut dyn FnMut(&str) -> Result<Vec<u8>, String>,
) -> Result<Stage, UsdError> {
    let (root, packed) = archive::opened(bytes)?;
    let mut bundle = Bundle { root, files: packed.layers(), absent: BTreeSet::new() };
    let (mut bytes, mut missing) = (bundle.root.len(), Vec::new());
    for _ in 0..ROUNDS {
        let lacks = match apart::told(&bundle)? {
            Told::Stage(mut stage) => {
                stage.missing.splice(0..0, missing);
                return Ok(stage);
            }
            Told::Lacks(names) => names,
        };
        for name in lacks {
            let is_too_much = bundle.files.len() >= MOST_FILES || bytes > MOST_BYTES;
            let got = match is_too_much {
                true => {
                    Err(format!("a stage has at most {MOST_FILES} files and {MOST_BYTES} bytes"))
                }
                false if name.to_ascii_lowercase().ends_with(".usdz") => {
                    Err("an archive within a stage is not read here".into())
                }
                false => fetch(&name),
            };
            match got {
                Ok(layer) => {
                    bytes += layer.len();
                    bundle.files.insert(name, layer);
                }
                Err(why) => {
                    let shown: String = name.chars().take(200).collect();
                    missing.push(format!("layer `{shown}`: {why}"));
                    bundle.absent.insert(name);
                }
            }
        }
    }
    Err(UsdError::Unreadable(format!("its files name each other more than {ROUNDS} deep")))
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROOT: &[u8] = br#"#usda 1.0
(
    defaultPrim = "W"
    metersPerUnit = 1
    upAxis = "Z"
)
def Xform "W" (
    variants = { string size = "big" }
    prepend variantSets = "size"
)
{
    double3 xformOp:translate = (1, 2, 3)
    uniform token[] xformOpOrder = ["xformOp:translate"]
    variantSet "size" = {
        "big" { double xformOp:scale:x = 1 }
        "small" { over "arm" ( active = false ) {} }
    }
    def "arm" ( prepend references = @./parts/arm.usda@ ) {}
    def "leg" ( prepend payload = @gone.usda@ ) {}
    def PhysicsRevoluteJoint "j" {
        rel physics:body0 = </W/arm>
        float physics:lowerLimit = -inf
        uniform token physics:axis = "Z"
    }
}
"#;

    const ARM: &[u8] = br#"#usda 1.0
( defaultPrim = "arm" )
def Xform "arm" ( prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsDriveAPI:angular"] )
{
    float physics:mass = 2.5
    token visibility = "invisible"
    def Mesh "m" ( prepend references = @../skin.usd@</skin> ) { uniform token purpose = "guide" }
}
"#;

    const SKIN: &[u8] = br#"#usda 1.0
def Mesh "skin"
{
    int[] faceVertexCounts = [4]
    int[] faceVertexIndices = [0, 1, 2, 3]
    point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
}
"#;

    #[test]
    fn what_an_instance_shows_is_there_though_its_source_is_an_over() {
        let text = b"#usda 1.0\nover \"src\" { def Cube \"c\" {} }\ndef Xform \"a\" {\n\
            double3 xformOp:translate = (1, 0, 0)\n uniform token[] xformOpOrder = [\"xformOp:translate\"]\n\
            def \"i\" (instanceable = true prepend references = </src>) {} }\n";
        let stage = read_prims(text.to_vec(), &mut |name| panic!("{name}")).unwrap();
        let cube = stage.prims.iter().find(|p| p.kind == "Cube").unwrap();
        assert_eq!((cube.path.as_str(), cube.place[3]), ("/a/i/c", [1.0, 0.0, 0.0]));
    }

    #[test]
    fn a_stage_of_several_files_is_put_together_of_those_that_may_be_read() {
        let mut asked = Vec::new();
        let stage = read_prims(ROOT.to_vec(), &mut |name| {
            asked.push(name.to_owned());
            match name {
                "parts/arm.usda" => Ok(ARM.to_vec()),
                "skin.usd" => Ok(SKIN.to_vec()),
                _ => Err("does not exist".into()),
            }
        });
        let stage = stage.unwrap();
        asked.sort();
        assert_eq!(asked, ["gone.usda", "parts/arm.usda", "skin.usd"]);
        assert_eq!(stage.missing[0], "layer `gone.usda`: does not exist");
        assert_eq!((stage.metres, stage.up.as_deref()), (1.0, Some("Z")));
        let of = |path: &str| stage.prims.iter().find(|p| p.path == path).unwrap();
        let arm = of("/W/arm");
        assert_eq!(arm.schemas, ["PhysicsRigidBodyAPI", "PhysicsDriveAPI:angular"]);
        assert_eq!(
            (arm.numbers["physics:mass"].as_slice(), arm.place[3]),
            (&[2.5][..], [1.0, 2.0, 3.0])
        );
        let mesh = of("/W/arm/m");
        assert!(mesh.is_hidden && mesh.purpose == "guide");
        assert_eq!(mesh.surface.as_ref().unwrap().faces, [[0, 1, 2, 3]]);
        let joint = of("/W/j");
        assert_eq!(joint.targets["physics:body0"], ["/W/arm"]);
        assert_eq!(joint.numbers["physics:lowerLimit"], [f64::NEG_INFINITY]);
        assert_eq!(joint.words["physics:axis"], "Z");
    }
}
