//! A split screen: several views inside one set of pictures, each at its origin. What a view finds, builds, shades and deblocks there is
//! what it would of pictures of its own, and nothing outside it is touched.

use fastrand::Rng;
use vrcs::{
    Analyser, ObjectOptions, Pass, PassOptions, Rate, Scene, Source, View, ViewError,
    analyse::{
        Cameras, Frame, FrameError, OwnRates, Settings,
        own::IdRates,
        settings::{
            Content, Fetch, Granularity, HalfRate, Materials, MaterialsOf, Motion, Norm,
            Reprojection,
        },
        tiles::data_bytes,
    },
    build::BuildOptions,
    check::gpu::Gpu,
    coverage::{Coverage, Depth, DepthKind, Textures},
    deblock::{self, Deblocker, Inputs, Picture, PictureInput},
    plan::{Binding, Plan},
    sri::Sri,
};
use wgpu::TextureFormat as Format;

use crate::{common, renderer::SIZE};

/// The pictures of a whole screen, or a part of them.
struct Screen {
    textures: Vec<(Binding, wgpu::TextureView)>,
    surfaces: wgpu::TextureView,
}

const WHOLE: [u32; 2] = [100, 80];

/// A texel by chance; `patch` is 0 to 3, and the same for neighbours.
type Texel = fn(&mut Rng, u32) -> Vec<u8>;

/// Each picture's binding and format, and its texels: calm in some patches and busy in others, so that every rate comes up.
fn kinds() -> Vec<(Binding, Format, Texel)> {
    fn grey(rng: &mut Rng, patch: u32) -> Vec<u8> {
        let noise = [0, 4, 12, 90][patch as usize];
        let grey = 100 + rng.u8(0..=noise);
        vec![grey, grey, grey, 255]
    }
    fn depth(rng: &mut Rng, _: u32) -> Vec<u8> {
        let depth = match rng.u8(0..60) {
            0 => 0.9f32,
            _ => 0.5 + rng.f32() * 1e-4,
        };
        depth.to_le_bytes().to_vec()
    }
    vec![
        (Binding::Colour, Format::Rgba8Unorm, grey),
        (Binding::After, Format::Rgba8Unorm, grey),
        (Binding::Motion, Format::Rg32Float, |_, patch| {
            let vector = [patch as f32 * 2.0, (patch & 1) as f32];
            bytemuck::cast_slice(&vector).to_vec()
        }),
        (Binding::Depth, Format::R32Float, depth),
        (Binding::PreviousDepth, Format::R32Float, depth),
        (Binding::Materials, Format::Rgba8Unorm, |rng, _| {
            let shine = if rng.u8(0..30) == 0 { 255 } else { 0 };
            vec![shine, shine, 0, 0]
        }),
        (Binding::Noise, Format::R8Unorm, |_, patch| {
            vec![(patch * 85) as u8]
        }),
        (Binding::Ids, Format::R8Uint, |_, patch| vec![patch as u8]),
        (Binding::Flags, Format::R8Uint, |rng, _| {
            vec![if rng.u8(0..40) == 0 { rng.u8(1..8) } else { 0 }]
        }),
        (Binding::Blur, Format::R32Float, |_, patch| {
            (patch as f32 * 2.0).to_le_bytes().to_vec()
        }),
    ]
}

/// A rectangle of texels, row by row.
fn crop(bytes: &[u8], origin: [u32; 2], size: [u32; 2], texel: usize) -> Vec<u8> {
    (origin[1]..origin[1] + size[1])
        .flat_map(|y| {
            let first = (y * WHOLE[0] + origin[0]) as usize * texel;
            bytes[first..first + size[0] as usize * texel].to_vec()
        })
        .collect()
}

