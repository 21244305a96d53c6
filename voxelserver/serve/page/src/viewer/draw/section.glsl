// Cuts away what lies beyond a plane. What is cut away is as if it were not there: neither does it
// stop light, nor does it hide anything from an observer or darken corners, so that what a section
// lays open is lit as if it stood free.
//
// The plane is given relative to the eye: coordinates of a country leave no digits for fractions.

#ifdef ANALYSIS
uniform bool uIsCut;
uniform vec3 uSectionNormal;
uniform float uSectionOffset;      // along the normal, from uOrigin
uniform ivec3 uOrigin;             // the whole voxel of the eye

float primaryReach = 1e30;         // of rays that are cast up to a distance

// Height of a point above the plane; what is above is cut away. The plane lies a little deeper than
// told: where it runs along faces of voxels, those that are kept are met, without noise.
float heightOver(ivec3 base, vec3 offset) {
  const float kDepth = 1.0 / 128.0;
  return dot(uSectionNormal, vec3(base - uOrigin) + offset) - uSectionOffset + kDepth;
}

// Lets a primary ray start where it enters what is kept.
// @param offset of its origin, as in enterBounds()
// @param atPlane out: it starts on the plane
// @return false where it meets nothing of what is kept
bool enterKept(inout Ray ray, vec3 offset, out bool atPlane) {
  atPlane = false;
  if (!uIsCut) return true;
  float height = heightOver(ray.base, offset);
  if (height <= 0.0) return true;
  float t = height / -dot(uSectionNormal, ray.direction);
  const float kFarthest = 1e9;
  if (!(t >= 0.0 && t < kFarthest)) return false;
  if (t <= ray.t) return true;
  ray.t = t;
  ray.voxel = voxelAt(ray, t);
  ray.face = -1;
  atPlane = true;
  return all(greaterThanEqual(ray.voxel, uBoundsMin)) && all(lessThan(ray.voxel, uBoundsMax));
}

// How far a ray may go before it leaves what is kept.
float reachOf(ivec3 base, vec3 offset, vec3 direction) {
  if (!uIsCut) return 1e30;
  float rise = dot(uSectionNormal, direction);
  return rise > 0.0 ? max(0.0, -heightOver(base, offset)) / rise : 1e30;
}

// The normal of a cut face.
vec3 capNormal() {
  return uSectionNormal;
}

bool isCutAway(ivec3 voxel, int level) {
  return uIsCut && heightOver(voxel << level, vec3(exp2(float(level)) * 0.5)) > 0.0;
}
#else
const float primaryReach = 1e30;

bool enterKept(inout Ray ray, vec3 offset, out bool atPlane) {
  atPlane = false;
  return true;
}

float reachOf(ivec3 base, vec3 offset, vec3 direction) {
  return 1e30;
}

vec3 capNormal() {
  return vec3(0.0, 1.0, 0.0);
}

bool isCutAway(ivec3 voxel, int level) {
  return false;
}
#endif
