/**
 * The panel as a whole: its texts, folding, light and dark, and how it looks inside other pages.
 */
import { byId, setText } from '../../dom.js';
import type { Room } from './navigation.js';
import type { Options } from './options.js';
import type { Say, TextKey } from './texts.js';

// Where a panel would cover much of the place it begins folded.
const kRoomy = '(min-width: 40rem) and (min-height: 25rem)';
// A free part of the picture that is smaller than this share of it is too small for a place.
const kLeastRoom = 1 / 3;

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

type Rectangle = {
  readonly left: number;
  readonly top: number;
  readonly right: number;
  readonly bottom: number;
};

/**
 * The largest part of the picture that the panel does not cover; all of it where little is free.
 * Both in pixels of the window, down from its upper edge.
 */
export function roomBeside(picture: Rectangle, panel: Rectangle): Room {
  const size = ({ left, top, right, bottom }: Rectangle): number =>
    Math.max(0, right - left) * Math.max(0, bottom - top);
  const isApart =
    panel.left >= picture.right ||
    panel.right <= picture.left ||
    panel.top >= picture.bottom ||
    panel.bottom <= picture.top;
  const { left, top, right, bottom } = picture;
  const free = [
    { left, top, right, bottom: panel.top },
    { left, top: panel.bottom, right, bottom },
    { left, top, right: panel.left, bottom },
    { left: panel.right, top, right, bottom },
  ];
  const largest = free.reduce((a, b) => (size(b) > size(a) ? b : a));
  const isEnough = !isApart && size(largest) >= kLeastRoom * size(picture);
  const room = isEnough ? largest : picture;
  const x = (v: number): number => (2 * (v - left)) / (right - left) - 1;
  const y = (v: number): number => 1 - (2 * (v - top)) / (bottom - top);
  return { left: x(room.left), right: x(room.right), bottom: y(room.bottom), top: y(room.top) };
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
  show(options.isPanelOpen && (options.isPanelForced || matchMedia(kRoomy).matches));
}

function setUpTheme(options: Options): void {
  const choice = byId('theme', HTMLSelectElement);
  const root = document.documentElement;
  const apply = (): void => {
    if (choice.value === 'system') delete root.dataset['theme'];
    else root.dataset['theme'] = choice.value;
  };
  choice.value = options.theme ?? 'system';
  choice.addEventListener('change', apply);
  apply();
}
