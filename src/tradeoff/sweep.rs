//! Which settings are tried: a sweep, as TOML.
//!
//! ```toml
//! [base]                      # from here on, instead of the defaults
//! deblock = "off"
//!
//! [vary]                      # each value on its own, all else as in base
//! norm = ["l1", "l2", "max"]
//!
//! [[grid]]                    # every combination
//! threshold = [0.05, 0.1, 0.15]
//! largest = ["2x2", "4x2"]
//!
//! [[peers]]                   # the same, marked as published estimators
//! estimator = ["paper", "gdc"]
//! ```

use toml::{Table, Value};

use super::setting::{DeblockName, Estimator, LumaName, Preset, Setting, presets};

/// A setting that is tried, and why.
#[derive(Clone, Debug, PartialEq)]
pub struct Trial {
    /// The name of its preset.
    pub preset: Option<&'static str>,
    /// Whether it stands for a published estimator.
    pub is_peer: bool,
    /// The setting.
    pub setting: Setting,
}

impl Trial {
    /// What sets it apart, in a few words.
    pub fn name(&self) -> String {
        match (self.preset, self.is_peer) {
            (Some(name), _) => name.to_owned(),
            (None, true) => self.setting.estimator_summary(),
            (None, false) => self.setting.summary(),
        }
    }
}

/// Why a sweep makes no sense.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SweepError {
    /// The file is not TOML.
    #[error("line {line}: {why}")]
    NotToml {
        /// The line, from 1.
        line: usize,
        /// Why not.
        why: String,
    },
    /// A part of it is not one of `base`, `vary`, `grid` and `peers`.
    #[error("a sweep has `base`, `vary`, `grid` and `peers`; `{0}` is none of them")]
    UnknownPart(String),
    /// A part has the wrong form.
    #[error("`{part}` has to be {wanted}")]
    Form {
        /// The part.
        part: String,
        /// What it should be.
        wanted: &'static str,
    },
    /// A setting or a value does not exist.
    #[error("`{key}`: {why}")]
    Setting {
        /// The setting.
        key: String,
        /// Why it cannot be.
        why: String,
    },
    /// Nothing would be tried.
    #[error("the sweep tries nothing: give values under [vary] or [[grid]]")]
    Nothing,
}

/// The settings that a sweep file asks for, after the presets, each once.
///
/// # Errors
/// If it is no sweep, names a setting or a value that does not exist, or tries nothing.
pub fn parse(text: &str) -> Result<Vec<Trial>, SweepError> {
    let file = table_of(text)?;
    for part in file.keys() {
        if !["base", "vary", "grid", "peers"].contains(&part.as_str()) {
            return Err(SweepError::UnknownPart(part.clone()));
        }
    }
    let base = match file.get("base") {
        None => Table::new(),
        Some(base) => table(base, "base")?.clone(),
    };
    with(&base, &[])?;
    let mut asked = Vec::new();
    if let Some(vary) = file.get("vary") {
        for (key, values) in table(vary, "vary")? {
            for value in list(values, key)? {
                asked.push(asked_for(with(&base, &[(key, value)])?, false));
            }
        }
    }
    for (part, wanted, is_peer) in [
        ("grid", "a list of tables, [[grid]]", false),
        ("peers", "a list of tables, [[peers]]", true),
    ] {
        let grids = match file.get(part) {
            None => continue,
            Some(Value::Array(grids)) => grids,
            Some(_) => return Err(form(part, wanted)),
        };
        for grid in grids {
            let settings = combinations(&base, table(grid, part)?)?;
            asked.extend(settings.into_iter().map(|s| asked_for(s, is_peer)));
        }
    }
    if asked.is_empty() {
        return Err(SweepError::Nothing);
    }
    Ok(trials(asked))
}

/// What is tried if nothing is asked: thresholds by largest rates, each other knob on its own, and the published
/// estimators.
pub fn standard() -> Vec<Trial> {
    match parse(include_str!("standard.toml")) {
        Ok(trials) => trials,
        Err(error) => unreachable!("the standard sweep: {error}"),
    }
}

