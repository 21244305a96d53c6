/**
 * The sky for one place of the sun: the table that the shader looks up, and what the sky sends to
 * the six faces of a voxel. The formulas are those of raytracer/core/sky (and of sky.glsl); colours
 * are
 * linear, directions of unit length with y up.
 */
import { type Vec2, add, clamp, cross, dot, scaled, towards } from '../../vec3.js';
import type { Appearance, Rgb } from './appearance.js';
import { fromHalf } from '../../bytes.js';
import type { SunPosition } from './sun-position.js';

export type SkyLight = {
  readonly toSun: Rgb;
  /** At right angles to toSun, for points of the disc. */
  readonly sunRight: Rgb;
  readonly sunUp: Rgb;
  readonly sunLight: Rgb;
  /** 1 - cosine of the sun's radius. */
  readonly sunHeight: number;
  /** Share of the disc above the horizon, [0, 1]. */
  readonly sunShare: number;
  /** Light of the open country around the world. */
  readonly ground: Rgb;
  /** Light of the sky on a white face: west, east, bottom, top, north, south. */
  readonly ambient: readonly Rgb[];
  /** Three colours a node: rayleigh, mie, multiple; columns, then rows. */
  readonly nodes: Float32Array;
  readonly columns: number;
  readonly rows: number;
};

const kRad = Math.PI / 180;
const kSunRadiusRad = 0.2666 * kRad;
const kBackdropM = 2500;
const kRayleighScaleM = 8000;
const kMieScaleM = 2000;
const kMieForward = 0.8;
const kRings = 24; // of directions, over the half of the sky; twice as many around

const by = (a: Rgb, b: Rgb): Rgb => [a[0] * b[0], a[1] * b[1], a[2] * b[2]];
const mix = (a: Rgb, b: Rgb, t: number): Rgb => add(scaled(a, 1 - t), scaled(b, t));
const luminance = (c: Rgb): number => 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];

/** @param size of the sun's disc, 1: as it is */
export function skyLight(look: Appearance, sun: SunPosition, size = 1): SkyLight {
  const { sky } = look;
  const altitude = sun.altitudeDeg * kRad;
  const azimuth = sun.azimuthDeg * kRad;
  const toSun = towards(sun.azimuthDeg, sun.altitudeDeg);
  const sunRight: Rgb = [Math.cos(azimuth), 0, Math.sin(azimuth)];
  const sunUp = cross(sunRight, toSun);
  const radius = kSunRadiusRad * size;
  const sunShare = shareAbove(-altitude / (radius > 0 ? radius : kSunRadiusRad));
  const seenDeg = (altitude >= radius ? altitude : Math.max(0, (altitude + radius) / 2)) / kRad;
  const sunLight =
    sunShare > 0
      ? scaled(
          interpolated(sky.sunAltitudes_deg, (i) => sky.sunLight[i]!, seenDeg),
          sunShare,
        )
      : ([0, 0, 0] as const);
  const nodes = nodesFor(look, sun.altitudeDeg);
  const table = new SkyTable(nodes, look, toSun);
  const up = gather(table, [[0, 1, 0]])[0]!;
  const ground = by(sky.ground, add(up, scaled(sunLight, Math.max(0, toSun[1]))));
  const ambient = gather(table, kNormals, ground);
  return {
    toSun,
    sunRight,
    sunUp,
    sunLight,
    sunHeight: 2 * Math.sin(radius / 2) ** 2,
    sunShare,
    ground,
    ambient,
    nodes,
    columns: sky.columns,
    rows: sky.rows,
  };
}

/**
 * Stops that compensate for a dim sun and sky, as the ray tracer's exposure does.
 * @param share of the lack of daylight, [0, 1]
 */
export function adaptationEv(light: SkyLight, share: number): number {
  const level = luminance(
    add(light.ambient[3]!, scaled(light.sunLight, Math.max(0, light.toSun[1]))),
  );
  return clamp(-share * Math.log2(Math.max(level, 1e-6)), 0, 9);
}

const kNormals: readonly Rgb[] = [
  [-1, 0, 0],
  [1, 0, 0],
  [0, -1, 0],
  [0, 1, 0],
  [0, 0, -1],
  [0, 0, 1],
];

// The light of the upper half, and of the ground's where it is given, that white faces send on.
function gather(table: SkyTable, normals: readonly Rgb[], ground?: Rgb): Rgb[] {
  const sums: Rgb[] = normals.map(() => [0, 0, 0]);
  const solidAngle = (2 * Math.PI) / (kRings * 2 * kRings);
  const first = ground === undefined ? 0 : -kRings;
  for (let ring = first; ring < kRings; ++ring) {
    for (let i = 0; i < 2 * kRings; ++i) {
      const y = (ring + 0.5) / kRings;
      const r = Math.sqrt(1 - y * y);
      const turn = (Math.PI * (i + 0.5)) / kRings;
      const d: Rgb = [r * Math.cos(turn), y, r * Math.sin(turn)];
      const light = y >= 0 ? table.clear(d) : table.below(d, ground!);
      normals.forEach((n, k) => {
        const facing = Math.max(0, dot(n, d)) * (solidAngle / Math.PI);
        sums[k] = add(sums[k]!, scaled(light, facing));
      });
    }
  }
  return sums;
}

class SkyTable {
  readonly #nodes: Float32Array;
  readonly #look: Appearance;
  readonly #toSun: Rgb;
  readonly #sunFlat: Vec2;

