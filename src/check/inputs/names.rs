//! The names that a user sets: each has to occur in the shader.

use naga::TypeInner;

use super::{InputError, Maker};

impl Maker<'_> {
    /// Checks that every name that the user set occurs in the shader.
    ///
    /// # Errors
    /// The first that does not.
    pub fn check_names(&self) -> Result<(), InputError> {
        let module = self.module;
        let is_global = |name: &str| {
            module
                .global_variables
                .iter()
                .any(|(_, g)| g.name.as_deref() == Some(name))
        };
        let is_member = |name: &str| {
            module.types.iter().any(|(_, ty)| match &ty.inner {
                TypeInner::Struct { members, .. } => members
                    .iter()
                    .any(|member| member.name.as_deref() == Some(name)),
                _ => false,
            })
        };
        let is_override = |name: &str| {
            module
                .overrides
                .iter()
                .any(|(_, o)| o.name.as_deref() == Some(name))
        };
        for name in self.settings.set.keys() {
            let last = name.rsplit('.').next().unwrap_or(name);
            if !is_global(name) && !is_member(last) && !is_override(name) {
                return Err(self.unknown(name));
            }
        }
        match self.settings.files.keys().find(|name| !is_global(name)) {
            Some(name) => Err(self.unknown(name)),
            None => Ok(()),
        }
    }

    /// A name that does not occur, and what does: what is nearest, or all.
    fn unknown(&self, name: &str) -> InputError {
        let module = self.module;
        let mut names = Vec::new();
        for (_, global) in module.global_variables.iter() {
            let Some(name) = &global.name else { continue };
            if let TypeInner::Struct { members, .. } = &module.types[global.ty].inner {
                let members = members.iter().filter_map(|member| member.name.as_ref());
                names.extend(members.map(|member| format!("{name}.{member}")));
            }
            names.push(name.clone());
        }
        names.extend(module.overrides.iter().filter_map(|(_, o)| o.name.clone()));
        let known = names.iter().map(String::as_str);
        let instead = match vrcs_passes::near::nearest(name, known.clone()) {
            Some(near) => format!("; did you mean `{near}`?"),
            None if names.is_empty() => String::new(),
            None => format!("; it has {}", vrcs_passes::near::list(known)),
        };
        InputError::Unknown {
            name: name.to_owned(),
            instead,
        }
    }
}
