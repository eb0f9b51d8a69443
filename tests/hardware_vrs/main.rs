//! Hardware variable-rate shading, where a device has it: a triangle is drawn over a picture with our attachment, the fragment
//! shader writes the rate that it sees, and the picture equals what `vrcs::attach` says, for every code, tile size and sample
//! count that the device offers.
//!
//! Every device that the Vulkan loader finds is tried. What cannot be run is named on standard output, with the reason.
//! NOTES.md has what was seen on real devices.

mod device;

use std::ffi::CStr;

use ash::{khr, nv, vk};
use device::{Device, Extension, Rates, Seen, UNTOUCHED, sample_counts};
use fastrand::Rng;
use vrcs::{
    Rate,
    attach::{
        AttachOptions, Encoding, PALETTE, Samples, Shading, Support, Tile, cpu::attach,
        palette_index,
    },
    sri::Sri,
};

/// Partial tiles on both edges, whatever the tile.
const SIZE: [u32; 2] = [203, 117];

struct Found {
    physical: vk::PhysicalDevice,
    name: String,
}

/// The instance, which lives as long as the process, and its devices; the reason if there is none.
fn instance() -> Result<(ash::Entry, ash::Instance, Vec<Found>), String> {
    let application = vk::ApplicationInfo::default().api_version(vk::API_VERSION_1_3);
    let info = vk::InstanceCreateInfo::default().application_info(&application);
    // SAFETY: the loader is the system's own; the structures outlive the calls.
    unsafe {
        let entry = ash::Entry::load().map_err(|error| format!("no Vulkan loader: {error}"))?;
        let instance = entry
            .create_instance(&info, None)
            .map_err(|error| format!("no Vulkan driver: {error}"))?;
        let devices = instance.enumerate_physical_devices().unwrap_or_default();
        let found = devices
            .into_iter()
            .map(|physical| {
                let properties = instance.get_physical_device_properties(physical);
                let name = properties.device_name_as_c_str().unwrap_or(c"?");
                Found {
                    physical,
                    name: name.to_string_lossy().into_owned(),
                }
            })
            .collect();
        Ok((entry, instance, found))
    }
}

/// Why a device cannot be drawn with by an extension.
fn missing(instance: &ash::Instance, found: &Found, extension: &CStr) -> Option<String> {
    // SAFETY: the instance and the device are alive.
    let (properties, extensions) = unsafe {
        (
            instance.get_physical_device_properties(found.physical),
            instance.enumerate_device_extension_properties(found.physical),
        )
    };
    if properties.api_version < vk::API_VERSION_1_3 {
        return Some("it has no Vulkan 1.3".to_owned());
    }
    let has = extensions
        .unwrap_or_default()
        .iter()
        .any(|offered| offered.extension_name_as_c_str() == Ok(extension));
    (!has).then(|| format!("it does not offer {}", extension.to_string_lossy()))
}

fn skip(found: &str, extension: Extension, why: &str) {
    println!("skipped: {extension:?} on {found}: {why}");
}

/// Pictures to draw: each rate everywhere, then mosaics in which every tile has its own, then single quads of noise.
fn images(tile: Tile, rng: &mut Rng) -> Vec<(String, Sri)> {
    let codes = Rate::ALL.map(Rate::code);
    let uniform = Rate::ALL.map(|rate| {
        (
            format!("{rate} everywhere"),
            Sri::uniform(SIZE[0], SIZE[1], rate),
        )
    });
    let quads = tile.side() / 2;
    let mosaics = (0..4).map(|number| {
        let of_tile: Vec<u8> = (0..64 * 64).map(|_| codes[rng.usize(..7)]).collect();
        let sri = Sri::from_fn(SIZE[0], SIZE[1], |x, y| {
            of_tile[(y / quads * 64 + x / quads) as usize]
        });
        (format!("mosaic {number}"), sri)
    });
    let mut images: Vec<_> = uniform.into_iter().chain(mosaics).collect();
    let noise = Sri::from_fn(SIZE[0], SIZE[1], |_, _| match rng.u32(..60) {
        0 => codes[rng.usize(..7)],
        _ => Rate::R4X4.code(),
    });
    images.push(("noise".to_owned(), noise));
    images
}