/// The picture of a kind: all of it, its part at an origin, and its part at the first corner.
fn cut(
    gpu: &Gpu,
    seed: u64,
    (format, texel): (Format, Texel),
    origin: [u32; 2],
    size: [u32; 2],
) -> [wgpu::TextureView; 3] {
    let mut rng = Rng::with_seed(seed);
    let patches: Vec<u32> = (0..256).map(|_| rng.u32(0..4)).collect();
    let pixels = (0..WHOLE[1]).flat_map(|y| (0..WHOLE[0]).map(move |x| (x, y)));
    let bytes: Vec<u8> = pixels
        .flat_map(|(x, y)| texel(&mut rng, patches[(y / 9 * 16 + x / 11) as usize]))
        .collect();
    let each = bytes.len() / (WHOLE[0] * WHOLE[1]) as usize;
    [
        gpu.texture("whole", WHOLE, format, &bytes),
        gpu.texture("part", size, format, &crop(&bytes, origin, size, each)),
        gpu.texture("corner", size, format, &crop(&bytes, [0; 2], size, each)),
    ]
}

/// The pictures of the stage by tiles: depths that differ from patch to patch, so that tiles move apart.
fn kinds_by_tile() -> Vec<(Binding, Format, Texel)> {
    let mut kinds = kinds();
    kinds.retain(|(binding, ..)| *binding == Binding::Flags);
    // noise that a tile's threshold lies amid
    kinds.push((Binding::Colour, Format::Rgba8Unorm, |rng, patch| {
        let grey = 100 + rng.u8(0..=[0, 2, 10, 14][patch as usize]);
        vec![grey, grey, grey, 255]
    }));
    kinds.push((Binding::Depth, Format::R32Float, |_, patch| {
        (0.2f32 + 0.2 * patch as f32).to_le_bytes().to_vec()
    }));
    kinds
}

/// The screens: all of it, its part at an origin, and its part at the first corner.
fn screens(
    gpu: &Gpu,
    kinds: Vec<(Binding, Format, Texel)>,
    origin: [u32; 2],
    size: [u32; 2],
) -> [Screen; 3] {
    let seed = common::seed();
    let numbers: Texel = |_, patch| vec![patch as u8 & 1];
    let surfaces = cut(gpu, seed, (Format::R8Uint, numbers), origin, size);
    let mut screens = surfaces.map(|surfaces| Screen {
        textures: Vec::new(),
        surfaces,
    });
    for (kind, (binding, format, texel)) in (1..).zip(kinds) {
        let cut = cut(gpu, seed + kind, (format, texel), origin, size);
        for (screen, texture) in screens.iter_mut().zip(cut) {
            screen.textures.push((binding, texture));
        }
    }
    screens
}

/// Everything that looks at a picture pixel by pixel.
fn by_pixel() -> (Scene, Settings) {
    let scene = Scene {
        after_transparents: true,
        motion: true,
        depth: true,
        materials: true,
        noise: true,
        ids: true,
        flags: true,
        blur: true,
        attachment: true,
        ..Scene::default()
    };
    (scene, settings())
}

/// The stage by tiles.
fn by_tile() -> (Scene, Settings) {
    let scene = Scene {
        cameras: true,
        depth: true,
        flags: true,
        attachment: true,
        ..Scene::default()
    };
    let settings = Settings {
        motion: Some(Motion::default()),
        reprojection: Some(Reprojection {
            fetch: Fetch::Tile,
            tolerance: f64::INFINITY,
            ..Reprojection::default()
        }),
        // few tiles: many rates for each
        largest: Rate::R4X4,
        content: Content {
            norm: Norm::LInf,
            threshold: 0.1,
            ..Content::default()
        },
        ..Settings::default()
    };
    (scene, settings)
}

fn settings() -> Settings {
    Settings {
        motion: Some(Motion::default()),
        later_blur: true,
        reprojection: Some(Reprojection::default()),
        materials: Some(Materials::default()),
        half_rate: Some(HalfRate::default()),
        transparents: true,
        own: Some(OwnRates {
            ids: Some(IdRates {
                rates: vec![None, Some(Rate::R1X1), Some(Rate::R2X2), Some(Rate::R2X1)],
                ..IdRates::default()
            }),
            ..OwnRates::default()
        }),
        ..Settings::default()
    }
}

fn built() -> BuildOptions {
    BuildOptions {
        coverage: Coverage {
            surfaces: true,
            depth: Some(Depth::new(DepthKind::Linear)),
            ..Coverage::default()
        },
        effective: true,
        ..BuildOptions::default()
    }
}

