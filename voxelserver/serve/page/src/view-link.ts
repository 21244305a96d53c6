import type { Vec2, Vec3 } from './vec3.js';
import { decimalsFor, type FoundPlace } from './coordinates.js';
import { lookingAt } from './viewer/ui/navigation.js';
import { viewWords } from './viewer/ui/link.js';
import type { WorldProjection } from './world-projection.js';

/** Proposed pictures of places of the map: as a link to the viewer, and as a command. */

/** A place with its height above the CRS's zero, metres. */
export type Spot = FoundPlace & { readonly heightM: number };

const kAwayM = 400;
/** Height above the target by horizontal distance. */
const kRise = 0.75;
const kClearM = 60;
const kFovDeg = 45;

/**
 * Where the camera stands: south-west of the target, looking down on it.
 * @param groundM height of what is under the camera, if known: it must not stand in a hill
 */
export function placeCamera(
  target: Spot,
  projection: WorldProjection,
  groundM = -Infinity,
  awayM = kAwayM,
): Spot {
  const offset = (awayM * Math.SQRT1_2) / projection.metresPerUnit;
  return {
    easting: target.easting - offset,
    northing: target.northing - offset,
    heightM: Math.max(target.heightM + kRise * awayM, groundM + kClearM),
  };
}

/** The address of the viewer; the time is left to it. */
export function viewLink(target: Spot, camera: Spot, projection: WorldProjection): string {
  const position = toVoxel(camera, projection);
  const at = { position, headingDeg: 0, pitchDeg: 0, fovDeg: kFovDeg };
  return `view/#${viewWords(lookingAt(at, toVoxel(target, projection)))}`;
}

/** The place, taken to be in the middle of the world's heights. */
export function inTheMiddle(place: FoundPlace, { world }: WorldProjection): Spot {
  const { min, max } = world.framed;
  return { ...place, heightM: ((min[1] + max[1]) / 2) * world.voxelM };
}

/**
 * What the map shows, from above all that the world holds: its heights there are not known without
 * a request.
 * @param across CRS units
 */
export function viewOfMap(
  [easting, northing]: Vec2,
  across: number,
  projection: WorldProjection,
): string {
  const target = inTheMiddle({ easting, northing }, projection);
  const { framed, voxelM } = projection.world;
  const aboveM = framed.max[1] * voxelM + 10 - target.heightM;
  const awayM = Math.max(across * projection.metresPerUnit, aboveM / kRise);
  return viewLink(target, placeCamera(target, projection, undefined, awayM), projection);
}

// Not a whole voxel, unlike WorldProjection.toVoxel().
function toVoxel({ easting, northing, heightM }: Spot, { world }: WorldProjection): Vec3 {
  return [easting / world.unitsPerVoxel, heightM / world.voxelM, -northing / world.unitsPerVoxel];
}

/**
 * One line for a shell.
 * @param server its address, without a slash at the end
 * @param name of the picture, any text
 */
export function renderCommand(
  server: string,
  target: Spot,
  camera: Spot,
  name: string,
  projection: WorldProjection,
): string {
  const decimals = Math.min(2, decimalsFor(projection.world.unitsPerVoxel));
  const list = (s: Spot): string =>
    `${s.easting.toFixed(decimals)},${s.northing.toFixed(decimals)},${s.heightM.toFixed(1)}`;
  const places = `--camera-target=${list(target)} --camera-position=${list(camera)}`;
  return `./terravox render ${quoted(server)} ${places} -o ${fileName(name)}.png`;
}

// The server's address comes from the browser's own address bar, but a path may hold characters
// with a meaning for the shell.
const quoted = (text: string): string =>
  /^[\w:/.\]@%+-]*$/.test(text) ? text : `'${text.replace(/'/g, `'\\''`)}'`;

/**
 * Letters, digits, dashes and dots only, as names from the server end up in the shell of a user.
 */
export function fileName(name: string): string {
  const safe = name
    .replace(/[^A-Za-z0-9_.-]+/g, '-')
    .replace(/^[-.]+|[-.]+$/g, '')
    .slice(0, 60);
  return safe === '' ? 'picture' : safe;
}
