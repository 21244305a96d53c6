/** Small helpers around the document. Text enters it as text only: nothing here, or anywhere, parses HTML. */

type Child = Node | string;

export function element<K extends keyof HTMLElementTagNameMap>(
  tag: K,
  attributes: Readonly<Record<string, string>> = {},
  ...children: readonly Child[]
): HTMLElementTagNameMap[K] {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.append(...children);
  return made;
}

/** @throws Error when index.html has no such element */
export function byId<T extends HTMLElement>(id: string, type: new () => T): T {
  const found = document.getElementById(id);
  if (!(found instanceof type)) throw new Error(`the page has no ${type.name} named ${id}`);
  return found;
}

/** Sets the text only when it differs: a screen reader would repeat the same text. */
export function setText(target: Element, text: string): void {
  if (target.textContent !== text) target.textContent = text;
}

/** Rows of a definition list; those with an empty text are left out. Keeps the elements whose text did not change. */
export function setFacts(
  list: HTMLDListElement,
  facts: readonly (readonly [string, string])[],
): void {
  const shown = facts.filter(([, text]) => text !== '');
  while (list.children.length > shown.length) list.lastElementChild?.remove();
  while (list.children.length < shown.length) {
    list.append(element('div', {}, element('dt'), element('dd')));
  }
  shown.forEach(([name, text], i) => {
    const row = list.children[i]!;
    setText(row.children[0]!, name);
    setText(row.children[1]!, text);
  });
}

/** The value of a colour or the like from app.css, which differs between light and dark. */
export const cssValue = (name: string): string =>
  getComputedStyle(document.documentElement).getPropertyValue(name).trim();

/** A button that copies a text, and confirms it. */
export function copyButton(label: string, text: () => string): HTMLButtonElement {
  const button = element('button', { type: 'button' }, label);
  button.addEventListener('click', () => {
    void copy(text()).then((done) => {
      button.textContent = done ? 'Copied' : 'Could not copy';
      setTimeout(() => (button.textContent = label), 2000);
    });
  });
  return button;
}

/**
 * Copies a text. The clipboard is there for HTTPS and localhost only; the old command works for a server on another machine too.
 * @return whether it was copied
 */
export async function copy(text: string): Promise<boolean> {
  try {
    await navigator.clipboard.writeText(text);
    return true;
  } catch {
    const area = element('textarea', { class: 'hidden-text', readonly: '' });
    area.value = text;
    const focused = document.activeElement;
    document.body.append(area);
    area.select();
    const done = document.execCommand('copy');
    area.remove();
    if (focused instanceof HTMLElement) focused.focus();
    return done;
  }
}
