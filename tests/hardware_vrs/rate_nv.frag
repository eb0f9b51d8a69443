#version 450
#extension GL_NV_shading_rate_image : require
// What Vulkan NV says the fragment's size and invocations are: width | height << 4 | invocations << 8.
layout(location = 0) out uvec4 seen;
void main() {
    uvec2 centre = uvec2(gl_FragCoord.xy * 2.0);
    seen = uvec4(
        uint(gl_FragmentSizeNV.x | (gl_FragmentSizeNV.y << 4) | (gl_InvocationsPerPixelNV << 8)),
        centre,
        0u
    );
}
