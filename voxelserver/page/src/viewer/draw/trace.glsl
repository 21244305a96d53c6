// The entry of the tracing pass: one sample of each pixel.

uniform ivec3 uEye;                // whole level-0 voxel of the eye
uniform vec3 uEyeOffset;           // rest of its position
uniform vec3 uForward;
uniform vec3 uRight;               // times the tangent of half the vertical field of view
uniform vec3 uUp;
uniform vec2 uSize;                // of the picture, pixels
uniform vec2 uJitter;              // of the sample inside the pixel, [0, 1)
uniform float uPixelRad;           // angle covered by the pixel in the middle
uniform uint uFrame;
uniform highp sampler2D uPrevious;  // what has been accumulated: light in rgb, samples in a
uniform bool uAccumulate;

#ifdef FIRST_HITS
layout(location = 0) out highp ivec4 oVoxel;     // voxel of the level; bits: see below
layout(location = 1) out highp ivec4 oDetails;   // t as the bits of a float, attribute
#else
layout(location = 0) out highp vec4 oLight;
#endif

void main() {
  // Pixels count from the upper left corner, as in pictures.
  vec2 pixel = vec2(gl_FragCoord.x - 0.5, uSize.y - gl_FragCoord.y - 0.5);
  vec2 at = pixel + uJitter;
  vec2 across = vec2(2.0 * at.x - uSize.x, uSize.y - 2.0 * at.y) / uSize.y;
  Task primary;
  primary.base = uEye;
  primary.offset = uEyeOffset;
  primary.direction = normalize(uForward + uRight * across.x + uUp * across.y);
  primary.voxel = ivec3(0);
  primary.level = 0;
  primary.face = -1;
  primary.t = 0.0;
  primary.weight = vec3(1.0);
  primary.medium = 0u;
  primary.kind = kPrimary;
  primary.depth = 0;
  primary.footprint = 0.0;
  primary.stream = pcg(uint(pixel.x) + pcg(uint(pixel.y) + pcg(uFrame)));
  primary.leaves = false;
  FirstHit first;
  vec3 light = lightAlong(primary, uPixelRad, first);
#ifdef FIRST_HITS
  // Bits: face 0-2, level 4-8, hole 12, hit 13, in the sun 14.
  int bits = (first.face & 7) | first.level << 4 | (first.isHole ? 1 << 12 : 0) | 1 << 13 |
             (first.sun > 0.5 ? 1 << 14 : 0);
  oVoxel = ivec4(first.voxel, first.isHit ? bits : 0);
  oDetails = ivec4(floatBitsToInt(first.t), int(first.attr), 0, 0);
#else
  vec4 before = uAccumulate ? texelFetch(uPrevious, ivec2(gl_FragCoord.xy), 0) : vec4(0.0);
  oLight = before + vec4(light, 1.0);
#endif
}
