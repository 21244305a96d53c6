// The appearance of materials (raytracer/core/material), from the tables of appearance.bin
// (docs/formats/site.md).

uniform highp sampler2D uMaterials;  // kMaterialTexels texels a row, a row a material
uniform highp sampler2D uRatio;      // drawings: colour ratio, opacity; rows of 1024
uniform highp sampler2D uOwn;        // drawings: colour of their own, its share; rows of 1024
uniform highp sampler2D uPanes;      // windows: two texels each, own colour and share, then glass
uniform vec4 uMeanPane;              // of all windows: own colour, share
uniform float uMeanGlass;
uniform float uVoxel_m;              // edge of a level-0 voxel
uniform float uColourMix;            // share of the true colour; below 0: true colours only
uniform bool uTextures;
uniform bool uNightTime;             // some windows are lit
uniform ivec2 uWavesAt;              // x and z, level-0 voxels, at which waves have these phases:
uniform float uWaves[8];             // turns, [0, 1)
uniform vec2 uRuffled;               // of the patches of calm and ruffled water

const int kMips = 5;
const int kTexels = 16;
const uint kVariantTexels = 341u;
const uint kLamp = 28u;
const uint kWall = 8u;
const uint kGround = 3u;
const uint kGrass = 4u;
const uint kLowPlants = 5u;
const uint kHighPlants = 7u;

const int kSolid = 0;
const int kLeaves = 1;
const int kWater = 2;
const int kGlass = 3;

struct Appearance {
  int kind;
  vec3 colour;
  float variation;
  float roughness;
  float index;
  bool reflects;
  vec3 absorption_per_m;
  bool windows;
  vec3 glow;
  bool waves;
  vec3 emission;
  vec3 own;
};

struct Texel {
  vec3 ratio;
  vec3 own;
  float ownShare;
  float opacity;
  float emission;
  float gloss;
  vec2 tilt;
};

struct FacePoint {
  ivec3 voxel;      // of `level`
  int level;
  int face;
  float u;          // [0, 1) over the face, along the axes after the face's own in cyclic order
  float v;
  float footprint;  // edge of what a pixel covers, level-0 voxels
  uint around;      // bits of the solid voxels around the one in front of the face
};

vec4 materialTexel(uint material, int i) {
  return texelFetch(uMaterials, ivec2(i, int(material)), 0);
}

Appearance appearanceOf(uint material) {
  vec4 a = materialTexel(material, 0);
  vec4 b = materialTexel(material, 1);
  vec4 c = materialTexel(material, 2);
  vec4 d = materialTexel(material, 3);
  return Appearance(int(a.w), a.rgb, b.x, b.y, b.z, b.w > 0.5, c.rgb, c.w > 0.5, d.rgb, d.w > 0.5,
                    materialTexel(material, 4).rgb, materialTexel(material, 5).rgb);
}

bool isTransparent(uint material) {
  int kind = int(materialTexel(material, 0).w);
  return kind == kWater || kind == kGlass;
}

uvec2 scrambled(int a, int b, uint c) {
  uvec2 h = multiply64(uvec2(uint(a), 0u), uvec2(0x7f4a7c15u, 0x9e3779b9u)) ^
            multiply64(uvec2(uint(b), 0u), uvec2(0x27d4eb4fu, 0xc2b2ae3du));
  h ^= multiply64(uvec2(c, 0u), uvec2(0x9e3779f9u, 0x165667b1u));
  h = multiply64(h ^ shiftRight64(h, 29), uvec2(0x1ce4e5b9u, 0xbf58476du));
  return h ^ uvec2(h.y, 0u);
}

// log2 of the voxels that a drawing of about a metre spans.
int spanShift() {
  if (uVoxel_m >= 0.7) return 0;
  if (uVoxel_m >= 0.35) return 1;
  if (uVoxel_m >= 0.17) return 2;
  return uVoxel_m >= 0.08 ? 3 : 4;
}

// An approximate binary logarithm, linear between powers of two.
float roughLog2(float x) {
  uint bits = floatBitsToUint(x);
  return float(int(bits >> 23) - 127) + float(bits & 0x7fffffu) * (1.0 / 8388608.0);
}

int mipOf(float texels, out float coarseShare) {
  coarseShare = 0.0;
  if (!(texels > 1.0)) return 0;
  float at = min(roughLog2(texels), float(kMips - 1));
  int fine = int(at);
  coarseShare = at - float(fine);
  return fine;
}

uint mipStart(int mip) {
  return mip == 0 ? 0u : mip == 1 ? 256u : mip == 2 ? 320u : mip == 3 ? 336u : 340u;
}

