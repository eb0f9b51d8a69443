//! A Vulkan device that draws one triangle over a picture, with a hardware-VRS image, and reads the picture back.
//!
//! Does: for one physical device and one of the two extensions, draws at each sample count with any texels.
//! Needs: Vulkan 1.3, for dynamic rendering.
//! Guarantees: errors of Vulkan are panics that name the call; what was made lives as long as the process.

use ash::{khr, nv, vk};
use vrcs::attach::PALETTE;

/// The extension that a device draws with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extension {
    Khr,
    Nv,
}

/// What was drawn at a pixel: the first word of the shader, and the centre of the coarse pixel in half pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Seen {
    pub word: u32,
    pub centre: [u32; 2],
}

/// What a picture holds where nothing was drawn.
pub const UNTOUCHED: u32 = 0xffff_ffff;

const FORMAT: vk::Format = vk::Format::R32G32B32A32_UINT;
const RATES: vk::Format = vk::Format::R8_UINT;

/// A device with one extension on.
pub struct Device {
    extension: Extension,
    memory: vk::PhysicalDeviceMemoryProperties,
    device: ash::Device,
    binder: Option<nv::shading_rate_image::Device>,
    queue: vk::Queue,
    commands: vk::CommandBuffer,
}

/// The texels to draw with, as bytes whose rows are `pitch` long, and the side of a tile.
pub struct Rates<'t> {
    pub texels: &'t [u8],
    pub size: [u32; 2],
    pub pitch: u32,
    pub tile: u32,
}

impl Device {
    /// Makes a device; the reason if it cannot be.
    pub fn new(
        instance: &ash::Instance,
        physical: vk::PhysicalDevice,
        extension: Extension,
    ) -> Result<Device, String> {
        let mut rendering =
            vk::PhysicalDeviceDynamicRenderingFeatures::default().dynamic_rendering(true);
        let mut khr_features = vk::PhysicalDeviceFragmentShadingRateFeaturesKHR::default()
            .pipeline_fragment_shading_rate(true)
            .attachment_fragment_shading_rate(true);
        let mut nv_features =
            vk::PhysicalDeviceShadingRateImageFeaturesNV::default().shading_rate_image(true);
        let priorities = [1.0];
        // SAFETY: the instance and the physical device are alive, and every structure outlives the calls.
        unsafe {
            let family = instance
                .get_physical_device_queue_family_properties(physical)
                .iter()
                .position(|family| family.queue_flags.contains(vk::QueueFlags::GRAPHICS))
                .ok_or("it has no queue for graphics")? as u32;
            let queues = [vk::DeviceQueueCreateInfo::default()
                .queue_family_index(family)
                .queue_priorities(&priorities)];
            let names = match extension {
                Extension::Khr => [khr::fragment_shading_rate::NAME.as_ptr()],
                Extension::Nv => [nv::shading_rate_image::NAME.as_ptr()],
            };
            let info = vk::DeviceCreateInfo::default()
                .queue_create_infos(&queues)
                .enabled_extension_names(&names)
                .push_next(&mut rendering);
            let info = match extension {
                Extension::Khr => info.push_next(&mut khr_features),
                Extension::Nv => info.push_next(&mut nv_features),
            };
            let device = instance
                .create_device(physical, &info, None)
                .map_err(|error| format!("it gives no device: {error}"))?;
            let pool = vk::CommandPoolCreateInfo::default()
                .queue_family_index(family)
                .flags(vk::CommandPoolCreateFlags::RESET_COMMAND_BUFFER);
            let pool = device.create_command_pool(&pool, None).expect("a pool");
            let buffers = vk::CommandBufferAllocateInfo::default()
                .command_pool(pool)
                .command_buffer_count(1);
            let commands = device.allocate_command_buffers(&buffers).expect("commands")[0];
            Ok(Device {
                extension,
                memory: instance.get_physical_device_memory_properties(physical),
                binder: (extension == Extension::Nv)
                    .then(|| nv::shading_rate_image::Device::new(instance, &device)),
                queue: device.get_device_queue(family, 0),
                commands,
                device,
            })
        }
    }

    fn memory_for(
        &self,
        needs: vk::MemoryRequirements,
        flags: vk::MemoryPropertyFlags,
    ) -> vk::DeviceMemory {
        let index = (0..self.memory.memory_type_count)
            .find(|&index| {
                let kind = self.memory.memory_types[index as usize];
                needs.memory_type_bits >> index & 1 != 0 && kind.property_flags.contains(flags)
            })
            .expect("a kind of memory");
        let info = vk::MemoryAllocateInfo::default()
            .allocation_size(needs.size)
            .memory_type_index(index);
        // SAFETY: the device is alive, and the index is one of its kinds of memory.
        unsafe { self.device.allocate_memory(&info, None) }.expect("memory")
    }

