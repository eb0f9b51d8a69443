// Lines of ten pixels of √luma, straight from its buffer.
#define_import_path vrcs::analyse::lines

#import vrcs::analyse::params::params
#import vrcs::analyse::pictures
#import vrcs::analyse::source
#import vrcs::analyse::strips::Line

#ifdef WHOLE
// The codes of a line: two words, and the bytes left and right of them. The previous picture is as large as this one, and as wide as so
// many words of rates.
fn words_at(origin: vec2<u32>, column: u32, line: u32) -> vec4<u32> {
    let y = clamp(i32(origin.y + line) - 1, 0, i32(params.size.y) - 1);
    let at = ((u32(y) * params.luma_pitch) >> 1u) + (origin.x >> 3u) + column;
    let words = pictures::colour[at];
    let before = pictures::colour[max(at, 1u) - 1u].y;
    let behind = pictures::colour[at + 1u].x;
    return vec4<u32>(words, before, behind);
}
#else
fn code_at(row: u32, x: i32) -> u32 {
    let source_x = source::still_source(vec2<u32>(u32(clamp(x, 0, i32(params.size.x) - 1)), 0u)).x;
    let pair = pictures::colour[(row + (source_x >> 2u)) >> 1u];
    return pictures::code_in(select(pair.x, pair.y, (source_x & 4u) != 0u), source_x);
}

// The codes of a line: two words, and the bytes left and right of them.
fn words_at(origin: vec2<u32>, column: u32, line: u32) -> vec4<u32> {
    let y = clamp(i32(origin.y + line) - 1, 0, i32(params.size.y) - 1);
    let row = source::still_row(u32(y)) * params.luma_pitch;
    let x = origin.x + column * 8u;
    if params.ratio.x == (1u << 24u) && x + 8u <= params.size.x {
        let at = (row >> 1u) + (x >> 3u);
        let words = pictures::colour[at];
        let before = pictures::colour[max(at, 1u) - 1u].y;
        let behind = pictures::colour[at + 1u].x;
        return vec4<u32>(words, before, behind);
    }
    let first = i32(x);
    return vec4<u32>(
        code_at(row, first) | (code_at(row, first + 1) << 8u) | (code_at(row, first + 2) << 16u) | (code_at(row, first + 3) << 24u),
        code_at(row, first + 4) | (code_at(row, first + 5) << 8u) | (code_at(row, first + 6) << 16u) | (code_at(row, first + 7) << 24u),
        code_at(row, first - 1) << 24u,
        code_at(row, first + 8),
    );
}
#endif

fn line_of(origin: vec2<u32>, column: u32, words: vec4<u32>) -> Line {
    let x = origin.x + column * 8u;
    let left = vec4<u32>(
        select(words.z >> 24u, words.x & 255u, x == 0u), (words.x >> 8u) & 255u, words.x >> 24u, (words.y >> 8u) & 255u);
    let right = vec4<u32>(words.x & 255u, (words.x >> 16u) & 255u, words.y & 255u, (words.y >> 16u) & 255u);
    let last = vec2<u32>(words.y >> 24u, select(words.w & 255u, words.y >> 24u, x + 8u == params.size.x));
    return Line(pictures::lumas_of(left), pictures::lumas_of(right), pictures::lumas_of(last.xyxy).xy);
}

fn line_at(origin: vec2<u32>, column: u32, line: u32) -> Line {
    return line_of(origin, column, words_at(origin, column, line));
}
