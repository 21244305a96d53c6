// Walks rays through the boxes of a cut (docs/adr/0028): the same cells, order of crossings and
// ties as raytracer/core/walk, in single precision.
// Ref: Amanatides & Woo, "A Fast Voxel Traversal Algorithm", Eurographics 1987; Museth,
// "Hierarchical Digital Differential Analyzer", SIGGRAPH Talks 2014.
//
// Coordinates: x east, y up, z south. A point is a whole level-0 voxel and a fraction in [0, 1], so
// that precision is relative to the ray's origin. A voxel of level n is 2^n level-0 voxels wide.
// Faces: 0 west, 1 east, 2 bottom, 3 top, 4 north, 5 south, by their outward normal; -1: none.

uniform highp usampler2DArray uCells;       // mask (low, high), detail (low, high); rows of 256
uniform highp usampler2DArray uFirst;       // index of the first child with detail; rows of 256
// Red, green, blue, material (| 128: it has a colour); rows of 1024.
uniform highp usampler2DArray uAttributes;
uniform highp usampler2DArray uClasses;     // of the survey, for each attribute
uniform highp usampler2D uColumns;          // hash table of columns: bx, bz, level and kind, base
// At a column's base: by of the first box, how many there are; then the boxes.
uniform highp usampler2D uBoxes;
uniform uint uColumnsMask;                  // size of the hash table - 1
uniform ivec3 uBoundsMin;                   // of the world, level-0 voxels, rounded outwards to the
uniform ivec3 uBoundsMax;                   // coarsest level
uniform int uCoarsest;                      // level
uniform int uMaxSteps;                      // of one walk: a bound against hangs

const int kRowBits = 8;
const int kLayerBits = 18;  // 1024 rows of 256 cells, 256 rows of 1024 attributes
const int kAttributeRowBits = 10;

const uint kLeaf = 1u;
const uint kSplit = 2u;
const uint kBox = 1u;
const uint kHole = 2u;

const uint kAirMaterial = 0u;
const uint kRock = 1u << 24;  // as an attribute: rock without a colour
const uint kNoIndex = 0xffffffffu;
const int kUnknownClass = 256;

const int kMiss = 0;
const int kHit = 1;
const int kHoleHit = 2;

struct Ray {
  ivec3 base;       // whole part of the origin, level-0 voxels
  vec3 offset;      // rest of the origin
  vec3 direction;   // of unit length
  vec3 inverse;
  bvec3 forward;
  ivec3 voxel;      // of `level`, that the ray is in
  int level;
  int face;         // through which it entered its voxel
  float t;          // level-0 voxels
};

struct Stop {
  uint passed;      // material that does not stop the ray, apart from air
  bool atAir;       // whether air stops it: where a medium ends
};

struct Hit {
  int kind;
  uint attr;   // as in uAttributes
  uint index;  // of the attribute; kNoIndex: the voxel has none of its own
};

Ray rayOf(ivec3 base, vec3 offset, vec3 direction) {
  Ray ray;
  ray.base = base;
  ray.offset = offset;
  ray.direction = direction;
  ray.forward = not(lessThan(direction, vec3(0.0)));
  // A component of zero counts as positive: its next plane lies ahead, at infinity.
  bvec3 level3 = equal(direction, vec3(0.0));
  ray.inverse = 1.0 / mix(direction, vec3(1e-30), level3);
  ray.offset = mix(offset, vec3(0.5), level3);
  ray.level = 0;
  ray.face = -1;
  ray.t = 0.0;
  ray.voxel = base + ivec3(floor(offset));
  return ray;
}

// t of planes at these level-0 coordinates.
vec3 crossings(Ray ray, ivec3 planes) {
  return (vec3(planes - ray.base) - ray.offset) * ray.inverse;
}

// The voxel of the ray's level that contains the ray at t.
ivec3 voxelAt(Ray ray, float t) {
  return (ray.base + ivec3(floor(ray.offset + ray.direction * t))) >> ray.level;
}

int firstOf(vec3 t) {
  return t.x <= t.y ? (t.x <= t.z ? 0 : 2) : (t.y <= t.z ? 1 : 2);
}

int faceOf(int axis, bool forward) {
  return axis * 2 + (forward ? 0 : 1);
}