/// What a shader has to see.
fn word_of(extension: Extension, shading: Shading) -> u32 {
    match (extension, shading) {
        (Extension::Khr, Shading::Coarse(rate)) => u32::from(rate.code()),
        (Extension::Nv, Shading::Coarse(rate)) => rate.width() | rate.height() << 4 | 1 << 8,
        (Extension::Nv, Shading::Supersampled(times)) => 1 | 1 << 4 | times.count() << 8,
        (_, Shading::Cull) => UNTOUCHED,
        (Extension::Khr, Shading::Supersampled(_)) => unreachable!("KHR has none"),
    }
}

/// Draws an image of rates and compares every pixel with the CPU's model. The number of pixels whose coarse pixel lies on
/// the grid that starts at the picture's corner; the first difference if there is one.
fn draw_and_compare(
    device: &Device,
    extension: Extension,
    options: &AttachOptions,
    name: &str,
    sri: &Sri,
) -> Result<usize, String> {
    let attachment = attach(sri, SIZE, options);
    let layout = attachment.layout();
    let seen = device.draw(
        SIZE,
        options.samples.count(),
        &Rates {
            texels: attachment.bytes(),
            size: [layout.width, layout.height],
            pitch: layout.pitch,
            tile: options.tile.side(),
        },
    );
    let mut on_grid = 0;
    for (index, seen) in seen.into_iter().enumerate() {
        let (x, y) = (index as u32 % SIZE[0], index as u32 / SIZE[0]);
        let shading = attachment.shading_at(x, y);
        let wanted = word_of(extension, shading);
        if seen.word != wanted {
            return Err(format!(
                "{name}, pixel {x},{y}: {:#x} was seen, {shading:?} is {wanted:#x}",
                seen.word
            ));
        }
        on_grid += usize::from(is_on_grid(shading, [x, y], seen));
    }
    Ok(on_grid)
}

/// Draws many images with the same options, and tells how it went. The number of images that differ.
fn draw_all(
    device: &Device,
    found: &Found,
    extension: Extension,
    options: &AttachOptions,
    rng: &mut Rng,
) -> usize {
    let what = format!(
        "{extension:?} on {}: tile {}, {} samples, {:?}",
        found.name,
        options.tile.side(),
        options.samples.count(),
        options.encoding
    );
    let images = images(options.tile, rng);
    let (mut on_grid, mut differing) = (0, 0);
    for (name, sri) in &images {
        match draw_and_compare(device, extension, options, name, sri) {
            Ok(count) => on_grid += count,
            Err(why) => {
                println!("failed: {what}: {why}");
                differing += 1;
            }
        }
    }
    let pixels = (images.len() - differing) * (SIZE[0] * SIZE[1]) as usize;
    println!(
        "{} of {} pictures equal: {what}; {on_grid} of {pixels} pixels on the grid",
        images.len() - differing,
        images.len()
    );
    differing
}

/// Whether the pixel's coarse pixel is the one of a grid from the picture's corner.
fn is_on_grid(shading: Shading, pixel: [u32; 2], seen: Seen) -> bool {
    let Shading::Coarse(rate) = shading else {
        return true;
    };
    let size = [rate.width(), rate.height()];
    (0..2).all(|axis| {
        let first = pixel[axis] / size[axis] * size[axis];
        seen.centre[axis] == first * 2 + size[axis]
    })
}

fn seed() -> Rng {
    let seed = std::env::var("VRCS_SEED").map_or(1, |seed| seed.parse().expect("a number"));
    println!("VRCS_SEED={seed}");
    Rng::with_seed(seed)
}

#[test]
fn fragments_see_the_rates_of_a_khr_attachment() {
    let (_entry, instance, devices) = match instance() {
        Ok(instance) => instance,
        Err(why) => return skip("this machine", Extension::Khr, &why),
    };
    let mut rng = seed();
    for found in devices {
        if let Some(why) = missing(&instance, &found, khr::fragment_shading_rate::NAME) {
            skip(&found.name, Extension::Khr, &why);
            continue;
        }
        khr_on(&instance, &found, &mut rng);
    }
}

