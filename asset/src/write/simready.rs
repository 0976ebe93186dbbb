//! The asset as NVIDIA's SimReady Foundation wants a prop packaged: profile Robotics-Prop 4.0.0.
//!
//! `NAME/usd/NAME.usda` holds UsdPhysics alone, with labels and provenance; its pictures lie beside it.
//! Each engine's own words are a layer of `runnables/physics` there, which a variant of the root turns on:
//! one beside `usd`, as the profile's examples have it, is outside the asset to its own rule AA.001.
//! A thumbnail is in `.thumbs/256x256`.
//!
//! Provenance asks for what no asset knows. Where the file cannot say, it says where it stands: day and
//! source in the run's trace. The same asset gives the same bytes, so no day is written.

use std::collections::BTreeMap;

use crate::asset::Asset;
use crate::write::appearance::look::AssetAppearance;
use crate::write::moved::inertia;
use crate::write::runtimes::{Runtime, Words};
use crate::write::urdf::Package;
use crate::write::usd::{Frame, kind_and_drive};
use crate::write::usda::{Usda, float, quoted, schemas, triple};

/// Wikidata's item "physical object": true of every asset; what kind of object it is, its words say. The
/// number is a guess: it was not looked up.
const PHYSICAL_OBJECT: &str = "Q223557";
/// What the first version of the core feature looks for beside the dictionary of all.
const AGAIN: [&str; 4] = ["asset_name", "asset_type", "source_file", "usd_date_generated"];
/// Where the day, the photo and the licence of what was used are recorded.
const IN_TRACE: &str = "see trace.mcap";

impl Asset {
    /// The asset as a SimReady package, each path below a folder of the asset's name; `thumbnail` is a
    /// PNG picture of it, 256 × 256. The same asset gives the same bytes.
    pub fn to_simready_with(&self, appearance: &AssetAppearance, thumbnail: Vec<u8>) -> Package {
        let name = &self.name;
        let frame = Frame {
            runtimes: &[],
            metadata: metadata(self),
            root: vec![chosen(), format!("prepend variantSets = [{}]", named())],
            variants: variants(),
        };
        let mut files = BTreeMap::new();
        let base = self.layer(appearance, &frame).into_bytes();
        files.insert(format!("{name}/usd/{name}.usda"), base);
        files.insert(format!("{name}/usd/.thumbs/256x256/{name}.usda.png"), thumbnail);
        for texture in &appearance.textures {
            files.insert(format!("{name}/usd/{}", texture.path), texture.picture.bytes().to_vec());
        }
        for runtime in Runtime::ALL {
            let path = format!("{name}/usd/runnables/physics/{}.usda", file(runtime));
            files.insert(path, own(self, runtime).into_bytes());
        }
        Package { files }
    }
}

fn file(runtime: Runtime) -> String {
    runtime.name().to_lowercase()
}

fn named() -> String {
    Runtime::ALL.map(|r| quoted(r.name())).join(", ")
}

/// No engine's words, unless one is chosen.
fn chosen() -> String {
    let each = Runtime::ALL.map(|r| format!("string {} = \"Disabled\"", r.name()));
    format!("variants = {{ {} }}", each.join("; "))
}

fn variants() -> Vec<String> {
    let set = |runtime: Runtime| {
        let layer = format!("./runnables/physics/{}.usda", file(runtime));
        [
            format!("variantSet {} = {{", quoted(runtime.name())),
            "    \"Disabled\" {".into(),
            "    }".into(),
            format!("    \"Enabled\" (prepend payload = @{layer}@) {{"),
            "    }".into(),
            "}".into(),
        ]
    };
    Runtime::ALL.into_iter().flat_map(set).collect()
}

/// What SimReady wants to know of where an asset comes from (SR.004; four of it again where SR.001 looks),
/// and which variants there are.
fn metadata(asset: &Asset) -> Vec<String> {
    let category = if asset.category.is_empty() { &asset.name } else { &asset.category };
    let strings = [
        ("asset_license", "not stated"),
        ("asset_name", &asset.name),
        ("asset_type", "prop"),
        ("author", concat!("kinfold ", env!("CARGO_PKG_VERSION"))),
        ("category", category),
        ("qcode", PHYSICAL_OBJECT),
        ("source_file", IN_TRACE),
        ("usd_date_generated", IN_TRACE),
    ];
    let mut lines = vec!["customLayerData = {".to_string()];
    let again = strings.iter().filter(|(key, _)| AGAIN.contains(key));
    lines.extend(again.map(|(k, v)| format!("    string {k} = {}", quoted(v))));
    lines.push("    dictionary SimReady_Metadata = {".into());
    lines.extend(strings.iter().map(|(k, v)| format!("        string {k} = {}", quoted(v))));
    lines.push(format!("        int rigid_body_count = {}", asset.links.len()));
    lines.push(format!("        float3 asset_extents = {}", triple(asset.size.value)));
    lines.push(format!("        float mass = {}", float(asset.mass())));
    lines.push("        dictionary Variants = {".into());
    lines.push("            dictionary Physics = {".into());
    for runtime in Runtime::ALL {
        let name = runtime.name();
        lines.push(format!("                dictionary {name} = {{"));
        lines.push("                    string activateOption = \"Enabled\"".into());
        lines.push(format!(
            "                    string prim = {}",
            quoted(&format!("/{}", asset.name))
        ));
        lines.push(format!("                    string variantSetName = {}", quoted(name)));
        lines.push("                }".into());
    }
    lines.extend(["            }", "        }", "    }", "}"].map(String::from));
    lines
}

/// One engine's words, as opinions over the prims of the base.
fn own(asset: &Asset, runtime: Runtime) -> String {
    let mut usda = Usda::new(&[
        format!("defaultPrim = {}", quoted(&asset.name)),
        "kilogramsPerUnit = 1".into(),
        "metersPerUnit = 1".into(),
        "upAxis = \"Z\"".into(),
    ]);
    let pieces = runtime.collider();
    usda.over(&asset.name, &[], |usda| {
        usda.over("Joints", &[], |usda| {
            for joint in &asset.joints {
                let moves = kind_and_drive(joint).1.zip(joint.motion.as_ref());
                let Some((drive, motion)) = moves else { continue };
                let words = runtime.joint(drive, motion, inertia(asset, joint));
                put(usda, &joint.name, &words);
            }
        });
        if pieces.schemas.is_empty() {
            return;
        }
        usda.over("Links", &[], |usda| {
            for link in &asset.links {
                let Some(body) = &link.body else { continue };
                usda.over(&link.name, &[], |usda| {
                    usda.over("collision", &[], |usda| {
                        for index in 0..body.collision.len() {
                            put(usda, &format!("piece_{index:02}"), &pieces);
                        }
                    });
                });
            }
        });
    });
    usda.finish()
}

fn put(usda: &mut Usda, name: &str, words: &Words) {
    let applied: Vec<&str> = words.schemas.iter().map(String::as_str).collect();
    usda.over(name, &[schemas(&applied)], |usda| {
        words.values.iter().for_each(|(name, value)| usda.set(name, value));
    });
}
