/**
 * What colours a picture instead of true colours, and the legend to it. One table of colours serves
 * both the shader and the page, so that a legend cannot differ from its picture.
 */
import { type Vec2, type Vec3, clamp } from '../../vec3.js';
import type { Appearance } from './appearance.js';

export type Layer = 'none' | 'height' | 'material' | 'class' | 'level';

type Bytes = Vec3;

/**
 * What has a colour, sRGB: the name of a material, the number of a class (ASPRS LAS 1.4, or
 * kOtherClass, kUnknownClass), or the edge of the voxels of a level, metres.
 */
export type LegendEntry = { readonly of: string | number; readonly colour: Bytes };

/** Places in a layer's table: one of each class of a survey, and one for what has no class. */
export const kLayerColours = 257;
export const kUnknownClass = 256;
export const kOtherClass = -1;

// Groups keep the hue that maps give them; within a group, and between groups that colour-blind
// people confuse, lightness differs. Orange, sky blue, green, yellow, blue, vermilion and purple
// are
// those of Okabe and Ito, "Color Universal Design", 2008.
const kUnclassified: Bytes = [186, 186, 192];
const kGround: Bytes = [201, 169, 122];
const kWire: Bytes = [240, 228, 66];
const kClasses: ReadonlyMap<number, Bytes> = new Map([
  [0, [228, 228, 232]], // created, never classified
  [1, kUnclassified],
  [2, kGround],
  [3, [190, 225, 150]], // vegetation: low, medium, high
  [4, [0, 158, 115]],
  [5, [0, 92, 60]],
  [6, [213, 94, 0]], // building
  [9, [0, 114, 178]], // water
  [10, [204, 121, 167]], // rail
  [11, [120, 122, 132]], // road surface
  [13, kWire], // guard
  [14, kWire], // conductor
  [15, [230, 159, 0]], // tower
  [16, kWire], // connector
  [17, [122, 40, 130]], // bridge deck
  [19, [150, 50, 40]], // overhead structure
  [20, kGround], // ignored
  [21, [86, 180, 233]], // snow
]);
const kOther: Bytes = [20, 20, 30];
const kNoClass: Bytes = [50, 44, 62];

// By the names of docs/formats/box.md.
const kMaterials: ReadonlyMap<string, Bytes> = new Map([
  ['rock', [78, 74, 72]],
  ['soil', [115, 77, 38]],
  ['ground', kGround],
  ['grass', [170, 205, 90]],
  ['low_vegetation', [110, 190, 120]],
  ['medium_vegetation', [0, 158, 115]],
  ['high_vegetation', [0, 92, 60]],
  ['wall', [250, 215, 190]],
  ['roof', [213, 94, 0]],
  ['orange_roof', [230, 159, 0]],
  ['grey_roof', [92, 66, 100]],
  ['flat_roof', [235, 150, 150]],
  ['water', [0, 114, 178]],
  ['bridge', [122, 40, 130]],
  ['road', [120, 122, 132]],
  ['concrete', [170, 172, 180]],
  ['rail', [204, 121, 167]],
  ['wire', kWire],
  ['tower', [170, 125, 10]],
  ['object', [200, 50, 110]],
  ['sand', [250, 238, 160]],
  ['snow', [250, 252, 255]],
  ['unknown', [255, 0, 200]],
  ['trunk', [66, 36, 22]],
  ['glass', [140, 225, 235]],
  ['ice', [86, 180, 233]],
  ['lava', [190, 0, 30]],
  ['lamp', [255, 255, 0]],
  ['wood', [165, 105, 60]],
  ['masonry', [150, 70, 50]],
  ['plain', [215, 200, 232]],
  ['solar_panel', [20, 35, 105]],
]);

// The ramp of heights in OKLCh: lightness rises evenly, which is what orders heights for everybody,
// while the hue turns from blue over green to yellow, which all common kinds of colour blindness
// keep apart. Ref: Ottosson, "A perceptual color space for image processing", 2020; the order of
// hues is that of viridis (Smith and van der Walt, 2015).
const kRampLightness = [0.44, 0.94] as const;
const kRampHueDeg = [285, 105] as const;
const kRampChroma = 0.135;

