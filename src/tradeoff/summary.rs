//! What all scenes together say of the paper's analysis: its Fig. 10 redrawn, and a verdict on its t and l.
//!
//! *Guarantees*: every scene counts the same; nothing is said before a scene has its truth.

use super::study::{SceneStudy, Summary, Truth, TruthAt};
use crate::analyse::content::Sensitivity;

/// The SSIM below which a threshold is called high: the loss of one in fifty.
const KEPT: f64 = 0.98;

/// The summary of scenes whose truth is known; nothing if there are none.
pub fn of(scenes: &[SceneStudy]) -> Option<Summary> {
    let known: Vec<(&str, &Truth)> = scenes
        .iter()
        .filter_map(|scene| Some((scene.name.as_str(), scene.truth.as_ref()?)))
        .collect();
    let truths: Vec<&Truth> = known.iter().map(|(_, truth)| *truth).collect();
    let (_, first) = known.first()?;
    let curve = mean(&truths, |truth| &truth.curve);
    let ambients = mean(&truths, |truth| &truth.ambients);
    let peers = (0..first.peers.len())
        .filter_map(|index| {
            let mut sum = TruthAt::default();
            for truth in &truths {
                sum.add(&truth.peers.get(index)?.1, 1.0 / truths.len() as f64);
            }
            Some((first.peers[index].0.clone(), sum))
        })
        .collect();
    let verdict = [on_t(&known, &curve), on_l(&ambients)];
    Some(Summary {
        scenes: known.iter().map(|(name, _)| (*name).to_owned()).collect(),
        verdict: verdict.into_iter().flatten().collect(),
        curve,
        peers,
    })
}

/// Each place of a curve, its mean over scenes.
fn mean(truths: &[&Truth], of: impl Fn(&Truth) -> &Vec<TruthAt>) -> Vec<TruthAt> {
    let places = truths.iter().map(|truth| of(truth).len()).min();
    (0..places.unwrap_or_default())
        .map(|index| {
            let mut sum = TruthAt::default();
            for truth in truths {
                sum.add(&of(truth)[index], 1.0 / truths.len() as f64);
            }
            sum
        })
        .collect()
}

fn is_near(a: f64, b: f64) -> bool {
    (a - b).abs() < 1e-9
}

/// A number without what adding it up in parts has left behind.
fn plain(value: f64) -> f64 {
    (value * 1e6).round() / 1e6
}

fn percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}

/// The paper's t.
fn on_t(known: &[(&str, &Truth)], curve: &[TruthAt]) -> Option<String> {
    let paper = Sensitivity::default();
    let here = |at: &&TruthAt| is_near(at.t, paper.threshold);
    let at = curve.iter().find(here)?;
    let (worst, share) = known
        .iter()
        .filter_map(|(name, truth)| Some((*name, truth.curve.iter().find(here)?.too_coarse)))
        .max_by(|a, b| a.1.total_cmp(&b.1))?;
    let verdict = match curve.iter().rfind(|at| at.ssim >= KEPT) {
        Some(best) if best.t < paper.threshold => format!(
            "For pictures of this size it is high: of the thresholds tried, {} is the largest that keeps SSIM at {KEPT} or more, at an average \
             rate of {:.3}.",
            plain(best.t),
            best.rate
        ),
        Some(best) if best.t > paper.threshold => format!(
            "For pictures of this size it is cautious: {} still keeps SSIM at {KEPT} or more, at an average rate of {:.3}.",
            plain(best.t),
            best.rate
        ),
        Some(_) => format!("It is the largest of those tried that keeps SSIM at {KEPT} or more."),
        None => format!("It is high, as is every other that was tried: none keeps SSIM at {KEPT}."),
    };
    Some(format!(
        "At the paper's t = {}, {} of quads are too coarse on the mean of the scenes, {} in the worst of them ({worst}), and {} too fine; it \
         shades {:.3} of the pixels where {:.3} would do, at an SSIM of {:.4}. {verdict}",
        paper.threshold,
        percent(at.too_coarse),
        percent(share),
        percent(at.too_fine),
        at.rate,
        at.true_rate,
        at.ssim
    ))
}

/// The paper's l.
fn on_l(ambients: &[TruthAt]) -> Option<String> {
    let paper = Sensitivity::default();
    let wrong = |at: &TruthAt| at.too_coarse + at.too_fine;
    let at = ambients.iter().find(|at| is_near(at.l, paper.ambient))?;
    let best = ambients
        .iter()
        .min_by(|a, b| wrong(a).total_cmp(&wrong(b)))?;
    let (first, last) = (ambients.first()?, ambients.last()?);
    let verdict = match is_near(best.l, at.l) || wrong(at) - wrong(best) < 0.01 {
        true => format!("The paper's l = {} is a fair choice", plain(at.l)),
        false => format!(
            "For the paper's l, {} would be right more often, in {} of quads for {}",
            plain(best.l),
            percent(1.0 - wrong(best)),
            percent(1.0 - wrong(at))
        ),
    };
    Some(format!(
        "{verdict}: from l = {} to {} the average rate goes from {:.3} to {:.3}, and what is too coarse from {} to {}.",
        plain(first.l),
        plain(last.l),
        first.rate,
        last.rate,
        percent(first.too_coarse),
        percent(last.too_coarse)
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(t: f64, l: f64, too_coarse: f64) -> TruthAt {
        TruthAt {
            t,
            l,
            too_coarse,
            rate: 1.0 - t,
            ssim: 1.0 - t / 5.0,
            ..TruthAt::default()
        }
    }

    fn scene(name: &str, too_coarse: [f64; 3]) -> SceneStudy {
        let [low, paper, high] = too_coarse;
        SceneStudy {
            name: name.to_owned(),
            truth: Some(Truth {
                about: String::new(),
                curve: vec![
                    at(0.06, 0.05, low),
                    at(0.15, 0.05, paper),
                    at(0.3, 0.05, high),
                ],
                ambients: vec![at(0.15, 0.0, low), at(0.15, 0.05, paper)],
                peers: vec![("gdc".to_owned(), at(0.15, 0.05, high))],
            }),
            ..SceneStudy::default()
        }
    }

    #[test]
    fn without_truth_nothing_is_said() {
        assert_eq!(of(&[]), None);
        assert_eq!(of(&[SceneStudy::default()]), None);
    }

    #[test]
    fn the_mean_over_scenes_is_judged_and_the_worst_is_named() {
        let found = of(&[
            scene("plain", [0.0, 0.02, 0.1]),
            scene("ramps", [0.06, 0.2, 0.5]),
        ])
        .expect("a summary");
        assert!((found.curve[1].too_coarse - 0.11).abs() < 1e-12);
        assert!((found.peers[0].1.too_coarse - 0.3).abs() < 1e-12);
        let said = &found.verdict[0];
        assert!(said.contains("11.0 % of quads are too coarse"), "{said}");
        assert!(
            said.contains("20.0 % in the worst of them (ramps)"),
            "{said}"
        );
        assert!(
            said.contains("it is high") && said.contains("0.06"),
            "{said}"
        );
        assert!(found.verdict[1].contains("l, 0 would be right more often"));
    }

    #[test]
    fn a_threshold_that_could_be_higher_is_called_cautious() {
        let mut plain = scene("plain", [0.0, 0.01, 0.04]);
        let truth = plain.truth.as_mut().expect("it has one");
        truth.curve.iter_mut().for_each(|at| at.ssim = 0.99);
        let found = of(&[plain]).expect("a summary");
        assert!(found.verdict[0].contains("cautious"), "{:?}", found.verdict);
    }
}
