//! What a check tells the reader: the first difference with its pixel, and whether the check could have failed at all.

use naga::{GlobalVariable, Handle, Span};
use vrcs_passes::{instrument::OUTSIDE, options::Mode};

use super::{
    Failure, Law,
    compare::{Difference, Original},
    inputs::{Made, MadeKind},
    learn::Set,
    picture::{self, Mark},
    reference::position,
    run::Outputs,
    session::{Case, Session, Stop, inconclusive},
};

/// What the original was seen to do, over all sets of inputs.
#[derive(Debug, Default)]
pub(super) struct Seen {
    /// For each site, whether it was reached, and its place in the source.
    reached: Vec<(bool, Span)>,
    /// For each output, the values that were stored: at most two are kept.
    values: Vec<Vec<Vec<u8>>>,
    /// For each output, whether the rewrite says that a constant rules its stores out.
    ruled_out: Vec<bool>,
    /// Stores outside their resources.
    outside: usize,
}

impl Session<'_> {
    pub(super) fn failed(
        &self,
        set: &Set,
        case: &Case,
        law: Law,
        difference: &Difference,
        outputs: &Outputs,
    ) -> Stop {
        let written: Vec<&Made> = set.made.iter().filter(|made| made.written).collect();
        let made = written[difference.output];
        let texel = set.original.unit(difference.output);
        let place = match &made.kind {
            MadeKind::Texture { texture, .. } => {
                let size = texture.size();
                let [x, y, z] = position(
                    difference.byte / texel,
                    [size.width, size.height, size.depth_or_array_layers],
                );
                match size.depth_or_array_layers {
                    1 => format!("texel ({x}, {y})"),
                    _ => format!("texel ({x}, {y}, {z})"),
                }
            }
            _ => format!("byte {}", difference.byte),
        };
        let tile = self.job.options.tile;
        let hex = |bytes: &[u8]| {
            bytes
                .iter()
                .map(|byte| format!("{byte:02x}"))
                .collect::<Vec<_>>()
                .join(" ")
        };
        let (expected, got) = match law {
            Law::Partition => {
                let times = |bytes: &[u8]| {
                    let mut word = [0; 4];
                    word.copy_from_slice(&bytes[..4]);
                    format!("written {} times", u32::from_le_bytes(word))
                };
                (times(&difference.expected), times(&difference.got))
            }
            _ => (hex(&difference.expected), hex(&difference.got)),
        };
        Stop::Failed(Box::new(Failure {
            law,
            case: case.number,
            pattern: format!("{:?}", case.pattern),
            extent: case.extent,
            target: made.resource.name.clone(),
            place,
            pixel: difference.pixel,
            tile: difference.pixel.map(|p| [p[0] / tile[0], p[1] / tile[1]]),
            primary: difference.primary,
            expected,
            got,
            picture: self.picture(set, case, outputs),
        }))
    }

    fn picture(&self, set: &Set, case: &Case, outputs: &Outputs) -> Vec<u8> {
        let [width, height] = case.extent;
        let count = (width * height) as usize;
        let mut marks = vec![Mark::Nothing; count];
        let expected = set.original.expected(&case.groups, case.extent);
        set.original
            .each_due(&expected, outputs, &mut |pixel, right| {
                let mark = &mut marks[(pixel[1] * width + pixel[0]) as usize];
                if *mark != Mark::Wrong {
                    *mark = if right { Mark::Right } else { Mark::Wrong };
                }
            });
        let mut primaries = vec![false; count];
        for group in &case.groups {
            primaries[(group.primary[1] * width + group.primary[0]) as usize] = true;
        }
        picture::png(width, self.job.options.tile, &marks, &primaries)
    }

    /// Notes which stores were reached, and which values were stored.
    pub(super) fn note_seen(&mut self, original: &Original) {
        if self.seen.reached.is_empty() {
            // where the rewrite says that a constant rules every store out, none is waited for; one that comes counts
            let is_waited_for: Vec<bool> = (original.sites.iter())
                .map(|site| self.is_target(site.global))
                .collect();
            let seen = &mut self.seen;
            seen.reached = (original.sites.iter().zip(&is_waited_for))
                .map(|(site, is_waited_for)| (!is_waited_for, site.span))
                .collect();
            seen.values = vec![Vec::new(); original.outputs.len()];
            seen.ruled_out = (0..original.outputs.len())
                .map(|output| {
                    let mut sites = original.output_of_site.iter().zip(&is_waited_for);
                    !sites.any(|(of, is_waited_for)| *of == output && *is_waited_for)
                })
                .collect();
        }
        let seen = &mut self.seen;
        for invocation in 0..original.log.invocations() {
            for stored in original.log.of(invocation) {
                let site = &original.sites[stored.site as usize];
                seen.reached[stored.site as usize].0 = true;
                if stored.place == OUTSIDE {
                    continue;
                }
                let output = original.output_of_site[stored.site as usize];
                let (from, size) = match original.texel_bytes[output] {
                    Some(texel) => (stored.place as usize * texel, texel),
                    None => (stored.place as usize, site.size as usize),
                };
                let values = &mut seen.values[output];
                let value = &original.outputs[output][from..from + size];
                if values.len() < 2 && !values.iter().any(|known| known == value) {
                    values.push(value.to_vec());
                }
            }
        }
        seen.outside += original.log.outside();
    }

    /// Whether every store was reached, and no output is the same everywhere.
    pub(super) fn is_all_seen(&self) -> bool {
        self.seen.reached.iter().all(|(reached, _)| *reached) && self.constant_output().is_none()
    }

    /// An output that is the same everywhere.
    fn constant_output(&self) -> Option<usize> {
        let mut outputs = self.seen.values.iter().zip(&self.seen.ruled_out);
        outputs.position(|(values, is_ruled_out)| values.len() < 2 && !is_ruled_out)
    }

    /// Whether the rewrite says that something is stored to a resource.
    fn is_target(&self, global: Handle<GlobalVariable>) -> bool {
        let entry = &self.rewritten.manifest.entries[0];
        match &self.module.global_variables[global].name {
            Some(name) if entry.mode != Mode::Graded => {
                entry.targets.iter().any(|target| target.name == *name)
            }
            _ => true,
        }
    }

    /// A check that could not have failed has not passed.
    pub(super) fn check_seen(&mut self) -> Result<(), Stop> {
        if self.seen.outside > 0 {
            self.report.notes.push(format!(
                "{} stores of the original lie outside their resources, and have no reference",
                self.seen.outside
            ));
        }
        if let Some(&(_, span)) = self.seen.reached.iter().find(|(reached, _)| !reached) {
            return Err(inconclusive(format!(
                "a store was never reached{}",
                self.at(span)
            )));
        }
        if let Some(output) = self.constant_output() {
            let before = self.seen.ruled_out[..output].iter();
            let target = before.filter(|is_ruled_out| !**is_ruled_out).count();
            let name = self.report.targets.get(target).cloned().unwrap_or_default();
            return Err(inconclusive(format!("`{name}` is the same everywhere")));
        }
        Ok(())
    }

    /// Where a span starts, as an addition to a sentence.
    pub(super) fn at(&self, span: Span) -> String {
        match self.source.place(span) {
            Some(place) => format!(" ({}:{}:{})", place.file, place.line, place.column),
            None => String::new(),
        }
    }
}
