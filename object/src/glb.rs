//! GLB file ↔ mesh.
