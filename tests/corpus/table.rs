//! What became of each entry point, as a table.

use std::panic::{AssertUnwindSafe, catch_unwind};

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
/// of which a refusal speaks written by every pixel; atomics by weight.
fn choices(shader: &Shader, reasons: &[(Code, String)]) -> Vec<Choice> {
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
    for choice in choices(shader, reasons) {
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

/// The table as Markdown.
pub fn print(rows: &[Row]) -> String {
    let share = |of: &dyn Fn(&Row) -> &Became| {
        let count =
            |wanted: &dyn Fn(&Became) -> bool| rows.iter().filter(|row| wanted(of(row))).count();
        let rewritten = count(&|became| *became == Became::Rewritten);
        let refused = count(&|became| matches!(became, Became::Refused(_)));
        let all = rewritten + refused;
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
    let mut text = format!(
        "# Published shaders\n\n\
         Written by `BLESS=1 cargo test --test corpus`; the test fails where it is not current.\n\n\
         - Rewritten, of the entry points that store per pixel, with the default options: {}.\n\
         - The same with what a user may choose (32 buffers of each kind a stage, one target `full`, `--atomics weight`): {}.\n\
         - Entry points that store nothing per pixel: {nothing}. Files that are not shaders on their own: {unread}.\n\n\
         | crate | file | entry point | becomes | because | verdict of a reader |\n\
         |---|---|---|---|---|---|\n",
        share(&|row| &row.became),
        share(&|row| &row.chosen),
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
        let verdict = match row.became {
            Became::Refused(_) => verdicts::of(&row.package, &row.file, &row.entry).unwrap_or(""),
            _ => "",
        };
        text.push_str(&format!(
            "| {} | {} | {} | {became} | {} | {verdict} |\n",
            row.package,
            row.file,
            row.entry,
            note.replace('|', "/"),
        ));
    }
    text
}