ivec3 unitAxis(int axis) {
  return ivec3(axis == 0, axis == 1, axis == 2);
}

// Places the ray in its first voxel inside the bounds, which it may start in.
bool enterBounds(inout Ray ray) {
  ivec3 nearSide = ivec3(ray.forward.x ? uBoundsMin.x : uBoundsMax.x,
                     ray.forward.y ? uBoundsMin.y : uBoundsMax.y,
                     ray.forward.z ? uBoundsMin.z : uBoundsMax.z);
  ivec3 farSide = uBoundsMin + uBoundsMax - nearSide;
  vec3 tNear = crossings(ray, nearSide);
  vec3 tFar = crossings(ray, farSide);
  float enter = max(max(tNear.x, tNear.y), tNear.z);
  float leave = min(min(tFar.x, tFar.y), tFar.z);
  if (leave < 0.0 || enter > leave) return false;
  if (enter <= 0.0) return true;
  // Of equal crossings the later axis is the last one to be crossed.
  int axis = tNear.z >= enter ? 2 : tNear.y >= enter ? 1 : 0;
  ray.t = enter;
  ray.face = faceOf(axis, ray.forward[axis]);
  ivec3 voxel = clamp(voxelAt(ray, enter), uBoundsMin, uBoundsMax - 1);
  voxel[axis] = ray.forward[axis] ? uBoundsMin[axis] : uBoundsMax[axis] - 1;
  ray.voxel = voxel;
  return true;
}

// Leaves in one step the aligned cell of 2^shift voxels on each axis that contains the ray.
void leap(inout Ray ray, ivec3 shift) {
  ivec3 low = (ray.voxel >> shift) << shift;
  ivec3 size = ivec3(1) << shift;
  ivec3 high = low + size - 1;
  ivec3 ahead = ivec3(ray.forward);
  vec3 out3 = crossings(ray, (low + size * ahead) << ray.level);
  int axis = firstOf(out3);
  float at = out3[axis];
  // A ray never turns back: voxels that it has passed are excluded.
  ivec3 lowest = ahead * ray.voxel + (1 - ahead) * low;
  ivec3 highest = ahead * high + (1 - ahead) * ray.voxel;
  ivec3 voxel = clamp(voxelAt(ray, at), lowest, highest);
  voxel[axis] = ray.forward[axis] ? high[axis] + 1 : low[axis] - 1;
  ray.voxel = voxel;
  ray.t = max(ray.t, at);
  ray.face = faceOf(axis, ray.forward[axis]);
}

// The next finer level: the half of the voxel that contains the ray.
void refine(inout Ray ray) {
  ray.level -= 1;
  ivec3 low = ray.voxel << 1;
  ivec3 voxel = clamp(voxelAt(ray, ray.t), low, low + 1);
  if (ray.face >= 0) {
    int axis = ray.face >> 1;
    voxel[axis] = ray.forward[axis] ? low[axis] : low[axis] + 1;
  }
  ray.voxel = voxel;
}

ivec3 placeOfCell(uint index) {
  int i = int(index);
  return ivec3(i & 255, i >> kRowBits & 1023, i >> kLayerBits);
}

uvec4 cellAt(uint index) {
  return texelFetch(uCells, placeOfCell(index), 0);
}

uint firstAt(uint index) {
  return texelFetch(uFirst, placeOfCell(index), 0).x;
}

ivec3 placeOfAttribute(uint index) {
  int i = int(index);
  return ivec3(i & 1023, i >> kAttributeRowBits & 255, i >> kLayerBits);
}

uint attributeAt(uint index) {
  uvec4 a = texelFetch(uAttributes, placeOfAttribute(index), 0);
  return a.x | a.y << 8 | a.z << 16 | a.w << 24;
}

int classAt(uint index) {
  if (index == kNoIndex) return kUnknownClass;
  return int(texelFetch(uClasses, placeOfAttribute(index), 0).x);
}

bool hasBit(uvec2 mask, int bit) {
  return ((bit < 32 ? mask.x : mask.y) >> (bit & 31) & 1u) != 0u;
}

