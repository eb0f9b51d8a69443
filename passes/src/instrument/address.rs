//! The place that a store goes to, as a number: a texel's, or a byte offset.

use naga::{
    ArraySize, BinaryOperator, Expression, Function, GlobalVariable, Handle, Literal, Module,
    Scalar, Statement, Type, TypeInner,
    proc::{Alignment, Layouter},
    valid::FunctionInfo,
};

use super::{OUTSIDE, Shape};
use crate::ir::build::Code;

/// A step of a pointer into a buffer.
enum ByteStep {
    /// So many bytes on.
    Fixed(u32),
    /// To the element at a computed place.
    Computed {
        index: Handle<Expression>,
        stride: u32,
        /// How many elements there are, if the type says so.
        count: Option<u32>,
    },
}

/// What a pointer points to, on the way to what is stored to.
#[derive(Clone, Copy)]
enum Cursor {
    Type(Handle<Type>),
    /// A column of a matrix, which the module may have no type for.
    Column(u32, Scalar),
    Component(Scalar),
}

/// Where a store goes: how a pointer leads there, and how much is stored.
pub(super) struct Destination {
    pub(super) global: Handle<GlobalVariable>,
    steps: Vec<ByteStep>,
    /// Bytes, or 1 for a texel.
    pub(super) size: u32,
    /// For each two bytes, or for a texel, whether nothing is stored there.
    pub(super) padding: Vec<bool>,
}

/// Where a pointer leads.
pub(super) fn destination(
    module: &Module,
    function: &Function,
    statement: &Statement,
    pointer: Handle<Expression>,
) -> Option<Destination> {
    let mut links = Vec::new();
    let mut at = pointer;
    let global = loop {
        at = match function.expressions[at] {
            Expression::AccessIndex { base, .. } | Expression::Access { base, .. } => {
                links.push(at);
                base
            }
            Expression::GlobalVariable(global) => break global,
            _ => return None,
        };
    };
    module.global_variables[global].binding?;
    let mut destination = Destination {
        global,
        steps: Vec::new(),
        size: 1,
        padding: vec![false],
    };
    if matches!(
        statement,
        Statement::ImageStore { .. } | Statement::ImageAtomic { .. }
    ) {
        return Some(destination);
    }
    let mut cursor = Cursor::Type(module.global_variables[global].ty);
    for link in links.into_iter().rev() {
        let (step, next) = follow(module, function, cursor, link);
        destination.steps.extend(step);
        cursor = next;
    }
    destination.size = bytes(module, cursor);
    destination.padding = padding(module, cursor, destination.size);
    Some(destination)
}

fn follow(
    module: &Module,
    function: &Function,
    cursor: Cursor,
    link: Handle<Expression>,
) -> (Option<ByteStep>, Cursor) {
    let (stride, count, next) = match cursor {
        Cursor::Type(ty) => match module.types[ty].inner {
            TypeInner::Struct { ref members, .. } => {
                let Expression::AccessIndex { index, .. } = function.expressions[link] else {
                    unreachable!("a struct has no computed members");
                };
                let member = &members[index as usize];
                return (
                    Some(ByteStep::Fixed(member.offset)),
                    Cursor::Type(member.ty),
                );
            }
            // all elements of a binding array are one resource here
            TypeInner::BindingArray { base, .. } => return (None, Cursor::Type(base)),
            TypeInner::Array { base, size, stride } => {
                let count = match size {
                    ArraySize::Constant(count) => Some(count.get()),
                    ArraySize::Pending(_) | ArraySize::Dynamic => None,
                };
                (stride, count, Cursor::Type(base))
            }
            TypeInner::Matrix {
                columns,
                rows,
                scalar,
            } => {
                let stride = Alignment::from(rows) * u32::from(scalar.width);
                let column = Cursor::Column(rows as u32, scalar);
                (stride, Some(columns as u32), column)
            }
            TypeInner::Vector { size, scalar } => {
                let width = u32::from(scalar.width);
                (width, Some(size as u32), Cursor::Component(scalar))
            }
            ref other => unreachable!("{other:?} has no parts"),
        },
        Cursor::Column(rows, scalar) => {
            let width = u32::from(scalar.width);
            (width, Some(rows), Cursor::Component(scalar))
        }
        Cursor::Component(_) => unreachable!("a component has no parts"),
    };
    let step = match function.expressions[link] {
        Expression::AccessIndex { index, .. } => ByteStep::Fixed(index * stride),
        Expression::Access { index, .. } => ByteStep::Computed {
            index,
            stride,
            count,
        },
        ref other => unreachable!("{other:?} is no step"),
    };
    (Some(step), next)
}

fn bytes(module: &Module, cursor: Cursor) -> u32 {
    match cursor {
        Cursor::Component(scalar) => u32::from(scalar.width),
        Cursor::Column(rows, scalar) => rows * u32::from(scalar.width),
        Cursor::Type(ty) => {
            let mut layouter = Layouter::default();
            match layouter.update(module.to_ctx()) {
                Ok(()) => layouter[ty].size,
                Err(_) => module.types[ty].inner.size(module.to_ctx()),
            }
        }
    }
}

/// For each two bytes of a value, whether nothing of it is in them.
fn padding(module: &Module, cursor: Cursor, size: u32) -> Vec<bool> {
    let mut used = vec![false; size as usize];
    match cursor {
        Cursor::Type(ty) => occupy(module, ty, &mut used),
        Cursor::Column(..) | Cursor::Component(_) => used.fill(true),
    }
    used.chunks(2).map(|pair| !pair.contains(&true)).collect()
}

