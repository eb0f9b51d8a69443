//! Time against error as an SVG for a README: a panel for each scene, the front, the presets by name, and a legend.
//!
//! *Guarantees*: no script, no font of its own, no network; legible on light and on dark pages.

use std::fmt::Write;

use super::{
    report::front_of,
    study::{Point, SceneStudy, Study},
};

const WIDTH: f64 = 380.0;
const HEIGHT: f64 = 250.0;
const LEFT: f64 = 50.0;
const RIGHT: f64 = 14.0;
const TOP: f64 = 34.0;
const BOTTOM: f64 = 40.0;
const COLUMNS: usize = 2;
/// What stands below the panels: what is plotted, and the legend.
const FOOT: f64 = 48.0;

const STYLE: &str = "svg{color-scheme:light dark;font:12px system-ui,sans-serif}\
.paper{fill:#fcfcfb}.span{stroke-width:1.2}.span.preset{stroke:#c4501b}.span.on{stroke:#1b6ca8}text{fill:#43484d}.name{fill:#1d1f21;font-weight:600}.grid{stroke:#dfe1e3}.front{stroke:#1b6ca8;fill:none;stroke-width:1.5}\
.on{fill:#1b6ca8}.off{fill:#a9b1b7}.preset{fill:#c4501b}.general{fill:#fcfcfb;stroke:#c4501b;stroke-width:1.5}.peer{fill:#6b4fa0}\
@media(prefers-color-scheme:dark){.paper{fill:#16181a}.span.preset{stroke:#f08a54}.span.on{stroke:#63b3ea}text{fill:#a8aeb3}.name{fill:#e8e9ea}.grid{stroke:#34383b}.front{stroke:#63b3ea}\
.on{fill:#63b3ea}.off{fill:#6b747b}.preset{fill:#f08a54}.general{fill:#16181a;stroke:#f08a54}.peer{fill:#b39ae0}}";

/// The plot.
pub fn svg(study: &Study) -> String {
    let columns = study.scenes.len().clamp(1, COLUMNS);
    let rows = study.scenes.len().div_ceil(COLUMNS).max(1);
    // never narrower than the line that says what is plotted
    let (width, height) = (
        (WIDTH * columns as f64).max(760.0),
        HEIGHT * rows as f64 + FOOT,
    );
    let mut text = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" height=\"{height}\" role=\"img\" \
         aria-label=\"Time against error\"><style>{STYLE}</style><rect class=\"paper\" width=\"{width}\" height=\"{height}\"/>"
    );
    for (index, scene) in study.scenes.iter().enumerate() {
        let (x, y) = (index % COLUMNS, index / COLUMNS);
        panel(&mut text, scene, WIDTH * x as f64, HEIGHT * y as f64);
    }
    push(
        &mut text,
        format_args!(
            "<text x=\"12\" y=\"{}\">{}, {}×{}: mean ꟻLIP (up) against time ÷ full rate (across)</text>",
            height - 30.0,
            escaped(&study.adapter),
            study.size[0],
            study.size[1]
        ),
    );
    legend(&mut text, height - 10.0);
    text + "</svg>\n"
}

/// What each mark means, in a row.
fn legend(text: &mut String, y: f64) {
    let entries = [
        ("preset", "the scene's preset, 95 % interval"),
        ("general", "general preset"),
        ("on", "on the front"),
        ("peer", "published estimator"),
        ("off", "another setting"),
    ];
    let mut x = 18.0;
    for (class, name) in entries {
        let mark = mark(class, x, y - 4.0, 4.0, "");
        push(
            text,
            format_args!("{mark}<text x=\"{}\" y=\"{y}\">{name}</text>", x + 9.0),
        );
        x += 9.0 + breadth(name) + 14.0;
    }
}

/// How wide a text is at most, in whatever font a page has: its letters at 12 pixels.
fn breadth(text: &str) -> f64 {
    6.9 * text.chars().count() as f64
}