fn khr_on(instance: &ash::Instance, found: &Found, rng: &mut Rng) {
    let mut features = vk::PhysicalDeviceFragmentShadingRateFeaturesKHR::default();
    let mut limits = vk::PhysicalDeviceFragmentShadingRatePropertiesKHR::default();
    // SAFETY: the device is alive and offers the extension, and the chains outlive the calls.
    unsafe {
        let mut all = vk::PhysicalDeviceFeatures2::default().push_next(&mut features);
        instance.get_physical_device_features2(found.physical, &mut all);
        let mut all = vk::PhysicalDeviceProperties2::default().push_next(&mut limits);
        instance.get_physical_device_properties2(found.physical, &mut all);
    }
    println!("{}: {features:?}", found.name);
    println!("{}: {limits:?}", found.name);
    if features.attachment_fragment_shading_rate == 0 {
        return skip(
            &found.name,
            Extension::Khr,
            "attachmentFragmentShadingRate is false",
        );
    }
    let listed = listed_rates(instance, found);
    for (size, counts) in &listed {
        println!(
            "{}: {}x{} at sample counts {counts:#b}",
            found.name, size[0], size[1]
        );
    }
    let support = Support::vulkan(listed);
    let device = match Device::new(instance, found.physical, Extension::Khr) {
        Ok(device) => device,
        Err(why) => return skip(&found.name, Extension::Khr, &why),
    };
    let least = limits.min_fragment_shading_rate_attachment_texel_size;
    let most = limits.max_fragment_shading_rate_attachment_texel_size;
    let drawable = sample_counts(instance, found.physical);
    let mut differing = 0;
    for tile in Tile::ALL {
        let side = tile.side();
        let fits = (least.width..=most.width).contains(&side)
            && (least.height..=most.height).contains(&side);
        if !fits {
            println!("skipped: tile {side} on {}: it is not offered", found.name);
            continue;
        }
        for samples in Samples::ALL {
            if drawable & samples.count() == 0 {
                continue;
            }
            let options = AttachOptions {
                tile,
                encoding: Encoding::Khr,
                support: support.clone(),
                samples,
            };
            differing += draw_all(&device, found, Extension::Khr, &options, rng);
        }
    }
    assert_eq!(differing, 0, "pictures differ");
}

/// `vkGetPhysicalDeviceFragmentShadingRatesKHR`.
fn listed_rates(instance: &ash::Instance, found: &Found) -> Vec<([u32; 2], u32)> {
    // SAFETY: the loader has the entry point, as the device offers the extension; the second call gets as many structures
    // as the first one counted.
    unsafe {
        let entry = ash::Entry::load().expect("a Vulkan loader");
        let name = c"vkGetPhysicalDeviceFragmentShadingRatesKHR";
        let function = entry
            .get_instance_proc_addr(instance.handle(), name.as_ptr())
            .expect("the function of the extension");
        let list: vk::PFN_vkGetPhysicalDeviceFragmentShadingRatesKHR =
            std::mem::transmute(function);
        let mut count = 0;
        let status = list(found.physical, &mut count, std::ptr::null_mut());
        assert_eq!(status, vk::Result::SUCCESS);
        let mut rates = vec![vk::PhysicalDeviceFragmentShadingRateKHR::default(); count as usize];
        let status = list(found.physical, &mut count, rates.as_mut_ptr());
        assert_eq!(status, vk::Result::SUCCESS);
        rates
            .iter()
            .map(|rate| {
                let size = rate.fragment_size;
                ([size.width, size.height], rate.sample_counts.as_raw())
            })
            .collect()
    }
}

#[test]
fn fragments_see_the_rates_of_an_nv_shading_rate_image() {
    let (_entry, instance, devices) = match instance() {
        Ok(instance) => instance,
        Err(why) => return skip("this machine", Extension::Nv, &why),
    };
    let mut rng = seed();
    for found in devices {
        if let Some(why) = missing(&instance, &found, nv::shading_rate_image::NAME) {
            skip(&found.name, Extension::Nv, &why);
            continue;
        }
        nv_on(&instance, &found, &mut rng);
    }
}

