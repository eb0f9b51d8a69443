//! Parameters that follow the order of primaries, without an upload when it changes.

use bytemuck::Pod;

use crate::build::primary::Order;

/// A kernel's parameters for every [order](Order::code) of primaries, one after another, so that primaries rotate by a dynamic offset and
/// nothing is uploaded for it.
#[derive(Debug)]
pub(crate) struct Slots {
    buffer: wgpu::Buffer,
    /// Bytes of one.
    size: u64,
    /// Bytes from one to the next.
    stride: u32,
}

impl Slots {
    /// Room for parameters of `size` bytes.
    pub(crate) fn new(device: &wgpu::Device, size: usize, label: &str) -> Slots {
        let alignment = device.limits().min_uniform_buffer_offset_alignment;
        let stride = (size as u32).next_multiple_of(alignment.max(16));
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size: u64::from(stride) * Order::CODES as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        Slots {
            buffer,
            size: size as u64,
            stride,
        }
    }

    /// What is bound, with a dynamic offset.
    pub(crate) fn binding(&self) -> wgpu::BindingResource<'_> {
        wgpu::BindingResource::Buffer(wgpu::BufferBinding {
            buffer: &self.buffer,
            offset: 0,
            size: wgpu::BufferSize::new(self.size),
        })
    }

    /// Uploads the parameters of every order.
    pub(crate) fn write<P: Pod>(&self, queue: &wgpu::Queue, of: impl Fn(Order) -> P) {
        for order in Order::all() {
            let params = of(order);
            let at = u64::from(self.offset(order));
            queue.write_buffer(&self.buffer, at, bytemuck::bytes_of(&params));
        }
    }

    /// The dynamic offset of an order's parameters.
    pub(crate) fn offset(&self, order: Order) -> u32 {
        order.code() * self.stride
    }
}
