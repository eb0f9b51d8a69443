//! Terms in words: the author's own where there are some, else put together from the parts.

use naga::{Handle, Literal, Span, Type, TypeInner};

use super::Words;
use crate::{
    analysis::term::{Axis, Id, Step, Term, TermId},
    emit,
};

/// How deep a term is told.
const MOST: usize = 6;

const AXES: [&str; 4] = ["x", "y", "z", "w"];

impl Words<'_> {
    /// A term in words.
    pub(super) fn term(&self, term: TermId) -> String {
        self.told(term, 0)
    }

    fn told(&self, term: TermId, depth: usize) -> String {
        let words = self
            .span(term)
            .and_then(|span| self.source.expression(span));
        words.unwrap_or_else(|| self.put_together(term, depth))
    }

    fn put_together(&self, term: TermId, depth: usize) -> String {
        if depth >= MOST {
            return "…".to_owned();
        }
        let inner = |term: TermId| self.told(term, depth + 1);
        let list = |terms: &[TermId]| {
            let terms: Vec<String> = terms.iter().map(|&term| inner(term)).collect();
            terms.join(", ")
        };
        let axis = |name: &str, axis: Axis| format!("{name}.{}", AXES[usize::from(axis) & 3]);
        match self.plan.found.terms.get(term) {
            Term::Literal(bits) => literal(bits.0),
            Term::Override(handle) => self.module.overrides[*handle]
                .name
                .clone()
                .unwrap_or_default(),
            Term::Constant(handle) => self.module.constants[*handle]
                .name
                .clone()
                .unwrap_or_default(),
            Term::Id(id) => match *id {
                Id::Global(of) => axis("global_invocation_id", of),
                Id::Local(of) => axis("local_invocation_id", of),
                Id::LocalIndex => "local_invocation_index".to_owned(),
                Id::Group(of) => axis("workgroup_id", of),
                Id::GroupCount(of) => axis("num_workgroups", of),
            },
            Term::Load(global, steps) => {
                let variable = &self.module.global_variables[*global];
                let name = variable.name.clone().unwrap_or_default();
                name + &self.path(variable.ty, steps, depth)
            }
            Term::Extract(of, part) => {
                format!(
                    "{}.{}",
                    inner(*of),
                    AXES.get(*part as usize).unwrap_or(&"…")
                )
            }
            Term::Index(of, at) => format!("{}[{}]", inner(*of), inner(*at)),
            Term::Compose { parts, .. } => format!("({})", list(parts)),
            Term::Unary(op, of) => format!("{}({})", emit::constant::unary(*op), inner(*of)),
            Term::Binary(op, left, right) => {
                format!(
                    "({} {} {})",
                    inner(*left),
                    emit::constant::operator(*op),
                    inner(*right)
                )
            }
            Term::Select(condition, accept, reject) => format!(
                "select({}, {}, {})",
                inner(*reject),
                inner(*accept),
                inner(*condition)
            ),
            Term::Splat(_, of) | Term::As(_, _, of) | Term::Relational(_, of) => inner(*of),
            Term::Math(function, arguments) => {
                format!(
                    "{}({})",
                    format!("{function:?}").to_lowercase(),
                    list(arguments)
                )
            }
            Term::Call(function, arguments) => {
                let name = self.module.functions[*function].name.clone();
                format!("{}({})", name.unwrap_or_default(), list(arguments))
            }
            Term::ImageQuery(_, image, _) => format!("a size of {}", inner(*image)),
            Term::Resource(global, _) | Term::ArrayLength(global, _) => {
                let name = self.module.global_variables[*global].name.clone();
                name.unwrap_or_default()
            }
            Term::LoopVar { .. } => "a loop's variable".to_owned(),
            Term::LoopExit { .. } => "what a loop leaves".to_owned(),
            Term::Merge { values, .. } => format!("one of ({})", list(values)),
            _ => "a value of the shader".to_owned(),
        }
    }

    /// The way from a variable to a part of it.
    fn path(&self, mut ty: Handle<Type>, steps: &[Step], depth: usize) -> String {
        let mut path = String::new();
        for step in steps {
            let (word, next) = match (&self.module.types[ty].inner, *step) {
                (TypeInner::Struct { members, .. }, Step::Index(index)) => {
                    let Some(member) = members.get(index as usize) else {
                        return path;
                    };
                    (
                        format!(".{}", member.name.clone().unwrap_or_default()),
                        member.ty,
                    )
                }
                (TypeInner::Array { base, .. }, Step::Index(index)) => {
                    (format!("[{index}]"), *base)
                }
                (TypeInner::Array { base, .. }, Step::Dynamic(at)) => {
                    (format!("[{}]", self.told(at, depth + 1)), *base)
                }
                (_, Step::Index(index)) => {
                    let axis = AXES.get(index as usize).unwrap_or(&"…");
                    return format!("{path}.{axis}");
                }
                (_, Step::Dynamic(at)) => return format!("{path}[{}]", self.told(at, depth + 1)),
            };
            path.push_str(&word);
            ty = next;
        }
        path
    }

    fn span(&self, term: TermId) -> Option<Span> {
        let found = &self.plan.found;
        let condition = found.conditions.iter().find(|c| c.condition == term);
        if let Some(condition) = condition.filter(|c| c.span.is_defined()) {
            return Some(condition.span);
        }
        found.instances.iter().find_map(|instance| {
            let function = instance.function.get(self.module, self.entry);
            let expressions = function.expressions.iter().zip(&instance.values);
            expressions
                .filter(|(_, value)| **value == Some(term))
                .map(|((handle, _), _)| function.expressions.get_span(handle))
                .find(|span| span.is_defined())
        })
    }
}

fn literal(literal: Literal) -> String {
    match literal {
        Literal::F64(v) => v.to_string(),
        Literal::F32(v) => v.to_string(),
        Literal::F16(v) => v.to_string(),
        Literal::U16(v) => v.to_string(),
        Literal::I16(v) => v.to_string(),
        Literal::U32(v) => v.to_string(),
        Literal::I32(v) => v.to_string(),
        Literal::U64(v) => v.to_string(),
        Literal::I64(v) => v.to_string(),
        Literal::Bool(v) => v.to_string(),
        Literal::AbstractInt(v) => v.to_string(),
        Literal::AbstractFloat(v) => v.to_string(),
    }
}
