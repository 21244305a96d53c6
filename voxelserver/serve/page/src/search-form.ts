import { parsePlace, type FoundPlace } from './coordinates.js';
import { byId, setText } from './dom.js';
import type { WorldProjection } from './world-projection.js';

/** The field that takes coordinates. */
export function setUpSearch(
  projection: WorldProjection,
  onFound: (place: FoundPlace) => void,
): void {
  const field = byId('search-text', HTMLInputElement);
  const error = byId('search-error', HTMLElement);
  byId('search', HTMLFormElement).addEventListener('submit', (event) => {
    event.preventDefault();
    const found = parsePlace(field.value, projection);
    const failed = typeof found === 'string';
    setText(error, failed ? found : '');
    field.setAttribute('aria-invalid', String(failed));
    if (failed) field.focus();
    else onFound(found);
  });
}