  constructor(nodes: Float32Array, look: Appearance, toSun: Rgb) {
    this.#nodes = nodes;
    this.#look = look;
    this.#toSun = toSun;
    const flat = Math.hypot(toSun[0], toSun[2]);
    this.#sunFlat = flat > 1e-9 ? [toSun[0] / flat, toSun[2] / flat] : [0, 1];
  }

  clear(d: Rgb): Rgb {
    const flat = Math.hypot(d[0], d[2]);
    const cosine = flat > 1e-9 ? this.#azimuth(d) / flat : 1;
    return add(
      inGamut(this.#at(d[1], cosine, clamp(dot(d, this.#toSun), -1, 1))),
      this.#night(d[1]),
    );
  }

  below(d: Rgb, ground: Rgb): Rgb {
    const left = this.#transmittance(d, kBackdropM / -d[1]);
    return add(by(ground, left), by(this.#horizon(d), [1 - left[0], 1 - left[1], 1 - left[2]]));
  }

  #horizon(d: Rgb): Rgb {
    const length = Math.hypot(d[0], 2 * d[1], d[2]);
    const seen: Rgb = d[1] < 0 ? [d[0] / length, (2 * d[1]) / length, d[2] / length] : d;
    const cosine = clamp(this.#azimuth(d), -1, 1);
    const sunCosine = clamp(dot(seen, this.#toSun), -1, 1);
    return add(inGamut(this.#at(0, cosine, sunCosine)), this.#night(0));
  }

  #azimuth(d: Rgb): number {
    return d[0] * this.#sunFlat[0] + d[2] * this.#sunFlat[1];
  }

  #night(y: number): Rgb {
    return scaled(this.#look.sky.night, 1 + 0.6 * (1 - y) ** 3);
  }

  #transmittance(d: Rgb, metres: number): Rgb {
    const rise = Math.abs(d[1]);
    const rayleigh = denseLength(metres, rise, kRayleighScaleM);
    const mie = denseLength(metres, rise, kMieScaleM);
    const { hazeRayleigh_per_m: r, hazeMie_per_m: m } = this.#look.sky;
    const left = (i: 0 | 1 | 2): number => Math.exp(-r[i] * rayleigh - m[i] * mie);
    return [left(0), left(1), left(2)];
  }

  #at(elevation: number, azimuthCosine: number, sunCosine: number): Rgb {
    const { rows, columns } = this.#look.sky;
    const u = Math.sqrt(clamp(elevation, 0, 1)) * (rows - 1);
    const v = Math.sqrt(clamp((1 - azimuthCosine) / 2, 0, 1)) * (columns - 1);
    const i = Math.min(Math.floor(u), rows - 2);
    const j = Math.min(Math.floor(v), columns - 2);
    const rayleigh = rayleighPhase(sunCosine);
    const mie = miePhase(sunCosine);
    const node = (row: number, column: number): Rgb => {
      const at = (row * columns + column) * 9;
      const n = this.#nodes;
      const channel = (k: number): number =>
        n[at + k]! * rayleigh + n[at + 3 + k]! * mie + n[at + 6 + k]!;
      return [channel(0), channel(1), channel(2)];
    };
    return mix(
      mix(node(i, j), node(i, j + 1), v - j),
      mix(node(i + 1, j), node(i + 1, j + 1), v - j),
      u - i,
    );
  }
}

// The table for an altitude between two of those that there are.
function nodesFor(look: Appearance, altitudeDeg: number): Float32Array {
  const { altitudes_deg, rows, columns } = look.sky;
  const [i, t] = placeIn(altitudes_deg, altitudeDeg);
  const size = rows * columns * 9;
  const out = new Float32Array(size);
  for (let k = 0; k < size; ++k) {
    out[k] =
      fromHalf(look.skyNodes[i * size + k]!) * (1 - t) +
      fromHalf(look.skyNodes[(i + 1) * size + k]!) * t;
  }
  return out;
}

function interpolated(places: readonly number[], value: (i: number) => Rgb, at: number): Rgb {
  const [i, t] = placeIn(places, at);
  return mix(value(i), value(i + 1), t);
}

// The interval of ascending places that holds `at`, and where in it, [0, 1].
function placeIn(places: readonly number[], at: number): Vec2 {
  let i = 0;
  while (i < places.length - 2 && places[i + 1]! <= at) ++i;
  const [low, high] = [places[i]!, places[i + 1]!];
  return [i, clamp((at - low) / (high - low), 0, 1)];
}

// Share of a circle above a line at y radii over its middle.
function shareAbove(y: number): number {
  const c = clamp(y, -1, 1);
  return (Math.acos(c) - c * Math.sqrt(1 - c * c)) / Math.PI;
}

function denseLength(metres: number, rise: number, scaleM: number): number {
  const x = (metres * rise) / scaleM;
  return x > 1e-6 ? (metres * (1 - Math.exp(-x))) / x : metres * (1 - x / 2);
}

function inGamut(c: Rgb): Rgb {
  const kLeast = 0.04;
  const grey = luminance(c);
  if (!(grey > 0)) return [0, 0, 0];
  const least = Math.min(...c);
  if (least >= kLeast * grey) return c;
  const t = (grey * (1 - kLeast)) / (grey - least);
  const paled = (v: number): number => Math.max(0, grey + (v - grey) * t);
  return [paled(c[0]), paled(c[1]), paled(c[2])];
}

const rayleighPhase = (c: number): number => (3 / (16 * Math.PI)) * (1 + c * c);

function miePhase(c: number): number {
  const g = kMieForward;
  const g2 = g * g;
  const k = 1 + g2 - 2 * g * c;
  return ((3 / (8 * Math.PI)) * (1 - g2) * (1 + c * c)) / ((2 + g2) * k * Math.sqrt(k));
}