/// A few settings, for a first look: thresholds around the paper's, and the published estimators.
pub fn quick() -> Vec<Trial> {
    match parse(include_str!("quick.toml")) {
        Ok(trials) => trials,
        Err(error) => unreachable!("the quick sweep: {error}"),
    }
}

/// A setting that a sweep asks for. Another's estimator is a peer wherever it stands.
fn asked_for(setting: Setting, is_peer: bool) -> Trial {
    Trial {
        preset: None,
        is_peer: is_peer || setting.estimator != Estimator::Paper,
        setting,
    }
}

fn trials(asked: Vec<Trial>) -> Vec<Trial> {
    let mut trials: Vec<Trial> = presets()
        .into_iter()
        .map(|Preset { name, setting, .. }| Trial {
            preset: Some(name),
            is_peer: false,
            setting,
        })
        .collect();
    for trial in asked {
        let known = trials.iter_mut().find(|k| k.setting == trial.setting);
        match known {
            Some(known) => known.is_peer |= trial.is_peer,
            None => trials.push(trial),
        }
    }
    trials
}

/// The table that a text is.
pub(super) fn table_of(text: &str) -> Result<Table, SweepError> {
    toml::from_str(text).map_err(|error| not_toml(text, &error))
}

fn not_toml(text: &str, error: &toml::de::Error) -> SweepError {
    let before = error.span().map_or(0, |span| span.start).min(text.len());
    SweepError::NotToml {
        line: text.as_bytes()[..before]
            .iter()
            .filter(|&&b| b == b'\n')
            .count()
            + 1,
        why: error.message().replace('\n', " "),
    }
}

fn form(part: &str, wanted: &'static str) -> SweepError {
    SweepError::Form {
        part: part.to_owned(),
        wanted,
    }
}

fn table<'v>(value: &'v Value, part: &str) -> Result<&'v Table, SweepError> {
    match value {
        Value::Table(table) => Ok(table),
        _ => Err(form(part, "a table of settings")),
    }
}

fn list<'v>(value: &'v Value, key: &str) -> Result<&'v [Value], SweepError> {
    match value {
        Value::Array(values) => Ok(values),
        _ => Err(form(key, "a list of values")),
    }
}

/// Every combination of a grid's values.
fn combinations(base: &Table, grid: &Table) -> Result<Vec<Setting>, SweepError> {
    let mut chosen: Vec<Vec<(&String, &Value)>> = vec![Vec::new()];
    for (key, values) in grid {
        let values = list(values, key)?;
        chosen = chosen
            .iter()
            .flat_map(|before| {
                values.iter().map(move |value| {
                    let mut next = before.clone();
                    next.push((key, value));
                    next
                })
            })
            .collect();
    }
    if grid.is_empty() {
        return Ok(Vec::new());
    }
    chosen.iter().map(|changes| with(base, changes)).collect()
}

/// The base with some values changed.
pub(super) fn with(base: &Table, changes: &[(&String, &Value)]) -> Result<Setting, SweepError> {
    let mut all = base.clone();
    for &(key, value) in changes {
        all.insert(key.clone(), value.clone());
    }
    // one key after the other, so that the one to blame is named
    for (key, value) in &all {
        let alone = Table::from_iter([(key.clone(), value.clone())]);
        alone
            .try_into::<Setting>()
            .map_err(|error| SweepError::Setting {
                key: key.clone(),
                why: error.message().replace('\n', " "),
            })?;
    }
    let setting: Setting =
        all.try_into()
            .map_err(|error: toml::de::Error| SweepError::Setting {
                key: "base".to_owned(),
                why: error.message().replace('\n', " "),
            })?;
    check(&setting).map_err(|(key, why)| SweepError::Setting {
        key: key.to_owned(),
        why: why.to_owned(),
    })?;
    Ok(setting)
}

