// 64-bit integers in two words (low, high), for the hashes by which the ray tracer chooses drawings
// and shades of voxels (raytracer/core/base/random.hpp).

uvec2 add64(uvec2 a, uvec2 b) {
  uint low = a.x + b.x;
  return uvec2(low, a.y + b.y + (low < a.x ? 1u : 0u));
}

uvec2 shiftRight64(uvec2 v, int by) {
  if (by == 0) return v;
  return by < 32 ? uvec2(v.x >> by | v.y << (32 - by), v.y >> by) : uvec2(v.y >> (by - 32), 0u);
}

// The whole product of two words.
uvec2 multiplyWords(uint a, uint b) {
  uint a0 = a & 0xffffu;
  uint a1 = a >> 16;
  uint b0 = b & 0xffffu;
  uint b1 = b >> 16;
  uint low = a0 * b0;
  uint middle = a1 * b0 + (low >> 16);
  uint carried = a0 * b1 + (middle & 0xffffu);
  return uvec2(low & 0xffffu | carried << 16, a1 * b1 + (middle >> 16) + (carried >> 16));
}

uvec2 multiply64(uvec2 a, uvec2 b) {
  uvec2 low = multiplyWords(a.x, b.x);
  return uvec2(low.x, low.y + a.x * b.y + a.y * b.x);
}

uvec2 hash64(uvec2 v) {
  v = add64(v, uvec2(0x7f4a7c15u, 0x9e3779b9u));
  v = multiply64(v ^ shiftRight64(v, 30), uvec2(0x1ce4e5b9u, 0xbf58476du));
  v = multiply64(v ^ shiftRight64(v, 27), uvec2(0x133111ebu, 0x94d049bbu));
  return v ^ shiftRight64(v, 31);
}

uvec2 hash64Of(uvec2 a, uvec2 b) {
  return hash64(a ^ hash64(b));
}

// A uniform number in [0, 1).
float unitFrom(uvec2 hash) {
  return float(hash.y >> 8) * (1.0 / 16777216.0);
}

// Cheap random numbers for the samples of a pixel; the ray tracer has others.
// Ref: Jarzynski and Olano, "Hash Functions for GPU Rendering", JCGT 2020 (PCG).
uint pcg(uint v) {
  uint state = v * 747796405u + 2891336453u;
  uint word = (state >> ((state >> 28) + 4u) ^ state) * 277803737u;
  return word >> 22 ^ word;
}