uint texelOf(uint variant, uint turn, vec2 st, int mip) {
  uint size = uint(kTexels >> mip);
  uint last = size - 1u;
  uint s = min(uint(int(st.x * float(size))), last);
  uint t = min(uint(int(st.y * float(size))), last);
  if ((turn & 4u) != 0u) {
    uint swapped = s;
    s = t;
    t = swapped;
  }
  if ((turn & 1u) != 0u) s ^= last;
  if ((turn & 2u) != 0u) t ^= last;
  return variant * kVariantTexels + mipStart(mip) + (t << (4 - mip)) + s;
}

vec4 poolTexel(highp sampler2D pool, uint index) {
  return texelFetch(pool, ivec2(int(index) & 1023, int(index) >> 10), 0);
}

// The turn that lets a drawing run up a roof; 8: no slope is known.
uint slopeTurn(uint around) {
  int east = 0;
  int south = 0;
  for (int bit = 0; bit < 8; ++bit) {
    if ((around >> bit & 1u) == 0u) continue;
    int place = bit < 4 ? bit : bit + 1;
    south += place / 3 - 1;
    east += place % 3 - 1;
  }
  if (south == 0 && east == 0) return 8u;
  if (south * south >= east * east) return south > 0 ? 0u : 2u;
  return 4u | (east > 0 ? 0u : 2u);
}

int dividedBy(int v, int by) {
  return (v - (v < 0 ? by - 1 : 0)) / by;
}

uvec2 windowHash(int a, int b, int c, uint seed) {
  uvec2 seeded = add64(uvec2(uint(c), 0u), uvec2(seed, 0u));
  uvec2 sum = multiply64(seeded, uvec2(0x7f4a7c15u, 0x9e3779b9u));
  return hash64(uvec2(uint(a), uint(b)) ^ sum);
}

struct Pane {
  vec3 own;
  float share;
  float glass;
};

Pane blendPanes(Pane a, Pane b, float t) {
  float share = a.share * (1.0 - t) + b.share * t;
  if (!(share > 0.0)) return Pane(vec3(0.0), 0.0, 0.0);
  return Pane((a.own * (a.share * (1.0 - t)) + b.own * (b.share * t)) / share, share,
              a.glass * (1.0 - t) + b.glass * t);
}

Pane paneAt(uint style, int mip, vec2 st) {
  int size = kTexels >> mip;
  ivec2 at = ivec2(st * float(size));
  int texel = int(style) * int(kVariantTexels) + int(mipStart(mip)) + (at.y << (4 - mip)) + at.x;
  int index = texel * 2;
  vec4 own = texelFetch(uPanes, ivec2(index & 1023, index >> 10), 0);
  float glass = texelFetch(uPanes, ivec2(index + 1 & 1023, index + 1 >> 10), 0).x;
  return Pane(own.rgb, own.a, glass);
}

