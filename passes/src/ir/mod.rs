//! What naga's IR lacks for whoever rewrites it: one operand visitor, statement numbers, a code builder that keeps the
//! rules of emission, an importer of functions from another module, names that stay with resources, and the checks that naga's
//! validator leaves out.

pub mod build;
pub mod import;
pub mod names;
pub mod statements;
pub mod verify;
pub mod visit;