    /// A buffer that the host sees, and its address.
    fn buffer(&self, size: u64, usage: vk::BufferUsageFlags) -> (vk::Buffer, *mut u8) {
        let info = vk::BufferCreateInfo::default().size(size).usage(usage);
        // SAFETY: the device is alive; the memory is bound once, and mapped whole, once.
        unsafe {
            let buffer = self.device.create_buffer(&info, None).expect("a buffer");
            let flags =
                vk::MemoryPropertyFlags::HOST_VISIBLE | vk::MemoryPropertyFlags::HOST_COHERENT;
            let memory = self.memory_for(self.device.get_buffer_memory_requirements(buffer), flags);
            self.device
                .bind_buffer_memory(buffer, memory, 0)
                .expect("bound memory");
            let address = self
                .device
                .map_memory(memory, 0, vk::WHOLE_SIZE, vk::MemoryMapFlags::empty())
                .expect("mapped memory");
            (buffer, address.cast())
        }
    }

    fn image(
        &self,
        format: vk::Format,
        [width, height]: [u32; 2],
        samples: u32,
        usage: vk::ImageUsageFlags,
    ) -> (vk::Image, vk::ImageView) {
        let info = vk::ImageCreateInfo::default()
            .image_type(vk::ImageType::TYPE_2D)
            .format(format)
            .extent(vk::Extent3D {
                width,
                height,
                depth: 1,
            })
            .mip_levels(1)
            .array_layers(1)
            .samples(vk::SampleCountFlags::from_raw(samples))
            .usage(usage);
        // SAFETY: the device is alive, and the memory is bound once.
        unsafe {
            let image = self.device.create_image(&info, None).expect("an image");
            let needs = self.device.get_image_memory_requirements(image);
            let memory = self.memory_for(needs, vk::MemoryPropertyFlags::DEVICE_LOCAL);
            self.device
                .bind_image_memory(image, memory, 0)
                .expect("bound memory");
            let info = vk::ImageViewCreateInfo::default()
                .image(image)
                .view_type(vk::ImageViewType::TYPE_2D)
                .format(format)
                .subresource_range(WHOLE);
            let view = self.device.create_image_view(&info, None).expect("a view");
            (image, view)
        }
    }

    fn shader(&self, bytes: &[u8]) -> vk::ShaderModule {
        let words = ash::util::read_spv(&mut std::io::Cursor::new(bytes)).expect("SPIR-V");
        let info = vk::ShaderModuleCreateInfo::default().code(&words);
        // SAFETY: the words are SPIR-V that spirv-val accepts.
        unsafe { self.device.create_shader_module(&info, None) }.expect("a shader")
    }

    fn pipeline(&self, [width, height]: [u32; 2], samples: u32) -> vk::Pipeline {
        let vertex = self.shader(include_bytes!("triangle.vert.spv"));
        let fragment = match self.extension {
            Extension::Khr => self.shader(include_bytes!("rate_khr.frag.spv")),
            Extension::Nv => self.shader(include_bytes!("rate_nv.frag.spv")),
        };
        let stage = |stage, module| {
            vk::PipelineShaderStageCreateInfo::default()
                .stage(stage)
                .module(module)
                .name(c"main")
        };
        let stages = [
            stage(vk::ShaderStageFlags::VERTEX, vertex),
            stage(vk::ShaderStageFlags::FRAGMENT, fragment),
        ];
        let input = vk::PipelineVertexInputStateCreateInfo::default();
        let assembly = vk::PipelineInputAssemblyStateCreateInfo::default()
            .topology(vk::PrimitiveTopology::TRIANGLE_LIST);
        let viewports = [vk::Viewport {
            width: width as f32,
            height: height as f32,
            max_depth: 1.0,
            ..vk::Viewport::default()
        }];
        let scissors = [area([width, height])];
        let entries =
            PALETTE.map(|entry| vk::ShadingRatePaletteEntryNV::from_raw(i32::from(entry.vulkan)));
        let palettes = [vk::ShadingRatePaletteNV::default().shading_rate_palette_entries(&entries)];
        let mut palette = vk::PipelineViewportShadingRateImageStateCreateInfoNV::default()
            .shading_rate_image_enable(true)
            .shading_rate_palettes(&palettes);
        let viewport = vk::PipelineViewportStateCreateInfo::default()
            .viewports(&viewports)
            .scissors(&scissors);
        let viewport = match self.extension {
            Extension::Khr => viewport,
            Extension::Nv => viewport.push_next(&mut palette),
        };
        let raster = vk::PipelineRasterizationStateCreateInfo::default().line_width(1.0);
        let multisample = vk::PipelineMultisampleStateCreateInfo::default()
            .rasterization_samples(vk::SampleCountFlags::from_raw(samples));
        let blends = [vk::PipelineColorBlendAttachmentState::default()
            .color_write_mask(vk::ColorComponentFlags::RGBA)];
        let blend = vk::PipelineColorBlendStateCreateInfo::default().attachments(&blends);
        let formats = [FORMAT];
        let mut rendering =
            vk::PipelineRenderingCreateInfo::default().color_attachment_formats(&formats);
        let mut rate = vk::PipelineFragmentShadingRateStateCreateInfoKHR::default()
            .fragment_size(vk::Extent2D {
                width: 1,
                height: 1,
            })
            .combiner_ops([
                vk::FragmentShadingRateCombinerOpKHR::KEEP,
                vk::FragmentShadingRateCombinerOpKHR::REPLACE,
            ]);
        // SAFETY: the device is alive, and every structure outlives the calls.
        unsafe {
            let layout = vk::PipelineLayoutCreateInfo::default();
            let layout = self
                .device
                .create_pipeline_layout(&layout, None)
                .expect("a layout");
            let info = vk::GraphicsPipelineCreateInfo::default()
                .stages(&stages)
                .vertex_input_state(&input)
                .input_assembly_state(&assembly)
                .viewport_state(&viewport)
                .rasterization_state(&raster)
                .multisample_state(&multisample)
                .color_blend_state(&blend)
                .layout(layout)
                .push_next(&mut rendering);
            let info = match self.extension {
                Extension::Khr => info
                    .push_next(&mut rate)
                    .flags(vk::PipelineCreateFlags::RENDERING_FRAGMENT_SHADING_RATE_ATTACHMENT_KHR),
                Extension::Nv => info,
            };
            self.device
                .create_graphics_pipelines(vk::PipelineCache::null(), &[info], None)
                .expect("a pipeline")[0]
        }
    }

