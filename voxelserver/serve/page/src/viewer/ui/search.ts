/** Going to a place by its coordinates. */
import { parsePlace, type FoundPlace } from '../../coordinates.js';
import { byId, setText } from '../../dom.js';
import type { WorldProjection } from '../../world-projection.js';
import { lookingAt, type Viewpoint } from './navigation.js';
import type { Say } from './texts.js';

const kNearest = 60; // level-0 voxels above and south of the place

/** @param projection of the world, once it is known */
export function setUpSearch(
  say: Say,
  projection: () => WorldProjection | undefined,
  onFound: (place: FoundPlace, projection: WorldProjection) => void,
): void {
  const search = byId('search-text', HTMLInputElement);
  search.placeholder = say('goToHint');
  byId('search', HTMLFormElement).addEventListener('submit', (event) => {
    event.preventDefault();
    const known = projection();
    if (known === undefined) return;
    const found = parsePlace(search.value, known);
    const isFound = typeof found !== 'string';
    setText(byId('search-error', HTMLSpanElement), isFound ? '' : say('goToFailed'));
    if (isFound) onFound(found, known);
  });
}

/** From above and from the south, whatever height the place has. */
export function toView(
  { easting, northing }: FoundPlace,
  projection: WorldProjection,
  before: Viewpoint,
): Viewpoint {
  const [x, z] = projection.toVoxel(easting, northing);
  const { min, max } = projection.world;
  const middle = (min[1] + max[1]) / 2;
  const away = Math.max(kNearest, max[1] - min[1]);
  return lookingAt({ ...before, position: [x, middle + away, z + away] }, [x, middle, z]);
}
