//! Small assemblies whose clearances are known.