/** @param share of the range of heights, [0, 1] @return sRGB */
export function heightColour(share: number): Bytes {
  const t = clamp(share, 0, 1);
  const [lightness, hueDeg] = [between(kRampLightness, t), between(kRampHueDeg, t)];
  const hue = (hueDeg * Math.PI) / 180;
  // Less chroma where the screen has no such colour.
  for (let chroma = kRampChroma; ; chroma -= 0.002) {
    const rgb = fromOklab(lightness, chroma * Math.cos(hue), chroma * Math.sin(hue));
    if (rgb.every((c) => c >= 0 && c <= 1) || chroma <= 0) {
      return rgb.map((c) => Math.round(toSrgb(c) * 255)) as unknown as Bytes;
    }
  }
}

const kBands = 16;

/**
 * Heights are drawn in bands of two alternating shades, whose edges are contour lines.
 * @param range of heights, metres @return height of a band, metres: 1, 2 or 5 times a power of ten
 */
export function contourStepM(range: number): number {
  const least = range / kBands;
  const power = 10 ** Math.floor(Math.log10(least));
  return power * [1, 2, 5, 10].find((step) => step * power >= least * (1 - 1e-9))!;
}

/**
 * @param voxelM edge of a level-0 voxel, metres
 * @param levels that the world has
 * @return empty for layers without steps
 */
export function makeLegend(
  layer: Layer,
  appearance: Appearance,
  voxelM: number,
  levels: number,
): readonly LegendEntry[] {
  if (layer === 'material') {
    return appearance.materials
      .slice(1) // air
      .map((material, i) => ({ of: material.name, colour: materialColour(appearance, i + 1) }));
  }
  if (layer === 'level') {
    return Array.from({ length: levels }, (_, level) => ({
      of: Number((voxelM * 2 ** level).toPrecision(3)),
      colour: levelColour(level, levels),
    }));
  }
  if (layer === 'class') {
    return [
      ...[...kClasses].map(([number, colour]) => ({ of: number, colour })),
      { of: kOtherClass, colour: kOther },
      { of: kUnknownClass, colour: kNoClass },
    ];
  }
  return [];
}

/**
 * @return linear red, green, blue and 1 of each place: of the range of heights in even steps, by
 *   material, class or level
 */
export function layerTable(layer: Layer, appearance: Appearance, levels: number): Float32Array {
  const out = new Float32Array(kLayerColours * 4);
  for (let i = 0; i < kLayerColours; ++i) {
    out.set([...layerColour(layer, i, appearance, levels).map((c) => toLinear(c / 255)), 1], i * 4);
  }
  return out;
}

function layerColour(layer: Layer, i: number, appearance: Appearance, levels: number): Bytes {
  switch (layer) {
    case 'none':
      return [0, 0, 0];
    case 'height':
      return heightColour(i / (kLayerColours - 1));
    case 'material':
      return materialColour(appearance, i);
    case 'class':
      return i === kUnknownClass ? kNoClass : (kClasses.get(i) ?? kOther);
    case 'level':
      return levelColour(i, levels);
  }
}

function materialColour({ materials }: Appearance, i: number): Bytes {
  const material = materials[i];
  if (material === undefined) return kOther;
  const own = material.colour.map((c) => Math.round(toSrgb(clamp(c, 0, 1)) * 255));
  return kMaterials.get(material.name) ?? (own as unknown as Bytes);
}

// The finest is the lightest.
function levelColour(level: number, levels: number): Bytes {
  return heightColour(1 - level / Math.max(1, levels - 1));
}

function between(ends: Vec2, t: number): number {
  return ends[0] + (ends[1] - ends[0]) * t;
}

function fromOklab(lightness: number, a: number, b: number): [number, number, number] {
  const l = (lightness + 0.3963377774 * a + 0.2158037573 * b) ** 3;
  const m = (lightness - 0.1055613458 * a - 0.0638541728 * b) ** 3;
  const s = (lightness - 0.0894841775 * a - 1.291485548 * b) ** 3;
  return [
    4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
    -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
    -0.0041960863 * l - 0.7034186147 * m + 1.707614701 * s,
  ];
}

const toSrgb = (c: number): number => (c <= 0.0031308 ? c * 12.92 : 1.055 * c ** (1 / 2.4) - 0.055);
const toLinear = (c: number): number => (c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4);
