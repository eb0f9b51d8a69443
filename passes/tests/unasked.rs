//! The policy `full` where nothing was said and copies cannot serve: what is taken, what is left refused, and what is told.

use vrcs_passes::{
    Code, Entries, Options, Refusal, Rewritten, Source, input,
    options::{Atomics, Mode, Policy},
    rewrite,
};

const HEAD: &str = "
    struct Frame { size: vec2<u32>, count: u32 }
    @group(0) @binding(0) var<uniform> frame: Frame;
    @group(0) @binding(1) var picture: texture_storage_2d<rgba8unorm, write>;
    @group(0) @binding(2) var<storage, read_write> note: array<u32>;
    @group(0) @binding(3) var<storage, read_write> other: array<f32>;
    @group(0) @binding(4) var<storage, read_write> tally: array<atomic<u32>>;
    @group(0) @binding(5) var<storage, read_write> cells: array<f32>;
    var<private> seed: u32;
    fn light(id: vec3<u32>) -> vec4<f32> {
        var sum = vec4<f32>(0.0);
        for (var i = 0u; i < 32u; i++) { sum += sin(vec4<f32>(id.xyxy * i)); }
        return sum;
    }";

fn made(body: &str, options: &Options) -> Result<Rewritten, Refusal> {
    let text = format!(
        "{HEAD}
    @compute @workgroup_size(8, 8) fn main(@builtin(global_invocation_id) id: vec3<u32>) {{ {body} }}"
    );
    let source = Source::new("unasked.wgsl", text);
    let (module, info) = input::wgsl(&source).unwrap_or_else(|e| panic!("{}", e.rendered));
    rewrite(&module, &info, Entries::PerPixel, options)
}

/// The targets that are stored for every pixel; the codes of a refusal.
fn full(body: &str, options: &Options) -> Result<Vec<String>, Vec<Code>> {
    match made(body, options) {
        Ok(rewritten) => {
            let told = rewritten.warnings.iter();
            let told = told.filter(|(_, warning)| warning.code == Code::StoredForEveryPixel);
            let targets = rewritten.manifest.entries[0].targets.iter();
            let full: Vec<_> = targets
                .filter(|target| target.policy == Policy::Full)
                .map(|target| target.name.clone())
                .collect();
            assert_eq!(told.count() == 0, full.is_empty(), "{body}");
            Ok(full)
        }
        Err(refusal) => Err(refusal.findings.iter().map(|f| f.code).collect()),
    }
}

const SHADE: &str = "textureStore(picture, id.xy, light(id));";
const COUNT: &str = "if all(id == vec3<u32>(0u)) { note[0] = frame.count; }";

