//! Mesh to pictures, pixel to surface point: what a VLM and a person look at.
//!
//! A [`Camera`] sees a mesh; [`render`] draws it, in its own colours or one colour per part; a
//! caption, numbered marks and joint axes can be drawn on top; an [`Unprojector`] takes a pixel
//! back to the surface. Pictures are the same bytes for the same input on any number of threads.
//!
//! Pixels: x to the right, y down, (0, 0) the top left corner of the picture, so the centre of the
//! first pixel is (0.5, 0.5).

mod ambient;
mod backdrop;
mod shade;
mod visibility;

pub mod camera;
pub mod draw;
pub mod film;
pub mod font;
pub mod lines;
pub mod palette;
pub mod png;
pub mod raster;
pub mod sheet;
pub mod unproject;

pub use camera::{Camera, View, eight_views};
pub use draw::{caption, draw_axis, mark};
pub use film::Film;
pub use palette::part_colour;
pub use png::encode_png;
pub use raster::{Paint, Picture, Renderer, render, render_views};
pub use sheet::contact_sheet;
pub use unproject::Unprojector;
pub use visibility::NO_FACE;

/// Why a picture could not be made into a file.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ViewError {
    /// A picture without pixels, or whose buffers do not fit its size.
    #[error("a picture needs one colour per pixel, found {width} × {height} with {colours}")]
    Size {
        /// Pixels across.
        width: u32,
        /// Pixels down.
        height: u32,
        /// Colours it has.
        colours: usize,
    },
    /// The encoder refused.
    #[error("the encoder of pictures gave up: {0}")]
    Encode(String),
    /// A sheet or an animation of nothing.
    #[error("a contact sheet needs at least one picture and one column, an animation one picture")]
    EmptySheet,
}
