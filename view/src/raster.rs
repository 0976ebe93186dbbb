//! Mesh to picture: what is seen, how it is lit, and the lines that set parts apart.

use glamx::{DQuat, DVec3};
use object::Mesh;
use object::mesh::Bounds;
use object::normals::{CREASE_ANGLE, corner_normals};
use rayon::prelude::*;

use crate::ambient::Openness;
use crate::backdrop::Backdrop;
use crate::camera::{Camera, View};
use crate::lines::{Line, line_strength, softened};
use crate::palette::part_colour;
use crate::shade::{Colours, Facing, Light, Shaded, Shader, ToBytes, linear_of_byte};
use crate::visibility::{BAND, NO_FACE, Screen, Seen};

/// Colour of a surface nobody coloured: light clay, sRGB.
pub const CLAY: [u8; 3] = [206, 200, 191];

/// What colour a surface is drawn in.
#[derive(Clone, Copy, Debug)]
pub enum Paint<'a> {
    /// The mesh's own colours, or clay where it has none.
    Surface,
    /// One palette colour per part; the slice holds the part of each face. A face beyond its end
    /// is drawn in clay.
    Parts(&'a [u16]),
    /// One part in its palette colour, everything else in clay.
    Part {
        /// The part of each face.
        part_of_face: &'a [u16],
        /// The part that stands out.
        part: u16,
    },
}

/// A picture with what each pixel sees; all buffers go row by row from the top left.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Pixels across and down.
    pub size: [u32; 2],
    /// Distance along the view axis of what the pixel's centre sees, metres; infinite for
    /// background.
    pub depth: Vec<f32>,
    /// The face the pixel's centre sees, or [`NO_FACE`].
    pub face: Vec<u32>,
    /// sRGB colour and opacity.
    pub colour: Vec<[u8; 4]>,
}

impl Picture {
    /// A picture of nothing, all in one colour.
    pub fn blank(size: [u32; 2], colour: [u8; 4]) -> Self {
        let pixels = size[0] as usize * size[1] as usize;
        let (depth, face) = (vec![f32::INFINITY; pixels], vec![NO_FACE; pixels]);
        Self { size, depth, face, colour: vec![colour; pixels] }
    }

    /// Where a pixel's data lies in the buffers; none outside the picture.
    pub fn index(&self, [x, y]: [u32; 2]) -> Option<usize> {
        let inside = x < self.size[0] && y < self.size[1];
        inside.then(|| y as usize * self.size[0] as usize + x as usize)
    }
}

/// Draws a mesh once. For several views of one mesh take a [`Renderer`] or [`render_views`].
pub fn render(mesh: &Mesh, paint: &Paint<'_>, camera: &Camera) -> Picture {
    Renderer::new(mesh, paint).render(camera)
}

/// Draws a mesh from several standpoints, in their order.
pub fn render_views(mesh: &Mesh, paint: &Paint<'_>, views: &[View]) -> Vec<Picture> {
    let (renderer, mut desk) = (Renderer::new(mesh, paint), Desk::default());
    views.iter().map(|view| renderer.render_on(&mut desk, &view.camera)).collect()
}

/// A mesh with its normals and colours made ready for any number of pictures.
#[derive(Clone, Debug)]
pub struct Renderer<'a> {
    mesh: &'a Mesh,
    bounds: Bounds,
    normals: Vec<[DVec3; 3]>,
    colours: Colours,
    parts: Option<&'a [u16]>,
    backdrop: Backdrop,
}

