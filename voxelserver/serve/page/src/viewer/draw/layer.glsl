// Layers: what a pixel's first voxel is, as a colour of a legend, and what an observer sees of it.
// Nothing is transparent or shining here: a water's surface, a pane and a crown of leaves are what
// is met, as on a map.

#ifdef ANALYSIS
uniform highp sampler2D uLayerColours;  // linear; see layers.ts
uniform int uLayer;                     // 0: true colours
uniform float uLowest;                  // y of the range of heights, from uOrigin
uniform float uPerHeight;               // places of the table in a voxel of height
uniform float uBand;                    // height of a band between contours, level-0 voxels
uniform float uInBands;                 // height of uOrigin in two bands, [0, 2 uBand)
uniform bool uHasObserver;
uniform ivec3 uObserver;                // whole voxel
uniform vec3 uObserverOffset;

const int kHeight = 1;
const int kMaterial = 2;
const int kClass = 3;
const int kLevel = 4;

const vec3 kPaper = vec3(0.80, 0.83, 0.86);  // linear: where there is nothing

// How bright a face is drawn, by its face: the tops brightest, and neighbouring sides unlike, so
// that forms stay readable while the hue is the legend's.
const float kFaceShade[6] = float[](0.74, 0.84, 0.6, 1.0, 0.68, 0.9);
const float kShadowShade = 0.7;

int placeInLayer(FirstHit first, float height) {
  if (uLayer == kHeight) return int(clamp((height - uLowest) * uPerHeight, 0.0, 256.0) + 0.5);
  if (uLayer == kMaterial) return int(materialOf(first.attr));
  if (uLayer == kClass) return classAt(first.index);
  return first.level;
}

// Bands between contours, by two shades: their edges are lines from wherever they are seen.
float bandShade(float height) {
  // Just below a face on top, so that it does not lie on an edge.
  float bands = (height - 0.02 + uInBands) / uBand;
  return mod(floor(bands), 2.0) < 1.0 ? 1.0 : 0.86;
}

// Follows a ray from a face that has been met.
bool isFree(Task from, FirstHit first, vec3 direction, float atMost) {
  vec3 place = from.offset + from.direction * first.t;
  ivec3 whole = ivec3(floor(place));
  Ray ray = rayOf(from.base + whole, place - vec3(whole), direction);
  ray.voxel = neighbourOf(first.voxel, first.face);
  ray.level = first.level;
  float reach = min(atMost, reachOf(from.base, place, direction));
  return walk(ray, Stop(kAirMaterial, false), reach).kind == kMiss;
}

// Whether an eye at the observer's place sees what a primary ray has met: the very point, of what
// is shown at this level of detail.
bool isSeen(Task primary, FirstHit first) {
  if (!first.isHit || first.isHole) return false;
  vec3 place = primary.offset + primary.direction * first.t;
  vec3 to = vec3(uObserver - primary.base) + (uObserverOffset - place);
  float far = length(to);
  if (!(far > 0.0)) return true;
  vec3 direction = to / far;
  if (first.isCap) return dot(capNormal(), direction) > 0.0;
  if (first.face < 0 || !(dot(normalOf(first.face), direction) > 0.0)) return false;
  return isFree(primary, first, direction, far);
}

vec3 layerAlong(Task task, out FirstHit first) {
  first = kNothing;
  Ray ray = rayOf(task.base, task.offset, task.direction);
  bool atPlane;
  if (!enterBounds(ray) || !enterKept(ray, task.offset, atPlane)) return kPaper;
  Hit hit = walk(ray, Stop(kAirMaterial, false),
                 reachOf(task.base, task.offset, task.direction));
  if (hit.kind == kMiss) return kPaper;
  bool isHole = hit.kind == kHoleHit;
  bool isCap = atPlane && !isHole && ray.face < 0;
  first = FirstHit(true, ray.voxel, ray.level, ray.face, ray.t, hit.attr, hit.index, isHole, isCap,
                   0.0);
  if (isHole) return kHoleColour;
  vec3 place = task.offset + task.direction * ray.t;
  float height = float(task.base.y - uOrigin.y) + place.y;
  vec3 colour = texelFetch(uLayerColours, ivec2(placeInLayer(first, height), 0), 0).rgb;
  if (uLayer == kHeight) colour *= bandShade(height);
  if (ray.face < 0) return colour * kCapShade;
  float shade = kFaceShade[ray.face];
  if (uOcclusion) {
    int axis = ray.face >> 1;
    shade *= openShare(aroundOf(ray.voxel, ray.level, ray.face),
                       partOf(place, (axis + 1) % 3, ray.level, task.base, ray.voxel),
                       partOf(place, (axis + 2) % 3, ray.level, task.base, ray.voxel));
  }
  if (uShadows && uSunShare > 0.0) {
    vec3 toSun = sampledSun(task.stream);
    bool faces = dot(normalOf(ray.face), toSun) > 0.0 && toSun.y > 0.0;
    if (!faces || !isFree(task, first, toSun, 1e30)) shade *= kShadowShade;
  }
  return colour * shade;
}

// What an observer does not see lies under a veil of one colour, which is nowhere in nature, even
// where it is dark: neither the shade of the sun nor a wood looks like it. In a layer it is grey,
// as maps draw what is unknown.
vec3 unseen(vec3 light) {
  const vec3 kLuminance = vec3(0.2126, 0.7152, 0.0722);
  float grey = dot(light, kLuminance);
  if (uLayer != 0) return vec3(0.05 + grey * 0.25);
  const vec3 kTint = vec3(0.30, 0.22, 0.55);
  const float kVeil = 0.12;
  return (grey * 0.7 + dot(uAmbient[3], kLuminance) * kVeil) * kTint;
}
#endif