    /// Draws over a picture of a size at a sample count, and reads what every pixel saw: its first sample.
    pub fn draw(&self, size: [u32; 2], samples: u32, rates: &Rates) -> Vec<Seen> {
        let [width, height] = size;
        let pipeline = self.pipeline(size, samples);
        let (image, view) = self.image(
            RATES,
            rates.size,
            1,
            // Vulkan NV's SHADING_RATE_IMAGE is the same bit
            vk::ImageUsageFlags::FRAGMENT_SHADING_RATE_ATTACHMENT_KHR
                | vk::ImageUsageFlags::TRANSFER_DST,
        );
        let (upload, bytes) = self.buffer(
            rates.texels.len() as u64,
            vk::BufferUsageFlags::TRANSFER_SRC,
        );
        let target = vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::TRANSFER_SRC;
        let (picture, picture_view) = self.image(FORMAT, size, 1, target);
        let many = (samples > 1).then(|| self.image(FORMAT, size, samples, target));
        let length = (width * height * 4) as usize;
        let (download, words) = self.buffer(length as u64 * 4, vk::BufferUsageFlags::TRANSFER_DST);

        let clear = vk::ClearValue {
            color: vk::ClearColorValue {
                uint32: [UNTOUCHED; 4],
            },
        };
        let color = vk::RenderingAttachmentInfo::default()
            .image_layout(vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL)
            .load_op(vk::AttachmentLoadOp::CLEAR)
            .store_op(vk::AttachmentStoreOp::STORE)
            .clear_value(clear);
        let color = match many {
            None => color.image_view(picture_view),
            Some((_, view)) => color
                .image_view(view)
                .resolve_mode(vk::ResolveModeFlags::SAMPLE_ZERO)
                .resolve_image_view(picture_view)
                .resolve_image_layout(vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL),
        };
        let colors = [color];
        let mut attached = vk::RenderingFragmentShadingRateAttachmentInfoKHR::default()
            .image_view(view)
            .image_layout(vk::ImageLayout::FRAGMENT_SHADING_RATE_ATTACHMENT_OPTIMAL_KHR)
            .shading_rate_attachment_texel_size(vk::Extent2D {
                width: rates.tile,
                height: rates.tile,
            });
        let rendering = vk::RenderingInfo::default()
            .render_area(area(size))
            .layer_count(1)
            .color_attachments(&colors);
        let rendering = match self.extension {
            Extension::Khr => rendering.push_next(&mut attached),
            Extension::Nv => rendering,
        };
        // SAFETY: all handles are of this device and alive; the upload is as long as its buffer; the device is idle before
        // the download is read; every structure outlives the calls.
        unsafe {
            let (device, commands) = (&self.device, self.commands);
            bytes.copy_from_nonoverlapping(rates.texels.as_ptr(), rates.texels.len());
            let begin = vk::CommandBufferBeginInfo::default()
                .flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
            device
                .begin_command_buffer(commands, &begin)
                .expect("begun");
            let undefined = vk::ImageLayout::UNDEFINED;
            let color_layout = vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL;
            self.barrier(image, undefined, vk::ImageLayout::TRANSFER_DST_OPTIMAL);
            self.barrier(picture, undefined, color_layout);
            if let Some((image, _)) = many {
                self.barrier(image, undefined, color_layout);
            }
            let copy = vk::BufferImageCopy::default()
                .buffer_row_length(rates.pitch)
                .image_subresource(LAYER)
                .image_extent(extent(rates.size));
            let to = vk::ImageLayout::TRANSFER_DST_OPTIMAL;
            device.cmd_copy_buffer_to_image(commands, upload, image, to, &[copy]);
            let rate_layout = vk::ImageLayout::FRAGMENT_SHADING_RATE_ATTACHMENT_OPTIMAL_KHR;
            self.barrier(image, to, rate_layout);
            device.cmd_begin_rendering(commands, &rendering);
            device.cmd_bind_pipeline(commands, vk::PipelineBindPoint::GRAPHICS, pipeline);
            if let Some(binder) = &self.binder {
                (binder.fp().cmd_bind_shading_rate_image_nv)(commands, view, rate_layout);
            }
            device.cmd_draw(commands, 3, 1, 0, 0);
            device.cmd_end_rendering(commands);
            let from = vk::ImageLayout::TRANSFER_SRC_OPTIMAL;
            self.barrier(picture, color_layout, from);
            let copy = vk::BufferImageCopy::default()
                .image_subresource(LAYER)
                .image_extent(extent(size));
            device.cmd_copy_image_to_buffer(commands, picture, from, download, &[copy]);
            device.end_command_buffer(commands).expect("ended");
            let list = [commands];
            let submit = [vk::SubmitInfo::default().command_buffers(&list)];
            device
                .queue_submit(self.queue, &submit, vk::Fence::null())
                .expect("submitted");
            device.device_wait_idle().expect("done");
            let words = std::slice::from_raw_parts(words.cast::<u32>(), length);
            words
                .chunks_exact(4)
                .map(|pixel| Seen {
                    word: pixel[0],
                    centre: [pixel[1], pixel[2]],
                })
                .collect()
        }
    }