/// One player's view, and what looks at their part of a screen.
struct Player {
    view: View,
    analyser: Analyser,
    /// Where the rates for hardware go, and what tiles look like.
    buffers: [(Binding, wgpu::Buffer); 2],
}

impl Player {
    fn new(
        gpu: &Gpu,
        (scene, settings): (Scene, Settings),
        screen: &Screen,
        origin: [u32; 2],
        size: [u32; 2],
    ) -> Player {
        let extent = [size[0], size[1], 1];
        let mut view = View::new(&gpu.device, &gpu.queue, extent, built()).expect("a view");
        view.set_origin(origin).expect("it lies in the screen");
        let scene = Scene {
            origin: origin != [0; 2],
            ..scene
        };
        let plan = Plan::new(&scene, &settings).expect("a plan");
        let objects = ObjectOptions::default();
        let sizes = [
            (Binding::Attachment, view.sri().size()),
            (Binding::TileData, data_bytes(size)),
        ];
        let buffers = sizes.map(|(binding, bytes)| {
            let zeroes = vec![0; bytes as usize];
            let buffer = gpu.buffer(binding.name(), &zeroes, wgpu::BufferUsages::STORAGE);
            (binding, buffer)
        });
        let given = resources(screen, &buffers);
        let analyser = Analyser::with(&gpu.device, &view, &plan, &given, &objects);
        Player {
            analyser: analyser.expect("bound"),
            view,
            buffers,
        }
    }

    /// The rates that the analysis finds in a screen, also those for hardware, and the coordinates and effective rates that follow.
    fn found(&mut self, gpu: &Gpu, screen: &Screen) -> [Vec<u8>; 4] {
        let view = &mut self.view;
        let depth = screen.textures.iter().find(|(b, _)| *b == Binding::Depth);
        let textures = Textures {
            surfaces: Some(&screen.surfaces),
            depth: depth.map(|(_, view)| view),
            ..Textures::default()
        };
        view.cover(&gpu.queue, &textures).expect("large enough");
        self.analyser
            .bind(view, &resources(screen, &self.buffers))
            .expect("as before");
        let mut encoder = gpu.encoder();
        let mut compute = encoder.begin_compute_pass(&Default::default());
        self.analyser
            .record(&gpu.queue, &mut compute, view, &frame(view))
            .expect("a frame");
        view.build_in(&mut compute).expect("covered");
        drop(compute);
        let coords = view.coords().expect("tiled");
        let effective = view.effective().expect("asked for");
        let read = gpu
            .submit_and_read(
                encoder,
                &[view.sri(), &self.buffers[0].1, coords, effective],
            )
            .expect("read");
        read.try_into().expect("four buffers")
    }
}

/// A frame of a camera that moves sideways, near things further.
fn frame(view: &View) -> Frame {
    let now = glam::DMat4::perspective_infinite_reverse_rh(1.0, 1.6, 0.1);
    let mut shear = glam::DMat4::IDENTITY;
    shear.z_axis.x = 0.2;
    Frame {
        cameras: Some(Cameras {
            now,
            before: now * shear,
        }),
        ..Frame::of_view(view)
    }
}

fn resources<'s>(
    screen: &'s Screen,
    buffers: &'s [(Binding, wgpu::Buffer)],
) -> Vec<(Binding, wgpu::BindingResource<'s>)> {
    let textures = screen.textures.iter();
    textures
        .map(|(binding, view)| (*binding, wgpu::BindingResource::TextureView(view)))
        .chain(
            buffers
                .iter()
                .map(|(binding, buffer)| (*binding, buffer.as_entire_binding())),
        )
        .collect()
}

#[test]
fn a_view_at_an_origin_finds_and_builds_what_it_would_of_pictures_of_its_own() {
    hold_alone_and_inside(&by_pixel, &kinds);
}

#[test]
fn so_do_rates_of_tiles_and_materials_of_the_frame_before() {
    let by_area = || {
        let (scene, settings) = by_pixel();
        let settings = Settings {
            // small, so that there are many
            granularity: Granularity::Tile4,
            materials: Some(Materials {
                of: MaterialsOf::Previous,
                ..Materials::default()
            }),
            ..settings
        };
        (scene, settings)
    };
    hold_alone_and_inside(&by_area, &kinds);
}