uint countBits(uint v) {
  v = v - (v >> 1 & 0x55555555u);
  v = (v & 0x33333333u) + (v >> 2 & 0x33333333u);
  return ((v + (v >> 4) & 0x0f0f0f0fu) * 0x01010101u) >> 24;
}

uint countBelow(uvec2 mask, int bit) {
  uint below = (1u << (bit & 31)) - 1u;
  return bit < 32 ? countBits(mask.x & below) : countBits(mask.x) + countBits(mask.y & below);
}

int childBit(ivec3 v) {
  return (v.x & 3) | (v.z & 3) << 2 | (v.y & 3) << 4;
}

// log2 of the leap out of an empty child: its own size, or twice that where the seven others of its
// aligned 2 x 2 x 2 are empty as well.
int leapShift(uvec2 mask, int bit, int childShift) {
  int corner = bit & ~21;
  uint word = corner < 32 ? mask.x : mask.y;
  return (word >> (corner & 31) & 0x330033u) != 0u ? childShift : childShift + 1;
}

// The attribute of a voxel of a box; 0 in the material's byte: air.
uint attributeOf(uvec2 box, ivec3 local) {
  uint index = box.x + uint(local.y >> 6 & 3);
  for (int shift = 4; shift >= 0; shift -= 2) {
    uvec4 cell = cellAt(index);
    int bit = childBit(local >> shift);
    if (!hasBit(cell.xy, bit)) return 0u;
    if (!hasBit(cell.zw, bit)) return kRock;
    uint next = firstAt(index) + countBelow(cell.zw, bit);
    if (shift == 0) return attributeAt(box.y + next);
    index = box.x + next;
  }
  return 0u;
}

// A solid voxel without an attribute of its own, because no face of it is visible within its box,
// looks like what lies close above it; deep down it is rock.
uint hiddenAttribute(uvec2 box, ivec3 local) {
  for (int above = 1; above <= 3 && local.y + above < 256; ++above) {
    uint attr = attributeOf(box, ivec3(local.x, local.y + above, local.z));
    if (attr >> 24 == kAirMaterial) break;
    if (attr != kRock) return attr;
  }
  return kRock;
}

uint hashOf(ivec2 column, int level) {
  uint h = uint(column.x) * 0x9e3779b1u ^ uint(column.y) * 0x85ebca77u ^ uint(level) * 0xc2b2ae3du;
  h ^= h >> 15;
  h *= 0x2c1b3c6du;
  return h ^ h >> 12;
}

// @return kind in x, 0: not in the table; base in y
uvec2 columnAt(ivec2 column, int level) {
  uint at = hashOf(column, level);
  for (int probe = 0; probe < 64; ++probe) {
    at &= uColumnsMask;
    uvec4 entry = texelFetch(uColumns, ivec2(int(at) & 255, int(at) >> 8), 0);
    if (entry.z == 0u) return uvec2(0);
    if (entry.xy == uvec2(column) && int(entry.z & 31u) == level)
      return uvec2(entry.z >> 8, entry.w);
    ++at;
  }
  return uvec2(0);
}

// Finds the leaf whose column contains the ray's voxel, and changes the ray's level to its.
// @return false where there is none: outside of all columns
bool findColumn(inout Ray ray, out uint base) {
  bool up = true;
  for (int i = 0; i < 48; ++i) {
    uvec2 found = columnAt(ray.voxel.xz >> 6, ray.level);
    if (found.x == kLeaf) {
      base = found.y;
      return true;
    }
    if (found.x == kSplit) {
      if (ray.level == 0) return false;
      refine(ray);
      up = false;
    } else {
      // Halves of a split column are always in the table.
      if (!up || ray.level >= uCoarsest) return false;
      ray.level += 1;
      ray.voxel >>= 1;
    }
  }
  return false;
}

uvec4 boxEntry(uint index) {
  return texelFetch(uBoxes, ivec2(int(index) & 1023, int(index) >> 10), 0);
}

// The box of a column that lies at a height: state in x, bases of cells and attributes in y and z.
uvec3 boxAt(uint base, int by) {
  uvec4 head = boxEntry(base);
  int i = by - int(head.x);
  return i < 0 || i >= int(head.y) ? uvec3(0) : boxEntry(base + 1u + uint(i)).xyz;
}

