import { parsePlace, type FoundPlace } from './coordinates.js';
import { byId, setText } from './dom.js';
import type { WorldProjection } from './world-projection.js';

/**
 * The field that takes coordinates.
 * @param projection of the world, once it is known
 * @param fault what is said of what is no place; by default why it is none
 */
export function setUpSearch(
  projection: () => WorldProjection | undefined,
  onFound: (place: FoundPlace, projection: WorldProjection) => void,
  fault?: string,
): void {
  const field = byId('search-text', HTMLInputElement);
  byId('search', HTMLFormElement).addEventListener('submit', (event) => {
    event.preventDefault();
    const known = projection();
    if (known === undefined) return;
    const found = parsePlace(field.value, known);
    const failed = typeof found === 'string';
    setText(byId('search-error', HTMLElement), failed ? (fault ?? found) : '');
    field.setAttribute('aria-invalid', String(failed));
    if (failed) field.focus();
    else onFound(found, known);
  });
}