/// A point: a circle, or for a published estimator a diamond.
fn mark(class: &str, x: f64, y: f64, radius: f64, title: &str) -> String {
    let title = match title.is_empty() {
        true => String::new(),
        false => format!("<title>{}</title>", escaped(title)),
    };
    match class {
        "peer" => {
            let r = radius * 1.2;
            format!(
                "<path class=\"peer\" d=\"M{:.1} {y:.1}L{x:.1} {:.1}L{:.1} {y:.1}L{x:.1} {:.1}Z\">{title}</path>",
                x - r,
                y - r,
                x + r,
                y + r
            )
        }
        _ => format!(
            "<circle class=\"{class}\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius}\">{title}</circle>"
        ),
    }
}

fn push(text: &mut String, what: std::fmt::Arguments) {
    // a String takes all
    let _ = text.write_fmt(what);
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

/// Steps of 1, 2 or 5 that cut a length into four to eight parts.
fn step(length: f64) -> f64 {
    let base = 10f64.powf((length / 5.0).log10().floor());
    [1.0, 2.0, 5.0, 10.0]
        .into_iter()
        .map(|k| k * base)
        .find(|step| length / step <= 6.0)
        .unwrap_or(10.0 * base)
}

fn place(point: &Point) -> [f64; 2] {
    [point.time.share.median, point.seen.error.flip_mean]
}

fn panel(text: &mut String, scene: &SceneStudy, left: f64, top: f64) {
    let most = |of: usize, least: f64| {
        scene
            .points
            .iter()
            .map(|point| place(point)[of])
            .filter(|value| value.is_finite())
            .fold(least, f64::max)
            * 1.06
    };
    let (x_most, y_most) = (most(0, 1.0), most(1, 1e-3));
    let x = |value: f64| left + LEFT + value / x_most * (WIDTH - LEFT - RIGHT);
    let y = |value: f64| top + HEIGHT - BOTTOM - value / y_most * (HEIGHT - TOP - BOTTOM);
    push(
        text,
        format_args!(
            "<text class=\"name\" x=\"{}\" y=\"{}\">{}</text>",
            left + LEFT,
            top + 20.0,
            scene.name
        ),
    );
    let (x_step, y_step) = (step(x_most), step(y_most));
    for i in 0..=(x_most / x_step) as u32 {
        let at = f64::from(i) * x_step;
        push(
            text,
            format_args!(
                "<path class=\"grid\" d=\"M{0:.1} {1:.1}V{2:.1}\"/><text x=\"{0:.1}\" y=\"{3:.1}\" text-anchor=\"middle\">{4}</text>",
                x(at),
                y(0.0),
                top + TOP,
                y(0.0) + 16.0,
                shown(at)
            ),
        );
    }
    for i in 0..=(y_most / y_step) as u32 {
        let at = f64::from(i) * y_step;
        push(
            text,
            format_args!(
                "<path class=\"grid\" d=\"M{0:.1} {1:.1}H{2:.1}\"/><text x=\"{3:.1}\" y=\"{4:.1}\" text-anchor=\"end\">{5}</text>",
                x(0.0),
                y(at),
                left + WIDTH - RIGHT,
                x(0.0) - 6.0,
                y(at) + 4.0,
                shown(at)
            ),
        );
    }
    let front = front_of(scene);
    let line: Vec<String> = front
        .iter()
        .map(|&i| place(&scene.points[i]))
        .map(|[a, b]| format!("{:.1} {:.1}", x(a), y(b)))
        .collect();
    if !line.is_empty() {
        push(
            text,
            format_args!("<path class=\"front\" d=\"M{}\"/>", line.join("L")),
        );
    }
    let mut labels: Vec<Label> = Vec::new();
    let mut order: Vec<usize> = (0..scene.points.len()).collect();
    order.sort_by_key(|&i| {
        (
            !scene.presets_of(i).is_empty(),
            scene.points[i].preset.is_some(),
        )
    });
    for i in order {
        let point = &scene.points[i];
        let [a, b] = place(point);
        if !(a.is_finite() && b.is_finite()) {
            continue;
        }
        let chosen = scene.presets_of(i).join(", ");
        let is_general = point.preset.is_some();
        let (class, radius) = match (chosen.is_empty(), point.peer, front.contains(&i)) {
            (false, ..) => ("preset", 5.0),
            (true, ..) if is_general => ("general", 3.5),
            (true, true, _) => ("peer", 3.5),
            (true, false, true) => ("on", 3.0),
            (true, false, false) => ("off", 2.5),
        };
        push(
            text,
            format_args!("{}", mark(class, x(a), y(b), radius, &point.name)),
        );
        if matches!(class, "preset" | "on") {
            let (low, high) = (point.time.share.low, point.time.share.high);
            push(
                text,
                format_args!(
                    "<path class=\"span {class}\" d=\"M{:.1} {2:.1}H{:.1}\"/>",
                    x(low),
                    x(high.min(x_most)),
                    y(b)
                ),
            );
        }
        if !chosen.is_empty() {
            let label = Label::beside([x(a), y(b) - 7.0], &chosen, left + WIDTH)
                .above(&labels, top + TOP - 4.0);
            push(
                text,
                format_args!(
                    "<text class=\"name\" x=\"{:.1}\" y=\"{:.1}\">{chosen}</text>",
                    label.left, label.base
                ),
            );
            labels.push(label);
        }
    }
}

/// Where a label stands.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Label {
    left: f64,
    right: f64,
    /// The line that its letters stand on.
    base: f64,
}

