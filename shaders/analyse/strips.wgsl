// Sums of windows along a row of four quads: strips of two lines are summed once, and a row's windows are two strips.
#define_import_path vrcs::analyse::strips

#import vrcs::analyse::sums::Sums

// Ten pixels: those left and right in each of five squares, of which the last stands alone.
struct Line {
    left: vec4<u32>,
    right: vec4<u32>,
    last: vec2<u32>,
}

// Two lines' part of four windows, and the lower line.
struct Strip {
    across: vec4<u32>,
    down: vec4<u32>,
    brightness: vec4<u32>,
    under: Line,
}

// A difference as it is summed. What is squared needs no sign.
fn strength(a: vec4<u32>, b: vec4<u32>) -> vec4<u32> {
#ifdef MEAN
    return max(a, b) - min(a, b);
#else
    let d = a - b;
    return d * d;
#endif
}

fn strength_last(a: vec2<u32>, b: vec2<u32>) -> vec2<u32> {
#ifdef MEAN
    return max(a, b) - min(a, b);
#else
    let d = a - b;
    return d * d;
#endif
}

// Of squares to of windows, each of two.
fn paired(squares: vec4<u32>, last: u32) -> vec4<u32> {
    return squares + vec4<u32>(squares.yzw, last);
}

fn next_left(line: Line) -> vec4<u32> {
    return vec4<u32>(line.left.yzw, line.last.x);
}

// The pairs of one line and the next.
fn down_of(upper: Line, lower: Line) -> vec4<u32> {
    let last = strength_last(upper.last, lower.last);
    return paired(strength(upper.left, lower.left) + strength(upper.right, lower.right), last.x + last.y);
}

fn strip_of(upper: Line, lower: Line) -> Strip {
    let inside = strength(upper.left, upper.right) + strength(lower.left, lower.right);
    let last = strength_last(vec2<u32>(upper.last.x, lower.last.x), vec2<u32>(upper.last.y, lower.last.y));
    let between = strength(upper.right, next_left(upper)) + strength(lower.right, next_left(lower));
    let light = (upper.left + upper.right) + (lower.left + lower.right);
    let light_last = upper.last + lower.last;
    return Strip(
        between + paired(inside, last.x + last.y),
        down_of(upper, lower),
        paired(light, light_last.x + light_last.y),
        lower,
    );
}

// The windows that are two strips, given the lower one's upper line as well.
fn sums_between(upper: Strip, line: Line, lower: Strip) -> Sums {
    return Sums(
        upper.across + lower.across,
        upper.down + down_of(upper.under, line) + lower.down,
        upper.brightness + lower.brightness,
    );
}
