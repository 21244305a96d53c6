/** What the address of a page asks for behind `?`: how it looks where others embed it. */
import { chooseLanguage, type Language } from './texts.js';

export type Theme = 'light' | 'dark';

export type Options = {
  /** The panel hides behind a button. */
  readonly isEmbedded: boolean;
  readonly isPanelOpen: boolean;
  /** Open or closed by the address, whatever the size of the window is. */
  readonly isPanelForced: boolean;
  /** Whether the picture can be moved. */
  readonly hasControls: boolean;
  readonly language: Language;
  /** undefined: as the system. */
  readonly theme: Theme | undefined;
};

const kEmbedSize = [800, 500] as const;

/**
 * @param search the part of an address from `?` on; unknown words and values are ignored
 * @param languages of the reader, most wanted first
 */
export function readOptions(search: string, languages: readonly string[]): Options {
  const words = new URLSearchParams(search);
  const isEmbedded = words.get('embed') === '1';
  const panel = words.get('panel');
  const language = words.get('lang');
  const theme = words.get('theme');
  return {
    isEmbedded,
    isPanelOpen: panel === 'open' || (panel !== 'closed' && !isEmbedded),
    isPanelForced: panel === 'open' || panel === 'closed',
    hasControls: words.get('controls') !== 'none',
    language: language === 'en' || language === 'sl' ? language : chooseLanguage(languages),
    theme: theme === 'light' || theme === 'dark' ? theme : undefined,
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

/** The command that shows a folder in a browser. @param address of a page in it, file:///... */
export function viewCommand(address: string): string {
  const folder = decodeURIComponent(new URL('.', address).pathname);
  const isPlain = /^[\w/.,:@%+-]+$/.test(folder);
  return `terravox view ${isPlain ? folder : `'${folder.replaceAll("'", `'\\''`)}'`}`;
}

const kEntities: Readonly<Record<string, string>> = {
  '&': '&amp;',
  '<': '&lt;',
  '>': '&gt;',
  '"': '&quot;',
};

const escaped = (text: string): string => text.replace(/[&<>"]/g, (c) => kEntities[c]!);
