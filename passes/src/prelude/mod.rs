//! The WGSL that every rewritten shader shares: VRCSPrefix and what it needs.
//!
//! It is a module of its own, from which a rewritten shader [imports](crate::ir::import) what it uses. The few
//! numbers that differ between rewrites stand in front of it as constants, so that each combination is parsed once
//! in a process.

use std::sync::{Arc, Mutex, PoisonError};

use naga::Module;
use rustc_hash::FxHashMap;

use crate::options::{Mode, Options, Sky};

const COMMON: &str = include_str!("common.wgsl");
const TILED: &str = include_str!("tiled.wgsl");
const GROUP: &str = include_str!("group.wgsl");
const LIST: &str = include_str!("list.wgsl");
const CLASSIFIED: &str = include_str!("classified.wgsl");
const ENTRIES: &str = include_str!("entries.wgsl");
const UNIFORM: &str = include_str!("uniform.wgsl");
const PLAIN: &str = include_str!("plain.wgsl");
const DEEP: &str = include_str!("deep.wgsl");
const GRADED: &str = include_str!("graded.wgsl");

/// What the text of the prelude depends on.
type Key = (Mode, [u32; 2], Sky, bool);

static PARSED: Mutex<Option<FxHashMap<Key, Arc<Module>>>> = Mutex::new(None);

/// The prelude for these options.
pub fn prelude(options: &Options) -> Arc<Module> {
    let key = (
        options.mode,
        options.tile,
        options.sky,
        options.linear_depth,
    );
    let mut parsed = PARSED.lock().unwrap_or_else(PoisonError::into_inner);
    parsed
        .get_or_insert_default()
        .entry(key)
        .or_insert_with(|| Arc::new(parse(&text(options))))
        .clone()
}

fn text(options: &Options) -> String {
    let [width, height] = options.tile;
    let shades_sky = options.sky == Sky::Shade;
    let entry = match options.linear_depth {
        true => DEEP,
        false => PLAIN,
    };
    let parts: &[&str] = match options.mode {
        Mode::Tiled => &[COMMON, UNIFORM, entry, TILED, GROUP],
        Mode::List => &[COMMON, entry, ENTRIES, LIST],
        Mode::Classified => &[COMMON, UNIFORM, entry, ENTRIES, CLASSIFIED],
        Mode::Graded => &[COMMON, GRADED],
        Mode::Auto => unreachable!("the mode is chosen before anything is made"),
    };
    format!(
        "const VRCS_TILE_WIDTH: u32 = {width}u;\nconst VRCS_TILE_HEIGHT: u32 = {height}u;\nconst VRCS_GROUP_ROOM: u32 = {}u;\nconst VRCS_SHADES_SKY: bool = {shades_sky};\n{}",
        width * height,
        parts.concat()
    )
}

fn parse(text: &str) -> Module {
    match naga::front::wgsl::parse_str(text) {
        Ok(module) => module,
        Err(error) => unreachable!("the prelude: {}", error.emit_to_string(text)),
    }
}
