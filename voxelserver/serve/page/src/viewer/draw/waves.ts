import type { Vec2 } from '../../vec3.js';

/**
 * Phases of water's waves at a place, in double precision: coordinates of a country have no digits
 * left for waves in the single precision of shaders. As raytracer/core/material/material_table.cpp.
 */

const kPerX = [0.0713, 0.1319, 0.2137, 0.1873, 0.3511, 0.4943, 0.5519, 0.9277] as const;
const kPerZ = [-0.0291, 0.0347, -0.1423, 0.1987, -0.0529, 0.2713, -0.4177, 0.5881] as const;

export type WavePhases = {
  /** Of the trains of waves, turns in [0, 1). */
  readonly waves: readonly number[];
  /** Of the patches of calm and of ruffled water. */
  readonly ruffled: Vec2;
};

/** @param xM, zM metres east and south */
export function wavePhases(xM: number, zM: number): WavePhases {
  return {
    waves: kPerX.map((perX, i) => turns(xM * perX + zM * kPerZ[i]!)),
    ruffled: [turns(xM * 0.0113 + zM * 0.0067), turns(zM * 0.0171 - xM * 0.0049 + 0.3)],
  };
}

const turns = (v: number): number => v - Math.floor(v);
