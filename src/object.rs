//! What every object of this crate can be given: a name for captures, and the caller's cache of pipelines.

/// What objects are made with, beside what they are to do.
#[derive(Clone, Copy, Debug, Default)]
pub struct ObjectOptions<'o> {
    /// What the labels of buffers, pipelines, bind groups and debug groups start with, so that a capture tells one view from
    /// another; by default `vrcs`.
    pub label: Option<&'o str>,
    /// The caller's cache of compiled pipelines; it belongs to the same device. What is loaded from and saved to a file is the
    /// caller's affair.
    pub cache: Option<&'o wgpu::PipelineCache>,
}

impl<'o> ObjectOptions<'o> {
    /// With a name.
    pub fn labelled(label: &'o str) -> ObjectOptions<'o> {
        ObjectOptions {
            label: Some(label),
            cache: None,
        }
    }

    /// The label of a part.
    pub(crate) fn name(&self, part: &str) -> String {
        format!("{} {part}", self.label.unwrap_or("vrcs"))
    }
}
