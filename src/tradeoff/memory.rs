//! Whether pictures fit into memory, before any is made.
//!
//! *Does*: reckons what a study holds at once, and knows a device's complaint when it sees one. *Guarantees*: the refusal says
//! the size and the bytes. *Refuses*: on a software driver, whose memory is the machine's, what is not there.

use super::Trouble;
use crate::check::gpu::{Gpu, GpuError};

/// Bytes for each pixel of a scene's textures, the finished picture's poison and its read-back among them.
const OF_A_SCENE: u64 = 80;
/// Bytes for each pixel of a setting at work: the picture and depth before, coordinates and lists, rates.
const OF_A_SETTING: u64 = 36;

/// What a study of pictures of this size holds at once, in bytes, with so many settings that are timed together.
pub fn needed(size: [u32; 2], together: usize) -> u64 {
    let pixels = u64::from(size[0]) * u64::from(size[1]);
    pixels * (OF_A_SCENE + OF_A_SETTING * together as u64)
}

/// What the machine has left, in bytes, where it says so (Linux).
fn available() -> Option<u64> {
    parse(&std::fs::read_to_string("/proc/meminfo").ok()?)
}

fn parse(text: &str) -> Option<u64> {
    let line = text.lines().find_map(|l| l.strip_prefix("MemAvailable:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kibibytes * 1024)
}

/// Refuses what a software driver's machine has no memory for. What a GPU has, nobody knows before it refuses.
///
/// # Errors
/// If there is too little.
pub fn check(gpu: &Gpu, size: [u32; 2], together: usize) -> Result<(), Trouble> {
    let bytes = needed(size, together);
    match available() {
        Some(left) if gpu.is_software() && left < bytes => Err(too_little(gpu, size, bytes)),
        _ => Ok(()),
    }
}

/// Puts the size and the bytes to a device's complaint about memory; leaves every other as it is.
pub fn explained(trouble: Trouble, gpu: &Gpu, size: [u32; 2], together: usize) -> Trouble {
    let is_memory = match &trouble {
        Trouble::Gpu(GpuError::Refused(why)) => tells_of_memory(why),
        Trouble::Stage(error) => tells_of_memory(&error.why),
        Trouble::Own(why) => tells_of_memory(why),
        _ => false,
    };
    match is_memory {
        true => too_little(gpu, size, needed(size, together)),
        false => trouble,
    }
}

fn tells_of_memory(why: &str) -> bool {
    let why = why.to_lowercase();
    ["out of memory", "not enough memory", "out_of_memory"]
        .iter()
        .any(|told| why.contains(told))
}

fn too_little(gpu: &Gpu, size: [u32; 2], bytes: u64) -> Trouble {
    Trouble::Memory {
        adapter: gpu.info.name.clone(),
        size,
        gibibytes: bytes as f64 / (1u64 << 30) as f64,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_pixels_and_more_settings_need_more() {
        assert_eq!(needed([1, 1], 0), OF_A_SCENE);
        assert!(needed([1920, 1080], 9) > needed([1920, 1080], 1));
        assert!(needed([3840, 2160], 1) > 3 * needed([1920, 1080], 1));
    }

    #[test]
    fn what_linux_says_is_read_in_bytes() {
        let text = "MemTotal:       24000000 kB\nMemAvailable:    1000 kB\n";
        assert_eq!(parse(text), Some(1_024_000));
        assert_eq!(parse("MemTotal: 4 kB\n"), None);
    }

    #[test]
    fn only_a_complaint_about_memory_is_taken_for_one() {
        assert!(tells_of_memory(
            "In Device::create_texture: Not enough memory left."
        ));
        assert!(!tells_of_memory(
            "Dimension X value 99999 exceeds the limit of 16384"
        ));
    }
}
