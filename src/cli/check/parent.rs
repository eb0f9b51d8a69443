//! Starts the process that makes a check, listens to it, and ends it if it takes too long.

use std::{
    collections::BTreeMap,
    io::{BufRead, BufReader, Write},
    process::{Child, Command, Stdio},
    sync::mpsc::{Receiver, RecvTimeoutError, channel},
    time::Duration,
};

use super::{Failure, Order, Word, child, talk};
use crate::check::{Report, Verdict};

/// Has a check made.
pub(super) fn check(order: &Order, limit: Duration) -> Result<Report, Failure> {
    let outside = |error: &dyn std::fmt::Display| {
        Failure::Outside(format!("the check could not be started: {error}"))
    };
    let program = std::env::current_exe().map_err(|error| outside(&error))?;
    let mut child = Command::new(program)
        .arg(child::NAME)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .map_err(|error| outside(&error))?;
    let json = serde_json::to_string(order).map_err(|error| outside(&error))?;
    if let Some(mut stdin) = child.stdin.take() {
        stdin
            .write_all(json.as_bytes())
            .map_err(|error| outside(&error))?;
    }
    let words = listen(&mut child);
    let mut done = 0;
    let outcome = loop {
        match words.recv_timeout(limit) {
            Ok(Word::Case(_)) => {
                done += 1;
                talk::status(&format!("{}: {done} of {} cases", order.entry, order.cases));
            }
            Ok(Word::Report(report)) => break Ok(*report),
            Ok(Word::Failed(status, message)) => {
                break Err(match status {
                    1 => Failure::Refused(message),
                    2 => Failure::Misused(message),
                    _ => Failure::Outside(message),
                });
            }
            Err(RecvTimeoutError::Timeout) => {
                // nothing more can be done if it does not die
                let _ = child.kill();
                let why = format!("case {done} took longer than {} s", limit.as_secs());
                break Ok(without_result(order, Verdict::Inconclusive, why));
            }
            Err(RecvTimeoutError::Disconnected) => {
                let how = match child.wait() {
                    Ok(status) => status.to_string(),
                    Err(error) => error.to_string(),
                };
                // before the first case only the original has run
                let (verdict, what) = match done {
                    0 => (
                        Verdict::Inconclusive,
                        "the original, or the first case,".to_owned(),
                    ),
                    n => (Verdict::Failed, format!("case {n}")),
                };
                let why = format!("{what} ended the process ({how})");
                break Ok(without_result(order, verdict, why));
            }
        }
    };
    talk::status_done();
    let _ = child.wait();
    outcome
}

fn listen(child: &mut Child) -> Receiver<Word> {
    let (sender, receiver) = channel();
    if let Some(stdout) = child.stdout.take() {
        std::thread::spawn(move || {
            for line in BufReader::new(stdout).lines().map_while(Result::ok) {
                let Ok(word) = serde_json::from_str(&line) else {
                    continue;
                };
                if sender.send(word).is_err() {
                    return;
                }
            }
        });
    }
    receiver
}

fn without_result(order: &Order, verdict: Verdict, why: String) -> Report {
    Report {
        entry: order.entry.clone(),
        adapter: order
            .adapter
            .clone()
            .unwrap_or_else(|| "the default adapter".to_owned()),
        verdict,
        why: Some(why),
        held: BTreeMap::new(),
        failure: None,
        notes: Vec::new(),
        targets: Vec::new(),
    }
}