/// Linear colours of a mesh as it is painted.
fn colours_of(mesh: &Mesh, paint: &Paint<'_>) -> Colours {
    let clay = linear(CLAY);
    let of_parts = |part_of_face: &[u16], shown: &dyn Fn(u16) -> bool| {
        let colour = |f: usize| match part_of_face.get(f) {
            Some(&part) if shown(part) => linear(part_colour(part.into())),
            _ => clay,
        };
        Colours::PerFace((0..mesh.faces().len()).map(colour).collect())
    };
    match (paint, mesh.colours()) {
        (Paint::Parts(part_of_face), _) => of_parts(part_of_face, &|_| true),
        (Paint::Part { part_of_face, part }, _) => of_parts(part_of_face, &|p| p == *part),
        (Paint::Surface, None) => Colours::One(clay),
        (Paint::Surface, Some(colours)) => {
            Colours::PerVertex(colours.iter().map(|&[r, g, b, _]| linear([r, g, b])).collect())
        }
    }
}

fn linear(srgb: [u8; 3]) -> DVec3 {
    DVec3::from_array(srgb.map(linear_of_byte))
}

impl<'a> Renderer<'a> {
    /// Makes normals and colours ready.
    pub fn new(mesh: &'a Mesh, paint: &Paint<'a>) -> Self {
        let parts = match *paint {
            Paint::Surface => None,
            Paint::Parts(part_of_face) | Paint::Part { part_of_face, .. } => Some(part_of_face),
        };
        Self {
            mesh,
            bounds: mesh.bounds(),
            normals: corner_normals(mesh, CREASE_ANGLE),
            colours: colours_of(mesh, paint),
            parts,
            backdrop: Backdrop::new(mesh),
        }
    }

    /// The same for a surface that moved: `mesh` has the same faces elsewhere, and `turn` says how each
    /// of them was turned. Cheaper than a new one by far, for its normals are known.
    pub fn moved<'b>(&self, mesh: &'b Mesh, turn: impl Fn(usize) -> DQuat) -> Renderer<'b>
    where
        'a: 'b,
    {
        let turned = |(face, corners): (usize, &[DVec3; 3])| {
            let turn = turn(face);
            corners.map(|normal| turn * normal)
        };
        Renderer {
            mesh,
            bounds: mesh.bounds(),
            normals: self.normals.iter().enumerate().map(turned).collect(),
            colours: self.colours.clone(),
            parts: self.parts,
            backdrop: Backdrop::new(mesh),
        }
    }

    /// Draws one picture.
    pub fn render(&self, camera: &Camera) -> Picture {
        self.render_on(&mut Desk::default(), camera)
    }

    fn render_on(&self, desk: &mut Desk, camera: &Camera) -> Picture {
        self.look(camera, desk);
        let part = |face: u32| self.parts.and_then(|p| p.get(face as usize).copied());
        let line = Line {
            size: camera.size,
            seen: &desk.seen,
            shaded: &desk.shaded,
            step: 0.02 * self.bounds.diagonal(),
            part: &part,
        };
        line_strength(&line, &mut desk.lines);
        self.compose(camera, desk)
    }

    /// Finds and lights what each pixel sees, a band at a time: a band's samples stay in the cache.
    fn look(&self, camera: &Camera, desk: &mut Desk) {
        let [width, height] = camera.size.map(|n| n as usize);
        let facing = Facing::all(self.mesh, camera.eye);
        let shader = Shader {
            mesh: self.mesh,
            facing: &facing,
            normals: &self.normals,
            colours: &self.colours,
            camera: *camera,
            axes: camera.axes(),
            light: Light::for_camera(camera),
        };
        let screen = Screen::new(self.mesh, camera);
        desk.seen.resize(width * height, Seen::default());
        desk.shaded.resize(width * height, Shaded::default());
        let band = (width * BAND).max(1);
        let bands = desk.seen.par_chunks_mut(band).zip(desk.shaded.par_chunks_mut(band));
        bands.enumerate().for_each_init(Vec::new, |samples, (b, (seen, shaded))| {
            screen.look(b, seen.len(), samples);
            for (i, s) in samples.iter().enumerate() {
                seen[i] = Seen::of(s);
                shaded[i] = shader.pixel([i % width, b * BAND + i / width], s);
            }
        });
    }

    fn compose(&self, camera: &Camera, desk: &Desk) -> Picture {
        let width = (camera.size[0] as usize).max(1);
        let open = Openness::new(camera, &desk.seen, &desk.shaded, self.bounds.diagonal());
        let (paper, to_bytes) = (self.backdrop.seen_by(camera), ToBytes::new());
        let mut picture = Picture::blank(camera.size, [0; 4]);
        let Picture { depth, face, colour, .. } = &mut picture;
        let rows = depth.par_chunks_mut(width).zip(face.par_chunks_mut(width));
        colour.par_chunks_mut(width).zip(rows).enumerate().for_each(|(y, (colour, row))| {
            let paper = paper.row(y);
            for (x, colour) in colour.iter_mut().enumerate() {
                let (i, Shaded { light, cover, .. }) = (y * width + x, desk.shaded[y * width + x]);
                let seen = &desk.seen[i];
                (row.0[x], row.1[x]) = (1.0 / seen.nearness, seen.face);
                if cover == 0.0 {
                    *colour = to_bytes.grey(paper.light(x));
                    continue;
                }
                let line = softened(&desk.lines, width, i);
                let strength = open.at([x, y], seen) * (1.0 - line);
                let behind = if cover < 1.0 { paper.light(x) * (1.0 - cover) } else { 0.0 };
                *colour = to_bytes.of(light.map(|c| c * strength + behind));
            }
        });
        picture
    }
}

