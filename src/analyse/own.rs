//! The application's own rates: what it knows of a material, an object, a distance or its particles, combined with what was found.
//!
//! Does: on each pixel, combines the rate that the analysis found with each rate that the application states, by D3D12's and Vulkan's
//! [combiners](crate::rate::Combiner): ids first, then distance, then particles. A quad has the finest of its pixels.
//! Needs: a texture of ids, this frame's depth, or flags: for what is stated, and no other.
//! Guarantees: what is flagged for [full rate](super::inputs::flags::FULL) stays there whatever is stated (alpha-tested surfaces, a HUD);
//! what is no depth is at full rate; nothing is coarser than [`Settings::largest`](super::Settings::largest); a source that states
//! nothing changes no byte.
//! Refuses: nothing; an id beyond the list states nothing.
//!
//! The rates are those of compute passes. The hardware's attachment leaves them out: draws state theirs themselves there, and the same
//! combiners join them to the attachment (NVIDIA, GDC 2019, "Using Combiners").
//!
//! Sources: GDC 2019, "DX12 API: Using Combiners"; Wicked Engine, per-material rates and coarse particles; Intel VALAR's and AMD's
//! documents, rates by distance.

use super::{
    inputs::{Inputs, flags},
    params,
    reasons::Reason,
};
use crate::{
    rate::{Combiner, LargestAxis, Rate},
    sri::Sri,
};

/// The application's own rates. The default states nothing.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "cli",
    derive(serde::Deserialize),
    serde(rename_all = "kebab-case", default, deny_unknown_fields)
)]
pub struct OwnRates {
    /// By material or object.
    pub ids: Option<IdRates>,
    /// By distance.
    pub distance: Option<DistanceLadder>,
    /// Of particles.
    pub particles: Option<Particles>,
}

/// Rates by material or object.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "cli",
    derive(serde::Deserialize),
    serde(rename_all = "kebab-case", default, deny_unknown_fields)
)]
pub struct IdRates {
    /// The rate of each id, of at most 256; `None`, or an id beyond the list, states nothing.
    #[cfg_attr(
        feature = "cli",
        serde(deserialize_with = "super::written::rates_by_id")
    )]
    pub rates: Vec<Option<Rate>>,
    /// How it is combined: what was found is A, the rate stated is B.
    pub combiner: Combiner,
}

impl Default for IdRates {
    /// No rates, and the finer of what is found and stated.
    fn default() -> IdRates {
        IdRates {
            rates: Vec::new(),
            combiner: Combiner::Min,
        }
    }
}

/// Rates by distance: what is far may be coarse, or what is near need not be.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "cli",
    derive(serde::Deserialize),
    serde(rename_all = "kebab-case", default, deny_unknown_fields)
)]
pub struct DistanceLadder {
    /// A distance, and the rate from there on, in order of distance; the last that is reached holds. An infinite distance is
    /// no step. In units of the scene, as `near`.
    #[cfg_attr(feature = "cli", serde(deserialize_with = "super::written::steps"))]
    pub steps: [(f64, Rate); 4],
    /// How it is combined: what was found is A, the rate stated is B.
    pub combiner: Combiner,
    /// The near plane's distance.
    pub near: f64,
    /// The far plane's distance; may be infinite.
    pub far: f64,
    /// Whether depth 1 is near.
    pub reversed_z: bool,
}

impl Default for DistanceLadder {
    /// No steps.
    fn default() -> DistanceLadder {
        DistanceLadder {
            steps: [(f64::INFINITY, Rate::R1X1); 4],
            combiner: Combiner::Max,
            near: 0.1,
            far: f64::INFINITY,
            reversed_z: true,
        }
    }
}

/// The rate of what is flagged as a [particle](flags::PARTICLE).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "cli",
    derive(serde::Deserialize),
    serde(rename_all = "kebab-case", default, deny_unknown_fields)
)]
pub struct Particles {
    /// The rate.
    pub rate: Rate,
    /// How it is combined: what was found is A, the rate stated is B.
    pub combiner: Combiner,
}

