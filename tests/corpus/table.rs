//! What became of each entry point, as a table.

use std::{
    collections::BTreeMap,
    panic::{AssertUnwindSafe, catch_unwind},
};

use vrcs_passes::{
    Code, Options, emit,
    input::Shader,
    options::{Atomics, Policy},
    rewrite,
};

use super::{crates::Package, verdicts};

/// What became of an entry point.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Became {
    /// The file cannot be read on its own.
    NotRead(String),
    Rewritten,
    /// It stores nothing per pixel.
    NothingToDo,
    Refused(Vec<(Code, String)>),
    /// A panic, or text that is not valid.
    Defect(String),
}

/// An entry point.
#[derive(Clone, Debug)]
pub struct Row {
    pub package: String,
    pub file: String,
    pub entry: String,
    /// What became of it under the default options.
    pub became: Became,
    /// What becomes of it with what a user may choose.
    pub chosen: Became,
    /// The choice that was made, if one was, as arguments.
    pub choice: Option<Choice>,
    /// Whether it is a [screen-space](super::screen) entry point.
    pub counts: bool,
    /// A feature that it needs and no software driver has.
    pub lacking: Option<&'static str>,
}

/// What a user chose.
#[derive(Clone, Debug)]
pub struct Choice {
    pub options: Options,
    pub arguments: String,
}

impl Row {
    pub fn new(
        package: &Package,
        file: &str,
        entry: &str,
        (became, chosen, choice): (Became, Became, Option<Choice>),
    ) -> Row {
        Row {
            package: format!("{} {}", package.name, package.version),
            file: file.to_owned(),
            entry: entry.to_owned(),
            became,
            chosen,
            choice,
            counts: true,
            lacking: None,
        }
    }

    /// Whether somebody has to say why it is right that this is not rewritten.
    pub fn is_refused(&self) -> bool {
        match self.became {
            Became::Refused(_) => true,
            Became::NothingToDo => self.counts,
            _ => false,
        }
    }

    /// Its crate, file and entry point.
    pub fn name(&self) -> String {
        format!("{} {} {}", self.package, self.file, self.entry)
    }
}

/// The first line of a message.
pub fn first_line(text: &str) -> String {
    text.lines().next().unwrap_or_default().to_owned()
}

/// What a user may choose, from what changes least: more buffers than WebGPU's default limits, as many devices have; a target
/// of which a refusal speaks written by every pixel; atomics by weight; the word that a target is read apart from its stores, where somebody
/// has read the shader and could give it.
fn choices(shader: &Shader, entry: &str, reasons: &[(Code, String)]) -> Vec<Choice> {
    let limits = Options {
        max_uniform_buffers: 32,
        max_storage_buffers: 32,
        ..Options::default()
    };
    let mut choices = vec![Choice {
        options: limits.clone(),
        arguments: "--max-storage-buffers 32".to_owned(),
    }];
    for (_, global) in shader.module.global_variables.iter() {
        let (Some(name), Some(_)) = (&global.name, global.binding) else {
            continue;
        };
        let quoted = format!("`{name}`");
        if !reasons.iter().any(|(_, why)| why.contains(&quoted)) {
            continue;
        }
        let mut options = limits.clone();
        options.targets.insert(name.clone(), Policy::Full);
        choices.push(Choice {
            options,
            arguments: format!("--target {name}=full"),
        });
    }
    for (_, name) in verdicts::WORDS.iter().filter(|(of, _)| *of == entry) {
        let mut options = limits.clone();
        options.apart.insert((*name).to_owned());
        choices.push(Choice {
            options,
            arguments: format!("--apart {name}"),
        });
    }
    choices.push(Choice {
        options: Options {
            atomics: Atomics::Weight,
            ..limits
        },
        arguments: "--atomics weight".to_owned(),
    });
    choices
}

/// What becomes of an entry point under the default options, and with what a user may choose.
pub fn rewritten(shader: &Shader, entry: &str) -> (Became, Became, Option<Choice>) {
    let default = rewritten_with(shader, entry, &Options::default());
    let Became::Refused(reasons) = &default else {
        return (default.clone(), default, None);
    };
    for choice in choices(shader, entry, reasons) {
        let chosen = rewritten_with(shader, entry, &choice.options);
        if chosen == Became::Rewritten {
            return (default, chosen, Some(choice));
        }
    }
    (default.clone(), default, None)
}

fn rewritten_with(shader: &Shader, entry: &str, options: &Options) -> Became {
    let work = || match rewrite(&shader.module, &shader.info, entry, options) {
        Ok(rewritten) => match emit::wgsl(&rewritten.module, &rewritten.info) {
            Ok(_) => Became::Rewritten,
            // what has no WGSL, such as a ray query, is handed on as a module or as SPIR-V
            Err(error) if error.to_string().contains("ray quer") => Became::Rewritten,
            Err(error) => Became::Defect(error.to_string()),
        },
        Err(refusal) => {
            let reasons: Vec<(Code, String)> = refusal
                .findings
                .iter()
                .map(|finding| (finding.code, finding.message.clone()))
                .collect();
            let is_nothing = |(code, _): &(Code, String)| *code == Code::NothingPerPixel;
            match reasons.iter().any(is_nothing) {
                true => Became::NothingToDo,
                false => Became::Refused(reasons),
            }
        }
    };
    match catch_unwind(AssertUnwindSafe(work)) {
        Ok(became) => became,
        Err(_) => Became::Defect("a panic".to_owned()),
    }
}