#[test]
fn so_does_a_stage_by_tiles() {
    hold_alone_and_inside(&by_tile, &kinds_by_tile);
}

fn hold_alone_and_inside(
    planned: &dyn Fn() -> (Scene, Settings),
    kinds: &dyn Fn() -> Vec<(Binding, Format, Texel)>,
) {
    let gpu = common::gpu();
    for (origin, size) in [([37, 11], [61, 59]), ([50, 0], [50, 80]), ([1, 79], [7, 1])] {
        let [whole, mut part, corner] = screens(&gpu, kinds(), origin, size);
        let inside = Player::new(&gpu, planned(), &whole, origin, size).found(&gpu, &whole);
        let mut player = Player::new(&gpu, planned(), &part, [0; 2], size);
        let alone = player.found(&gpu, &part);
        for (what, (inside, alone)) in [
            "rates",
            "rates for hardware",
            "coordinates",
            "effective rates",
        ]
        .iter()
        .zip(inside.iter().zip(&alone))
        {
            assert!(inside == alone, "{what} at {origin:?}");
        }
        if size[1] == 1 {
            continue;
        }
        let codes: std::collections::BTreeSet<u8> = alone[0].iter().copied().collect();
        assert!(codes.len() >= 2, "too plain: {codes:?}");
        // every picture has a say, so that none was read at another place unnoticed
        for (index, (binding, texture)) in corner.textures.iter().enumerate() {
            let own = std::mem::replace(&mut part.textures[index].1, texture.clone());
            let other = player.found(&gpu, &part);
            assert!(other != alone, "{binding:?} has no say at {origin:?}");
            part.textures[index].1 = own;
        }
    }
    gpu.check().expect("nothing came to the device");
}

/// Two players' halves of one picture, shaded by one pass with the author's own origin in a uniform, then deblocked.
#[test]
fn two_views_shade_and_deblock_their_halves_of_one_picture() {
    let gpu = common::gpu();
    let source = Source::new(
        "half.wgsl",
        "struct Player { origin: vec2<u32>, size: vec2<u32> }
         @group(0) @binding(0) var picture: texture_storage_2d<rgba8unorm, write>;
         @group(0) @binding(1) var<uniform> player: Player;
         @compute @workgroup_size(8, 8)
         fn main(@builtin(global_invocation_id) id: vec3<u32>) {
             if any(id.xy >= player.size) { return; }
             let light = vec2<f32>(id.xy) / vec2<f32>(player.size);
             textureStore(picture, player.origin + id.xy, vec4(light, f32(player.origin.x > 0u), 1.0));
         }",
    );
    let pass = Pass::new(&gpu.device, &source, &PassOptions::default()).expect("a pass");
    let wishes = BuildOptions {
        effective: true,
        ..BuildOptions::default()
    };
    let descriptor = crate::renderer::picture(SIZE);
    let texture = gpu.device.create_texture(&descriptor);
    let target = texture.create_view(&Default::default());
    let options = deblock::Options::new(Picture::Texture(texture.format()));
    let deblocker = Deblocker::new(&gpu.device, None, options).expect("a deblocker");
    // a border of four pixels between the halves is nobody's
    let halves = [([0, 0], [30, 48]), ([34, 0], [30, 48])];
    let mut encoder = gpu.encoder();
    let mut compute = encoder.begin_compute_pass(&Default::default());
    for (origin, size) in halves {
        let extent = [size[0], size[1], 1];
        let built = pass.build_options(wishes);
        let mut view = View::new(&gpu.device, &gpu.queue, extent, built).expect("a view");
        view.set_origin(origin).expect("inside");
        let rates = Sri::uniform(size[0], size[1], Rate::R2X2);
        view.write_sri(&gpu.queue, &rates).expect("its size");
        let words = [origin[0], origin[1], size[0], size[1]];
        let player = gpu.buffer(
            "player",
            bytemuck::cast_slice(&words),
            wgpu::BufferUsages::UNIFORM,
        );
        let layout = pass.bind_group_layout(0).expect("a group");
        let group =
            crate::renderer::group(&gpu.device, layout, &target, player.as_entire_binding());
        view.build_in(&mut compute).expect("no coverage");
        compute.set_bind_group(0, &group, &[]);
        pass.dispatch(&mut compute, &view).expect("a view for it");
        let inputs = Inputs::of_view(&view, PictureInput::Texture(&target)).expect("rates");
        let bound = deblocker.bind(&gpu.device, &inputs).expect("bound");
        deblocker
            .record_view(&gpu.queue, &mut compute, &bound, &view)
            .expect("inside");
    }
    drop(compute);
    let pixels = gpu.read_rgba8(encoder, &texture).expect("read");
    gpu.check().expect("nothing came to the device");
    let at = |x: u32, y: u32| {
        let first = ((y * SIZE[0] + x) * 4) as usize;
        [0, 1, 2, 3].map(|channel| pixels[first + channel])
    };
    for y in 0..SIZE[1] {
        for x in 0..SIZE[0] {
            let [red, _, blue, alpha] = at(x, y);
            match x {
                0..30 => assert_eq!([blue, alpha], [0, 255], "{x},{y}"),
                30..34 => assert_eq!(at(x, y), [0; 4], "{x},{y} is nobody's"),
                _ => assert_eq!([blue, alpha], [255, 255], "{x},{y}"),
            }
            // deblocked, a ramp is a ramp again but for the last quad, which has no neighbour
            let own = if x < 30 { x } else { x.wrapping_sub(34) };
            if own < 28 && !(30..34).contains(&x) {
                let wanted = 255.0 * f64::from(own) / 30.0;
                assert!(
                    (f64::from(red) - wanted).abs() <= 1.0,
                    "{x},{y}: {red} for {wanted}"
                );
            }
        }
    }
}

