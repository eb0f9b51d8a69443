//! The crates whose shaders are the corpus, and how their files are put together.
//!
//! The rule, so that nobody chooses by the result: a crate of crates.io that somebody comes upon, looking for compute shaders, goes in
//! if its files of WGSL or WESL are read (as they are, or as its own build and renderer [put them together](super::prepare)) and one of
//! their entry points is a [screen-space](super::screen) one; all of its compute files come with it, whatever becomes of them.
//!
//! Looked at, and left out by that rule (December 2026): bevy_gaussian_splatting, bevy_hanabi and rend3-routine (particles, sorts and
//! culling: nothing per pixel), forma-render (its painter shadows names in one scope, which is no WGSL any more), gpgpu (`[[stage(compute)]]`), wonnx
//! (templates), and alpha2-shaders, bevy_water, cranpose-ui-graphics, nightshade, re_renderer, renderling and solis_2d (no files with per-pixel compute
//! shaders).

use std::path::{Path, PathBuf};

use vrcs_passes::input::{Invalid, Reader, Shader, compose};

use super::{prepare, wesl};

#[path = "../common/published.rs"]
mod published;

/// A crate that carries compute shaders.
pub struct Package {
    pub name: &'static str,
    pub version: &'static str,
    /// What its build or its renderer defines.
    defines: &'static [(&'static str, &'static str)],
    /// Crates whose shaders it imports.
    imports: &'static [(&'static str, &'static str)],
    /// Crates whose shaders the preparation wants.
    fetched: &'static [(&'static str, &'static str)],
    /// What its build or its renderer defines for single files (the end of the file's path).
    passes: &'static [Pass],
    /// What its build or its renderer does to the text of a file before a compiler sees it.
    prepare: Option<fn(&Path, &Path, &str) -> String>,
    /// What stands before its shaders and did not have to for the naga that it was published with.
    head: &'static str,
}