/// What a picture is made on: laid out once for all views of a size.
#[derive(Default)]
struct Desk {
    seen: Vec<Seen>,
    shaded: Vec<Shaded>,
    lines: Vec<f32>,
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::camera::eight_views;

    /// A closed cube from 0 to 1, the face at y = 0 first.
    pub(crate) fn unit_cube() -> Mesh {
        let corner = |i: u32| DVec3::new((i & 1).into(), (i >> 1 & 1).into(), (i >> 2).into());
        let quads =
            [[0, 1, 5, 4], [0, 2, 3, 1], [4, 5, 7, 6], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let faces = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        Mesh::new((0..8).map(corner).collect(), faces).unwrap()
    }

    fn straight(size: [u32; 2]) -> Camera {
        let target = DVec3::new(0.5, 0.0, 0.5);
        let eye = target - DVec3::Y * 4.0;
        Camera { eye, target, up: DVec3::Z, fov_y: 0.5, size }
    }

    #[test]
    fn the_depth_of_a_plane_square_on_is_the_same_everywhere() {
        let picture = render(&unit_cube(), &Paint::Surface, &straight([121, 87]));
        let seen: Vec<f32> = picture.depth.iter().copied().filter(|d| d.is_finite()).collect();
        assert!(seen.iter().all(|d| (d - 4.0).abs() < 4e-6));
        assert!(
            picture
                .face
                .iter()
                .zip(&picture.depth)
                .all(|(f, d)| (*f == NO_FACE) == d.is_infinite())
        );
        assert!(picture.face.iter().all(|&f| f < 2 || f == NO_FACE), "only the front is seen");
    }

    #[test]
    fn a_square_covers_the_pixels_its_projection_says() {
        let camera = straight([240, 240]);
        let picture = render(&unit_cube(), &Paint::Surface, &camera);
        let side = camera.axes().focal / 4.0;
        let seen = picture.face.iter().filter(|&&f| f != NO_FACE).count() as f64;
        assert!((seen.sqrt() - side).abs() < 1.0, "{} against {side}", seen.sqrt());
    }

    #[test]
    fn a_sloping_plane_has_the_depth_of_its_rays() {
        let v = [(-1.0, 0.0, 0.0), (2.0, 0.0, 0.0), (2.0, 3.0, 1.0), (-1.0, 3.0, 1.0)];
        let v = v.map(|(x, y, z)| DVec3::new(x, y, z)).to_vec();
        let mesh = Mesh::new(v, vec![[0, 1, 2], [0, 2, 3]]).unwrap();
        let eye = DVec3::new(0.4, -2.0, 2.0);
        let target = DVec3::new(0.5, 1.0, 0.3);
        let camera = Camera { eye, target, up: DVec3::Z, fov_y: 0.4, size: [64, 48] };
        let picture = render(&mesh, &Paint::Surface, &camera);
        let normal = DVec3::new(0.0, -1.0, 3.0);
        for (i, depth) in picture.depth.iter().enumerate() {
            let (_, ray) = camera.ray([(i % 64) as f64 + 0.5, (i / 64) as f64 + 0.5]);
            let expected = -eye.dot(normal) / ray.dot(normal) * ray.dot(camera.axes().forward);
            assert!((f64::from(*depth) / expected - 1.0).abs() < 1e-5, "{depth} {expected}");
        }
    }

    #[test]
    fn shared_edges_leave_no_gap_and_the_same_picture_comes_on_any_number_of_threads() {
        let mesh = unit_cube();
        let pool = |n| rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
        for view in eight_views(&mesh.bounds(), 96) {
            let draw = || {
                render(&mesh, &Paint::Parts(&[0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5]), &view.camera)
            };
            let picture = draw();
            for row in picture.face.chunks(96) {
                let seen: Vec<bool> = row.iter().map(|&f| f != NO_FACE).collect();
                let edges = seen.windows(2).filter(|w| w[0] != w[1]).count();
                assert!(edges == 0 || edges == 2, "{}: a hole in a convex body", view.name);
            }
            assert_eq!(pool(1).install(draw), pool(2).install(draw));
            assert_eq!(pool(3).install(draw), picture);
        }
    }

    #[test]
    fn a_surface_that_moved_is_drawn_as_one_that_stands_there() {
        let cube = unit_cube();
        let (turn, paint) = (DQuat::from_rotation_z(0.5), Paint::Parts(&[1; 12]));
        let there = cube.map_vertices(|v| turn * v + DVec3::X).unwrap();
        let moved = Renderer::new(&cube, &paint).moved(&there, |_| turn);
        let camera = straight([80, 60]);
        let (moved, anew) = (moved.render(&camera), Renderer::new(&there, &paint).render(&camera));
        assert_eq!((&moved.face, &moved.depth), (&anew.face, &anew.depth));
        let alike = |(a, b): (&[u8; 4], &[u8; 4])| (0..4).all(|c| a[c].abs_diff(b[c]) <= 1);
        assert!(moved.colour.iter().zip(&anew.colour).all(alike));
    }

    #[test]
    fn parts_are_drawn_in_their_colours_and_a_single_part_stands_out() {
        let mesh = unit_cube();
        let parts: Vec<u16> = (0..12).map(|f| f / 2).collect();
        let camera = straight([60, 60]);
        let middle = |paint: &Paint<'_>| {
            let picture = render(&mesh, paint, &camera);
            picture.colour[picture.index([25, 30]).unwrap()]
        };
        let hue = |c: [u8; 4]| i32::from(c[2]) - i32::from(c[0]);
        assert!(hue(middle(&Paint::Parts(&[1; 12]))) > 60, "part 1 is blue");
        assert!(hue(middle(&Paint::Part { part_of_face: &[1; 12], part: 1 })) > 60);
        assert!(hue(middle(&Paint::Part { part_of_face: &parts, part: 1 })) < 20, "clay");
        assert!(hue(middle(&Paint::Parts(&[]))) < 20, "no label: clay");
    }

    #[test]
    fn a_camera_inside_the_surface_or_without_pixels_is_harmless() {
        let mesh = unit_cube();
        let inside = Camera { eye: DVec3::splat(0.5), ..straight([40, 30]) };
        let picture = render(&mesh, &Paint::Surface, &inside);
        assert!(picture.face.iter().all(|&f| f != NO_FACE), "walls all around");
        for size in [[0, 0], [1, 1], [1, 9], [0, 4]] {
            let picture = render(&mesh, &Paint::Surface, &straight(size));
            assert_eq!(picture.colour.len() as u32, size[0] * size[1]);
        }
    }
}
