/**
 * The panel as a whole: its texts, folding, light and dark, and how it looks inside other pages.
 */
import { byId, setText } from '../../dom.js';
import type { Options } from './options.js';
import type { Say, TextKey } from './texts.js';

// Where a panel would cover much of the place it begins folded.
const kRoomy = '(min-width: 40rem) and (min-height: 25rem)';
const kMostCovered = 2 / 3;

export function setUpPanel(options: Options, say: Say): void {
  document.documentElement.lang = options.language;
  document.body.classList.toggle('embedded', options.isEmbedded);
  for (const target of document.querySelectorAll<HTMLElement>('[data-text]')) {
    setText(target, say(target.dataset['text'] as TextKey));
  }
  setUpFolding(options, say);
  setUpTheme(options);
  const own = byId('own-page', HTMLAnchorElement);
  own.hidden = !options.isEmbedded;
  // The address as it is when somebody follows the link, without what embeds it.
  own.addEventListener('click', () => (own.href = `${location.pathname}${location.hash}`));
}

/** Where something lies in the window, pixels. */
type Rectangle = Pick<DOMRect, 'left' | 'top' | 'right' | 'bottom'>;

/** Share of the picture that the panel covers on the left; 0 where little would be left of it. */
export function coveredShare(picture: Rectangle, panel: Rectangle): number {
  if (panel.top >= picture.bottom) return 0;
  const share = Math.max(0, panel.right - picture.left) / (picture.right - picture.left);
  return share < kMostCovered ? share : 0;
}

function setUpFolding(options: Options, say: Say): void {
  const fold = byId('fold', HTMLButtonElement);
  const show = (isOpen: boolean): void => {
    document.body.classList.toggle('folded', !isOpen);
    fold.setAttribute('aria-expanded', String(isOpen));
    fold.setAttribute('aria-label', say(isOpen ? 'hidePanel' : 'showPanel'));
    setText(fold, isOpen ? '×' : '≡');
  };
  fold.addEventListener('click', () => show(document.body.classList.contains('folded')));
  const isRoomy = !options.isEmbedded && matchMedia(kRoomy).matches;
  show(options.panel === 'open' || (options.panel === undefined && isRoomy));
}

// By the style sheet's one set of dark colours.
function setUpTheme({ theme }: Options): void {
  const system = matchMedia('(prefers-color-scheme: dark)');
  const apply = (): void => {
    document.documentElement.dataset['theme'] = theme ?? (system.matches ? 'dark' : 'light');
  };
  system.addEventListener('change', apply);
  apply();
}
