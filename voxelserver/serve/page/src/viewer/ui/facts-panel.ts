/** What is known of the point that somebody has clicked. */
import type { Vec2 } from '../../vec3.js';
import { formatLatLon } from '../../coordinates.js';
import { byId, setFacts } from '../../dom.js';
import type { WorldProjection } from '../../world-projection.js';
import type { Appearance } from '../draw/appearance.js';
import type { Pick } from '../stage.js';
import { numberText } from './number-text.js';
import { className, materialName, type Language, type Say } from './texts.js';

/** @param onClosed somebody has closed it, with the focus in it, which must go elsewhere */
export function setUpFacts(onClosed: () => void): void {
  const close = (): void => {
    const section = byId('place', HTMLElement);
    const hadFocus = section.contains(document.activeElement);
    section.hidden = true;
    if (hadFocus) onClosed();
  };
  byId('close', HTMLButtonElement).addEventListener('click', close);
  document.addEventListener('keydown', (event) => {
    if (event.key === 'Escape') close();
  });
}

export const areFactsShown = (): boolean => !byId('place', HTMLElement).hidden;

/**
 * @param pick undefined hides what was shown
 * @param square name of the LiDAR square; '': none, or not known yet
 */
export function showFacts(
  pick: Pick | undefined,
  square: string,
  projection: WorldProjection,
  appearance: Appearance,
  say: Say,
  language: Language,
): void {
  byId('place', HTMLElement).hidden = pick === undefined;
  if (pick === undefined) return;
  const { world } = projection;
  const numbers = numberText(language, world.voxelM);
  const [easting, northing] = toPosition(pick, projection);
  const degrees = projection.toLatLon(easting, northing);
  const { colour, lidarClass, isVisible } = pick;
  const yesOrNo = (value: boolean | undefined): string =>
    value === undefined ? '' : say(value ? 'yes' : 'no');
  setFacts(byId('facts', HTMLDListElement), [
    [say('easting'), numbers.number(easting, 1)],
    [say('northing'), numbers.number(northing, 1)],
    [say('height'), numbers.length(pick.point[1] * world.voxelM)],
    [say('latLon'), degrees === undefined ? '' : formatLatLon(degrees)],
    [say('material'), materialName(say, appearance.materials[pick.material]?.name ?? '')],
    [say('lidarClass'), lidarClass === undefined ? '' : className(say, lidarClass)],
    [say('square'), square],
    [say('colour'), colour === undefined ? '' : `rgb(${colour.join(', ')})`],
    [say('level'), `${numbers.number(2 ** pick.level * world.voxelM, 2)} m`],
    [say('inSun'), yesOrNo(pick.isInSun)],
    [say('inSight'), yesOrNo(isVisible)],
  ]);
}

/** Easting and northing of a point, in units of the CRS. */
export function toPosition({ point }: Pick, { world }: WorldProjection): Vec2 {
  return [point[0] * world.unitsPerVoxel, -point[2] * world.unitsPerVoxel];
}
