// What an instrumented build calls wherever subgroups are counted.

@group(0) @binding(0) var<storage, read_write> vrcs_subgroups: array<atomic<u32>>;

// Counts a subgroup once: the first of its invocations that are here finds none before it.
fn vrcs_count_subgroup(word: u32) {
    if subgroupExclusiveAdd(1u) == 0u {
        atomicAdd(&vrcs_subgroups[word], 1u);
    }
}