/// How many entry points of one repository count where repositories are balanced, as in the survey that the goal comes from.
const MOST: usize = 10;

/// At most so many screen-space entry points of each repository, those with the least hashes of their names.
fn balanced(rows: &[Row]) -> Vec<&Row> {
    let mut of_repository: BTreeMap<&str, Vec<(u64, &Row)>> = BTreeMap::new();
    for row in rows.iter().filter(|row| row.counts) {
        // bevy's crates are one repository
        let is_bevys = row.package.starts_with("bevy_") && row.package.ends_with(" 0.19.1");
        let repository = if is_bevys { "bevy" } else { &row.package };
        let rows = of_repository.entry(repository).or_default();
        rows.push((hash(&row.name()), row));
    }
    let least = |mut rows: Vec<(u64, _)>| {
        rows.sort_by_key(|&(hash, _)| hash);
        rows.truncate(MOST);
        rows
    };
    let picked = of_repository.into_values().flat_map(least);
    picked.map(|(_, row)| row).collect()
}

/// FNV-1a.
fn hash(text: &str) -> u64 {
    text.bytes().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    })
}

/// The table as Markdown.
pub fn print(rows: &[Row]) -> String {
    let (all, balanced) = (rows.iter().collect::<Vec<_>>(), balanced(rows));
    let share = |rows: &[&Row], of: &dyn Fn(&Row) -> &Became| {
        let all = rows.iter().filter(|row| row.counts);
        let rewritten = all.clone().filter(|row| *of(row) == Became::Rewritten);
        let (rewritten, all) = (rewritten.count(), all.count());
        let percent = 100.0 * rewritten as f64 / all.max(1) as f64;
        format!("{rewritten} of {all} ({percent:.1} %)")
    };
    let nothing = rows
        .iter()
        .filter(|row| row.became == Became::NothingToDo)
        .count();
    let unread = rows
        .iter()
        .filter(|row| matches!(row.became, Became::NotRead(_)))
        .count();
    let of_others =
        |is: &dyn Fn(&Row) -> bool| rows.iter().filter(|row| !row.counts && is(row)).count();
    let others = of_others(&|row| row.became == Became::Rewritten);
    let left = of_others(&|row| matches!(row.became, Became::Refused(_)));
    let unrun = rows
        .iter()
        .filter(|row| row.counts && row.became == Became::Rewritten && row.lacking.is_some())
        .count();
    let mut text = format!(
        "# Published shaders\n\n\
         Written by `VRCS_BLESS=1 cargo test --test corpus`; the test fails where it is not current.\n\n\
         - Rewritten, of the screen-space entry points (`screen.rs` has the rule), with the default options: {}.\n\
         - The same with what a user may choose (32 buffers of each kind a stage, one target `full`, `--atomics weight`, `--apart` where it is true): {}.\n\
         - Both again, with at most {MOST} entry points of a repository (picked by hash), so that none sets the result alone: {} and {}.\n\
         - Of those rewritten by default, validated but never run, for want of a feature of lavapipe and SwiftShader: {unrun}.\n\
         - Others that are rewritten: {others}, refused: {left}. Entry points that store nothing per pixel: {nothing}. Files that are not shaders on their own: {unread}.\n\n\
         | crate | file | entry point | screen-space | becomes | on a driver | because | verdict of a reader |\n\
         |---|---|---|---|---|---|---|---|\n",
        share(&all, &|row| &row.became),
        share(&all, &|row| &row.chosen),
        share(&balanced, &|row| &row.became),
        share(&balanced, &|row| &row.chosen),
    );
    for row in rows {
        let note = match (&row.became, &row.chosen) {
            (Became::Refused(reasons), _) => {
                let mut codes: Vec<String> =
                    reasons.iter().map(|(code, _)| code.to_string()).collect();
                codes.dedup();
                let choice = match &row.choice {
                    Some(choice) => format!(" (rewritten with `{}`)", choice.arguments),
                    None => String::new(),
                };
                format!("{}: {}{choice}", codes.join(", "), reasons[0].1)
            }
            (Became::NotRead(reason) | Became::Defect(reason), _) => reason.clone(),
            _ => String::new(),
        };
        let became = match &row.became {
            Became::NotRead(_) => "not read",
            Became::Rewritten => "rewritten",
            Became::NothingToDo => "nothing to do",
            Became::Refused(_) => "refused",
            Became::Defect(_) => "defect",
        };
        let verdict = match row.is_refused() {
            true => verdicts::of(&row.package, &row.file, &row.entry).unwrap_or(""),
            false => "",
        };
        let driver = match (&row.chosen, row.lacking) {
            (Became::Rewritten, Some(feature)) => format!("not runnable: {feature}"),
            _ => String::new(),
        };
        text.push_str(&format!(
            "| {} | {} | {} | {} | {became} | {driver} | {} | {verdict} |\n",
            row.package,
            row.file,
            row.entry,
            if row.counts { "yes" } else { "no" },
            note.replace('|', "/"),
        ));
    }
    text
}
