// The entry of the tracing pass: one sample of each pixel. ANALYSIS: with what layer.glsl and
// section.glsl add. FIRST_HITS: what each pixel, or each ray of a list, meets.

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
uniform bool uIsCast;              // rays come from uRays, not from the camera
// Three texels a ray: whole voxel of its origin and length; rest of the origin; direction. All but
// the first three numbers are the bits of floats.
uniform highp isampler2D uRays;

layout(location = 0) out highp ivec4 oVoxel;     // voxel of the level; bits: see below
layout(location = 1) out highp ivec4 oDetails;   // t as the bits of a float, attribute, class
#else
layout(location = 0) out highp vec4 oLight;
#endif

Task primaryOf(ivec3 base, vec3 offset, vec3 direction, vec2 pixel) {
  Task primary;
  primary.base = base;
  primary.offset = offset;
  primary.direction = direction;
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
  return primary;
}

Task cameraTask() {
  // Pixels count from the upper left corner, as in pictures.
  vec2 pixel = vec2(gl_FragCoord.x - 0.5, uSize.y - gl_FragCoord.y - 0.5);
  vec2 at = pixel + uJitter;
  vec2 across = vec2(2.0 * at.x - uSize.x, uSize.y - 2.0 * at.y) / uSize.y;
  vec3 direction = normalize(uForward + uRight * across.x + uUp * across.y);
  return primaryOf(uEye, uEyeOffset, direction, pixel);
}

#ifdef FIRST_HITS
Task castTask() {
  ivec2 at = ivec2(gl_FragCoord.xy) * ivec2(3, 1);
  ivec4 origin = texelFetch(uRays, at, 0);
  vec3 offset = intBitsToFloat(texelFetch(uRays, at + ivec2(1, 0), 0).xyz);
  vec3 direction = intBitsToFloat(texelFetch(uRays, at + ivec2(2, 0), 0).xyz);
  primaryReach = intBitsToFloat(origin.w);
  return primaryOf(origin.xyz, offset, direction, vec2(0.0));
}

void main() {
  Task primary;
  if (uIsCast) primary = castTask();
  else primary = cameraTask();
  FirstHit first;
  lightAlong(primary, uPixelRad, first);
  bool isVisible = uHasObserver && isSeen(primary, first);
  // Bits: face 0-2, level 4-8, hole 12, hit 13, in the sun 14, visible from the observer 15, cut
  // face of a section 16.
  int bits = (first.face & 7) | first.level << 4 | (first.isHole ? 1 << 12 : 0) | 1 << 13 |
             (first.sun > 0.5 ? 1 << 14 : 0) | (isVisible ? 1 << 15 : 0) |
             (first.isCap ? 1 << 16 : 0);
  oVoxel = ivec4(first.voxel, first.isHit ? bits : 0);
  oDetails = ivec4(floatBitsToInt(first.t), int(first.attr), classAt(first.index), 0);
}
#else
void main() {
  Task primary = cameraTask();
  FirstHit first;
#ifdef ANALYSIS
  vec3 light;
  if (uLayer != 0) light = layerAlong(primary, first);
  else light = lightAlong(primary, uPixelRad, first);
  if (uHasObserver && first.isHit && !isSeen(primary, first)) light = unseen(light);
#else
  vec3 light = lightAlong(primary, uPixelRad, first);
#endif
  vec4 before = uAccumulate ? texelFetch(uPrevious, ivec2(gl_FragCoord.xy), 0) : vec4(0.0);
  oLight = before + vec4(light, 1.0);
}
#endif
