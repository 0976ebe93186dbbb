//! The page: its frame, its rules for the browser, its data and its script, in one file.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use miniz_oxide::deflate::compress_to_vec;
use sha2::{Digest as _, Sha256};

use crate::scene::Scene;
use crate::web::{FRAME, SCRIPT, STUDIO_FRAME, STUDIO_SCRIPT, STUDIO_STYLE, STYLE};
use crate::wire::wire;

/// How hard deflate tries, of 0 to 10.
const EFFORT: u8 = 9;

/// The page as HTML, UTF-8; the same scene gives the same bytes. It holds all it needs, and its
/// policy forbids it the network and every script but its own.
pub fn write(scene: &Scene) -> String {
    let (wire, bytes) = wire(scene);
    let data = inert(&serde_json::to_string(&wire).unwrap_or_default());
    let geometry = STANDARD.encode(compress_to_vec(&bytes, EFFORT));
    let title = guard::text::markup(&guard::text::shown(&scene.title)).into_owned();
    let parts = [
        ("{policy}", policy(&SCRIPT, STYLE, "img-src data:")),
        ("{title}", title),
        ("{style}", STYLE.to_owned()),
        ("{scene}", data),
        ("{geometry}", geometry),
        ("{script}", SCRIPT.clone()),
    ];
    filled(FRAME, &parts)
}

/// The page of `kinfold studio` as HTML, UTF-8: the same page with hands. It asks the server that it
/// comes from, and nobody else.
pub fn studio(title: &str) -> String {
    let more = "connect-src 'self'; img-src 'self' data: blob:";
    let palette: Vec<[u8; 3]> =
        (0..view::palette::COLOURS).map(view::palette::part_colour).collect();
    let parts = [
        ("{policy}", policy(&STUDIO_SCRIPT, STUDIO_STYLE, more)),
        ("{title}", guard::text::markup(&guard::text::shown(title)).into_owned()),
        ("{style}", STUDIO_STYLE.to_owned()),
        ("{palette}", serde_json::to_string(&palette).unwrap_or_default()),
        ("{script}", STUDIO_SCRIPT.clone()),
    ];
    filled(STUDIO_FRAME, &parts)
}

/// The scene as JSON and the packed surfaces of a page that [`write()`] wrote; nothing of any other text.
pub fn held(html: &str) -> Option<(&str, &str)> {
    let between = |id: &str| {
        let (_, rest) = html.split_once(id)?;
        let (_, rest) = rest.split_once('>')?;
        rest.split_once("</script>").map(|(text, _)| text)
    };
    Some((between(" id=\"scene\"")?, between(" id=\"geometry\"")?))
}

/// Fills the places of a frame in their order; what is filled in is not looked at again.
fn filled(frame: &str, parts: &[(&str, String)]) -> String {
    let mut page = String::new();
    let mut rest = frame;
    for (place, text) in parts {
        let Some((before, after)) = rest.split_once(place) else { continue };
        page.push_str(before);
        page.push_str(text);
        rest = after;
    }
    page + rest
}

/// Nothing from anywhere but `more`, no script but ours, no style but ours.
fn policy(script: &str, style: &str, more: &str) -> String {
    let hash = |text: &str| format!("'sha256-{}'", STANDARD.encode(Sha256::digest(text)));
    format!(
        "default-src 'none'; script-src {}; style-src {}; {more}; base-uri 'none'; form-action 'none'",
        hash(script),
        hash(style)
    )
}

/// JSON that no HTML parser and no script engine takes for anything else.
fn inert(json: &str) -> String {
    let mut safe = String::with_capacity(json.len());
    for c in json.chars() {
        match c {
            '<' | '>' | '&' | '\u{2028}' | '\u{2029}' => {
                safe.push_str(&format!("\\u{:04x}", u32::from(c)));
            }
            c => safe.push(c),
        }
    }
    safe
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pack::tests::ball;
    use crate::scene::Link;
    use object::Mesh;

    /// Faces in the order in which a file may have them: none.
    fn shuffled(mesh: &Mesh) -> Mesh {
        let mut faces = mesh.faces().to_vec();
        let mut state = 1u64;
        for i in (1..faces.len()).rev() {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            faces.swap(i, (state >> 33) as usize % (i + 1));
        }
        let colours = (0..mesh.vertices().len())
            .map(|i| (i as u32).wrapping_mul(2_654_435_769).to_le_bytes());
        let mesh = Mesh::new(mesh.vertices().to_vec(), faces).unwrap();
        let count = mesh.vertices().len();
        mesh.with_colours(Some(colours.take(count).collect())).unwrap()
    }

    fn asset() -> Scene {
        let visual = ball(101, 0.3);
        assert!(visual.faces().len() > 40_000);
        let link = |i: usize| Link {
            name: format!("link{i}"),
            visual: (i == 0).then(|| shuffled(&visual)),
            collisions: vec![ball(8, 0.1); 32],
            ..Link::default()
        };
        Scene { title: "ball".into(), links: (0..8).map(link).collect(), ..Scene::default() }
    }

    #[test]
    fn forty_thousand_faces_are_a_page_of_at_most_three_megabytes() {
        let scene = asset();
        let page = write(&scene);
        assert!(page.len() < 3_000_000, "{} bytes", page.len());
        assert_eq!(page, write(&scene), "the same bytes again");
    }

    #[test]
    fn what_a_page_holds_is_found_in_it() {
        let page = write(&Scene { title: "</script> id=\"geometry\">".into(), ..asset() });
        let (scene, geometry) = held(&page).unwrap();
        let scene: serde_json::Value = serde_json::from_str(scene).unwrap();
        assert_eq!(
            (&scene["schema"], scene["links"].as_array().unwrap().len()),
            (&"kinfold-page/1".into(), 8)
        );
        assert!(STANDARD.decode(geometry).is_ok_and(|bytes| bytes.len() > 1000));
        assert_eq!(held("<!doctype html>"), None);
    }

    #[test]
    fn words_of_strangers_stay_words() {
        let name = "</script><script>alert(1)</script>\u{2028}{script}<!--\u{202e}";
        let links = vec![Link { name: name.into(), ..Link::default() }];
        let page = write(&Scene { title: name.into(), links, ..Scene::default() });
        assert_eq!(page.matches("</script>").count(), 3);
        assert_eq!(page.matches("alert(1)").count(), 3);
        assert!(
            !page.contains("<script>alert")
                && !page.contains('\u{2028}')
                && !page.contains('\u{202e}')
        );
        assert!(page.contains("&lt;/script&gt;&lt;script&gt;alert(1)"));
    }

    #[test]
    fn the_studio_asks_its_own_server_alone() {
        let page = studio("</title><script>alert(1)</script>{script}");
        // The name of a language, which nobody fetches, and an icon that is none.
        let page = page.replace("http://www.w3.org/2000/svg", "").replace("href=\"data:,\"", "");
        assert!(page.contains("connect-src 'self'") && !page.contains("unsafe-"));
        assert_eq!(page.matches("alert(1)").count(), 1);
        for word in ["http://", "https://", "src=", "href=", "@import", "url("] {
            assert!(!page.contains(word), "{word}");
        }
    }

    #[test]
    fn the_page_is_told_to_load_nothing() {
        // The one address is the name of a language, which nobody fetches.
        let page = write(&Scene::default()).replace("http://www.w3.org/2000/svg", "");
        assert!(page.contains("default-src 'none'") && !page.contains("unsafe-"));
        for word in ["http://", "https://", "src=", "href=", "@import", "url("] {
            assert!(!page.contains(word), "{word}");
        }
    }
}
