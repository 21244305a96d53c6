import { inflate, toView } from '../../bytes.js';
import type { Vec3 } from '../../vec3.js';

/**
 * appearance.bin (docs/formats/site.md): how materials look, and the sky, as raytracer/apps/publish
 * writes them. It is published with this script, so only its version is checked here, and its bytes
 * by the checksum of gzip.
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

export type Material = {
  readonly name: string;
  /** 0 solid, 1 leaves, 2 water, 3 glass. */
  readonly kind: number;
  readonly colour: Rgb;
  readonly variation: number;
  readonly roughness: number;
  readonly index: number;
  readonly reflects: boolean;
  readonly absorption_per_m: Rgb;
  readonly glow: Rgb;
  readonly emission: Rgb;
  readonly own: Rgb;
  readonly windows: boolean;
  readonly waves: boolean;
  readonly side: Face;
  readonly bottom: Face;
  readonly top: Face;
};

export type Face = {
  /** First texel of the drawing in `ratio`, and of its own colours in `own`. */
  readonly first: number;
  readonly ownFirst: number;
  /** 0: nothing is drawn. */
  readonly variants: number;
  /** Which a voxel may choose: see raytracer/core/material/texture_list.hpp. */
  readonly turns: number;
  readonly metric: boolean;
  readonly layered: boolean;
  readonly hasOwn: boolean;
  readonly hasHoles: boolean;
};

export type SkyFacts = {
  /** Altitudes of the sun, ascending, of which there is a table in `skyNodes`. */
  readonly altitudes_deg: readonly number[];
  readonly rows: number;
  readonly columns: number;
  /** Ascending; the sun's light at each of them. */
  readonly sunAltitudes_deg: readonly number[];
  readonly sunLight: readonly Rgb[];
  readonly hazeRayleigh_per_m: Rgb;
  readonly hazeMie_per_m: Rgb;
  readonly night: Rgb;
  readonly ground: Rgb;
};

/** What the beginning of the file holds as JSON. */
type Facts = Pick<Appearance, 'materials' | 'sky'> & {
  readonly arrays: Readonly<
    Record<'ratio' | 'own' | 'panes' | 'sky', { readonly offset: number; readonly halves: number }>
  >;
};

const kMagic = 'TVXLOOK\n';
const kVersion = 1;
const kHeadBytes = 16;

/** @param packed the file @throws Error when it is none of this version */
export async function readAppearance(packed: Uint8Array): Promise<Appearance> {
  const bytes = await inflate(packed, 'gzip');
  const magic = String.fromCharCode(...bytes.subarray(0, kMagic.length));
  const version = magic === kMagic ? toView(bytes).getUint32(8, true) : undefined;
  if (version !== kVersion) {
    const what = `version ${version ?? 'unknown'}; this page reads ${kVersion}`;
    throw new Error(`read appearance.bin: ${what}; publish the place again`);
  }
  const start = kHeadBytes + toView(bytes).getUint32(12, true);
  const text = new TextDecoder().decode(bytes.subarray(kHeadBytes, start));
  const { materials, sky, arrays } = JSON.parse(text) as Facts;
  // A copy: the offset in memory need not be even.
  const halves = (name: keyof Facts['arrays']): Uint16Array => {
    const from = start + arrays[name].offset;
    return new Uint16Array(bytes.slice(from, from + arrays[name].halves * 2).buffer);
  };
  return {
    materials,
    sky,
    ratio: halves('ratio'),
    own: halves('own'),
    panes: halves('panes'),
    skyNodes: halves('sky'),
  };
}