/// Whether the numbers are in their ranges.
fn check(setting: &Setting) -> Result<(), (&'static str, &'static str)> {
    let is_fine = |value: f64| value.is_finite() && value >= 0.0;
    if !is_fine(setting.threshold) {
        return Err(("threshold", "has to be 0 or more"));
    }
    if !is_fine(setting.ambient) || setting.ambient > 1.0 {
        return Err(("ambient", "has to be 0 to 1"));
    }
    if !is_fine(setting.tolerance) {
        return Err(("tolerance", "has to be 0 or more"));
    }
    if !is_fine(setting.half_rate) || setting.half_rate > 1.0 {
        return Err(("half_rate", "has to be 0 to 1"));
    }
    if ![2, 4, 8, 16].contains(&setting.granularity) {
        return Err(("granularity", "has to be 2, 4, 8 or 16"));
    }
    if setting.luma == LumaName::Root && setting.deblock == DeblockName::Off {
        return Err((
            "luma",
            "the root of luma is what the deblocker leaves: it needs one",
        ));
    }
    if setting.every == 0 {
        return Err(("every", "has to be 1 or more"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::{super::setting::NormName, *};

    fn settings(text: &str) -> Vec<Setting> {
        let trials = parse(text).expect("a sweep");
        trials
            .into_iter()
            .skip(presets().len())
            .map(|t| t.setting)
            .collect()
    }

    #[test]
    fn a_sweep_of_nothing_is_refused() {
        assert_eq!(parse(""), Err(SweepError::Nothing));
        assert_eq!(parse("[base]\nthreshold = 0.1"), Err(SweepError::Nothing));
        assert_eq!(parse("[vary]\nthreshold = []"), Err(SweepError::Nothing));
    }

    #[test]
    fn each_value_varies_on_its_own() {
        let found =
            settings("[base]\nambient = 0.1\n[vary]\nthreshold = [0.1, 0.2]\nnorm = [\"max\"]");
        assert_eq!(found.len(), 3);
        assert!(found.iter().all(|s| s.ambient == 0.1));
        assert_eq!(found.iter().filter(|s| s.norm == NormName::Max).count(), 1);
    }

    #[test]
    fn a_grid_is_every_combination() {
        let found = settings("[[grid]]\nthreshold = [0.1, 0.2, 0.3]\nnorm = [\"l1\", \"max\"]");
        assert_eq!(found.len(), 6);
    }

    #[test]
    fn what_does_not_exist_is_named() {
        let refused = |text| parse(text).expect_err("no sweep").to_string();
        assert!(refused("[vary]\nthreshhold = [1.0]").contains("threshhold"));
        assert!(refused("[vary]\nnorm = [\"l3\"]").contains("l3"));
        assert!(refused("[vary]\nthreshold = [-1.0]").contains("0 or more"));
        assert!(refused("[vary]\ngranularity = [3]").contains("2, 4, 8 or 16"));
        assert!(refused("[vary]\nthreshold = [1.0\nx").starts_with("line "));
        assert!(refused("[sweep]\nnorm = []").contains("sweep"));
        let base = refused("[base]\nnorm = \"l9\"\n[vary]\nthreshold = [0.1]");
        assert!(base.starts_with("`norm`"), "{base}");
        let base = refused("[base]\nambient = 7.0\n[vary]\nthreshold = [0.1]");
        assert!(base.starts_with("`ambient`"), "{base}");
        assert!(refused("[vary]\nnorm = \"l1\"").contains("a list"));
    }

    #[test]
    fn the_standard_sweep_varies_every_knob() {
        let trials = standard();
        assert!(trials.len() > 30, "{}", trials.len());
        let all: Vec<Table> = trials
            .iter()
            .map(|t| Table::try_from(&t.setting).expect("plain data"))
            .collect();
        for key in all[0].keys() {
            assert!(
                all.iter().any(|other| other[key] != all[0][key]),
                "{key} never varies"
            );
        }
    }

    #[test]
    fn the_paper_stands_among_its_peers_and_all_are_kept_still_alike() {
        for trials in [quick(), standard()] {
            let peers: Vec<&Setting> = trials
                .iter()
                .filter(|trial| trial.is_peer)
                .map(|trial| &trial.setting)
                .collect();
            assert!(peers.iter().any(|s| s.estimator == Estimator::Paper));
            assert!(peers.len() >= 7, "{}", peers.len());
            for peer in &peers {
                assert_eq!(peer.hysteresis, peers[0].hysteresis);
                assert_eq!(peer.largest, peers[0].largest);
            }
        }
    }
}
