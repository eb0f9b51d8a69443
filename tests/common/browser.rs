//! Tint, in a headless Chromium: a second WGSL compiler, with the uniformity analysis that naga lacks.
//!
//! The page comes from a server in the test, on the loopback address, and posts what it found back to it.

use std::{
    collections::BTreeMap,
    io::{BufRead, BufReader, Read, Write},
    net::{TcpListener, TcpStream},
    path::Path,
    process::{Child, Command, Stdio},
    time::{Duration, Instant},
};

const PAGE: &str = "<!doctype html><meta charset=utf-8><script type=module>
const answer = {};
try {
    const texts = await (await fetch('/texts')).json();
    const adapter = await navigator.gpu.requestAdapter();
    const device = await adapter.requestDevice({ requiredFeatures: [...adapter.features] });
    for (const [name, code] of Object.entries(texts)) {
        device.pushErrorScope('validation');
        const info = await device.createShaderModule({ code }).getCompilationInfo();
        await device.popErrorScope();
        answer[name] = info.messages.filter(m => m.type == 'error')
            .map(m => `${m.lineNum}:${m.linePos} ${m.message}`);
    }
} catch (error) {
    answer.broken = [String(error)];
}
await fetch('/answer', { method: 'POST', body: JSON.stringify(answer) });
</script>";

/// Chromium's program; `None` if it is not installed and need not be.
///
/// # Panics
/// If it is not installed, and `VRCS_REQUIRE_TOOLS` names it.
fn chromium() -> Option<&'static str> {
    let required =
        std::env::var("VRCS_REQUIRE_TOOLS").is_ok_and(|tools| tools.contains("chromium"));
    // Ubuntu's package of that name is a stub that installs nothing here
    let program = "/usr/bin/chromium";
    let found = Path::new(program).exists() && Path::new("/usr/lib/chromium").exists();
    assert!(
        found || !required,
        "chromium is not installed (package chromium)"
    );
    if !found {
        eprintln!("skipped: chromium is not installed");
    }
    found.then_some(program)
}

/// A process that ends with the test.
struct Browser(Child);

impl Drop for Browser {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// What Tint says of WGSL texts, by name: nothing of a text that it accepts. `None` if there is no Chromium.
///
/// # Panics
/// If Chromium does not do what it should.
#[allow(dead_code, reason = "not every test compiles texts")]
pub fn tint(texts: &BTreeMap<String, String>) -> Option<BTreeMap<String, Vec<String>>> {
    let json = serde_json::to_string(texts).expect("texts");
    let found = run(PAGE, &json)?;
    let found: BTreeMap<String, Vec<String>> =
        serde_json::from_value(found).expect("what the page found");
    assert!(!found.contains_key("broken"), "{:?}", found["broken"]);
    Some(found)
}

/// What a page posts to `/answer`, as JSON; it gets `texts` from `/texts`. `None` if there is no Chromium.
///
/// # Panics
/// If Chromium does not do what it should.
pub fn run(page: &str, texts: &str) -> Option<serde_json::Value> {
    let gpu = ["--enable-unsafe-webgpu", "--use-webgpu-adapter=swiftshader"];
    run_with(&gpu, page, texts)
}

/// The same with other arguments than those for WebGPU on a software adapter.
///
/// # Panics
/// If Chromium does not do what it should.
pub fn run_with(arguments: &[&str], page: &str, texts: &str) -> Option<serde_json::Value> {
    let program = chromium()?;
    let profile = tempfile::tempdir().expect("a folder");
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let port = listener.local_addr().expect("an address").port();
    let _browser = Browser(
        Command::new(program)
            .args([
                "--headless",
                "--no-sandbox",
                "--disable-gpu-sandbox",
                "--disable-quic",
                "--no-first-run",
                "--disable-background-networking",
                "--disable-component-update",
                "--disable-sync",
            ])
            .args(arguments)
            .arg(format!("--user-data-dir={}", profile.path().display()))
            .arg(format!("http://127.0.0.1:{port}/?answer"))
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("chromium starts"),
    );
    Some(serve(&listener, page, texts))
}

/// Answers the page's requests until it has posted what it found.
fn serve(listener: &TcpListener, page: &str, texts: &str) -> serde_json::Value {
    listener.set_nonblocking(true).expect("a listener");
    let start = Instant::now();
    loop {
        match listener.accept() {
            Ok((stream, _)) => {
                if let Some(found) = answer(stream, page, texts) {
                    return found;
                }
            }
            Err(_) => std::thread::sleep(Duration::from_millis(5)),
        }
        assert!(
            start.elapsed() < Duration::from_secs(120),
            "chromium did not answer"
        );
    }
}

fn answer(stream: TcpStream, page: &str, texts: &str) -> Option<serde_json::Value> {
    stream.set_nonblocking(false).expect("a stream");
    stream
        .set_read_timeout(Some(Duration::from_secs(10)))
        .expect("a stream");
    let mut reader = BufReader::new(stream.try_clone().expect("a stream"));
    let mut request = String::new();
    let mut length = 0;
    loop {
        let mut line = String::new();
        // a browser opens connections that it never uses
        if reader.read_line(&mut line).unwrap_or(0) == 0 || line.trim().is_empty() {
            break;
        }
        if let Some(value) = line.to_lowercase().strip_prefix("content-length:") {
            length = value.trim().parse().expect("a length");
        }
        request.push_str(&line);
    }
    let mut body = vec![0; length];
    reader.read_exact(&mut body).ok()?;
    let (kind, reply) = match request.split_whitespace().nth(1) {
        Some("/?answer") => ("text/html", page),
        Some("/texts") => ("application/json", texts),
        _ => ("text/plain", ""),
    };
    let mut stream = stream;
    let _ = write!(
        stream,
        "HTTP/1.1 200 OK\r\nContent-Type: {kind}\r\nContent-Length: {}\r\nConnection: close\r\n\r\n{reply}",
        reply.len()
    );
    request
        .starts_with("POST /answer")
        .then(|| serde_json::from_slice(&body).expect("what the page found"))
}