// The windows of a wall, drawn over `texel`: see raytracer/core/material/windows.cpp.
void drawWindows(FacePoint at, ivec3 on, vec2 st, bool alongX, inout Texel texel) {
  const float kFloor_m = 3.0;
  const float kSquare_m = 1.7;
  const float kHas = (1.0 - 20.0 / 256.0) * (1.0 - 16.0 / 256.0);
  const float kMeanLit = 84.0 / 256.0 * 0.7;
  texel.emission = 0.0;
  if (!(uVoxel_m <= 4.0)) return;
  float per_m = 1.0 / uVoxel_m;
  int floors = max(1, int(floor(kFloor_m * per_m + 0.5)));
  int across = max(2, floors);
  int edge = uVoxel_m >= 1.0 ? 1 : clamp(int(floor(kSquare_m * per_m + 0.5)), 1, floors);
  float fills = uVoxel_m >= 1.0 ? min(1.14, kSquare_m * per_m) : 1.0;
  float square = float(edge) * fills;
  float texels = at.footprint * float(kTexels) / square;
  // Where a pixel covers more than a window, the mean of walls takes over.
  float farShare = 0.0;
  if (at.level > 0) farShare = 1.0;
  else if (texels > 8.0) farShare = min((roughLog2(texels) - 3.0) / 3.0, 1.0);
  Pane found = Pane(vec3(0.0), 0.0, 0.0);
  float lit = 0.0;
  if (farShare < 1.0) {
    int window = dividedBy(on.x, across);
    int storey = dividedBy(on.y, floors);
    ivec2 inside = ivec2(on.x - window * across - (across - edge) / 2,
                         on.y - storey * floors - (floors - edge + 1) / 2);
    vec2 place = (vec2(inside) + st) / square + (1.0 - 1.0 / fills) * 0.5;
    bool isInside = all(greaterThanEqual(inside, ivec2(0))) &&
                    all(lessThan(inside, ivec2(edge))) &&
                    all(greaterThanEqual(place, vec2(0.0))) && all(lessThan(place, vec2(1.0)));
    if (isInside) {
      int deep = dividedBy(on.z, across) >> 2;
      int house = window >> 2;
      uvec2 ofHouse = windowHash(alongX ? house : deep, alongX ? deep : house, storey >> 3, 1u);
      uvec2 ofWindow = windowHash(window, on.z, storey, alongX ? 2u : 3u);
      if ((ofHouse.x >> 8 & 255u) >= 20u && (ofWindow.x & 255u) >= 16u) {
        if ((ofWindow.x >> 8 & 255u) < 84u)
          lit = 0.4 + 0.6 * float(ofWindow.x >> 16 & 255u) / 255.0;
        uint style = ofHouse.x & 7u;
        float share;
        int mip = mipOf(texels, share);
        found = paneAt(style, mip, place);
        if (share > 0.0) found = blendPanes(found, paneAt(style, mip + 1, place), share);
      }
    }
  }
  float light = found.glass * lit;
  if (farShare > 0.0) {
    float share = square * square / float(across * floors) * kHas;
    Pane mean = Pane(uMeanPane.rgb, uMeanPane.a * share, uMeanGlass * share);
    found = blendPanes(found, mean, farShare);
    light += (mean.glass * kMeanLit - light) * farShare;
  }
  texel.own = found.own;
  texel.ownShare = found.share;
  texel.gloss = found.glass;
  if (uNightTime) texel.emission = light;
}

// Like a sine of period 1 with a continuous slope.
float swing(float turns) {
  float x = turns - floor(turns + 0.5);
  return 16.0 * x * (0.5 - abs(x));
}

// The slope of water's waves: see raytracer/core/material/material_table.cpp. Phases are those at uWavesAt, which
// the page computes in double precision; places are relative to it.
vec2 waterTilt(vec2 from_m, float footprint_m) {
  const float perX[8] = float[](0.0713, 0.1319, 0.2137, 0.1873, 0.3511, 0.4943, 0.5519, 0.9277);
  const float perZ[8] =
      float[](-0.0291, 0.0347, -0.1423, 0.1987, -0.0529, 0.2713, -0.4177, 0.5881);
  const float slope[8] = float[](0.0050, 0.0062, 0.0066, 0.0058, 0.0072, 0.0062, 0.0058, 0.0050);
  const float length_m[8] = float[](12.98, 7.33, 3.89, 3.66, 2.81, 1.77, 1.44, 0.91);
  float ruffled = 0.65 + 0.35 * swing(uRuffled.x + from_m.x * 0.0113 + from_m.y * 0.0067) *
                             swing(uRuffled.y + from_m.y * 0.0171 - from_m.x * 0.0049);
  vec2 tilt = vec2(0.0);
  for (int i = 0; i < 8; ++i) {
    float shown = clamp(1.5 - 1.5 * footprint_m / length_m[i], 0.0, 1.0);
    float turns = uWaves[i] + from_m.x * perX[i] + from_m.y * perZ[i];
    tilt += swing(turns) * slope[i] * shown * length_m[i] * vec2(perX[i], perZ[i]);
  }
  return tilt * ruffled;
}

