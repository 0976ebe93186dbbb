//! Mass, its centre and its inertia, from what a part is made of and the shape it has.
//!
//! A table gives density and wall by the words people use. A closed body counts as solid or as a
//! shell, an open surface as a sheet; neighbouring links stay within the ratio of masses that
//! solvers bear. Kilograms, metres; inertia about the centre of mass.

pub(crate) mod balance;
pub(crate) mod columns;
pub mod materials;
pub mod moments;
pub(crate) mod principal;
pub mod weigh;