#[test]
fn what_copies_cannot_serve_is_taken_and_nothing_else() {
    use Code::*;
    let mut wrong = Vec::new();
    let own = "other[id.y * frame.size.x + id.x] = 1.0;";
    let quarter =
        "if id.x % 2u == 0u && id.y % 2u == 0u { other[id.y / 2u * 64u + id.x / 2u] = 2.0; }";
    for (body, expected) in [
        // nothing to do: no store is lost
        (format!("{SHADE} {own}"), Ok(vec![])),
        // a lone invocation, a quarter of them, all of them at one place, a place that memory tells
        (format!("{SHADE} {COUNT}"), Ok(vec!["note"])),
        (format!("{SHADE} {quarter}"), Ok(vec!["other"])),
        (
            format!("{SHADE} note[id.x] = id.x + frame.count;"),
            Ok(vec!["note"]),
        ),
        (
            format!("{SHADE} other[id.y / 2u * 64u + id.x / 2u] = f32(id.x);"),
            Ok(vec!["other"]),
        ),
        (
            format!("{SHADE} let n = note[id.y * 64u + id.x]; note[n + id.y * 64u + id.x] = 1u;"),
            Err(vec![ReadsOthersOutput, AddressNotRecomputable]),
        ),
        // several at once, some through a return
        (
            format!("{COUNT} {quarter} if id.x >= frame.size.x {{ return; }} {SHADE}"),
            Ok(vec!["note", "other"]),
        ),
        // nothing else is stored, or nothing of the pixel's own
        (COUNT.to_owned(), Err(vec![NothingPerPixel])),
        // (a condition on everything is the domain, and a place for each of its pixels is their own)
        (quarter.to_owned(), Ok(vec![])),
        (
            format!("{COUNT} {quarter}"),
            Err(vec![AddressNotOneToOne, ConditionalOnIds]),
        ),
        // the other half reads it, or a private variable ties them
        (
            format!("{COUNT} textureStore(picture, id.xy, light(id) * f32(note[0]));"),
            Err(vec![AddressNotOneToOne]),
        ),
        (
            "seed = seed * 3u + 1u; if all(id == vec3<u32>(0u)) { note[0] = seed; } seed += 1u; textureStore(picture, id.xy, light(id) * f32(seed));".to_owned(),
            Err(vec![AddressNotOneToOne]),
        ),
        // atomics stay refused
        (
            format!("{SHADE} {COUNT} atomicAdd(&tally[0], 1u);"),
            Err(vec![Atomic, AddressNotOneToOne]),
        ),
        // so do reads of what others store
        (
            format!("{SHADE} {COUNT} let at = id.y * 64u + id.x; cells[at] = cells[at + 1u];"),
            Err(vec![ReadsOthersOutput, AddressNotOneToOne]),
        ),
        // all of the work is what both need
        (
            "let l = light(id); textureStore(picture, id.xy, l); if all(id.xy % 2u == vec2<u32>(0u)) { other[id.y / 2u * 64u + id.x / 2u] = l.x; }".to_owned(),
            Err(vec![ConditionalOnIds]),
        ),
        // work of the lone invocation's own is no loss
        (
            format!("{SHADE} if all(id == vec3<u32>(0u)) {{ other[0] = light(id).x; }}"),
            Ok(vec!["other"]),
        ),
    ] {
        let expected = expected.map(|names| names.into_iter().map(str::to_owned).collect());
        let got = full(&body, &Options::default());
        if got != expected {
            wrong.push(format!("{body}: {got:?}, not {expected:?}"));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn the_word_of_the_author_stands() {
    let body = format!("{SHADE} {COUNT}");
    let with = |policy| {
        let mut options = Options::default();
        options.targets.insert("note".to_owned(), policy);
        made(&body, &options)
    };
    let refusal = with(Policy::Copy).expect_err("a refusal");
    assert_eq!(refusal.findings[0].code, Code::AddressNotOneToOne);
    let full = with(Policy::Full).expect("a rewrite");
    assert!(full.warnings.is_empty(), "{:?}", full.warnings);
    let taken = made(&body, &Options::default()).expect("a rewrite");
    let [(entry, warning)] = taken.warnings.as_slice() else {
        panic!("{:?}", taken.warnings);
    };
    assert_eq!(
        (entry.as_str(), warning.code),
        ("main", Code::StoredForEveryPixel)
    );
    for part in ["`note`", "statements"] {
        assert!(warning.message.contains(part), "{}", warning.message);
    }
    let help = warning.help.as_deref().expect("help");
    assert!(help.contains("--target note=copy"), "{help}");
    // what was taken is what could have been asked for
    let text = |rewritten: &Rewritten| {
        vrcs_passes::emit::wgsl(&rewritten.module, &rewritten.info).expect("text")
    };
    assert_eq!(text(&taken), text(&full));
    assert_eq!(
        taken.manifest.entries[0].targets,
        full.manifest.entries[0].targets
    );
}

#[test]
fn only_modes_that_visit_every_pixel_take_it() {
    let body = format!("{SHADE} {COUNT}");
    let with = |mode, atomics| Options {
        mode,
        atomics,
        ..Options::default()
    };
    for mode in [Mode::List, Mode::Classified] {
        assert_eq!(
            full(&body, &with(mode, Atomics::Refuse)),
            Err(vec![Code::AddressNotOneToOne])
        );
    }
    let auto = made(&body, &with(Mode::Auto, Atomics::Refuse)).expect("a rewrite");
    assert_eq!(auto.manifest.entries[0].mode, Mode::Tiled);
    let reason = auto.manifest.entries[0].mode_reason.as_deref();
    assert!(
        reason.is_some_and(|why| why.contains("every pixel")),
        "{reason:?}"
    );
}

/// One entry point's policies are no other's.
#[test]
fn each_entry_point_has_its_own() {
    let text = format!(
        "{HEAD}
    @compute @workgroup_size(8, 8) fn shade(@builtin(global_invocation_id) id: vec3<u32>) {{ {SHADE} {COUNT} }}
    @compute @workgroup_size(8, 8) fn fill(@builtin(global_invocation_id) id: vec3<u32>) {{ note[id.y * frame.size.x + id.x] = id.x; }}"
    );
    let source = Source::new("two.wgsl", text);
    let (module, info) = input::wgsl(&source).expect("a shader");
    let rewritten = rewrite(&module, &info, Entries::PerPixel, &Options::default()).expect("both");
    let policies: Vec<_> = rewritten
        .manifest
        .entries
        .iter()
        .flat_map(|entry| {
            entry
                .targets
                .iter()
                .map(|t| (entry.name.as_str(), t.name.as_str(), t.policy))
        })
        .collect();
    assert_eq!(
        policies,
        [
            ("shade", "picture", Policy::Copy),
            ("shade", "note", Policy::Full),
            ("fill", "note", Policy::Copy),
        ]
    );
    let told = vrcs_passes::explain::explain(&module, &info, &source, None, &Options::default());
    let [shade, fill] = told.as_slice() else {
        panic!("{told:#?}")
    };
    assert!(
        shade
            .stores
            .iter()
            .any(|store| store.target == "note" && store.how == "full")
    );
    assert!(
        shade
            .findings
            .iter()
            .any(|finding| finding.code == "VRCS107")
    );
    assert!(fill.stores.iter().all(|store| store.how != "full") && fill.findings.is_empty());
}