// Walks a ray that lies inside the bounds to the first voxel that stops it with t <= tMax.
Hit walk(inout Ray ray, Stop stop, float tMax) {
  Hit hit = Hit(kMiss, 0u, kNoIndex);
  int steps = 0;
  while (ray.t <= tMax) {
    ivec3 low = uBoundsMin >> ray.level;
    ivec3 high = uBoundsMax >> ray.level;
    bvec3 beyond = bvec3(ray.forward.x ? ray.voxel.x >= high.x : ray.voxel.x < low.x,
                         ray.forward.y ? ray.voxel.y >= high.y : ray.voxel.y < low.y,
                         ray.forward.z ? ray.voxel.z >= high.z : ray.voxel.z < low.z);
    uint base = 0u;
    if (any(beyond) || !findColumn(ray, base)) {
      if (stop.atAir) hit.kind = kHit;
      return hit;
    }
    uvec3 box = boxAt(base, ray.voxel.y >> 8);
    if (box.x == kHole) {
      hit.kind = kHoleHit;
      return hit;
    }
    if (box.x != kBox) {
      if (++steps > uMaxSteps) return hit;
      if (stop.atAir) {
        hit.kind = kHit;
        return hit;
      }
      leap(ray, ivec3(6, 8, 6));
      continue;
    }
    ivec3 own = ivec3(ray.voxel.x >> 6, ray.voxel.y >> 8, ray.voxel.z >> 6);
    do {
      if (++steps > uMaxSteps) return hit;
      uint index = box.y + uint(ray.voxel.y >> 6 & 3);
      uvec4 cell = cellAt(index);
      int shift = 4;
      int empty = 6;
      bool hidden = false;
      int bit = 0;
      if ((cell.x | cell.y) != 0u) {
        // Down to the brick, or to the largest empty cell.
        empty = -1;
        for (; shift >= 0; shift -= 2) {
          bit = childBit(ray.voxel >> shift);
          if (!hasBit(cell.xy, bit)) {
            empty = shift == 0 ? 0 : leapShift(cell.xy, bit, shift);
            break;
          }
          if (!hasBit(cell.zw, bit)) {
            hidden = true;
            break;
          }
          if (shift == 0) break;
          index = box.y + firstAt(index) + countBelow(cell.zw, bit);
          cell = cellAt(index);
        }
      }
      if (empty >= 0) {
        if (stop.atAir) {
          hit.kind = ray.t <= tMax ? kHit : kMiss;
          return hit;
        }
        if (empty > 0) {
          leap(ray, ivec3(empty));
          continue;
        }
      }
      if (!hidden) {
        // Single steps through the brick.
        uvec4 brick = cell;
        uint brickIndex = index;
        ivec3 lowest = ray.voxel & ~3;
        bool stopped = false;
        for (int i = 0; i < 12; ++i) {
          bit = childBit(ray.voxel);
          if (hasBit(brick.xy, bit)) {
            if (!hasBit(brick.zw, bit)) {
              hidden = true;
              stopped = true;
              break;
            }
            uint place = box.z + firstAt(brickIndex) + countBelow(brick.zw, bit);
            uint attr = attributeAt(place);
            if ((attr >> 24 & 63u) != stop.passed) {
              hit.attr = attr;
              hit.index = place;
              stopped = true;
              break;
            }
          } else if (stop.atAir) {
            stopped = true;
            break;
          }
          vec3 out3 = crossings(ray, (ray.voxel + ivec3(ray.forward)) << ray.level);
          int axis = firstOf(out3);
          ray.t = max(ray.t, out3[axis]);
          ray.face = faceOf(axis, ray.forward[axis]);
          ray.voxel += unitAxis(axis) * (ray.forward[axis] ? 1 : -1);
          if ((ray.voxel & ~3) != lowest) break;
        }
        if (!stopped) continue;
      }
      hit.kind = ray.t <= tMax ? kHit : kMiss;
      if (hidden) hit.attr = hiddenAttribute(box.yz, ray.voxel & ivec3(63, 255, 63));
      return hit;
    } while (ivec3(ray.voxel.x >> 6, ray.voxel.y >> 8, ray.voxel.z >> 6) == own);
  }
  return hit;
}