impl Default for Particles {
    /// 2x2, or what is coarser (Wicked Engine: 24.7 to 3.4 ms).
    fn default() -> Particles {
        Particles {
            rate: Rate::R2X2,
            combiner: Combiner::Max,
        }
    }
}

/// The code of no rate.
const NONE: u32 = 15;

/// The own rates as the kernel and its twin take them.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(crate) struct Params {
    size: [u32; 2],
    pitch: u32,
    largest: u32,
    most: u32,
    ids_combiner: u32,
    distance_combiner: u32,
    particles_combiner: u32,
    particles: u32,
    steps: u32,
    depth_offset: u32,
    has: u32,
    reach: [u32; 4],
    ids: [u32; 32],
    origin: [u32; 2],
    padding: [u32; 2],
}

// `has`: bit 0, depth 1 is near; bit 1, the reasons are those of these rates

/// Four bits of each code, eight to a word.
fn nibbles<const N: usize>(codes: impl Iterator<Item = Option<Rate>>) -> [u32; N] {
    let mut words = [u32::MAX; N];
    for (at, rate) in codes.enumerate().take(N * 8) {
        let code = rate.map_or(NONE, |rate| u32::from(rate.code()));
        let shift = at % 8 * 4;
        words[at / 8] = words[at / 8] & !(15 << shift) | code << shift;
    }
    words
}

impl Params {
    pub(crate) fn new(own: &OwnRates, most: Rate, size: [u32; 2], has_reasons: bool) -> Params {
        let ids = own.ids.clone().unwrap_or_default();
        let ladder = own.distance.unwrap_or_default();
        let particles = own.particles.unwrap_or_default();
        let steps = ladder
            .steps
            .map(|(from, rate)| from.is_finite().then_some(rate));
        Params {
            size,
            pitch: crate::sri::SriLayout::new(size[0], size[1]).pitch / 4,
            largest: u32::from(clamp_of(most).rate().code()),
            most: u32::from(most.code()),
            ids_combiner: ids.combiner as u32,
            distance_combiner: ladder.combiner as u32,
            particles_combiner: particles.combiner as u32,
            particles: u32::from(particles.rate.code()),
            steps: nibbles::<1>(steps.into_iter())[0],
            depth_offset: (ladder.near / ladder.far * 1_073_741_824.0).clamp(0.0, 1_073_741_824.0)
                as u32,
            has: u32::from(ladder.reversed_z) | u32::from(has_reasons) << 1,
            // rounded down: what is on the border is nearer
            reach: ladder.steps.map(|(from, _)| {
                (ladder.near / from * 1_073_741_824.0).clamp(0.0, 1_073_741_824.0) as u32
            }),
            ids: nibbles(ids.rates.iter().copied()),
            origin: [0; 2],
            padding: [0; 2],
        }
    }

    /// The same where the view does not start at the pictures' first corner.
    pub(crate) fn placed_at(self, origin: [u32; 2]) -> Params {
        Params { origin, ..self }
    }
}

/// What the combiners clamp to: the axis of the coarsest rate that is asked for.
fn clamp_of(most: Rate) -> LargestAxis {
    match most.is_within(Rate::R2X2) {
        true => LargestAxis::Two,
        false => LargestAxis::Four,
    }
}

