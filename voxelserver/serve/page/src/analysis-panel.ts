import { AnalysisForm, toCaption, type FormPlace, type JobLimits } from './analysis-form.js';
import type { AnalysisLayer } from './analysis-layer.js';
import { AnalysisResult } from './analysis-result.js';
import { toMessage, type Api } from './http/api.js';
import { mayPass } from './http/retry.js';
import { byId, setText } from './dom.js';
import { toBody, makeFileName, readJob, type Job, type Places, type Wish } from './jobs.js';

const kPollMs = 1000;

/** Analyses by the server: asked for, watched and shown. A server that makes none says so here. */
export class AnalysisPanel {
  readonly #api: Api;
  readonly #isOnEarth: boolean;
  readonly #places: Places;
  readonly #result: AnalysisResult;
  readonly #state = byId('analysis-state', HTMLElement);
  readonly #bar = byId('analysis-bar', HTMLProgressElement);
  #form: AnalysisForm | undefined;
  #place: FormPlace | undefined;
  /** Of the job that is watched or shown; empty: none. */
  #id = '';

  constructor(api: Api, isOnEarth: boolean, places: Places, layer: AnalysisLayer) {
    this.#api = api;
    this.#isOnEarth = isOnEarth;
    this.#places = places;
    this.#result = new AnalysisResult(layer);
    for (const id of ['analysis-stop', 'analysis-remove']) {
      byId(id, HTMLButtonElement).addEventListener('click', () => void this.#remove());
    }
  }

  /** @param limits of the server; undefined: it makes no analyses */
  set limits(limits: JobLimits | undefined) {
    if (this.#form !== undefined) return;
    this.#say(
      limits === undefined
        ? 'This server computes no analyses. They are turned on by terravox serve --jobs 1.'
        : '',
    );
    if (limits === undefined) return;
    this.#form = new AnalysisForm(limits, this.#isOnEarth, (wish) => void this.#ask(wish));
    if (this.#place) this.#form.place = this.#place;
  }

  set place(place: FormPlace) {
    this.#place = place;
    if (this.#form) this.#form.place = place;
  }

  pointAt(easting: number, northing: number): void {
    this.#result.pointAt(easting, northing);
  }

  async #ask(wish: Wish | string): Promise<void> {
    if (typeof wish === 'string') return this.#say(wish, true);
    await this.#remove();
    this.#setBusy(true);
    try {
      const body = JSON.stringify(toBody(wish, this.#places));
      const reply = await this.#api.send('POST', 'v2/jobs', body);
      await this.#follow(readJob(await reply.json()), wish);
    } catch (error) {
      this.#setBusy(false);
      this.#say(toMessage(error), true);
    }
  }

  async #follow(job: Job, wish: Wish): Promise<void> {
    this.#id = job.id;
    let now = job;
    while (now.state === 'waiting' || now.state === 'running') {
      this.#bar.value = now.progress;
      this.#say(
        now.state === 'waiting'
          ? waitingText(now.before)
          : `Computing: ${Math.round(100 * now.progress)} %`,
      );
      await new Promise((resolve) => setTimeout(resolve, kPollMs));
      if (this.#id !== job.id) return;
      now = (await this.#look(job.id)) ?? now;
      if (this.#id !== job.id) return;
    }
    this.#setBusy(false);
    if (now.state === 'failed') {
      this.#id = '';
      return this.#say(`The analysis failed: ${now.message}`, true);
    }
    this.#say('Showing the result …');
    const reply = await this.#api.get(`v2/jobs/${job.id}/result.tif`);
    const file = new Blob([await reply.bytes()]);
    if (this.#id !== job.id) return;
    const [caption, fileName] = [toCaption(wish), makeFileName(wish)];
    await this.#result.show({ file, hasHoles: now.hasHoles, caption, fileName });
    if (this.#id === job.id) this.#say('');
  }

  /** @return undefined while the server does not answer */
  async #look(id: string): Promise<Job | undefined> {
    try {
      return readJob(await this.#api.getJson(`v2/jobs/${id}`));
    } catch (error) {
      if (!mayPass(error)) throw error;
      return undefined;
    }
  }

  async #remove(): Promise<void> {
    const id = this.#id;
    this.#id = '';
    this.#setBusy(false);
    this.#say('');
    this.#result.hide();
    if (id === '') return;
    try {
      await this.#api.send('DELETE', `v2/jobs/${id}`);
    } catch {
      // It is gone already, or will be when the server forgets it.
    }
  }

  #setBusy(busy: boolean): void {
    byId('analysis-progress', HTMLElement).hidden = !busy;
    this.#bar.value = 0;
    if (this.#form) this.#form.isBusy = busy;
  }

  #say(text: string, isError = false): void {
    setText(this.#state, text);
    this.#state.classList.toggle('error', isError);
  }
}

const waitingText = (before: number): string =>
  before === 0
    ? 'Waiting for its turn'
    : `Waiting for ${before} other ${before === 1 ? 'analysis' : 'analyses'}`;
