//! Rewrites every shader of `shaders/` into `OUT_DIR`.

fn main() {
    vrcs_passes::build::Rewriter::new()
        .folder("shaders")
        .define("WAVES", "24")
        .write_to_out_dir();
}
