import type { WorldProjection } from './world-projection.js';
import { decimalsFor } from './coordinates.js';

/** A place with its height above the CRS's zero, metres. */
export type Spot = {
  readonly easting: number;
  readonly northing: number;
  readonly heightM: number;
};

const kAwayM = 400;
const kAboveM = 300;
const kClearM = 60;

/**
 * Where the camera of the proposed picture stands: south-west of the target, looking down on it.
 */
export function cameraPlace(
  target: { readonly easting: number; readonly northing: number },
  projection: WorldProjection,
): [number, number] {
  const offset = (kAwayM * Math.SQRT1_2) / projection.metresPerUnit;
  return [target.easting - offset, target.northing - offset];
}

/**
 * @param groundM height of what is under the camera, if known: it must not stand in a hill. @return
 * metres
 */
export function cameraHeight(targetM: number, groundM: number | undefined): number {
  return Math.max(targetM + kAboveM, (groundM ?? -Infinity) + kClearM);
}

/**
 * One line for a shell. @param server its address, without a slash at the end. @param name of the
 * picture, any text
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
  /^[\w:/.[\]@%+-]*$/.test(text) && !text.includes('[') ? text : `'${text.replace(/'/g, `'\\''`)}'`;

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
