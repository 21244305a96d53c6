// Direct light, as integrator "direct" of the ray tracer (raytracer/core/shade): sun, sky, darkened
// corners, haze, water, leaves. One sample of a pixel; what is chosen at random averages over
// frames.

uniform int uBounces;              // of mirrors
uniform bool uShadows;
uniform bool uCutOuts;             // holes between leaves
uniform bool uOcclusion;           // darkened corners
uniform bool uSoftSun;             // shadows of the sun's disc, else of its middle
uniform vec3 uSunRight;
uniform vec3 uSunUp;

const int kMaxRays = 24;           // of a sample: a bound, not reached but between many leaves
const int kStack = 4;

const vec3 kHoleColour = vec3(1.0, 0.0, 0.8);

const int kPrimary = 0;
const int kShadow = 1;
const int kMirror = 2;
const int kRefracted = 3;

struct Task {
  ivec3 base;
  vec3 offset;
  vec3 direction;
  ivec3 voxel;       // to start in, of `level`; unless `enters`
  int level;
  int face;
  float t;           // where it starts
  vec3 weight;
  uint medium;       // material that it passes through, 0: air
  int kind;
  int depth;
  float footprint;   // what the pixel covers at its origin, level-0 voxels
  uint stream;       // of random numbers
  bool leaves;       // leaves may let it pass
};

float fresnel(float cosIn, float index) {
  float sin2 = (1.0 - cosIn * cosIn) / (index * index);
  if (sin2 >= 1.0) return 1.0;
  float cosOut = sqrt(1.0 - sin2);
  float s = (cosIn - index * cosOut) / (cosIn + index * cosOut);
  float p = (index * cosIn - cosOut) / (index * cosIn + cosOut);
  return (s * s + p * p) * 0.5;
}

vec3 normalOf(int face) {
  vec3 n = vec3(0.0);
  n[face >> 1] = (face & 1) != 0 ? 1.0 : -1.0;
  return n;
}

ivec3 neighbourOf(ivec3 voxel, int face) {
  voxel[face >> 1] += (face & 1) != 0 ? 1 : -1;
  return voxel;
}

// Whether a voxel of a level is solid in what is shown: where its column is coarser, what it is
// part of; where it is finer, its middle. Holes count as solid.
bool isSolid(ivec3 voxel, int level) {
  Ray at;
  at.voxel = voxel;
  at.level = level;
  uint base = 0u;
  for (int i = 0; i < 48; ++i) {
    uvec2 found = columnAt(at.voxel.xz >> 6, at.level);
    if (found.x == kLeaf) {
      uvec3 box = boxAt(found.y, at.voxel.y >> 8);
      if (isCutAway(at.voxel, at.level)) return false;
      if (box.x == kHole) return true;
      if (box.x != kBox) return false;
      return attributeOf(box.yz, at.voxel & ivec3(63, 255, 63)) >> 24 != kAirMaterial;
    }
    if (found.x == kSplit) {
      if (at.level == 0) return false;
      // The middle: towards the upper half of each axis first, then the lower ones.
      at.level -= 1;
      at.voxel = (at.voxel << 1) + (level - at.level == 1 ? 1 : 0);
    } else {
      if (at.level >= uCoarsest) return false;
      at.level += 1;
      at.voxel >>= 1;
    }
  }
  return false;
}

// Bits of the eight voxels around the one in front of a face: bit 3 (da + 1) + (db + 1), less one
// beyond the middle; a and b are the axes after the face's own in cyclic order.
uint aroundOf(ivec3 voxel, int level, int face) {
  ivec3 front = neighbourOf(voxel, face);
  int axis = face >> 1;
  int a = (axis + 1) % 3;
  int b = (axis + 2) % 3;
  uint bits = 0u;
  for (int i = 0; i < 8; ++i) {
    int place = i < 4 ? i : i + 1;
    ivec3 c = front;
    c[a] += place / 3 - 1;
    c[b] += place % 3 - 1;
    if (isSolid(c, level)) bits |= 1u << i;
  }
  return bits;
}

uint bitAt(uint bits, int i, int j) {
  int place = 3 * i + j;
  return bits >> (place > 4 ? place - 1 : place) & 1u;
}

