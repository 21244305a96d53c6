import { toMessage, toTrouble, type Api } from './http/api.js';
import { byId, setText } from './dom.js';
import { askForToken } from './token.js';

const kHelp =
  'It was started with a token file. The token stays in this tab until the tab is closed.';

/** Shows the state of the server in words, and asks the user for a token when one is required. */
export class Connection {
  readonly #status = byId('status', HTMLElement);
  readonly #api: Api;
  readonly #onBack: () => void;
  #isWell = true;
  #isAsking = false;
  #hasTried = false;

  /**
   * @param onBack the server answers again, or a token was given: missing data can be requested
   */
  constructor(api: Api, onBack: () => void) {
    this.#api = api;
    this.#onBack = onBack;
    this.#say('Connecting to the server …', false);
  }

  /** To be called after each answer of the poll that watches the server. */
  well(): void {
    const wasWell = this.#isWell;
    this.#isWell = true;
    this.#hasTried = false;
    this.#say('The server is up.', false);
    if (!wasWell) this.#onBack();
  }

  trouble(error: unknown): void {
    this.#isWell = false;
    const kind = toTrouble(error);
    if (kind === 'token') return void this.#askForToken();
    const texts = {
      gone: 'The server does not answer. Trying again …',
      busy: 'The server is too busy. Trying again …',
      missing: `${toMessage(error)} Trying again …`,
      refused: `${toMessage(error)} Trying again …`,
    };
    this.#say(texts[kind], true);
  }

  async #askForToken(): Promise<void> {
    const what = this.#hasTried ? 'does not take this token' : 'requires a token';
    this.#say(`The server ${what}.`, true);
    if (this.#isAsking) return;
    this.#isAsking = true;
    const texts = { title: `The server ${what}`, help: kHelp, label: 'Token', use: 'Use it' };
    this.#api.setToken(await askForToken(texts));
    this.#isAsking = false;
    this.#hasTried = true;
    this.#say('Trying the token …', false);
    this.#onBack();
  }

  #say(text: string, isTrouble: boolean): void {
    setText(this.#status, text);
    this.#status.classList.toggle('trouble', isTrouble);
  }
}