    /// Everything before is done, and the image has its new layout, before anything after starts.
    fn barrier(&self, image: vk::Image, old: vk::ImageLayout, new: vk::ImageLayout) {
        let barrier = vk::ImageMemoryBarrier::default()
            .image(image)
            .old_layout(old)
            .new_layout(new)
            .src_access_mask(vk::AccessFlags::MEMORY_WRITE)
            .dst_access_mask(vk::AccessFlags::MEMORY_READ | vk::AccessFlags::MEMORY_WRITE)
            .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .subresource_range(WHOLE);
        // SAFETY: the commands are being recorded, outside of rendering, and the image is alive.
        unsafe {
            self.device.cmd_pipeline_barrier(
                self.commands,
                vk::PipelineStageFlags::ALL_COMMANDS,
                vk::PipelineStageFlags::ALL_COMMANDS,
                vk::DependencyFlags::empty(),
                &[],
                &[],
                &[barrier],
            );
        }
    }
}

const WHOLE: vk::ImageSubresourceRange = vk::ImageSubresourceRange {
    aspect_mask: vk::ImageAspectFlags::COLOR,
    base_mip_level: 0,
    level_count: 1,
    base_array_layer: 0,
    layer_count: 1,
};

const LAYER: vk::ImageSubresourceLayers = vk::ImageSubresourceLayers {
    aspect_mask: vk::ImageAspectFlags::COLOR,
    mip_level: 0,
    base_array_layer: 0,
    layer_count: 1,
};

fn extent([width, height]: [u32; 2]) -> vk::Extent3D {
    vk::Extent3D {
        width,
        height,
        depth: 1,
    }
}

fn area([width, height]: [u32; 2]) -> vk::Rect2D {
    vk::Rect2D {
        offset: vk::Offset2D::default(),
        extent: vk::Extent2D { width, height },
    }
}

/// The sample counts, as bits, that a picture of the shaders' format can have.
pub fn sample_counts(instance: &ash::Instance, physical: vk::PhysicalDevice) -> u32 {
    // SAFETY: the instance and the physical device are alive.
    let format = unsafe {
        instance.get_physical_device_image_format_properties(
            physical,
            FORMAT,
            vk::ImageType::TYPE_2D,
            vk::ImageTiling::OPTIMAL,
            vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::TRANSFER_SRC,
            vk::ImageCreateFlags::empty(),
        )
    };
    format.map_or(1, |format| format.sample_counts.as_raw())
}
