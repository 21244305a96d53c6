/** The views that a place offers by name. */
import { byId, element } from '../../dom.js';
import type { NamedView } from './place-file.js';

export function setUpViews(views: readonly NamedView[], onChosen: (view: NamedView) => void): void {
  const choice = byId('views', HTMLSelectElement);
  choice.replaceChildren(
    ...views.map((view, i) => element('option', { value: String(i) }, view.name)),
  );
  choice.addEventListener('change', () => {
    const named = views[Number(choice.value)];
    if (named !== undefined) onChosen(named);
  });
}
