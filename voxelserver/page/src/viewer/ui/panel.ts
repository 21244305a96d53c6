/** The panel as a whole: its texts, folding, light and dark, and how it looks inside other pages. */
import { byId, copy, setText } from '../../dom.js';
import type { Options } from './options.js';
import type { Say, TextKey } from './texts.js';

// Where a panel would cover much of the place it begins folded.
const kRoomy = '(min-width: 40rem) and (min-height: 25rem)';
const kCopiedMs = 2000;

export function setUpPanel(options: Options, say: Say): void {
  document.documentElement.lang = options.language;
  document.body.classList.toggle('embedded', options.isEmbedded);
  for (const target of document.querySelectorAll<HTMLElement>('[data-text]'))
    setText(target, say(target.dataset['text'] as TextKey));
  setUpFolding(options, say);
  setUpTheme(options);
  const own = byId('own-page', HTMLAnchorElement);
  own.hidden = !options.isEmbedded;
  // The address as it is when somebody follows the link, without what embeds it.
  own.addEventListener('click', () => (own.href = `${location.pathname}${location.hash}`));
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

/** A button that copies a text, and says whether that went well. */
export function setUpCopy(
  button: HTMLButtonElement,
  content: () => string,
  say: Say,
  name: TextKey,
  done: TextKey,
): void {
  button.addEventListener('click', () => {
    void copy(content()).then((isCopied) => {
      setText(button, say(isCopied ? done : 'copyFailed'));
      setTimeout(() => setText(button, say(name)), kCopiedMs);
    });
  });
}
