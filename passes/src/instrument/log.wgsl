// What instrumented stores call.

@group(0) @binding(0) var<storage, read_write> vrcs_log_words: array<atomic<u32>>;

// This invocation's number in the grid, and how many stores it has made.
var<private> vrcs_invocation: u32;
var<private> vrcs_logged: u32;
// Which iterations of which loops it is in, through which calls: the same number for two invocations that are in the same.
var<private> vrcs_path: u32;

fn vrcs_begin(gid: vec3<u32>) {
    vrcs_invocation = (gid.z * HEIGHT + gid.y) * WIDTH + gid.x;
    vrcs_logged = 0u;
    vrcs_path = 0u;
}

fn vrcs_here() -> u32 {
    return vrcs_path;
}

// Enters a call, or the next iteration of a loop, by its number.
fn vrcs_go_on(step: u32) {
    vrcs_path = (vrcs_path ^ step) * 0x9e3779b1u + 0x7f4a7c15u;
}

// Leaves a loop or call.
fn vrcs_go_back(path: u32) {
    vrcs_path = path;
}

// Notes a store or atomic in this invocation's part of the log: their number, then site, place, path, confined place and an atomic's
// value of each.
fn vrcs_log(site: u32, base: u32, size: u32, place: u32, confined: u32, value: u32) {
    let start = vrcs_invocation * (1u + 5u * SLOTS);
    if vrcs_logged < SLOTS {
        let slot = start + 1u + 5u * vrcs_logged;
        atomicStore(&vrcs_log_words[slot], site);
        atomicStore(&vrcs_log_words[slot + 1u], place);
        atomicStore(&vrcs_log_words[slot + 2u], vrcs_path);
        atomicStore(&vrcs_log_words[slot + 3u], confined);
        atomicStore(&vrcs_log_words[slot + 4u], value);
    }
    vrcs_logged += 1u;
    atomicStore(&vrcs_log_words[start], vrcs_logged);
}

// Counts a store to each word of its place: a texel has one word, a buffer one for each two bytes.
fn vrcs_count(site: u32, base: u32, size: u32, place: u32, confined: u32, value: u32) {
    if place == 0xffffffffu {
        return;
    }
    if size == 1u {
        atomicAdd(&vrcs_log_words[base + place], 1u);
        return;
    }
    for (var byte = 0u; byte < size; byte += 2u) {
        atomicAdd(&vrcs_log_words[base + (place + byte) / 2u], 1u);
    }
}