/// Combines an image of rates with what the application states; writes [`Reason::Own`] where that changes it, if there are reasons.
pub(crate) fn combine(
    found: &Sri,
    own: &OwnRates,
    most: Rate,
    inputs: &Inputs,
    reasons: &mut [u8],
) -> Sri {
    let [width, height] = inputs.size;
    let params = Params::new(own, most, inputs.size, true);
    let pixel = |code: u8, at: usize| -> Rate {
        let clamp = clamp_of(most);
        let mut rate = Rate::from_code_or_full(code);
        let mut join = |stated: Option<Rate>, combiner: Combiner| {
            if let Some(stated) = stated {
                rate = combiner.combine(rate, stated, clamp);
            }
        };
        if let (Some(rates), Some(ids)) = (&own.ids, inputs.ids) {
            let stated = rates.rates.iter().take(256).nth(usize::from(ids[at]));
            join(stated.copied().flatten(), rates.combiner);
        }
        if let (Some(ladder), Some(depth)) = (&own.distance, inputs.depth) {
            let inverse =
                params::inverse_distance(depth[at], params.depth_offset, ladder.reversed_z);
            let Some(inverse) = inverse else {
                return Rate::R1X1;
            };
            let mut reached = ladder.steps.iter().zip(params.reach);
            let stated = reached.rfind(|((from, _), reach)| from.is_finite() && inverse <= *reach);
            join(stated.map(|((_, rate), _)| *rate), ladder.combiner);
        }
        let mark = inputs.flags.map_or(0, |flags| flags[at]);
        if let (Some(particles), true) = (own.particles, mark & flags::PARTICLE != 0) {
            join(Some(particles.rate), particles.combiner);
        }
        match mark & flags::FULL != 0 {
            true => Rate::R1X1,
            false => rate,
        }
    };
    let pitch = found.layout().pitch;
    Sri::from_fn(width, height, |x, y| {
        let code = found.code(x, y);
        let rates = (0..4).map(|i| {
            let (px, py) = (
                (x * 2 + i % 2).min(width - 1),
                (y * 2 + i / 2).min(height - 1),
            );
            pixel(code, (py * width + px) as usize)
        });
        let rate = rates.fold(most, Rate::meet);
        let reason = reasons.get_mut((y * pitch + x) as usize);
        if let (Some(reason), true) = (reason, rate.code() != code) {
            *reason = Reason::Own as u8;
        }
        rate.code()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analyse::{Colour, Settings, integer};

    const SIZE: [u32; 2] = [16, 8];

    /// What is known beside the picture.
    #[derive(Default)]
    struct Given<'a> {
        ids: Option<&'a [u8]>,
        depth: Option<&'a [f32]>,
        flags: Option<&'a [u8]>,
    }

    /// Rates of a plain picture (all 2x2) with striped lower half (all 1x2 there), under own rates.
    fn rates(own: OwnRates, given: Given) -> Sri {
        let picture: Vec<[u8; 4]> = (0..128u32)
            .map(|i| [if i >= 64 { (i % 2 * 200) as u8 } else { 90 }; 4])
            .collect();
        let inputs = Inputs {
            ids: given.ids,
            depth: given.depth,
            flags: given.flags,
            ..Inputs::of_colour(SIZE, Colour::Codes(&picture))
        };
        let settings = Settings {
            own: Some(own),
            ..Settings::default()
        };
        integer::analyse(&inputs, &settings).expect("inputs").sri
    }

    #[test]
    fn what_states_nothing_changes_nothing() {
        let plain = rates(OwnRates::default(), Given::default());
        let (ids, depth) = ([3; 128], [0.5; 128]);
        let stated = OwnRates {
            ids: Some(IdRates {
                rates: vec![Some(Rate::R1X1); 3],
                combiner: Combiner::Override,
            }),
            distance: Some(DistanceLadder::default()),
            particles: Some(Particles::default()),
        };
        let found = rates(
            stated,
            Given {
                ids: Some(&ids),
                depth: Some(&depth),
                flags: Some(&[0; 128]),
            },
        );
        assert_eq!(found, plain);
        assert_eq!(plain.code(0, 0), Rate::R2X2.code());
        assert_eq!(plain.code(0, 3), Rate::R1X2.code());
    }

    #[test]
    fn a_material_states_its_rate_by_its_combiner() {
        let ids: Vec<u8> = (0..128).map(|i| u8::from(i % 16 >= 8)).collect();
        for (combiner, above, below) in [
            (Combiner::Passthrough, Rate::R2X2, Rate::R1X2),
            (Combiner::Override, Rate::R2X1, Rate::R2X1),
            (Combiner::Min, Rate::R2X1, Rate::R1X1),
            (Combiner::Max, Rate::R2X2, Rate::R2X2),
            (Combiner::Sum, Rate::R2X2, Rate::R2X2),
        ] {
            let own = OwnRates {
                ids: Some(IdRates {
                    rates: vec![None, Some(Rate::R2X1)],
                    combiner,
                }),
                ..OwnRates::default()
            };
            let found = rates(
                own,
                Given {
                    ids: Some(&ids),
                    ..Given::default()
                },
            );
            assert_eq!(found.code(6, 0), above.code(), "{combiner:?}");
            assert_eq!(found.code(6, 3), below.code(), "{combiner:?}");
            assert_eq!(found.code(1, 0), Rate::R2X2.code(), "no rate stated");
        }
    }

    #[test]
    fn a_quad_is_as_fine_as_its_finest_pixel() {
        let mut ids = [0; 128];
        ids[5 * 16 + 4] = 1;
        let own = OwnRates {
            ids: Some(IdRates {
                rates: vec![Some(Rate::R2X2), Some(Rate::R1X1)],
                combiner: Combiner::Override,
            }),
            ..OwnRates::default()
        };
        let found = rates(
            own,
            Given {
                ids: Some(&ids),
                ..Given::default()
            },
        );
        for (x, y) in (0..8).flat_map(|x| (0..4).map(move |y| (x, y))) {
            let wanted = match (x, y) {
                (2, 2) => Rate::R1X1,
                _ => Rate::R2X2,
            };
            assert_eq!(found.code(x, y), wanted.code(), "{x},{y}");
        }
    }

    #[test]
    fn e33_the_ladder_goes_by_distance_in_both_ways_of_depth_and_no_depth_is_full() {
        let (near, far) = (0.1, 1000.0);
        let distance = |i: usize| 1.0 + i as f64;
        for reversed_z in [true, false] {
            let depth: Vec<f32> = (0..128)
                .map(|i| {
                    let z = distance(i % 16 / 2);
                    let toward = near * (far - z) / (z * (far - near));
                    (if reversed_z { toward } else { 1.0 - toward }) as f32
                })
                .collect();
            let ladder = DistanceLadder {
                steps: [
                    (2.5, Rate::R2X1),
                    (4.5, Rate::R2X2),
                    (f64::INFINITY, Rate::R1X1),
                    (f64::INFINITY, Rate::R1X1),
                ],
                combiner: Combiner::Override,
                near,
                far,
                reversed_z,
            };
            let own = OwnRates {
                distance: Some(ladder),
                ..OwnRates::default()
            };
            let found = rates(
                own.clone(),
                Given {
                    depth: Some(&depth),
                    ..Given::default()
                },
            );
            for x in 0..8 {
                let wanted = match x {
                    0 | 1 => Rate::R1X2,
                    2 | 3 => Rate::R2X1,
                    _ => Rate::R2X2,
                };
                assert_eq!(
                    found.code(x, 3),
                    wanted.code(),
                    "{x}, reversed {reversed_z}"
                );
            }
            for bad in [f32::NAN, -1.0, 2.0, f32::INFINITY] {
                let depth = [bad; 128];
                let found = rates(
                    own.clone(),
                    Given {
                        depth: Some(&depth),
                        ..Given::default()
                    },
                );
                assert_eq!(found, Sri::uniform(16, 8, Rate::R1X1), "{bad}");
            }
        }
    }

    #[test]
    fn particles_are_coarse_and_what_is_excluded_is_full_whatever_is_stated() {
        let mut marks = [0; 128];
        marks[7 * 16] = flags::PARTICLE;
        marks[7 * 16 + 4] = flags::PARTICLE | flags::FULL;
        let own = OwnRates {
            particles: Some(Particles::default()),
            ..OwnRates::default()
        };
        let found = rates(
            own,
            Given {
                flags: Some(&marks),
                ..Given::default()
            },
        );
        // one pixel of a quad is no particle: the finest holds
        assert_eq!(found.code(0, 3), Rate::R1X2.code());
        assert_eq!(found.code(2, 3), Rate::R1X1.code());
        let mut all = [flags::PARTICLE; 128];
        all[0] |= flags::FULL;
        let own = OwnRates {
            particles: Some(Particles::default()),
            ..OwnRates::default()
        };
        let found = rates(
            own,
            Given {
                flags: Some(&all),
                ..Given::default()
            },
        );
        assert_eq!(found.code(0, 0), Rate::R1X1.code());
        assert_eq!(found.code(3, 3), Rate::R2X2.code());
    }
}