Texel texelAt(uint material, Appearance look, FacePoint at) {
  Texel texel = Texel(vec3(1.0), vec3(0.0), 0.0, 1.0, 1.0, 0.0, vec2(0.0));
  if (!uTextures) {
    if (material == kWall) texel.emission = 0.0;
    return texel;
  }
  int axis = at.face >> 1;
  vec4 face = materialTexel(material, 6 + (axis != 1 ? 0 : at.face == 3 ? 2 : 1));
  uint variants = uint(face.z);
  if (variants != 0u) {
    uint flags = uint(face.w);
    uint turns = flags & 15u;
    bool metric = (flags & 256u) != 0u;
    bool layered = (flags & 512u) != 0u;
    bool hasOwn = (flags & 1024u) != 0u;
    bool hasHoles = (flags & 2048u) != 0u;
    // A face as a drawing sees it: s along the wall or east, t up or south.
    ivec3 on = ivec3(axis == 0 ? at.voxel.z : at.voxel.x, axis == 1 ? at.voxel.z : at.voxel.y,
                     at.voxel[axis]);
    vec2 st = axis == 2 ? vec2(at.u, at.v) : vec2(at.v, at.u);
    ivec3 onWall = on;
    vec2 stWall = st;
    uint variant = 0u;
    uint turn = 0u;
    float coarse = 0.0;
    int mip = kMips - 1;
    if (at.level == 0) {
      int shift = metric ? spanShift() : 0;
      if (shift > 0) {
        st = (vec2(on.xy & ((1 << shift) - 1)) + st) / float(1 << shift);
        on >>= shift;
      }
      mip = mipOf(at.footprint * float(kTexels) / float(1 << shift), coarse);
      uvec2 hash = scrambled(on.x, on.y, uint(on.z) * 8u + uint(at.face));
      uint pick = hash.x & 0xffffu;
      variant = pick * variants >> 16;
      turn = shiftRight64(hash, 20).x & turns;
      if (turns == 9u) {
        uint slope = slopeTurn(at.around);
        uint halfOf = variants / 2u;
        turn = (turn & 1u) | (slope & 6u);
        variant = (pick * halfOf >> 16) + (slope == 8u ? halfOf : 0u);
      }
      if (layered) {
        uint layout3 = shiftRight64(scrambled(on.y, 0, 0u), 7).x % 4u;
        variant = (pick * (variants / 4u) >> 16) * 4u + layout3;
      }
    }
    uint first = uint(face.x);
    uint fine = texelOf(variant, turn, st, mip);
    uint next = coarse > 0.0 ? texelOf(variant, turn, st, mip + 1) : fine;
    vec4 ratio = mix(poolTexel(uRatio, first + fine), poolTexel(uRatio, first + next), coarse);
    texel.ratio = ratio.rgb;
    texel.opacity = ratio.a;
    if (hasOwn) {
      uint ownFirst = uint(face.y);
      vec4 own = mix(poolTexel(uOwn, ownFirst + fine), poolTexel(uOwn, ownFirst + next), coarse);
      texel.own = own.rgb * look.own;
      texel.ownShare = own.a;
    }
    if (at.level > 0 && hasHoles) {
      float through = 1.0 - texel.opacity;
      for (int level = min(at.level, 5); level > 0; --level) through *= through;
      texel.opacity = 1.0 - through;
    }
    if (look.windows && axis != 1) drawWindows(at, onWall, stWall, axis == 2, texel);
  }
  if (look.waves && at.face == 3) {
    vec2 whole = vec2((at.voxel.xz << at.level) - uWavesAt);
    vec2 inside = vec2(at.v, at.u) * exp2(float(at.level));
    texel.tilt = waterTilt((whole + inside) * uVoxel_m, at.footprint * uVoxel_m);
  }
  return texel;
}

vec3 linearOf(uint attr) {
  vec3 c = vec3(attr & 255u, attr >> 8 & 255u, attr >> 16 & 255u) / 255.0;
  vec3 curved = pow((c + 0.055) / 1.055, vec3(2.4));
  return mix(c / 12.92, curved, greaterThan(c, vec3(0.04045)));
}

bool hasColour(uint attr) {
  return (attr >> 31) != 0u;
}

// A colour that is typical, not measured: the same for a whole building or tree.
bool isTinted(uint attr) {
  return (attr >> 30 & 1u) != 0u;
}

uint materialOf(uint attr) {
  return attr >> 24 & 63u;
}

// How far a photo's colour can be trusted to be that of a voxel: see raytracer/core/shade/surface.cpp.
float believed(uint material, vec3 photo) {
  if (material == kWall) return 0.0;
  bool isSoft = material == kGround || material == kGrass ||
                (material >= kLowPlants && material <= kHighPlants);
  if (!isSoft || photo.b < photo.g) return 1.0;
  return 1.0 - clamp((photo.b / max(photo.r, 1e-3) - 1.75) / (2.5 - 1.75), 0.0, 1.0);
}

vec3 baseColour(uint attr, Appearance look, ivec3 voxel, int level) {
  vec3 colour = look.colour;
  if (hasColour(attr)) {
    vec3 photo = linearOf(attr);
    float share = uColourMix < 0.0 ? 1.0 : uColourMix * believed(materialOf(attr), photo);
    colour = mix(colour, photo, share);
  }
  if (isTinted(attr) && uColourMix != 0.0) colour = linearOf(attr);
  float variation = look.variation * exp2(-float(level));
  uvec2 hash = hash64Of(uvec2(uint(voxel.x), uint(voxel.z)), uvec2(uint(voxel.y), 0u));
  return colour * (1.0 + (unitFrom(hash) - 0.5) * 2.0 * variation);
}
