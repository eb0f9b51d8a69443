//! A study as files: one page that works without a network, a table for spreadsheets, and JSON.

use std::collections::BTreeMap;

use super::{
    choice::pass_break_even_ms,
    front::front,
    setting::Setting,
    study::{Point, SceneStudy, Study},
};

const PAGE: &str = include_str!("report.html");

/// The page: everything in one file.
pub fn html(study: &Study) -> String {
    let data = match serde_json::to_string(study) {
        Ok(json) => json,
        Err(error) => unreachable!("a study is plain data: {error}"),
    };
    // nothing in the data may end the element that holds it
    PAGE.replacen("/*DATA*/", &data.replace('<', "\\u003c"), 1)
}

/// The study as JSON, without its pictures.
pub fn json(study: &Study) -> String {
    let mut study = study.clone();
    for scene in &mut study.scenes {
        scene.full.clear();
        scene.close = None;
        for point in &mut scene.points {
            point.pictures.clear();
        }
    }
    match serde_json::to_string_pretty(&study) {
        Ok(json) => json + "\n",
        Err(error) => unreachable!("a study is plain data: {error}"),
    }
}

/// The columns of the table, before those of the setting.
const COLUMNS: [&str; 29] = [
    "scene",
    "name",
    "preset",
    "chosen",
    "peer",
    "front",
    "full_ms",
    "full_p95_ms",
    "variable_ms",
    "variable_p95_ms",
    "machinery_ms",
    "control_ms",
    "control_p95_ms",
    "share",
    "share_low",
    "share_high",
    "rounds",
    "drift",
    "steady",
    "primary_share",
    "retired_share_if_tiled",
    "average_rate",
    "identical",
    "flip_mean",
    "flip_p99",
    "ssim",
    "psnr",
    "seam",
    "flips",
];

/// The table, as CSV with a line of names.
pub fn csv(study: &Study) -> String {
    let keys: Vec<String> = columns_of(&Setting::default())
        .into_iter()
        .map(|(key, _)| key)
        .collect();
    let mut table = format!("{},{}\n", COLUMNS.join(","), keys.join(","));
    for scene in &study.scenes {
        let on_front = front_of(scene);
        for (index, point) in scene.points.iter().enumerate() {
            let (error, time) = (&point.seen.error, &point.time);
            let mut cells = vec![
                scene.name.clone(),
                quoted(&point.name),
                point.preset.clone().unwrap_or_default(),
                scene.presets_of(index).join(" "),
                point.peer.to_string(),
                on_front.contains(&index).to_string(),
                time.full_ms.to_string(),
                time.full_p95_ms.to_string(),
                time.variable_ms.to_string(),
                time.variable_p95_ms.to_string(),
                time.machinery_ms().to_string(),
                time.control_ms.to_string(),
                time.control_p95_ms.to_string(),
                time.share.median.to_string(),
                time.share.low.to_string(),
                time.share.high.to_string(),
                time.rounds.to_string(),
                time.drift.to_string(),
                time.is_steady.to_string(),
                point.seen.primary_share.to_string(),
                point.seen.retired_share.to_string(),
                point.seen.average_rate.to_string(),
                point.seen.identical.to_string(),
                error.flip_mean.to_string(),
                error.flip_p99.to_string(),
                error.ssim.to_string(),
                error
                    .psnr
                    .map_or_else(|| "inf".to_owned(), |v| v.to_string()),
                error.seam.to_string(),
                error.flips.to_string(),
            ];
            let own = columns_of(&point.setting);
            cells.extend(own.into_iter().map(|(_, value)| quoted(&value)));
            table += &cells.join(",");
            table.push('\n');
        }
    }
    table
}

/// The time of each pass and stage, as CSV with a line of names. What a pass takes beyond the share of pixels that are shaded is held
/// to be the same for a heavier one: so `pays_from_ms` is had.
pub fn passes_csv(study: &Study) -> String {
    let mut table =
        "scene,name,pass,full_ms,full_p95_ms,variable_ms,variable_p95_ms,pays_from_ms\n".to_owned();
    for scene in &study.scenes {
        for point in &scene.points {
            for pass in &point.time.passes {
                let shown = |ms: Option<f64>| ms.map_or_else(String::new, |ms| ms.to_string());
                let cells = [
                    scene.name.clone(),
                    quoted(&point.name),
                    pass.name.clone(),
                    shown(pass.full_ms),
                    shown(pass.full_p95_ms),
                    pass.variable_ms.to_string(),
                    pass.variable_p95_ms.to_string(),
                    shown(pass_break_even_ms(pass, point.seen.primary_share)),
                ];
                table += &cells.join(",");
                table.push('\n');
            }
        }
    }
    table
}

/// A setting's fields and values.
fn columns_of(setting: &Setting) -> Vec<(String, String)> {
    let fields = match toml::Table::try_from(setting) {
        Ok(fields) => fields,
        Err(error) => unreachable!("a setting is plain data: {error}"),
    };
    fields
        .into_iter()
        .map(|(key, value)| match value {
            toml::Value::String(text) => (key, text),
            other => (key, other.to_string()),
        })
        .collect()
}

/// A cell that may hold commas (RFC 4180).
fn quoted(text: &str) -> String {
    match text.contains([',', '"', '\n']) {
        true => format!("\"{}\"", text.replace('"', "\"\"")),
        false => text.to_owned(),
    }
}

/// A measure by name.
type Measure = (&'static str, fn(&Point) -> f64);

/// What a point costs, less being better. The page has the same names.
const COSTS: [Measure; 3] = [
    ("time", |p| p.time.share.median),
    ("primaries", |p| p.seen.primary_share),
    ("waves", |p| 1.0 - p.seen.retired_share),
];

/// What a point gives up, less being better. The page has the same names.
const ERRORS: [Measure; 6] = [
    ("flip_mean", |p| p.seen.error.flip_mean),
    ("flip_p99", |p| p.seen.error.flip_p99),
    ("ssim", |p| 1.0 - p.seen.error.ssim),
    ("rms", |p| rms(p.seen.error.psnr)),
    ("seam", |p| p.seen.error.seam),
    ("flips", |p| p.seen.error.flips),
];

/// The root mean square difference in 8-bit steps of a PSNR.
fn rms(psnr: Option<f64>) -> f64 {
    psnr.map_or(0.0, |psnr| 255.0 * 10f64.powf(-psnr / 20.0))
}

/// For each cost and each error, as `time flip_mean`: the points that no other beats in both.
pub fn fronts(points: &[Point]) -> BTreeMap<String, Vec<usize>> {
    let mut all = BTreeMap::new();
    for (cost, cost_of) in COSTS {
        for (error, error_of) in ERRORS {
            let places: Vec<[f64; 2]> = points.iter().map(|p| [cost_of(p), error_of(p)]).collect();
            all.insert(format!("{cost} {error}"), front(&places));
        }
    }
    all
}

/// The points of a scene that no other beats in both the frame's time and mean ꟻLIP.
pub fn front_of(scene: &SceneStudy) -> Vec<usize> {
    let known = scene.fronts.get("time flip_mean");
    known.cloned().unwrap_or_default()
}

/// From what time at full rate on a setting saves more than its machinery takes, in milliseconds: 0 if there is no machinery,
/// nothing if no shading is saved.
pub fn break_even_ms(point: &Point) -> Option<f64> {
    let (machinery, saved) = (point.time.machinery_ms(), point.time.saved_share());
    match (machinery > 0.0, saved > 0.0) {
        (false, _) => Some(0.0),
        (true, true) => Some(machinery / saved),
        (true, false) => None,
    }
}
