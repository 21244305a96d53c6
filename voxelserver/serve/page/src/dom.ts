/** Helpers around the document. Text enters it as text only: nothing anywhere parses HTML. */

type Child = Node | string;
type Attributes = Readonly<Record<string, string | number>>;

const kCopiedMs = 2000;
const kDownloadMs = 60_000; // a browser may ask its user where to

export function element<K extends keyof HTMLElementTagNameMap>(
  tag: K,
  attributes: Attributes = {},
  ...children: readonly Child[]
): HTMLElementTagNameMap[K] {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, String(value));
  made.append(...children);
  return made;
}

/** A part of a drawing, or the drawing itself. */
export function svgElement(
  tag: string,
  attributes: Attributes,
  ...children: readonly Child[]
): SVGElement {
  const made = document.createElementNS('http://www.w3.org/2000/svg', tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, String(value));
  made.append(...children);
  return made;
}

export function button(label: string, run: () => void): HTMLButtonElement {
  const made = element('button', { type: 'button' }, label);
  made.addEventListener('click', run);
  return made;
}

export const buttonRow = (...buttons: readonly HTMLElement[]): HTMLParagraphElement =>
  element('p', { class: 'buttons' }, ...buttons);

/** @param options values and their names */
export const toOptions = (options: readonly (readonly [string, string])[]): HTMLElement[] =>
  options.map(([value, name]) => element('option', { value }, name));

/** @throws Error when the browser has no memory for it */
export function getContext2d(canvas: HTMLCanvasElement): CanvasRenderingContext2D {
  const context = canvas.getContext('2d');
  if (context === null) throw new Error('draw on a canvas: the browser gives none');
  return context;
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

/** Rows of a definition list, without those that are empty; elements whose text stays are kept. */
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

/** Makes a button copy a text, and say for a while whether that went well. */
export function copyOnClick(
  target: HTMLButtonElement,
  content: () => string,
  [done, failed]: readonly [string, string] = ['Copied', 'Could not copy'],
): void {
  const label = target.textContent;
  target.addEventListener('click', () => {
    void copy(content()).then((isCopied) => {
      setText(target, isCopied ? done : failed);
      setTimeout(() => setText(target, label), kCopiedMs);
    });
  });
}

/**
 * Copies a text. The clipboard is there for HTTPS and localhost only; the old command works for a
 * server on another machine too.
 * @return whether it was copied
 */
async function copy(text: string): Promise<boolean> {
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

/** Saves a file on the reader's machine. */
export function download(content: Blob, name: string): void {
  const link = element('a', { href: URL.createObjectURL(content), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), kDownloadMs);
}
