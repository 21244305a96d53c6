// The sky of raytracer/core/sky without clouds and stars: a table for the sun's altitude, phase
// functions, haze. Colours are linear; directions of unit length, y up.

uniform highp sampler2D uSky;      // three texels a node: rayleigh, mie, multiple
uniform ivec2 uSkySize;            // columns, rows of nodes
uniform vec3 uToSun;
uniform vec3 uSunLight;
uniform float uSunHeight;          // 1 - cosine of the sun's radius; 0: no disc
uniform float uSunShare;           // of the disc above the horizon
uniform vec3 uHazeRayleigh;        // extinction per metre
uniform vec3 uHazeMie;
uniform vec3 uNight;
uniform vec3 uGround;              // light of the open country around the world
uniform vec3 uAmbient[6];          // light of the sky on a white face, by face

const float kPi = 3.14159265358979;
const float kRayleighScale_m = 8000.0;
const float kMieScale_m = 2000.0;
const float kBackdrop_m = 2500.0;
const float kLimb = 0.6;
const float kMieForward = 0.8;

vec3 inGamut(vec3 c) {
  float grey = dot(c, vec3(0.2126, 0.7152, 0.0722));
  if (!(grey > 0.0)) return vec3(0.0);
  float least = min(min(c.r, c.g), c.b);
  const float kMin = 0.04;
  if (least >= kMin * grey) return c;
  return max(vec3(0.0), grey + (c - grey) * (grey * (1.0 - kMin) / (grey - least)));
}

float rayleighPhase(float c) {
  return 3.0 / (16.0 * kPi) * (1.0 + c * c);
}

// Ref: Cornette and Shanks, 1992.
float miePhase(float c) {
  const float g = kMieForward;
  const float g2 = g * g;
  float k = 1.0 + g2 - 2.0 * g * c;
  return 3.0 / (8.0 * kPi) * (1.0 - g2) * (1.0 + c * c) / ((2.0 + g2) * k * sqrt(k));
}

vec3 skyNode(int column, int row, float rayleigh, float mie) {
  int x = column * 3;
  return texelFetch(uSky, ivec2(x, row), 0).rgb * rayleigh +
         texelFetch(uSky, ivec2(x + 1, row), 0).rgb * mie +
         texelFetch(uSky, ivec2(x + 2, row), 0).rgb;
}

vec3 skyTable(float elevation, float azimuthCosine, float sunCosine) {
  float u = sqrt(clamp(elevation, 0.0, 1.0)) * float(uSkySize.y - 1);
  float v = sqrt(clamp((1.0 - azimuthCosine) * 0.5, 0.0, 1.0)) * float(uSkySize.x - 1);
  int i = min(int(u), uSkySize.y - 2);
  int j = min(int(v), uSkySize.x - 2);
  float a = u - float(i);
  float b = v - float(j);
  float rayleigh = rayleighPhase(sunCosine);
  float mie = miePhase(sunCosine);
  return mix(mix(skyNode(j, i, rayleigh, mie), skyNode(j + 1, i, rayleigh, mie), b),
             mix(skyNode(j, i + 1, rayleigh, mie), skyNode(j + 1, i + 1, rayleigh, mie), b), a);
}

float azimuthCosine(vec3 d, float flatLength) {
  vec2 sun = length(uToSun.xz) > 1e-6 ? normalize(uToSun.xz) : vec2(0.0, 1.0);
  return flatLength > 1e-6 ? dot(d.xz, sun) / flatLength : 1.0;
}

vec3 nightLight(float y) {
  float low = 1.0 - y;
  return uNight * (1.0 + 0.6 * low * low * low);
}

vec3 clearSky(vec3 d) {
  return inGamut(skyTable(d.y, azimuthCosine(d, length(d.xz)), clamp(dot(d, uToSun), -1.0, 1.0))) +
         nightLight(d.y);
}

vec3 horizon(vec3 d) {
  vec3 seen = d.y < 0.0 ? normalize(vec3(d.x, 2.0 * d.y, d.z)) : d;
  return inGamut(skyTable(0.0, clamp(azimuthCosine(d, 1.0), -1.0, 1.0),
                          clamp(dot(seen, uToSun), -1.0, 1.0))) + nightLight(0.0);
}

// Length of air as dense as at the lower end of a line that amounts to the same.
float denseLength(float metres, float rise, float scale_m) {
  float x = metres * rise / scale_m;
  return x > 1e-3 ? metres * (1.0 - exp(-x)) / x : metres * (1.0 - x * 0.5);
}

vec3 hazeTransmittance(vec3 d, float metres) {
  if (!(metres > 0.0)) return vec3(1.0);
  float rise = abs(d.y);
  return exp(-uHazeRayleigh * denseLength(metres, rise, kRayleighScale_m) -
             uHazeMie * denseLength(metres, rise, kMieScale_m));
}

// What a ray that has left the world sees, without the sun's disc.
vec3 skyRadiance(vec3 d) {
  if (d.y >= 0.0) return clearSky(d);
  vec3 left = hazeTransmittance(d, kBackdrop_m / -d.y);
  return uGround * left + horizon(d) * (1.0 - left);
}

vec3 sunDisc(vec3 d) {
  if (!(uSunHeight > 0.0) || d.y < 0.0 || uSunShare <= 0.0) return vec3(0.0);
  vec3 apart = d - uToSun;
  float down = dot(apart, apart) * 0.5;
  if (!(down < uSunHeight)) return vec3(0.0);
  float rim = sqrt(1.0 - down / uSunHeight);
  return uSunLight * ((1.0 - kLimb * (1.0 - rim)) / (1.0 - kLimb / 3.0) /
                      (2.0 * uSunHeight * uSunShare));
}
