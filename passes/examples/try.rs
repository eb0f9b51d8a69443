//! tmp
fn main() {
    let text = std::fs::read_to_string(std::env::args().nth(1).unwrap()).unwrap();
    let source = vrcs_passes::Source::new("in.wgsl", text.clone());
    let module = naga::front::wgsl::parse_str(&text).unwrap();
    let info = naga::valid::Validator::new(
        naga::valid::ValidationFlags::all(),
        naga::valid::Capabilities::all(),
    )
    .validate(&module)
    .unwrap();
    match vrcs_passes::rewrite(
        &module,
        &info,
        vrcs_passes::Entries::PerPixel,
        &Default::default(),
    ) {
        Ok(r) => {
            for (_, w) in &r.warnings {
                print!("{}", w.render(&source, vrcs_passes::Color::Never));
            }
            match vrcs_passes::emit::wgsl(&r.module, &r.info) {
                Ok(t) => println!("{t}"),
                Err(e) => println!("ERR {e}"),
            }
        }
        Err(e) => print!("{}", e.render(&source, vrcs_passes::Color::Never)),
    }
}
