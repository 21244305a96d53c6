/** What is known of the point that somebody has clicked. */
import { formatLatLon } from '../../coordinates.js';
import { byId, setFacts } from '../../dom.js';
import type { WorldProjection } from '../../world-projection.js';
import type { Appearance } from '../draw/appearance.js';
import type { Pick } from '../stage.js';
import type { NumberText } from './number-text.js';
import { className, materialName, type Say } from './texts.js';

export function showFacts(
  pick: Pick,
  projection: WorldProjection,
  appearance: Appearance,
  say: Say,
  numbers: NumberText,
): void {
  const { world } = projection;
  const units = world.unitsPerVoxel;
  const [easting, northing] = [pick.point[0] * units, -pick.point[2] * units];
  const degrees = projection.toLatLon(easting, northing);
  const { colour, lidarClass, isVisible } = pick;
  const yesOrNo = (value: boolean | undefined): string =>
    value === undefined ? '' : say(value ? 'yes' : 'no');
  setFacts(byId('facts', HTMLDListElement), [
    [say('easting'), numbers.number(easting, 1)],
    [say('northing'), numbers.number(northing, 1)],
    [say('height'), numbers.length(pick.point[1] * world.voxelM)],
    [say('latLon'), degrees === undefined ? '' : formatLatLon(degrees.latDeg, degrees.lonDeg)],
    [say('material'), materialName(say, appearance.materials[pick.material]?.name ?? '')],
    [say('lidarClass'), lidarClass === undefined ? '' : className(say, lidarClass)],
    [say('colour'), colour === undefined ? '' : `rgb(${colour.join(', ')})`],
    [say('level'), `${numbers.number(2 ** pick.level * world.voxelM, 2)} m`],
    [say('inSun'), yesOrNo(pick.isInSun)],
    [say('inSight'), yesOrNo(isVisible)],
  ]);
}
