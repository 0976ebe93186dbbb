//! The network behind the seam: one client, and what stands around it.

pub mod address;
pub mod calls;
pub mod discreet;
mod disguise;
pub mod gate;
pub mod hidden;
pub mod http;
#[cfg(test)]
mod loopback;
pub mod pace;
pub mod punctual;
pub mod redact;
pub mod redactor;
pub mod redirect;
pub mod remember;
pub mod retry;
pub mod tape;
