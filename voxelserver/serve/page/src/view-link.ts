import type { Vec2, Vec3 } from './vec3.js';
import { cameraHeight, cameraPlace, type Spot } from './render-command.js';
import { lookingAt, type Viewpoint } from './viewer/ui/navigation.js';
import type { WorldProjection } from './world-projection.js';

/** Addresses of the viewer (viewer/ui/link.ts) for places of the map; the time is left to it. */

const kFovDeg = 45;
const kDownDeg = 40;

/** @param target what is in the middle of the picture @param from where the camera stands */
export function viewLink(target: Spot, from: Spot, projection: WorldProjection): string {
  const at = { position: toVoxel(from, projection), headingDeg: 0, pitchDeg: 0, fovDeg: kFovDeg };
  return makeLink(lookingAt(at, toVoxel(target, projection)));
}

/** The place of the panel, seen from where the proposed picture is. @param topM undefined: air */
export function viewOfPlace(
  place: { readonly easting: number; readonly northing: number },
  topM: number | undefined,
  projection: WorldProjection,
): string {
  const target = { ...place, heightM: topM ?? middleM(projection) };
  const [easting, northing] = cameraPlace(place, projection);
  return viewLink(
    target,
    { easting, northing, heightM: cameraHeight(target.heightM, undefined) },
    projection,
  );
}

/**
 * What the map shows: from the south, from above all that the world holds. Its heights there are
 * not known without a request.
 * @param across CRS units
 */
export function viewOfMap(
  [easting, northing]: Vec2,
  across: number,
  projection: WorldProjection,
): string {
  const acrossM = across * projection.metresPerUnit;
  const target = { easting, northing, heightM: middleM(projection) };
  const heightM = Math.max(
    target.heightM + acrossM * Math.sin((kDownDeg * Math.PI) / 180),
    topM(projection) + 10,
  );
  const backM = (heightM - target.heightM) / Math.tan((kDownDeg * Math.PI) / 180);
  return viewLink(
    target,
    { easting, northing: northing - backM / projection.metresPerUnit, heightM },
    projection,
  );
}

const middleM = ({ world: { framed, voxelM } }: WorldProjection): number =>
  ((framed.min[1] + framed.max[1]) / 2) * voxelM;
const topM = ({ world: { framed, voxelM } }: WorldProjection): number => framed.max[1] * voxelM;

// Not a whole voxel, unlike WorldProjection.toVoxel().
function toVoxel({ easting, northing, heightM }: Spot, { world }: WorldProjection): Vec3 {
  return [easting / world.unitsPerVoxel, heightM / world.voxelM, -northing / world.unitsPerVoxel];
}

function makeLink({ position, headingDeg, pitchDeg, fovDeg }: Viewpoint): string {
  const list = (values: readonly number[]): string =>
    values.map((v) => Number(v.toFixed(2))).join();
  return `view/#at=${list(position)}&look=${list([headingDeg, pitchDeg, fovDeg])}`;
}
