//! What parts collide with: a few convex pieces each. No piece touches another part, wherever the
//! joints go.
//!
//! Simulators want convex bodies, and a convex body fills every hollow. So a part is cut into
//! pieces that keep its hollows free, pieces give way where other parts move past them, and a range
//! ends where no room can be made. Metres, asset frame, rest pose.

pub(crate) mod agreement;
pub mod clearance;
pub(crate) mod cover;
pub(crate) mod hinges;
pub mod hulls;
pub mod piece;
pub(crate) mod quickhull;
pub(crate) mod settle;
pub(crate) mod sockets;
pub(crate) mod solid;
pub(crate) mod whole;