float cornerOf(uint bits, int i, int j) {
  uint sideA = bitAt(bits, i, 1);
  uint sideB = bitAt(bits, 1, j);
  return float(sideA + sideB == 2u ? 3u : sideA + sideB + bitAt(bits, i, j));
}

// Ref: Lysenko, "Ambient occlusion for Minecraft-like worlds", 2012.
float openShare(uint bits, float u, float v) {
  if (bits == 0u) return 1.0;
  float level = mix(mix(cornerOf(bits, 0, 0), cornerOf(bits, 2, 0), u),
                    mix(cornerOf(bits, 0, 2), cornerOf(bits, 2, 2), u), v);
  return 1.0 - 0.22 * level;
}

// Where a point lies on a voxel's face along an axis, [0, 1).
float partOf(vec3 place, int axis, int level, ivec3 base, ivec3 voxel) {
  float size = exp2(float(level));
  float inside = (place[axis] - float((voxel[axis] << level) - base[axis])) / size;
  return clamp(inside, 0.0, 0.99999994);
}

vec3 throughMedium(uint medium, float depth_m, vec3 direction) {
  if (medium == 0u) return vec3(1.0);
  Appearance look = appearanceOf(medium);
  float sin2 = (1.0 - direction.y * direction.y) / (look.index * look.index);
  float cosIn = sqrt(max(1e-6, 1.0 - sin2));
  return exp(-look.absorption_per_m * (depth_m / cosIn)) *
         (1.0 - fresnel(max(direction.y, 0.0), look.index));
}

float numberOf(uint stream, uint use) {
  return float(pcg(stream ^ pcg(use + 1u)) >> 8) * (1.0 / 16777216.0);
}

Task sent(Task from, Ray ray, Hit hit, vec3 point, vec3 direction, int kind, vec3 weight,
          float footprint) {
  Task task = from;
  // The whole part moves along, so that the fraction stays small.
  ivec3 whole = ivec3(floor(point));
  task.base = from.base + whole;
  task.offset = point - vec3(whole);
  task.direction = direction;
  task.voxel = neighbourOf(ray.voxel, ray.face);
  task.level = ray.level;
  task.face = -1;
  task.t = 0.0;
  task.weight = weight;
  task.kind = kind;
  task.depth = from.depth + 1;
  task.footprint = footprint;
  task.stream = pcg(from.stream + uint(kind) * 7919u + 17u);
  return task;
}

struct FirstHit {
  bool isHit;
  ivec3 voxel;
  int level;
  int face;
  float t;
  uint attr;
  uint index;         // as in Hit
  bool isHole;
  bool isCap;         // the cut face of a section
  float sun;          // share of its sunlight that is not in shadow
};

const FirstHit kNothing =
    FirstHit(false, ivec3(0), 0, -1, 0.0, 0u, kNoIndex, false, false, 0.0);

// A place on the sun's disc.
vec3 sampledSun(uint stream) {
  if (!uSoftSun) return uToSun;
  float down = uSunHeight * numberOf(stream, 0u);
  float r = sqrt(down * (2.0 - down));
  float turn = 2.0 * kPi * numberOf(stream, 1u);
  return uToSun * (1.0 - down) + uSunRight * (r * cos(turn)) + uSunUp * (r * sin(turn));
}

// A cut face is as bright as level ground in the sun, and a little darker than that, wherever the
// sun stands: it is a drawing rather than a thing.
const float kCapShade = 0.8;