impl Label {
    const HEIGHT: f64 = 13.0;

    /// A label to the right of a point, or to its left where the panel ends before the label does.
    fn beside([x, base]: [f64; 2], text: &str, end: f64) -> Label {
        let (gap, breadth) = (8.0, breadth(text));
        let left = match x + gap + breadth <= end {
            true => x + gap,
            false => x - gap - breadth,
        };
        Label {
            left,
            right: left + breadth,
            base,
        }
    }

    /// The label, moved up until no other is in its way.
    fn above(self, others: &[Label], top: f64) -> Label {
        let mut moved = self;
        let hits = |moved: &Label, other: &Label| {
            moved.left < other.right
                && other.left < moved.right
                && (moved.base - other.base).abs() < Label::HEIGHT
        };
        while others.iter().any(|other| hits(&moved, other)) && moved.base > top {
            moved.base -= Label::HEIGHT;
        }
        moved
    }
}

/// A tick's number, without rounding errors.
fn shown(value: f64) -> String {
    format!("{}", (value * 1e6).round() / 1e6)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_round_and_neither_few_nor_many() {
        for length in [0.0013, 0.02, 0.5, 1.06, 3.3, 250.0] {
            let parts = length / step(length);
            assert!((2.0..=6.0).contains(&parts), "{length}: {parts}");
        }
        assert_eq!(step(1.06), 0.2);
    }

    #[test]
    fn labels_do_not_lie_on_one_another_nor_beyond_their_panel() {
        let first = Label::beside([100.0, 80.0], "Fast", 380.0);
        assert_eq!(first.above(&[], 30.0), first);
        assert!(first.left > 100.0);
        let second = Label::beside([104.0, 82.0], "Balanced", 380.0).above(&[first], 30.0);
        assert!(second.base <= first.base - 11.0, "{second:?}");
        let far = Label::beside([300.0, 80.0], "Fast", 380.0);
        assert_eq!(far.above(&[first], 30.0), far);
        let all = Label::beside([280.0, 80.0], "Exact, Balanced, Fast", 380.0);
        assert!(all.right < 280.0, "{all:?}");
    }

    #[test]
    fn what_could_end_a_text_is_escaped() {
        assert_eq!(escaped("a<b>&\"c\""), "a&lt;b&gt;&amp;&quot;c&quot;");
    }
}
