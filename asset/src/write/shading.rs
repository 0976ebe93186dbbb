//! Materials and textures in USD: `UsdPreviewSurface`, and which faces have which.

use std::collections::BTreeMap;

use glamx::DVec3;
use object::Mesh;
use object::appearance::{AlphaMode, Texture, Wrap};

use crate::write::appearance::look::{AssetAppearance, Group};
use crate::write::usda::{Usda, float, list, quoted, schemas, tokens, triple};

/// Texture coordinates of a surface, and its faces by material; nothing without groups. `materials` is
/// the path of the scope that holds them.
pub(crate) fn write_subsets(usda: &mut Usda, materials: &str, mesh: &Mesh, groups: &[Group]) {
    if groups.is_empty() {
        return;
    }
    let mut places = vec![[[0f32; 2]; 3]; mesh.faces().len()];
    for (face, corners) in groups.iter().flat_map(|g| g.faces.iter().zip(&g.corners)) {
        if let Some(place) = places.get_mut(*face as usize) {
            *place = *corners;
        }
    }
    if groups.iter().any(|g| !g.corners.is_empty()) {
        let mut known: BTreeMap<[u32; 2], usize> = BTreeMap::new();
        let (mut table, mut which) = (Vec::new(), Vec::new());
        for uv in places.iter().flatten() {
            let index = *known.entry(uv.map(f32::to_bits)).or_insert_with(|| {
                // USD's v points upward.
                let [u, v] = [f64::from(uv[0]), 1.0 - f64::from(uv[1])]
                    .map(|c| float((c * 1e6).round() / 1e6));
                table.push(format!("({u}, {v})"));
                table.len() - 1
            });
            which.push(index.to_string());
        }
        usda.set_each("texCoord2f[] primvars:st", &list(table), "faceVarying");
        usda.set("int[] primvars:st:indices", &list(which));
    }
    usda.set("uniform token subsetFamily:materialBind:familyType", "\"partition\"");
    for group in groups {
        usda.prim("GeomSubset", &group.name, &[schemas(&["MaterialBindingAPI"])], |usda| {
            usda.set("uniform token elementType", "\"face\"");
            usda.set("uniform token familyName", "\"materialBind\"");
            usda.set("int[] indices", &list(group.faces.iter().map(u32::to_string)));
            usda.set("rel material:binding", &format!("<{materials}/{}>", group.name));
        });
    }
}

/// One material of a group at `path`, of what its link is made of in words.
pub(crate) fn write_shading(
    usda: &mut Usda,
    (path, made_of): (&str, &str),
    group: &Group,
    appearance: &AssetAppearance,
) {
    let of = &group.material;
    let file = |texture: Option<Texture>| {
        texture.and_then(|t| Some((t, appearance.textures.get(t.picture)?.path.as_str())))
    };
    let [base, rough, normal, emissive] = of.textures().map(file);
    let from = |map: &str, output: &str| format!("<{path}/{map}.outputs:{output}>");
    let applied = [schemas(&["SemanticsLabelsAPI:material"])];
    usda.prim("Material", &group.name, &applied, |usda| {
        usda.set("token[] semantics:labels:material", &tokens(&[made_of]));
        usda.set("token outputs:surface.connect", &from("surface", "surface"));
        usda.prim("Shader", "surface", &[], |usda| {
            usda.set("uniform token info:id", "\"UsdPreviewSurface\"");
            let mut input = |kind: &str, name: &str, (map, output): (&str, &str), plain: &str| {
                if map.is_empty() {
                    usda.set(&format!("{kind} inputs:{name}"), plain);
                } else {
                    usda.set(&format!("{kind} inputs:{name}.connect"), &from(map, output));
                }
            };
            let named = |is_there: bool, map| if is_there { map } else { "" };
            let [r, g, b, alpha] = of.base_colour;
            let colour = named(base.is_some(), "base");
            input("color3f", "diffuseColor", (colour, "rgb"), &triple(DVec3::new(r, g, b)));
            let light = named(emissive.is_some(), "emissive");
            input(
                "color3f",
                "emissiveColor",
                (light, "rgb"),
                &triple(DVec3::from_array(of.emissive)),
            );
            let rough = named(rough.is_some(), "rough");
            input("float", "metallic", (rough, "b"), &float(of.metallic));
            input("float", "roughness", (rough, "g"), &float(of.roughness));
            match of.alpha {
                AlphaMode::Opaque => input("float", "opacity", ("", ""), "1"),
                AlphaMode::Blend => input("float", "opacity", (colour, "a"), &float(alpha)),
                AlphaMode::Mask(cutoff) => {
                    input("float", "opacity", (colour, "a"), &float(alpha));
                    input("float", "opacityThreshold", ("", ""), &float(cutoff));
                }
            }
            if normal.is_some() {
                input("normal3f", "normal", ("normal", "rgb"), "");
            }
            usda.line("token outputs:surface");
        });
        let [r, g, b, alpha] = of.base_colour;
        let [er, eg, eb] = of.emissive;
        let bend = 2.0 * of.normal_scale;
        let maps = [
            ("base", base, "sRGB", [r, g, b, alpha], [0.0; 4]),
            ("rough", rough, "raw", [1.0, of.roughness, of.metallic, 1.0], [0.0; 4]),
            (
                "normal",
                normal,
                "raw",
                [bend, bend, 2.0, 1.0],
                [-bend / 2.0, -bend / 2.0, -1.0, 0.0],
            ),
            ("emissive", emissive, "sRGB", [er, eg, eb, 1.0], [0.0; 4]),
        ];
        let mut is_textured = false;
        for (map, texture, space, scale, bias) in maps {
            let Some((texture, file)) = texture else { continue };
            is_textured = true;
            let place = from("place", "result");
            write_texture(usda, map, (texture, file), (space, scale, bias), &place);
        }
        if is_textured {
            usda.prim("Shader", "place", &[], |usda| {
                usda.set("uniform token info:id", "\"UsdPrimvarReader_float2\"");
                usda.set("string inputs:varname", "\"st\"");
                usda.line("float2 outputs:result");
            });
        }
    });
}

fn write_texture(
    usda: &mut Usda,
    map: &str,
    (texture, file): (Texture, &str),
    (space, scale, bias): (&str, [f64; 4], [f64; 4]),
    place: &str,
) {
    let four = |v: [f64; 4]| format!("({})", v.map(float).join(", "));
    let wrap = |wrap: Wrap| match wrap {
        Wrap::Repeat => "repeat",
        Wrap::Mirror => "mirror",
        Wrap::Clamp => "clamp",
    };
    usda.prim("Shader", map, &[], |usda| {
        usda.set("uniform token info:id", "\"UsdUVTexture\"");
        usda.set("asset inputs:file", &format!("@{file}@"));
        usda.set("float4 inputs:scale", &four(scale));
        if bias != [0.0; 4] {
            usda.set("float4 inputs:bias", &four(bias));
        }
        usda.set("token inputs:sourceColorSpace", &quoted(space));
        usda.set("float2 inputs:st.connect", place);
        usda.set("token inputs:wrapS", &quoted(wrap(texture.wrap[0])));
        usda.set("token inputs:wrapT", &quoted(wrap(texture.wrap[1])));
        for output in
            ["float outputs:a", "float outputs:b", "float outputs:g", "float3 outputs:rgb"]
        {
            usda.line(output);
        }
    });
}