// @param first out: what the primary ray has met
vec3 lightAlong(Task primary, float spread, out FirstHit first) {
  first = kNothing;
  vec3 light = vec3(0.0);
  Task stack[kStack];
  stack[0] = primary;
  int height = 1;
  for (int n = 0; n < kMaxRays && height > 0; ++n) {
    Task task = stack[--height];
    Ray ray = rayOf(task.base, task.offset, task.direction);
    bool atPlane = false;
    float reach = reachOf(task.base, task.offset, task.direction);
    if (task.kind == kPrimary) reach = min(reach, primaryReach);
    if (task.kind == kPrimary && task.t == 0.0 && task.depth == 0) {
      if (!enterBounds(ray) || !enterKept(ray, task.offset, atPlane)) {
        light += task.weight * (skyRadiance(task.direction) + sunDisc(task.direction));
        continue;
      }
    } else {
      ray.level = task.level;
      ray.voxel = task.voxel;
      ray.face = task.face;
      ray.t = task.t;
    }
    bool isShadow = task.kind == kShadow;
    Stop stop = Stop(task.medium, task.medium != 0u && !isShadow);
    Hit hit = walk(ray, stop, reach);
    bool isMiss = hit.kind == kMiss;
    if (isShadow && isMiss) {
      light += task.weight;
      if (task.depth == 1) first.sun = 1.0;
      continue;
    }
    uint material = materialOf(hit.attr);
    Appearance look = appearanceOf(material);
    bool hasFace = hit.kind == kHit && ray.face >= 0;
    bool isCap = atPlane && hit.kind == kHit && ray.face < 0;
    // Leaves let a share of rays pass where a pixel is small enough to show the gaps.
    float footprint = task.footprint + spread * ray.t;
    bool isLeaves = hit.kind == kHit && look.kind == kLeaves && uCutOuts;
    if (isShadow && !(task.leaves && isLeaves)) continue;
    vec3 place = task.offset + task.direction * ray.t;
    uint around = 0u;
    Texel texel = Texel(vec3(1.0), vec3(0.0), 0.0, 1.0, 1.0, 0.0, vec2(0.0));
    FacePoint at;
    if (hasFace && material != 0u) {
      int axis = ray.face >> 1;
      at.voxel = ray.voxel;
      at.level = ray.level;
      at.face = ray.face;
      at.u = partOf(place, (axis + 1) % 3, ray.level, task.base, ray.voxel);
      at.v = partOf(place, (axis + 2) % 3, ray.level, task.base, ray.voxel);
      at.footprint = footprint;
      if (!isShadow && (uOcclusion || uTextures) && look.kind != kWater && look.kind != kGlass)
        around = aroundOf(ray.voxel, ray.level, ray.face);
      at.around = around;
      texel = texelAt(material, look, at);
    }
    bool slips = isLeaves && hasFace && uTextures && texel.opacity < 1.0 && ray.level == 0 &&
                 footprint < 1.0 && texel.opacity <= numberOf(task.stream, 6u);
    if (slips || (isLeaves && !hasFace && !isCap)) {
      // Behind the voxel that was met.
      leap(ray, ivec3(0));
      task.voxel = ray.voxel;
      task.level = ray.level;
      task.face = ray.face;
      task.t = max(ray.t, 1e-20);
      task.stream = pcg(task.stream + 65537u);
      if (height < kStack) stack[height++] = task;
      continue;
    }
    if (isShadow) continue;
    vec3 weight = task.weight;
    if (task.medium != 0u) {
      Appearance medium = appearanceOf(task.medium);
      vec3 left = exp(-medium.absorption_per_m * (isMiss ? 1000.0 : ray.t * uVoxel_m));
      vec3 glow = medium.glow * (uAmbient[3] + uSunLight * max(0.0, uToSun.y));
      light += weight * glow * (1.0 - left);
      weight *= left;
      if (isMiss) continue;
    } else if (isMiss) {
      light += weight * (skyRadiance(task.direction) + sunDisc(task.direction));
      continue;
    } else {
      vec3 left = hazeTransmittance(task.direction, ray.t * uVoxel_m);
      light += weight * horizon(task.direction) * (1.0 - left);
      weight *= left;
    }
    if (task.kind == kPrimary)
      first = FirstHit(true, ray.voxel, ray.level, ray.face, ray.t, hit.attr, hit.index,
                       hit.kind == kHoleHit, isCap, 0.0);
    if (hit.kind == kHoleHit) {
      light += weight * kHoleColour;
      continue;
    }
    if (isCap) {
      vec3 arriving = uAmbient[3] + uSunLight * max(0.0, uToSun.y);
      light += weight * baseColour(hit.attr, look, ray.voxel, ray.level) * arriving * kCapShade;
      if (uSunShare > 0.0 && uToSun.y > 0.0 && dot(capNormal(), uToSun) > 0.0) first.sun = 1.0;
      continue;
    }
    bool isClear = look.kind == kWater || look.kind == kGlass;
    if (ray.face < 0) {
      // The ray starts inside: in water it goes on, in rock it ends.
      if (task.kind == kPrimary && isClear && task.medium == 0u && height < kStack) {
        task.voxel = ray.voxel;
        task.level = ray.level;
        task.face = ray.face;
        task.t = max(ray.t, 1e-20);
        task.medium = material;
        stack[height++] = task;
      }
      continue;
    }
    vec3 normal = normalOf(ray.face);
    vec3 smoothNormal = normal;
    if (ray.face == 3 && any(notEqual(texel.tilt, vec2(0.0))))
      smoothNormal = normalize(vec3(texel.tilt.x, 1.0, texel.tilt.y));
    vec3 albedo = vec3(0.0);
    vec3 emission = vec3(0.0);
    if (material != 0u) {
      albedo = baseColour(hit.attr, look, ray.voxel, ray.level) * texel.ratio *
                   (1.0 - texel.ownShare) + texel.own * texel.ownShare;
      vec3 hue = vec3(1.0);
      if (material == kLamp && hasColour(hit.attr)) {
        vec3 own = linearOf(hit.attr);
        hue = own / max(max(own.r, own.g), max(own.b, 1e-3));
      }
      emission = look.emission * texel.emission * hue;
    }
    bool mayGoOn = task.depth < max(uBounces, 1);
    if (isClear || material == 0u) {
      uint beyond = isClear ? material : 0u;
      float outer = task.medium == 0u ? 1.0 : appearanceOf(task.medium).index;
      float inner = beyond == 0u ? 1.0 : look.index;
      float index = inner / outer;
      vec3 n = dot(task.direction, smoothNormal) > -1e-3 ? normal : smoothNormal;
      float mirrored = fresnel(min(1.0, -dot(task.direction, n)), index);
      vec3 into = refract(task.direction, n, 1.0 / index);
      bool both = task.depth == 0;
      bool mirrorOnly = !both && numberOf(task.stream, 3u) < mirrored;
      if (mayGoOn && (both || mirrorOnly) && height < kStack) {
        vec3 direction = reflect(task.direction, smoothNormal);
        float inwards = dot(direction, normal);
        if (inwards < 1e-4)
          direction = normalize(direction + normal * (1e-4 - 2.0 * min(inwards, 0.0)));
        stack[height++] = sent(task, ray, hit, place, direction, kMirror,
                               both ? weight * mirrored : weight, footprint);
      }
      if (both ? mirrored >= 1.0 : mirrorOnly) continue;
      vec3 rest = both ? weight * (1.0 - mirrored) : weight;
      if (into != vec3(0.0) && mayGoOn) {
        if (height < kStack) {
          Task inside = sent(task, ray, hit, place, into, kRefracted, rest, footprint);
          inside.voxel = ray.voxel;
          inside.medium = beyond;
          stack[height++] = inside;
        }
        continue;
      }
      weight = rest;
    }
    // An opaque face.
    light += weight * emission;
    float polish = isClear ? 0.0 : look.reflects ? 1.0 : texel.gloss;
    if (polish > 0.0 && mayGoOn && task.depth < uBounces) {
      float mirrored = polish * fresnel(min(1.0, -dot(task.direction, normal)), look.index);
      if (mirrored * max(max(weight.r, weight.g), weight.b) > 0.004 && height < kStack - 1) {
        stack[height++] = sent(task, ray, hit, place, reflect(task.direction, normal), kMirror,
                               weight * mirrored, footprint);
        weight *= 1.0 - mirrored;
      }
    }
    vec3 matt = weight * albedo;
    float depth_m = ray.t * abs(task.direction.y) * uVoxel_m;
    vec3 sky = matt * uAmbient[ray.face] * throughMedium(task.medium, depth_m, vec3(0.0, 1.0, 0.0));
    if (uOcclusion && !isClear) sky *= openShare(around, at.u, at.v);
    light += sky;
    if (uSunShare <= 0.0) continue;
    vec3 toSun = sampledSun(task.stream);
    float facing = dot(normal, toSun);
    if (!(facing > 0.0) || !(toSun.y > 0.0)) continue;
    vec3 arriving = matt * uSunLight * facing * throughMedium(task.medium, depth_m, toSun);
    if (!uShadows) {
      light += arriving;
      if (task.depth == 0) first.sun = 1.0;
      continue;
    }
    if (height >= kStack) continue;
    Task shadow = sent(task, ray, hit, place, toSun, kShadow, arriving, footprint);
    shadow.leaves = ray.level == 0 && footprint < 1.0 && uCutOuts && uTextures;
    stack[height++] = shadow;
  }
  return light;
}
