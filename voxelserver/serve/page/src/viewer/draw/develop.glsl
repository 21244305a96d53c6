// From accumulated light to the screen: exposure, a tone curve, sRGB (raytracer/core/output/develop).

uniform highp sampler2D uAccumulated;  // light in rgb, number of samples in a
uniform vec2 uScale;                   // pixels of the screen to pixels of the picture
uniform float uExposure;               // factor
uniform int uTone;                     // 0 photographic, 1 linear

const float kPhotographicScale = 1.15;  // middle grey is that of the other curves

layout(location = 0) out highp vec4 oColour;

vec3 toSrgb(vec3 c) {
  c = clamp(c, 0.0, 1.0);
  return mix(c * 12.92, 1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, greaterThan(c, vec3(0.0031308)));
}

void main() {
  ivec2 size = textureSize(uAccumulated, 0);
  ivec2 at = clamp(ivec2(gl_FragCoord.xy * uScale), ivec2(0), size - 1);
  vec4 sum = texelFetch(uAccumulated, at, 0);
  vec3 light = max(sum.rgb / max(sum.a, 1e-6), 0.0) * uExposure;
  oColour = vec4(toSrgb(uTone == 0 ? 1.0 - exp(-light * kPhotographicScale) : light), 1.0);
}
