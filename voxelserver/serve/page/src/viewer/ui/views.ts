/** The views that a place offers by name. */
import { byId, toOptions } from '../../dom.js';
import type { NamedView } from './place-file.js';

export function setUpViews(views: readonly NamedView[], onChosen: (view: NamedView) => void): void {
  const choice = byId('views', HTMLSelectElement);
  choice.replaceChildren(...toOptions(views.map(({ name }, i) => [String(i), name])));
  choice.addEventListener('change', () => {
    const named = views[Number(choice.value)];
    if (named !== undefined) onChosen(named);
  });
}