fn nv_on(instance: &ash::Instance, found: &Found, rng: &mut Rng) {
    let mut limits = vk::PhysicalDeviceShadingRateImagePropertiesNV::default();
    let mut all = vk::PhysicalDeviceProperties2::default().push_next(&mut limits);
    // SAFETY: the device is alive and offers the extension, and the chain outlives the call.
    unsafe { instance.get_physical_device_properties2(found.physical, &mut all) };
    println!("{}: {limits:?}", found.name);
    let texel = limits.shading_rate_texel_size;
    let Some(tile) = Tile::new(texel.width).filter(|_| texel.width == texel.height) else {
        return skip(&found.name, Extension::Nv, "its tile is none of ours");
    };
    let device = match Device::new(instance, found.physical, Extension::Nv) {
        Ok(device) => device,
        Err(why) => return skip(&found.name, Extension::Nv, &why),
    };
    // what the hardware has at a sample count, it lists for Vulkan KHR only
    let support = match missing(instance, found, khr::fragment_shading_rate::NAME) {
        None => Support::vulkan(listed_rates(instance, found)),
        Some(_) => Support::nv(limits.shading_rate_max_coarse_samples),
    };
    let drawable = sample_counts(instance, found.physical);
    let mut differing = 0;
    for samples in Samples::ALL {
        if drawable & samples.count() == 0 {
            continue;
        }
        let encodings = [
            Encoding::Nv,
            Encoding::NvSupersampled(Samples::X2),
            Encoding::NvSupersampled(Samples::X16),
        ];
        for encoding in encodings {
            let options = AttachOptions {
                tile,
                encoding,
                support: support.clone(),
                samples,
            };
            differing += draw_all(&device, found, Extension::Nv, &options, rng);
        }
        cull(&device, tile, samples);
        raw_palette(&device, found, tile, samples);
    }
    assert_eq!(differing, 0, "pictures differ");
}

/// What the hardware makes of each entry of the palette, whether it supports it or not: never anything coarser.
fn raw_palette(device: &Device, found: &Found, tile: Tile, samples: Samples) {
    let side = tile.side();
    let size = SIZE.map(|length| length.div_ceil(side));
    let pitch = size[0].next_multiple_of(256);
    for entry in &PALETTE[1..] {
        let rates = Rates {
            texels: &vec![entry.vulkan; (pitch * size[1]) as usize],
            size,
            pitch,
            tile: side,
        };
        let seen = device.draw(SIZE, samples.count(), &rates);
        let word = seen[0].word;
        assert!(seen.iter().all(|seen| seen.word == word), "{entry:?}");
        let (width, height, times) = (word & 15, word >> 4 & 15, word >> 8);
        println!(
            "{}: {} samples, {:?}: {width}x{height}, {times} invocations for each pixel",
            found.name,
            samples.count(),
            entry.shading,
        );
        let asked = match entry.shading {
            Shading::Coarse(rate) => rate,
            _ => Rate::R1X1,
        };
        assert!(width <= asked.width() && height <= asked.height());
    }
}

/// Tiles whose texel is the index of the cull entry stay untouched, and only they.
fn cull(device: &Device, tile: Tile, samples: Samples) {
    let side = tile.side();
    let size = SIZE.map(|length| length.div_ceil(side));
    let pitch = size[0].next_multiple_of(256);
    let full = palette_index(Shading::Coarse(Rate::R1X1));
    let mut texels = vec![full; (pitch * size[1]) as usize];
    for (x, y) in (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y))) {
        if (x + y) % 2 == 1 {
            texels[(y * pitch + x) as usize] = palette_index(Shading::Cull);
        }
    }
    let rates = Rates {
        texels: &texels,
        size,
        pitch,
        tile: side,
    };
    let seen = device.draw(SIZE, samples.count(), &rates);
    for (index, seen) in seen.into_iter().enumerate() {
        let (x, y) = (index as u32 % SIZE[0], index as u32 / SIZE[0]);
        let is_culled = (x / side + y / side) % 2 == 1;
        assert_eq!(
            seen.word == UNTOUCHED,
            is_culled,
            "pixel {x},{y}, {samples:?}"
        );
    }
}