/// The end of a file's path, and what is defined for that file.
type Pass = (&'static str, &'static [&'static str]);

const fn plain(name: &'static str, version: &'static str) -> Package {
    Package {
        name,
        version,
        defines: &[],
        imports: &[],
        fetched: &[],
        passes: &[],
        prepare: None,
        head: "",
    }
}

const BEVY: &[(&str, &str)] = &[
    ("bevy_core_pipeline", "0.19.1"),
    ("bevy_pbr", "0.19.1"),
    ("bevy_render", "0.19.1"),
    ("bevy_shader", "0.19.1"),
    ("bevy_post_process", "0.19.1"),
    ("bevy_solari", "0.19.1"),
];

const fn bevy(name: &'static str) -> Package {
    Package {
        name,
        version: "0.19.1",
        defines: &[
            ("AVAILABLE_STORAGE_BUFFER_BINDINGS", "6"),
            ("MAX_DIRECTIONAL_LIGHTS", "10"),
            ("MAX_CASCADES_PER_LIGHT", "4"),
            ("MAX_RECT_LIGHTS", "8"),
            ("SLICE_COUNT", "3"),
            ("SAMPLES_PER_SLICE_SIDE", "3"),
            ("PER_OBJECT_BUFFER_BATCH_SIZE", "64"),
            ("MATERIAL_BIND_GROUP", "3"),
            ("WORLD_CACHE_SIZE", "1048576"),
        ],
        imports: BEVY,
        fetched: &[],
        passes: &[],
        prepare: None,
        head: "",
    }
}

/// All of them.
pub const PACKAGES: &[Package] = &[
    plain("arcane-core", "0.26.1"),
    Package {
        defines: &[
            ("MAX_DIRECTIONAL_LIGHTS", "10"),
            ("MAX_CASCADES_PER_LIGHT", "4"),
            ("AVAILABLE_STORAGE_BUFFER_BINDINGS", "3"),
            ("NO_TEXTURE", ""),
        ],
        fetched: &[("bevy_pbr", "0.9.1"), ("bevy_core_pipeline", "0.9.1")],
        passes: &[("denoise.wgsl", &["DENOISE_LEVEL_0"])],
        prepare: Some(prepare::hikari),
        ..plain("bevy-hikari", "0.3.15")
    },
    plain("bevy-volumetric-clouds", "0.2.0"),
    plain("bevy_atmosphere", "0.13.0"),
    Package {
        imports: BEVY,
        passes: &[("fbm.wgsl", &["2D", "PERLIN"])],
        prepare: Some(prepare::noise),
        ..plain("bevy_compute_noise", "0.4.0")
    },
    Package {
        passes: &[("mip_generation/downsample.wgsl", &["FIRST_PASS"])],
        prepare: Some(prepare::texture_format),
        ..bevy("bevy_core_pipeline")
    },
    Package {
        imports: &[
            ("bevy_core_pipeline", "0.20.1"),
            ("bevy_pbr", "0.20.1"),
            ("bevy_render", "0.20.1"),
        ],
        prepare: Some(prepare::elements),
        ..plain("bevy_elements", "0.7.8")
    },
    plain("bevy_eulerian_fluid", "0.4.0"),
    plain("bevy_magic_light_2d", "0.8.0"),
    Package {
        imports: &[("bevy_prototype_sdf", "0.1.0")],
        ..plain("bevy_march", "0.1.0")
    },
    Package {
        passes: &[
            (
                "cull_bvh.wgsl",
                &["MESHLET_BVH_CULLING_PASS", "MESHLET_FIRST_CULLING_PASS"],
            ),
            (
                "cull_clusters.wgsl",
                &["MESHLET_CLUSTER_CULLING_PASS", "MESHLET_FIRST_CULLING_PASS"],
            ),
            (
                "cull_instances.wgsl",
                &[
                    "MESHLET_INSTANCE_CULLING_PASS",
                    "MESHLET_FIRST_CULLING_PASS",
                ],
            ),
            (
                "visibility_buffer_software_raster.wgsl",
                &[
                    "MESHLET_VISIBILITY_BUFFER_RASTER_PASS",
                    "MESHLET_VISIBILITY_BUFFER_RASTER_PASS_OUTPUT",
                ],
            ),
        ],
        ..bevy("bevy_pbr")
    },
    bevy("bevy_post_process"),
    bevy("bevy_render"),
    Package {
        head: "enable wgpu_binding_array;\n",
        passes: &[
            ("resolve_dlss_rr_textures.wgsl", &["DLSS_RR_GUIDE_BUFFERS"]),
            (
                "world_cache_compact.wgsl",
                &["WORLD_CACHE_NON_ATOMIC_LIFE_BUFFER"],
            ),
        ],
        ..bevy("bevy_solari")
    },
    Package {
        prepare: Some(prepare::blade),
        head: "enable wgpu_binding_array;\nenable wgpu_ray_query;\n",
        ..plain("blade-render", "0.4.0")
    },
    plain("block_compression", "0.11.0"),
    plain("cuneus", "0.6.4"),
    Package {
        prepare: Some(prepare::fidget),
        ..plain("fidget-wgpu", "0.5.1")
    },
    Package {
        prepare: Some(prepare::filtrate),
        ..plain("filtrate", "0.2.0")
    },
    Package {
        prepare: Some(prepare::flashraw),
        ..plain("flashraw-gpu", "0.1.1")
    },
    Package {
        prepare: Some(prepare::kiss3d),
        ..plain("kiss3d", "0.44.0")
    },
    Package {
        head: "enable wgpu_binding_array;\nenable wgpu_ray_query;\n",
        prepare: Some(prepare::lambent),
        ..plain("lambent", "0.1.0")
    },
    plain("oximedia-gpu", "0.2.1"),
    plain("oxiui-render-wgpu", "0.1.1"),
    Package {
        prepare: Some(prepare::roxlap),
        ..plain("roxlap-gpu", "0.32.0")
    },
    plain("slime-mold", "1.0.0"),
    plain("tessera-ui-basic-components", "2.7.0"),
    plain("threers", "0.0.8"),
    Package {
        prepare: Some(prepare::vello),
        ..plain("vello_shaders", "0.9.0")
    },
    plain("viewport-lib", "0.22.0"),
    plain("wgimage", "0.2.0"),
];

/// A file with compute entry points, or the reason why it cannot be read on its own.
pub struct File {
    /// Its path in the crate.
    pub path: String,
    pub shader: Result<Shader, Invalid>,
    text: String,
}

impl File {
    /// Whether an entry point is its own, and none of a module that it imports.
    pub fn has(&self, entry: &str) -> bool {
        self.text.contains(&format!("fn {entry}("))
    }
}

impl Package {
    /// Fetches the crate and reads its compute shaders; `None` if the machine is told to stay offline.
    pub fn files(&self) -> Option<Vec<File>> {
        let root = published::crate_source(self.name, self.version)?;
        let mut reader = Reader::new();
        for (name, value) in self.defines {
            reader = reader.define(*name, *value);
        }
        let mut roots = vec![root.clone()];
        for (name, version) in self.imports {
            roots.push(published::crate_source(name, version)?);
        }
        for (name, version) in self.fetched {
            published::crate_source(name, version)?;
        }
        let read = |of: &Path, path: &Path| {
            let text = std::fs::read_to_string(path).expect("a shader of the crate");
            let is_wesl = path.extension().is_some_and(|end| end == "wesl");
            let is_compute = text.contains("@compute");
            let is_module = is_wesl || compose::import_path(&text).is_some();
            let text = match self.prepare {
                Some(prepare) if of == root && (is_compute || is_module) => {
                    prepare(of, path, &text)
                }
                _ => text,
            };
            match is_wesl {
                true => (wesl::to_wgsl(of, path, &text), is_compute),
                false => (text, is_compute),
            }
        };
        for of in &roots {
            for path in shaders(of) {
                let (text, _) = read(of, &path);
                if compose::import_path(&text).is_some() {
                    reader = reader.module(path.display().to_string(), text);
                }
            }
        }
        let mut files = Vec::new();
        for path in shaders(&root) {
            let (text, is_compute) = read(&root, &path);
            if !is_compute {
                continue;
            }
            let name = path.strip_prefix(&root).expect("a file of the crate");
            let name = name.display().to_string();
            let passes = self.passes.iter().filter(|(end, _)| name.ends_with(end));
            let reader = passes
                .flat_map(|(_, defines)| *defines)
                .fold(reader.clone(), |reader, name| reader.define(*name, ""));
            files.push(File {
                shader: reader.wgsl([(name.clone(), format!("{}{text}", self.head))]),
                path: name,
                text,
            });
        }
        Some(files)
    }
}

/// The WGSL and WESL files below a folder, in order.
fn shaders(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let entries = std::fs::read_dir(folder).expect("a folder of the crate");
    for entry in entries {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            found.extend(shaders(&path));
        } else if path
            .extension()
            .is_some_and(|extension| extension == "wgsl" || extension == "wesl")
        {
            found.push(path);
        }
    }
    found.sort();
    found
}
