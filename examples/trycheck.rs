//! tmp
use vrcs::check::*;
fn main() {
    let path = std::env::args().nth(1).unwrap();
    let text = std::fs::read_to_string(&path).unwrap();
    let source = vrcs_passes::Source::new(path, text.clone());
    let module = naga::front::wgsl::parse_str(&text).unwrap();
    let info = naga::valid::Validator::new(
        naga::valid::ValidationFlags::all(),
        naga::valid::Capabilities::all(),
    )
    .validate(&module)
    .unwrap();
    let gpu = gpu::Gpu::open(None).unwrap();
    println!("{:?}", gpu.info.name);
    for e in &module.entry_points {
        let job = Job::new(&e.name);
        let t = std::time::Instant::now();
        match check(&gpu, &source, &module, &info, &job, &mut |_| {}) {
            Ok(r) => {
                println!(
                    "{:?} {:?} {:?} {:?} {:?}",
                    r.verdict,
                    r.why,
                    r.held,
                    r.notes,
                    t.elapsed()
                );
                if let Some(f) = r.failure {
                    println!(
                        "{:?}",
                        Failure {
                            picture: vec![],
                            ..f.clone()
                        }
                    );
                    std::fs::write("/tmp/fail.png", &f.picture).unwrap();
                }
            }
            Err(CheckError::Refused(r)) => {
                print!("{}", r.render(&source, vrcs_passes::Color::Never))
            }
            Err(e) => println!("{e}"),
        }
    }
}
