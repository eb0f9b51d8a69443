#version 450
#extension GL_EXT_fragment_shading_rate : require
// What Vulkan KHR says the rate is, and where the centre of the coarse pixel lies, in half pixels.
layout(location = 0) out uvec4 seen;
void main() {
    uvec2 centre = uvec2(gl_FragCoord.xy * 2.0);
    seen = uvec4(uint(gl_ShadingRateEXT), centre, 0u);
}
