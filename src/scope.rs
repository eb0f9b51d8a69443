//! wgpu's own complaints as results.
//!
//! What the caller hands in (layouts, textures, buffers) tells wgpu more than it tells this crate: a bind group layout does not say what
//! its entries are, nor a texture view which aspect it has. So what is made of such things is made within an error scope, and what wgpu
//! has against it comes back to the caller, instead of going to the device's handler of uncaptured errors, which panics by default.
//!
//! *Guarantees*: nothing waits. On every native backend wgpu knows its errors when the call returns; where it does not yet (in a
//! browser), they go the usual way.

use std::{
    error::Error as _,
    pin::pin,
    task::{Context, Poll, Waker},
};

use wgpu::wgc::validation::{BindingError, StageError};

/// Makes something, and gives what wgpu has against it.
pub(crate) fn caught<T>(device: &wgpu::Device, make: impl FnOnce() -> T) -> Result<T, wgpu::Error> {
    let internal = device.push_error_scope(wgpu::ErrorFilter::Internal);
    let validation = device.push_error_scope(wgpu::ErrorFilter::Validation);
    let made = make();
    // both, and in the order in which they were pushed
    let validation = at_once(validation.pop());
    let internal = at_once(internal.pop());
    match validation.or(internal) {
        None => Ok(made),
        Some(error) => Err(error),
    }
}

/// Whether two devices are one, where wgpu's numbers are the same: see [`Home`](crate::home::Home).
pub(crate) fn is_same(one: &wgpu::Device, other: &wgpu::Device) -> bool {
    let outer = other.push_error_scope(wgpu::ErrorFilter::Validation);
    let inner = one.push_error_scope(wgpu::ErrorFilter::Validation);
    // a buffer that is used for nothing is an error, and nothing else
    let _ = other.create_buffer(&wgpu::BufferDescriptor {
        label: Some("vrcs asks whether two devices are one"),
        size: 4,
        usage: wgpu::BufferUsages::empty(),
        mapped_at_creation: false,
    });
    let in_inner = at_once(inner.pop());
    let in_outer = at_once(outer.pop());
    in_inner.is_some() || in_outer.is_none()
}

/// What a future has already: it is asked once, and the device not at all.
fn at_once<T>(future: impl Future<Output = Option<T>>) -> Option<T> {
    match Future::poll(pin!(future), &mut Context::from_waker(Waker::noop())) {
        Poll::Ready(value) => value,
        Poll::Pending => None,
    }
}

/// An error with all its causes, on one line.
pub(crate) fn in_words(error: &wgpu::Error) -> String {
    let mut words = Vec::new();
    let mut cause = error.source();
    while let Some(error) = cause {
        words.push(error.to_string());
        cause = error.source();
    }
    match words.is_empty() {
        true => error.to_string(),
        false => words.join(": "),
    }
}

/// The binding that a pipeline's layout does not serve, and why not, if that is the error.
pub(crate) fn unserved_binding(error: &wgpu::Error) -> Option<(naga::ResourceBinding, String)> {
    let mut cause = error.source();
    while let Some(error) = cause {
        match error.downcast_ref::<StageError>() {
            Some(StageError::Binding(at, why)) => {
                let why = match why {
                    BindingError::Missing => "the layout has no such binding".to_owned(),
                    BindingError::Invisible => {
                        "the binding is not visible to compute shaders".to_owned()
                    }
                    why => why.to_string(),
                };
                return Some((*at, why));
            }
            _ => cause = error.source(),
        }
    }
    None
}
