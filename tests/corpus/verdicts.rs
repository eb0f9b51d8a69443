//! What somebody who has read the shader says of each refusal.

/// Entry points, and the target that they read nowhere where another pixel stores, as somebody who has read them can say.
pub const WORDS: &[(&str, &str)] = &[("dof_gather", "dof"), ("dof_post", "dof")];

/// Of a crate, a file (its end) and entry points (`*` for all of the file's): why the refusal is right, or what would make it
/// a rewrite.
pub const VERDICTS: &[(&str, &str, &[&str], &str)] = &[
    (
        "bevy_core_pipeline",
        "downsample_depth.wgsl",
        &["*"],
        "right: a mip chain through workgroup memory, four texels an invocation; no pixel of its own",
    ),
    (
        "bevy_core_pipeline",
        "mip_generation/downsample.wgsl",
        &["*"],
        "right: a mip chain through workgroup memory, four texels an invocation; no pixel of its own",
    ),
    (
        "bevy_eulerian_fluid",
        "sample_forces.wgsl",
        &["*"],
        "right: sums forces into bins, one for each solid, by atomics",
    ),
    (
        "bevy_eulerian_fluid",
        "reseed_particles.wgsl",
        &["*"],
        "right: each cell marks particles that a heap picks",
    ),
    (
        "bevy_eulerian_fluid",
        "update.wgsl",
        &["*"],
        "right: an iteration in place reads its neighbours",
    ),
    (
        "bevy_eulerian_fluid",
        "extrapolate_u.wgsl",
        &["*"],
        "right: reads beside it what other cells write; that they are told apart by data (which cells are valid) does not help, since a copy goes where its own pixel's data would not let it",
    ),
    (
        "bevy_eulerian_fluid",
        "extrapolate_v.wgsl",
        &["*"],
        "right: reads beside it what other cells write; that they are told apart by data (which cells are valid) does not help, since a copy goes where its own pixel's data would not let it",
    ),
    (
        "bevy_eulerian_fluid",
        "extrapolate_velocity.wgsl",
        &["*"],
        "right: reads at the surface what other cells write",
    ),
    (
        "bevy_pbr",
        "multiscattering_lut.wgsl",
        &["*"],
        "right: 64 invocations sum up one texel, so a primary would be a workgroup; everything takes an invocation for a pixel so far: the prologue finds an entry by its \
         lane, the builder's indirect arguments count a group's entries, the tile of a shader with barriers is its workgroup, and the check logs by invocation",
    ),
    (
        "bevy_pbr",
        "preprocess_depth.wgsl",
        &["*"],
        "right: a mip chain through workgroup memory",
    ),
    (
        "bevy_solari",
        "restir_gi.wgsl",
        &["initial_and_temporal"],
        "right: claims cells of a hash table by compare-and-exchange",
    ),
    (
        "bevy_solari",
        "specular_gi.wgsl",
        &["*"],
        "right: claims cells of a hash table by compare-and-exchange",
    ),
    (
        "blade-render",
        "fill-gbuf.wgsl",
        &["*"],
        "right by default: the pixel under the mouse notes what it hit, and lines for debugging are appended by an atomic whose result is used; the policy `full` for `debug_buf` would do",
    ),
    (
        "kiss3d",
        "rt_kernel.wgsl",
        &["*"],
        "right by default: it uses all the storage buffers that WebGPU promises; with `--max-storage-buffers 9` it is rewritten",
    ),
    (
        "cuneus",
        "synth.wgsl",
        &["*"],
        "right: delay lines of sound, read at other places than written",
    ),
    (
        "cuneus",
        "pinscreen.wgsl",
        &["dof_gather", "dof_post"],
        "right as far as can be proved: reads one third of a buffer and writes another; that a third holds half the picture's pixels follows from `dims.x * dims.y <= MAXPIX` only for textures that are not much wider than high; with `--apart dof` it is rewritten",
    ),
    (
        "cuneus",
        "gaussian.wgsl",
        &["render_display"],
        "right: trains while it draws, adding gradients up by atomics",
    ),
    (
        "cuneus",
        "lich.wgsl",
        &["splat"],
        "right by default: scatters by atomics",
    ),
    (
        "cuneus",
        "physarum.wgsl",
        &["*"],
        "right: agents that scatter by atomics",
    ),
    (
        "cuneus",
        "src/mesh/instances.wgsl",
        &["*"],
        "right: appends by an atomic",
    ),
    (
        "vello_shaders",
        "coarse.wgsl",
        &["*"],
        "right: bins, in workgroup memory",
    ),
    (
        "vello_shaders",
        "fine.wgsl",
        &["*"],
        "right: spills blend state into memory that it allocates, in a loop",
    ),
    (
        "viewport-lib",
        "exposure.wgsl",
        &["build_main"],
        "right by default: counts into a histogram by atomics",
    ),
    (
        "viewport-lib",
        "hiz_reproject.wgsl",
        &["scatter"],
        "right by default: scatters depths to where they are seen from now, by atomics",
    ),
    (
        "bevy-volumetric-clouds",
        "clouds_compute.wgsl",
        &["update"],
        "right: last frame's camera stands in four texels of the picture that it writes, and last frame's colour is read where the camera saw it",
    ),
    (
        "bevy_elements",
        "clouds/shadow.wesl",
        &["*"],
        "right by default: one in sixteen writes a coarse map, too, of what all have computed; the policy `full` for `coarse` would do, and save nothing",
    ),
    (
        "bevy_elements",
        "clouds/weather.wesl",
        &["cloud_field"],
        "right: counts into a histogram by atomics",
    ),
    (
        "bevy_elements",
        "hydrology/substep.wesl",
        &["*"],
        "right by default: it uses all the storage buffers that WebGPU promises; with `--max-storage-buffers 9` it is rewritten",
    ),
    (
        "bevy_elements",
        "trails/trails.wesl",
        &["trail_stamp"],
        "right by default: bodies leave their tracks by atomics; with `--atomics weight` it is rewritten",
    ),
    (
        "bevy_elements",
        "trails/trails.wesl",
        &["trail_readback"],
        "right: the first invocation writes a head of four numbers into the buffer that all write",
    ),
    (
        "bevy_elements",
        "waves/waves.wesl",
        &["wave_head"],
        "right by default: bodies push the water by atomics; with `--atomics weight` it is rewritten",
    ),
    (
        "bevy_elements",
        "waves/waves.wesl",
        &["wave_step"],
        "right as far as can be proved: four texels of a window on a torus, of which a mask and an origin that is read for each cascade tell where they stand",
    ),
    (
        "fidget-wgpu",
        "shaders/interval_root.wgsl",
        &["*"],
        "right: tiles that are neither empty nor full go into a list, by an atomic whose result is used",
    ),
    (
        "fidget-wgpu",
        "shaders/interval_tiles.wgsl",
        &["*"],
        "right: tiles that are neither empty nor full go into a list, by an atomic whose result is used",
    ),
    (
        "fidget-wgpu",
        "pixel/shaders/pixel_tiles.wgsl",
        &["*"],
        "right as far as can be proved: groups take tiles from a list until it is empty; that no tile stands there twice the shader does not say",
    ),
    (
        "fidget-wgpu",
        "voxel/shaders/merge.wgsl",
        &["*"],
        "right: reads the pixels beside it to see whether a tile is full, a race that its author means to have",
    ),
    (
        "fidget-wgpu",
        "voxel/shaders/repack.wgsl",
        &["*"],
        "right: appends to lists by atomics",
    ),
    (
        "fidget-wgpu",
        "voxel/shaders/sort.wgsl",
        &["*"],
        "right: sorts by atomics",
    ),
    (
        "fidget-wgpu",
        "voxel/shaders/voxel_tiles.wgsl",
        &["*"],
        "right: several invocations of a column race for its highest voxel, by atomics, and look how far the others are",
    ),
    (
        "slime-mold",
        "compute.wgsl",
        &["main"],
        "right: agents that read the trails that others leave",
    ),
    (
        "slime-mold",
        "compute.wgsl",
        &["diffuse_trail"],
        "right: diffuses in place, reading its neighbours while they change",
    ),
    (
        "tessera-ui-basic-components",
        "mean.wgsl",
        &["*"],
        "right by default: sums up luminance by atomics, inside of an area alone; the policy `full` for `result` would do",
    ),
    (
        "threers",
        "pathtrace.wgsl",
        &["*"],
        "right: the pixels of a workgroup share out their samples, and whether a pixel has enough, which stands in the buffer that it writes, goes into workgroup memory",
    ),
];

/// The verdict on a refusal.
pub fn of(package: &str, file: &str, entry: &str) -> Option<&'static str> {
    VERDICTS
        .iter()
        .find(|(of, end, entries, _)| {
            package.split(' ').next() == Some(of)
                && file.ends_with(end)
                && entries.iter().any(|name| *name == "*" || *name == entry)
        })
        .map(|(_, _, _, verdict)| *verdict)
}
