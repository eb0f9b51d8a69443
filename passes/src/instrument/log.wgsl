// What instrumented stores call.

@group(0) @binding(0) var<storage, read_write> vrcs_log_words: array<atomic<u32>>;

// This invocation's number in the grid, and how many stores it has made.
var<private> vrcs_invocation: u32;
var<private> vrcs_logged: u32;

fn vrcs_begin(gid: vec3<u32>) {
    vrcs_invocation = (gid.z * HEIGHT + gid.y) * WIDTH + gid.x;
    vrcs_logged = 0u;
}

// Notes a store or atomic in this invocation's part of the log: their number, then site, place and an atomic's value of each.
fn vrcs_log(site: u32, base: u32, size: u32, place: u32, value: u32) {
    let start = vrcs_invocation * (1u + 3u * SLOTS);
    if vrcs_logged < SLOTS {
        atomicStore(&vrcs_log_words[start + 1u + 3u * vrcs_logged], site);
        atomicStore(&vrcs_log_words[start + 2u + 3u * vrcs_logged], place);
        atomicStore(&vrcs_log_words[start + 3u + 3u * vrcs_logged], value);
    }
    vrcs_logged += 1u;
    atomicStore(&vrcs_log_words[start], vrcs_logged);
}

// Counts a store to each word of its place: a texel has one word, a buffer one for each two bytes.
fn vrcs_count(site: u32, base: u32, size: u32, place: u32, value: u32) {
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