#[test]
fn an_origin_that_does_not_fit_is_refused() {
    let gpu = common::gpu();
    let size = [45, 33];
    let [whole, _, _] = screens(&gpu, kinds(), [0; 2], size);
    let mut view = View::of_size(&gpu.device, &gpu.queue, size).expect("a view");
    let colour = |screen: &Screen| screen.textures[0].1.clone();
    let codes = vrcs::plan::ColourForm::Codes;
    let analyser = Analyser::of_view(&gpu.device, &view, &colour(&whole), codes).expect("one");
    let mut encoder = gpu.encoder();
    let mut compute = encoder.begin_compute_pass(&Default::default());
    view.set_origin([10, 10]).expect("inside");
    let mut record = |frame: &Frame| analyser.record(&gpu.queue, &mut compute, &view, frame);
    assert_eq!(
        record(&Frame::of_size(size)),
        Err(FrameError::Origin {
            frame: [0, 0],
            view: [10, 10]
        })
    );
    let error = record(&Frame::of_view(&view)).expect_err("planned without");
    assert_eq!(error, FrameError::NoOrigin([10, 10]));
    assert!(error.to_string().contains("`Scene::origin`"), "{error}");
    drop(compute);

    view.set_origin([60, 0]).expect("a place");
    let error = Analyser::of_view(&gpu.device, &view, &colour(&whole), codes).expect_err("100");
    assert!(error.to_string().contains("at [60, 0] in it"), "{error}");
    let error = view.set_origin([u32::MAX, 0]).expect_err("far away");
    assert!(matches!(error, ViewError::Origin { .. }), "{error:?}");
    assert_eq!(view.origin(), [60, 0], "as it was");

    let mut covered =
        View::new(&gpu.device, &gpu.queue, [45, 33, 1], built()).expect("a covered view");
    let depth = &whole.textures[3].1;
    let given = Textures {
        surfaces: Some(&whole.surfaces),
        depth: Some(depth),
        ..Textures::default()
    };
    covered.cover(&gpu.queue, &given).expect("large enough");
    covered.set_origin([5, 5]).expect("inside");
    assert_eq!(
        covered.build(&mut gpu.encoder()),
        Err(ViewError::Uncovered),
        "to be given again"
    );
    covered.cover(&gpu.queue, &given).expect("still inside");
    covered.set_origin([60, 0]).expect("a place");
    let error = covered.cover(&gpu.queue, &given).expect_err("100 are few");
    assert!(matches!(error, ViewError::SmallTexture { .. }), "{error:?}");
}
