//! Places: what a pointer points to, what is loaded from it, and what an index picks from a value.
//!
//! An index that lies beyond the end of what it indexes, by a literal, gives a value that WGSL leaves open, and naga's validator
//! does not accept the literal where it is written: such an index is [opaque](Opacity::Beyond).

use std::rc::Rc;

use naga::{
    AddressSpace, Expression, GlobalVariable, Handle, ImageClass, Literal, TypeInner,
    proc::IndexableLength,
};

use super::{Place, Root, Value};
use crate::analysis::{
    AccessKind, Address, Target, Tie,
    env::Variable,
    term::{Opacity, Step, Term, TermId},
    walk::{Frame, Walk},
};

impl<'a> Walk<'a> {
    pub(super) fn global(&mut self, global: Handle<GlobalVariable>) -> Value {
        match self.module.global_variables[global].space {
            AddressSpace::Private => pointer(Root::Variable(Variable::Private(global))),
            AddressSpace::WorkGroup => pointer(Root::WorkGroup(global)),
            AddressSpace::Uniform | AddressSpace::Storage { .. } | AddressSpace::Immediate => {
                // a binding array of buffers is a handle until it is indexed; both are places here
                pointer(Root::Memory(global))
            }
            AddressSpace::Handle => {
                Value::Term(self.terms.intern(Term::Resource(global, Box::new([]))))
            }
            _ => pointer(Root::Unfollowed),
        }
    }

    /// A part of a value, or a pointer to a part.
    pub(super) fn step(
        &mut self,
        frame: &mut Frame<'a>,
        base: Handle<Expression>,
        step: Step,
    ) -> Value {
        let step = self.inside(frame, base, step);
        match self.value(frame, base) {
            Value::Place(place) => {
                let mut place = (*place).clone();
                place.steps.push(step);
                Value::Place(Rc::new(place))
            }
            Value::Term(base) => {
                if let Term::Resource(global, steps) = self.terms.get(base) {
                    let (global, mut steps) = (*global, steps.to_vec());
                    steps.push(step);
                    return Value::Term(self.terms.intern(Term::Resource(global, steps.into())));
                }
                Value::Term(match step {
                    Step::Index(index) => self.terms.extract(base, index),
                    Step::Dynamic(index) => self.terms.index(base, index),
                })
            }
        }
    }

    /// A step with its index as a number, where it is known; an opaque one where that lies beyond the end.
    fn inside(&mut self, frame: &Frame<'a>, base: Handle<Expression>, step: Step) -> Step {
        let Step::Dynamic(index) = step else {
            return step;
        };
        let index = match self.terms.as_literal(index) {
            Some(Literal::U32(index)) => Some(index),
            Some(Literal::I32(index)) => u32::try_from(index).ok(),
            _ => return step,
        };
        let length = self
            .inner(frame, base)
            .indexable_length_pending(self.module);
        match (index, length) {
            (Some(index), Ok(IndexableLength::Known(length))) if index < length => {
                Step::Index(index)
            }
            (Some(index), Ok(IndexableLength::Dynamic)) => Step::Index(index),
            _ => Step::Dynamic(self.terms.opaque(Opacity::Beyond, Vec::new())),
        }
    }

    pub(super) fn load(
        &mut self,
        frame: &mut Frame<'a>,
        handle: Handle<Expression>,
        place: &Place,
    ) -> TermId {
        match place.root {
            Root::Variable(variable) => {
                let whole = self.variable(frame, variable);
                self.part(whole, &place.steps)
            }
            Root::Memory(global) => self.load_memory(frame, handle, global, place),
            Root::WorkGroup(global) => {
                let span = frame.function.expressions.get_span(handle);
                self.note_tie(frame, Tie::WorkGroup(global), span);
                let operands = dynamic(&place.steps);
                self.terms.opaque(Opacity::WorkGroup, operands)
            }
            Root::Unfollowed => self.terms.opaque(Opacity::Unfollowed, Vec::new()),
        }
    }

