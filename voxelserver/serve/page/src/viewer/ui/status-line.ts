/**
 * The line that says what the page waits for, and what went wrong: what to do, then the details.
 */
import { element, setText } from '../../dom.js';
import type { Failure } from '../../http/errors.js';
import type { Say } from './texts.js';

export class StatusLine {
  readonly #target: HTMLElement;
  readonly #say: Say;
  #hasTrouble = false;
  #hasEnded = false;

  constructor(target: HTMLElement, say: Say) {
    this.#target = target;
    this.#say = say;
    setText(target, say('loading'));
  }

  showTrouble({ kind, message }: Failure): void {
    this.#hasTrouble = true;
    this.#target.classList.add('trouble');
    const details = element('small', { lang: 'en' }, message);
    // What a reader can do is the same, whatever is wrong with the bytes.
    const known = kind === 'range' || kind === 'cut' ? 'damaged' : kind;
    this.#target.replaceChildren(this.#say(`trouble.${known}`), details);
  }

  /** Nothing more can be read: the message stays. */
  end(failure: Failure): void {
    this.#hasEnded = true;
    this.showTrouble(failure);
  }

  showProgress(waiting: number): void {
    // What failed has been read by now, unless the place cannot be read any more.
    if (this.#hasTrouble && (waiting > 0 || this.#hasEnded)) return;
    this.#hasTrouble = false;
    this.#target.classList.remove('trouble');
    setText(this.#target, waiting > 0 ? this.#say('refining', String(waiting)) : '');
  }
}