/// Marks the bytes that a value of a type uses.
fn occupy(module: &Module, ty: Handle<Type>, bytes: &mut [bool]) {
    match module.types[ty].inner {
        TypeInner::Struct { ref members, .. } => {
            for member in members {
                if let Some(rest) = bytes.get_mut(member.offset as usize..) {
                    occupy(module, member.ty, rest);
                }
            }
        }
        TypeInner::Array {
            base,
            size: ArraySize::Constant(count),
            stride,
        } => {
            for element in bytes.chunks_mut(stride as usize).take(count.get() as usize) {
                occupy(module, base, element);
            }
        }
        TypeInner::Matrix {
            columns,
            rows,
            scalar,
        } => {
            let stride = Alignment::from(rows) * u32::from(scalar.width);
            let used = rows as usize * usize::from(scalar.width);
            for column in bytes.chunks_mut(stride as usize).take(columns as usize) {
                column.iter_mut().take(used).for_each(|byte| *byte = true);
            }
        }
        TypeInner::Vector { size, scalar } => {
            let used = size as usize * usize::from(scalar.width);
            bytes.iter_mut().take(used).for_each(|byte| *byte = true);
        }
        TypeInner::Scalar(scalar) | TypeInner::Atomic(scalar) => {
            let used = usize::from(scalar.width);
            bytes.iter_mut().take(used).for_each(|byte| *byte = true);
        }
        _ => bytes.fill(true),
    }
}

impl Destination {
    /// Writes code for the place of a store: a texel's number or a byte offset, [`OUTSIDE`] if it lies outside; and where in a
    /// buffer it goes if each index is confined to its array, as drivers may do.
    pub(super) fn write(
        &self,
        code: &mut Code,
        info: &FunctionInfo,
        statement: &Statement,
        shape: Shape,
    ) -> [Handle<Expression>; 2] {
        let mut place = Place {
            at: code.u32(0),
            confined: code.u32(0),
            inside: code.bool(true),
        };
        match (statement, shape) {
            (
                &Statement::ImageStore {
                    coordinate,
                    array_index,
                    ..
                }
                | &Statement::ImageAtomic {
                    coordinate,
                    array_index,
                    ..
                },
                Shape::Texture(size),
            ) => {
                let mut parts = match *info[coordinate].ty.inner_with(code.types) {
                    TypeInner::Vector { size, .. } => {
                        (0..size as u32).map(|i| code.at(coordinate, i)).collect()
                    }
                    _ => vec![coordinate],
                };
                if let Some(layer) = array_index {
                    while parts.len() < 2 {
                        parts.push(code.u32(0));
                    }
                    parts.push(layer);
                }
                let strides = [1, size[0], size[0] * size[1]];
                for ((part, stride), count) in parts.into_iter().zip(strides).zip(size) {
                    place.step(code, part, stride, count);
                }
            }
            (_, Shape::Buffer(bytes)) => self.write_offset(code, bytes, &mut place),
            _ => unreachable!("a texture has a texture's shape"),
        }
        let reject = code.u32(OUTSIDE);
        let at = code.add(Expression::Select {
            condition: place.inside,
            accept: place.at,
            reject,
        });
        [at, place.confined]
    }

    fn write_offset(&self, code: &mut Code, bytes: u32, place: &mut Place) {
        let mut before = 0;
        for step in &self.steps {
            match *step {
                ByteStep::Fixed(offset) => {
                    before += offset;
                    let offset = code.u32(offset);
                    place.at = code.binary(BinaryOperator::Add, place.at, offset);
                    place.confined = code.binary(BinaryOperator::Add, place.confined, offset);
                }
                ByteStep::Computed {
                    index,
                    stride,
                    count,
                } => {
                    // an array without a size ends with its buffer
                    let room = bytes.saturating_sub(before) / stride.max(1);
                    place.step(code, index, stride, count.unwrap_or(room));
                }
            }
        }
        // an element may start inside and end outside
        let last = code.u32(bytes.saturating_sub(self.size));
        let fits = code.binary(BinaryOperator::LessEqual, place.at, last);
        place.inside = code.binary(BinaryOperator::LogicalAnd, place.inside, fits);
    }
}

struct Place {
    at: Handle<Expression>,
    confined: Handle<Expression>,
    inside: Handle<Expression>,
}

impl Place {
    /// Goes to an element, and notes whether it exists.
    fn step(&mut self, code: &mut Code, index: Handle<Expression>, stride: u32, count: u32) {
        // a negative index becomes a large one
        let index = match code.expressions()[index] {
            Expression::Literal(Literal::I32(i)) => code.u32(i as u32),
            Expression::Literal(_) => index,
            _ => code.convert(index, Scalar::U32),
        };
        let last = code.u32(count.saturating_sub(1));
        let count = code.u32(count);
        let exists = code.binary(BinaryOperator::Less, index, count);
        self.inside = code.binary(BinaryOperator::LogicalAnd, self.inside, exists);
        let stride = code.u32(stride);
        let distance = code.binary(BinaryOperator::Multiply, index, stride);
        self.at = code.binary(BinaryOperator::Add, self.at, distance);
        let nearest = code.add(Expression::Select {
            condition: exists,
            accept: index,
            reject: last,
        });
        let distance = code.binary(BinaryOperator::Multiply, nearest, stride);
        self.confined = code.binary(BinaryOperator::Add, self.confined, distance);
    }
}
