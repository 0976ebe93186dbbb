//! OBJ file ↔ mesh.
