/** What the address of a page asks for behind `?`: how it looks where others embed it. */
import { chooseLanguage, kLanguages, type Language } from './texts.js';

export type Options = {
  /** The panel hides behind a button. */
  readonly isEmbedded: boolean;
  /** How the panel begins; undefined: open where there is room. */
  readonly panel: 'open' | 'closed' | undefined;
  /** Whether the picture can be moved. */
  readonly hasControls: boolean;
  readonly language: Language;
  /** undefined: as the system. */
  readonly theme: 'light' | 'dark' | undefined;
};

const kEmbedSize = [800, 500] as const;

/**
 * @param search the part of an address from `?` on; unknown words and values are ignored
 * @param languages of the reader, most wanted first
 */
export function readOptions(search: string, languages: readonly string[]): Options {
  const words = new URLSearchParams(search);
  const choose = <T extends string>(name: string, values: readonly T[]): T | undefined =>
    values.find((value) => value === words.get(name));
  return {
    isEmbedded: words.get('embed') === '1',
    panel: choose('panel', ['open', 'closed']),
    hasControls: words.get('controls') !== 'none',
    language: choose('lang', kLanguages) ?? chooseLanguage(languages),
    theme: choose('theme', ['light', 'dark']),
  };
}

/**
 * HTML that shows a view of the place in another page.
 * @param address of the page @param link the part from `#` on
 */
export function embedCode(address: string, link: string, title: string): string {
  const page = new URL(address);
  page.search = '?embed=1';
  page.hash = link;
  const [width, height] = kEmbedSize;
  return (
    `<iframe src="${escaped(page.href)}" title="${escaped(title)}" ` +
    `width="${width}" height="${height}" loading="lazy" ` +
    `allow="fullscreen; clipboard-write"></iframe>`
  );
}

const kEntities: Readonly<Record<string, string>> = {
  '&': '&amp;',
  '<': '&lt;',
  '>': '&gt;',
  '"': '&quot;',
};

const escaped = (text: string): string => text.replace(/[&<>"]/g, (c) => kEntities[c]!);