    fn load_memory(
        &mut self,
        frame: &mut Frame<'a>,
        handle: Handle<Expression>,
        global: Handle<GlobalVariable>,
        place: &Place,
    ) -> TermId {
        if self
            .facts
            .is_written(global, &leading_constants(&place.steps))
        {
            let span = frame.function.expressions.get_span(handle);
            let target = Target {
                global,
                element: Vec::new(),
            };
            let address = Address::Part(place.steps.clone());
            self.note_access(
                frame,
                AccessKind::Load { value: handle },
                target,
                address,
                span,
            );
            return self
                .terms
                .opaque(Opacity::Written(global), dynamic(&place.steps));
        }
        // vectors and matrices are loaded whole, so that all ways to a component give one term
        let mut whole = 0;
        while whole < place.steps.len()
            && matches!(
                self.terms.loaded(global, &place.steps[..whole]),
                Some(
                    TypeInner::Struct { .. }
                        | TypeInner::Array { .. }
                        | TypeInner::BindingArray { .. }
                )
            )
        {
            whole += 1;
        }
        let (path, rest) = place.steps.split_at(whole);
        let loaded = self.terms.intern(Term::Load(global, path.into()));
        self.part(loaded, rest)
    }

    fn part(&mut self, mut value: TermId, steps: &[Step]) -> TermId {
        for step in steps {
            value = match *step {
                Step::Index(index) => self.terms.extract(value, index),
                Step::Dynamic(index) => self.terms.index(value, index),
            };
        }
        value
    }

    /// What a variable holds; what it starts with, if nothing was stored yet.
    pub(in crate::analysis) fn variable(
        &mut self,
        frame: &mut Frame<'a>,
        variable: Variable,
    ) -> TermId {
        if let Some(value) = self.env.get(variable) {
            return value;
        }
        let value = match variable {
            Variable::Local { frame: of, local } if of == frame.id => {
                let local = &frame.function.local_variables[local];
                match local.init {
                    Some(init) => self.term(frame, init),
                    None => self.terms.zero(local.ty),
                }
            }
            // a caller's variable: its own frame has set it before it could hand out a pointer, or never will
            Variable::Local { .. } => self.terms.opaque(Opacity::Unfollowed, Vec::new()),
            Variable::Private(global) => {
                let global = &self.module.global_variables[global];
                match global.init {
                    Some(init) => self.terms.global_expression(init),
                    None => self.terms.zero(global.ty),
                }
            }
        };
        self.env.set(variable, value);
        value
    }

    /// Replaces a part of a value.
    pub(in crate::analysis) fn with_part(
        &mut self,
        whole: TermId,
        steps: &[Step],
        value: TermId,
    ) -> TermId {
        let Some((step, rest)) = steps.split_first() else {
            return value;
        };
        match *step {
            Step::Index(index) => {
                let part = self.terms.extract(whole, index);
                let part = self.with_part(part, rest, value);
                self.terms.insert(whole, index, part)
            }
            Step::Dynamic(index) => {
                let part = self.terms.index(whole, index);
                let part = self.with_part(part, rest, value);
                self.terms.intern(Term::Update(whole, index, part))
            }
        }
    }

    /// The texture behind an expression, if the shader writes it.
    pub(in crate::analysis) fn written_texture(
        &mut self,
        frame: &mut Frame<'a>,
        image: Handle<Expression>,
    ) -> Option<Target> {
        let image = self.term(frame, image);
        let Term::Resource(global, element) = self.terms.get(image) else {
            return None;
        };
        let is_storage = matches!(
            self.terms.loaded(*global, element),
            Some(TypeInner::Image {
                class: ImageClass::Storage { .. },
                ..
            })
        );
        (is_storage && self.facts.is_written_anywhere(*global)).then(|| Target {
            global: *global,
            element: element.to_vec(),
        })
    }

    /// The place of a texel.
    pub(in crate::analysis) fn texel(
        &mut self,
        frame: &mut Frame<'a>,
        coordinate: Handle<Expression>,
        layer: Option<Handle<Expression>>,
    ) -> Address {
        let at = self.term(frame, coordinate);
        let coordinate = match self.inner(frame, coordinate) {
            &TypeInner::Vector { size, .. } => (0..size as u32)
                .map(|i| self.terms.extract(at, i))
                .collect(),
            _ => vec![at],
        };
        Address::Texel {
            coordinate,
            layer: layer.map(|layer| self.term(frame, layer)),
        }
    }
}

pub(super) fn pointer(root: Root) -> Value {
    Value::Place(Rc::new(Place {
        root,
        steps: Vec::new(),
    }))
}

/// The computed indices among steps.
fn dynamic(steps: &[Step]) -> Vec<TermId> {
    steps
        .iter()
        .filter_map(|step| match *step {
            Step::Dynamic(index) => Some(index),
            Step::Index(_) => None,
        })
        .collect()
}

/// The steps before the first computed index.
fn leading_constants(steps: &[Step]) -> Vec<u32> {
    steps
        .iter()
        .map_while(|step| match *step {
            Step::Index(index) => Some(index),
            Step::Dynamic(_) => None,
        })
        .collect()
}
