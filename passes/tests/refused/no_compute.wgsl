@fragment
fn main() -> @location(0) vec4<f32> {
    return vec4(1.0);
}

// ---- is refused ----

error[VRCS001]: the module has no compute entry point
 = help: name a shader with `@compute`; vertex and fragment shaders have the hardware's variable-rate shading
