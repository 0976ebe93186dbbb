//! An articulated object as one HTML page: geometry, joints, masses and what a check found, in one
//! file that asks nobody for anything.
//!
//! [`studio()`] is the same page with hands: parts are named, clicked, painted and their axes pulled
//! right, and what was done is handed to the server that the page comes from.
//!
//! [`Scene`] says what there is to show, in the terms of nobody's format; [`write()`] makes the page.
//! Geometry is rounded to 16 bits of each mesh's box, deflated, and drawn by our own WebGL 2 in
//! `web/`. Words of strangers stand in the page as data and are only ever shown as text.
//!
//! ```
//! use glamx::{DPose3, DVec3};
//! use page::{Joint, Kind, Link, Scene};
//! let slide = Joint {
//!     name: "slide".into(),
//!     kind: Kind::Prismatic,
//!     parent: 0,
//!     child: 1,
//!     origin: DPose3::identity(),
//!     axis: DVec3::X,
//!     range: Some([0.0, 0.4]),
//!     mimic: None,
//!     facts: vec![],
//! };
//! let links = ["rail", "</script>"].map(|name| Link { name: name.into(), ..Link::default() });
//! let scene = Scene { title: "rail".into(), links: links.into(), joints: vec![slide], ..Scene::default() };
//! let html = page::write(&scene);
//! assert!(html.starts_with("<!doctype html>") && html.contains("\\u003c/script\\u003e"));
//! ```

mod html;
mod lean;
mod pack;
mod scene;
mod web;
mod wire;

pub use html::{held, studio, write};
pub use lean::MOST_FACES;
pub use scene::{
    Check, Evidence, Inertial, Joint, Kind, Line, Link, Mimic, Place, Scene, Status, Tier,
};
pub use web::{SCRIPT, STYLE};
