//! The width of a picture whose pixels a one-dimensional dispatch numbers row by row.

use naga::{
    AddressSpace, GlobalVariable, Handle, Literal, Module, Override, Scalar, ScalarKind, TypeInner,
};

use super::Walk;
use crate::{
    analysis::term::{Step, Term, TermId},
    options::Linear,
};

/// Where a width comes from.
#[derive(Clone, Debug, PartialEq)]
pub enum Width {
    /// A number.
    Pixels(u32),
    /// An `override`.
    Override(Handle<Override>),
    /// A part of a uniform or of the immediates, and whether it is an `i32`.
    Part {
        /// The variable.
        global: Handle<GlobalVariable>,
        /// The members on the way.
        path: Vec<u32>,
        /// The component of a vector.
        component: Option<u32>,
        /// Whether it is an `i32`.
        is_signed: bool,
    },
}

impl Width {
    /// Finds what a name means in a module.
    ///
    /// # Errors
    /// Why it means no width.
    pub fn find(module: &Module, linear: &Linear) -> Result<Width, String> {
        let name = match linear {
            Linear::Pixels(0) => return Err("a picture is at least one pixel wide".to_owned()),
            Linear::Pixels(pixels) => return Ok(Width::Pixels(*pixels)),
            Linear::Named(name) => name,
        };
        let is = |own: &Option<String>, name: &str| own.as_deref() == Some(name);
        if let Some((handle, item)) = module.overrides.iter().find(|(_, o)| is(&o.name, name)) {
            return match module.types[item.ty].inner {
                TypeInner::Scalar(Scalar::U32 | Scalar::I32) => Ok(Width::Override(handle)),
                _ => Err(format!("the override `{name}` is no 32-bit integer")),
            };
        }
        let mut parts = name.split('.');
        let variable = parts.next().unwrap_or_default();
        let found = module
            .global_variables
            .iter()
            .find(|(_, global)| is(&global.name, variable));
        let Some((global, item)) = found else {
            return Err(format!(
                "the shader has no uniform and no override called `{variable}`"
            ));
        };
        if !matches!(item.space, AddressSpace::Uniform | AddressSpace::Immediate) {
            return Err(format!("`{variable}` is no uniform"));
        }
        let mut ty = &module.types[item.ty].inner;
        let mut path = Vec::new();
        let mut component = None;
        for part in parts {
            ty = match ty {
                TypeInner::Struct { members, .. } => {
                    let Some(at) = members.iter().position(|m| is(&m.name, part)) else {
                        return Err(format!("`{variable}` has no member `{part}`"));
                    };
                    path.push(at as u32);
                    &module.types[members[at].ty].inner
                }
                TypeInner::Vector { size, scalar } if component.is_none() => {
                    let at = ["x", "y", "z", "w"].iter().position(|name| *name == part);
                    match at {
                        Some(at) if at < *size as usize => component = Some(at as u32),
                        _ => return Err(format!("a vector has no component `{part}`")),
                    }
                    match scalar.kind {
                        ScalarKind::Sint => &TypeInner::Scalar(Scalar::I32),
                        ScalarKind::Uint => &TypeInner::Scalar(Scalar::U32),
                        _ => &TypeInner::Scalar(Scalar::F32),
                    }
                }
                _ => return Err(format!("`{name}` has no part `{part}`")),
            };
        }
        match *ty {
            TypeInner::Scalar(scalar @ (Scalar::U32 | Scalar::I32)) => Ok(Width::Part {
                global,
                path,
                component,
                is_signed: scalar == Scalar::I32,
            }),
            _ => Err(format!("`{name}` is no 32-bit integer")),
        }
    }
}

impl Walk<'_> {
    /// A width as a `u32`.
    pub(super) fn width(&mut self, width: &Width) -> TermId {
        match width {
            Width::Pixels(pixels) => self.terms.literal(Literal::U32(*pixels)),
            Width::Override(handle) => {
                let value = self.terms.intern(Term::Override(*handle));
                self.terms.unsigned(value)
            }
            Width::Part {
                global,
                path,
                component,
                is_signed,
            } => {
                let path = path.iter().map(|&index| Step::Index(index)).collect();
                let mut value = self.terms.intern(Term::Load(*global, path));
                if let Some(component) = component {
                    value = self.terms.extract(value, *component);
                }
                match is_signed {
                    true => self.terms.cast(ScalarKind::Uint, Some(4), value),
                    false => value,
                }
            }
        }
    }
}
