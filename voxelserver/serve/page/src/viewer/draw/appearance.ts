import { inflate, toView } from '../../bytes.js';
import { JsonReader, type Fields } from '../../json.js';
import type { Vec3 } from '../../vec3.js';

/**
 * appearance.bin (docs/formats/site.md): how materials look, and the sky, as raytracer/apps/publish
 * writes them. Checked and typed; numbers that would lead outside of a texture are refused.
 */

export type Rgb = Vec3;

export type Appearance = {
  readonly materials: readonly Material[];
  readonly sky: SkyFacts;
  /** Half floats, four to a texel: colour ratio and opacity. */
  readonly ratio: Uint16Array;
  /** Four to a texel: a drawing's own colour and its share. */
  readonly own: Uint16Array;
  /** Eight to a texel of a window: own colour, share, glass, three unused. */
  readonly panes: Uint16Array;
  /** By altitude, row and column: rayleigh, mie, multiple, three each. */
  readonly skyNodes: Uint16Array;
};

const kMagic = 'TVXLOOK\n';
const kVersion = 1;
const kHeadBytes = 16;
const kMaxBytes = 16 * 2 ** 20;
const kVariantTexels = 341;
const kMaxMaterials = 127;
const kMaxTexels = 2 ** 22;
const kPaneHalves = 8 * kVariantTexels * 8;

function fail(what: string): never {
  throw new Error(`read the appearance of materials: ${what}; publish the place again`);
}

const read = new JsonReader(fail);
const rgb = (value: unknown, what: string): Rgb => read.vec3(value, what, 1e6, 'is no colour');

/** @throws Error when it is no gzip stream, or unpacks to more than any appearance.bin */
export async function unpackAppearance(packed: Uint8Array): Promise<Uint8Array> {
  const bytes = await inflate(packed, 'gzip', kMaxBytes);
  return bytes ?? fail(`it unpacks to more than ${kMaxBytes} bytes`);
}

/** @param bytes unpacked @throws Error that says what is wrong */
export function readAppearance(bytes: Uint8Array): Appearance {
  const view = toView(bytes);
  const magic = String.fromCharCode(...bytes.subarray(0, kMagic.length));
  if (bytes.length < kHeadBytes || magic !== kMagic) fail('it is no appearance.bin');
  const version = view.getUint32(8, true);
  if (version !== kVersion) fail(`its version is ${version}; this page reads ${kVersion}`);
  const textBytes = view.getUint32(12, true);
  if (textBytes > bytes.length - kHeadBytes) fail('it is cut off');
  const text = new TextDecoder().decode(bytes.subarray(kHeadBytes, kHeadBytes + textBytes));
  const facts = read.fields(JSON.parse(text), 'its facts');
  const start = kHeadBytes + textBytes;
  const halves = (name: string): Uint16Array => {
    const part = read.fields(read.fields(facts['arrays'], 'arrays')[name], `arrays.${name}`);
    const count = read.whole(part['halves'], `${name}.halves`, kMaxTexels * 4);
    const offset = read.whole(part['offset'], `${name}.offset`, bytes.length);
    if (offset % 2 !== 0 || start + offset + count * 2 > bytes.length) fail(`${name} is cut off`);
    // A copy: the offset in memory need not be even.
    return new Uint16Array(bytes.slice(start + offset, start + offset + count * 2).buffer);
  };
  const [ratio, own] = [halves('ratio'), halves('own')];
  const [panes, skyNodes] = [halves('panes'), halves('sky')];
  if (panes.length !== kPaneHalves) fail('windows have another size');
  const pools = { ratio: ratio.length / 4, own: own.length / 4 };
  const materials = read
    .list(facts['materials'], 'materials', kMaxMaterials)
    .map((item, i) => readMaterial(read.fields(item, `material ${i}`), pools));
  if (materials.length === 0) fail('it has no materials');
  const sky = readSky(read.fields(facts['sky'], 'sky'));
  if (skyNodes.length !== sky.altitudesDeg.length * sky.rows * sky.columns * 9) {
    fail('the sky has another size');
  }
  return { materials, sky, ratio, own, panes, skyNodes };
}

export type Material = Readonly<ReturnType<typeof readMaterial>>;

function readMaterial(m: Fields, pools: { ratio: number; own: number }) {
  const face = (name: string): Face => readFace(read.fields(m[name], name), pools);
  return {
    name: String(m['name']),
    /** 0 solid, 1 leaves, 2 water, 3 glass. */
    kind: read.whole(m['kind'], 'kind', 3),
    colour: rgb(m['colour'], 'colour'),
    variation: read.number(m['variation'], 'variation', 0, 1),
    roughness: read.number(m['roughness'], 'roughness', 0, 1),
    index: read.number(m['index'], 'index', 1, 4),
    reflects: m['reflects'] === true,
    absorptionPerM: rgb(m['absorption_per_m'], 'absorption_per_m'),
    glow: rgb(m['glow'], 'glow'),
    emission: rgb(m['emission'], 'emission'),
    own: rgb(m['own'], 'own'),
    windows: m['windows'] === true,
    waves: m['waves'] === true,
    side: face('side'),
    bottom: face('bottom'),
    top: face('top'),
  };
}

export type Face = Readonly<ReturnType<typeof readFace>>;

function readFace(f: Fields, pools: { ratio: number; own: number }) {
  const face = {
    /** First texel of the drawing in `ratio`, and of its own colours in `own`. */
    first: read.whole(f['first'], 'first', kMaxTexels),
    ownFirst: read.whole(f['ownFirst'], 'ownFirst', kMaxTexels),
    /** 0: nothing is drawn. */
    variants: read.whole(f['variants'], 'variants', 4096),
    /** Which a voxel may choose: see raytracer/core/material/texture_list.hpp. */
    turns: read.whole(f['turns'], 'turns', 15),
    metric: f['metric'] === true,
    layered: f['layered'] === true,
    hasOwn: f['hasOwn'] === true,
    hasHoles: f['hasHoles'] === true,
  };
  const texels = face.variants * kVariantTexels;
  if (texels > 0 && face.first + texels > pools.ratio) fail('a drawing is cut off');
  if (face.hasOwn && face.ownFirst + texels > pools.own) fail('a drawing is cut off');
  return face;
}

export type SkyFacts = Readonly<ReturnType<typeof readSky>>;

function readSky(s: Fields) {
  const degrees = (name: string): number[] => {
    const values = read.list(s[name], name, 1000).map((v) => read.number(v, name, -90, 90));
    if (values.length < 2 || values.some((v, i) => i > 0 && v <= values[i - 1]!)) {
      fail(`${name} do not ascend`);
    }
    return values;
  };
  const sunAltitudesDeg = degrees('sunAltitudes_deg');
  const sunLight = read.list(s['sunLight'], 'sunLight', 1000).map((c) => rgb(c, 'sunLight'));
  if (sunLight.length !== sunAltitudesDeg.length) fail('sunLight has another length');
  return {
    /** Altitudes of the sun, ascending, of which there is a table in `sky`. */
    altitudesDeg: degrees('altitudes_deg'),
    rows: read.whole(s['rows'], 'rows', 256, 2),
    columns: read.whole(s['columns'], 'columns', 256, 2),
    /** Ascending; the sun's light at each of them. */
    sunAltitudesDeg,
    sunLight,
    hazeRayleighPerM: rgb(s['hazeRayleigh_per_m'], 'hazeRayleigh_per_m'),
    hazeMiePerM: rgb(s['hazeMie_per_m'], 'hazeMie_per_m'),
    night: rgb(s['night'], 'night'),
    ground: rgb(s['ground'], 'ground'),
  };
}
