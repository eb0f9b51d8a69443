//! What naga's IR lacks for whoever rewrites it: one operand visitor, statement numbers, a code builder that keeps the
//! rules of emission, an importer of functions from another module, and the checks that naga's validator leaves out.

pub mod build;
pub mod import;
pub mod statements;
pub mod verify;
pub mod visit;
