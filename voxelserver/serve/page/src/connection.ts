import { toMessage, toTrouble, type Api } from './http/api.js';
import { byId, setText } from './dom.js';

/** Shows the state of the server in words, and asks the user for a token when one is required. */
export class Connection {
  readonly #status = byId('status', HTMLElement);
  readonly #form = byId('token', HTMLFormElement);
  readonly #field = byId('token-text', HTMLInputElement);
  readonly #onBack: () => void;
  #isWell = true;
  #hasTried = false;

  /**
   * @param onBack the server answers again, or a token was given: missing data can be requested
   */
  constructor(api: Api, onBack: () => void) {
    this.#onBack = onBack;
    this.#say('Connecting to the server …', false);
    this.#form.addEventListener('submit', (event) => {
      event.preventDefault();
      api.setToken(this.#field.value.trim());
      this.#field.value = '';
      this.#hasTried = true;
      this.#say('Trying the token …', false);
      onBack();
    });
  }

  /** To be called after each answer of the poll that watches the server. */
  well(): void {
    const wasWell = this.#isWell;
    this.#isWell = true;
    this.#hasTried = false;
    this.#form.hidden = true;
    this.#say('The server is up.', false);
    if (!wasWell) this.#onBack();
  }

  trouble(error: unknown): void {
    this.#isWell = false;
    const kind = toTrouble(error);
    if (kind === 'token') return this.#askForToken();
    const texts = {
      gone: 'The server does not answer. Trying again …',
      busy: 'The server is too busy. Trying again …',
      missing: `${toMessage(error)} Trying again …`,
      refused: `${toMessage(error)} Trying again …`,
    };
    this.#say(texts[kind], true);
  }

  #askForToken(): void {
    this.#say(
      this.#hasTried ? 'The server does not take this token.' : 'The server requires a token.',
      true,
    );
    if (!this.#form.hidden) return;
    this.#form.hidden = false;
    this.#field.focus();
  }

  #say(text: string, isTrouble: boolean): void {
    setText(this.#status, text);
    this.#status.classList.toggle('trouble', isTrouble);
  }
}
