import { clamp, type Vec3 } from '../vec3.js';
import { setUpSearch } from '../search-form.js';
import { squareNames } from '../squares.js';
import { makeHttp, type Reply } from '../http/http.js';
import { byId, copyOnClick, setText, toOptions } from '../dom.js';
import { WorldProjection } from '../world-projection.js';
import type { Facts } from './data/facts.js';
import type { Place } from './data/protocol.js';
import { readAppearance, type Appearance } from './draw/appearance.js';
import { kDefaultLook, type Look } from './draw/renderer.js';
import { Stage, type Pick, type StageStats } from './stage.js';
import { Controls } from './ui/controls.js';
import { areFactsShown, toPosition, setUpFacts, showFacts } from './ui/facts-panel.js';
import { fromLink, toLink, parseWords } from './ui/link.js';
import { chosenLook, followLook, lookWords, setUpLook } from './ui/look-switches.js';
import {
  toCamera,
  toView,
  fitted,
  isSameView,
  lookingAt,
  turned,
  type Viewpoint,
} from './ui/navigation.js';
import { numberText } from './ui/number-text.js';
import { embedCode, readOptions } from './ui/options.js';
import { Overlay, type Shape } from './ui/overlay.js';
import { coveredShare, setUpPanel } from './ui/panel.js';
import { readPlaceFile, type NamedView, type PlaceFile } from './ui/place-file.js';
import { savePicture } from './ui/save-picture.js';
import { fetchWithToken, serverPlace } from './ui/server-access.js';
import { watchServer } from './ui/server-watch.js';
import { StatusLine } from './ui/status-line.js';
import { text, type TextKey } from './ui/texts.js';
import { setUpTime, showTime } from './ui/time-inputs.js';
import type { ToolContext } from './ui/tool.js';
import { Toolbox } from './ui/toolbox.js';

/** The viewer of a site (docs/formats/site.md): opens place.json, and lets people fly around. */

declare global {
  // Only an interface merges with the one that is there.
  // eslint-disable-next-line @typescript-eslint/consistent-type-definitions
  interface Window {
    /** For scripts: see docs/guide/viewer.md. */
    terravox: {
      readonly ready: Promise<void>;
      readonly stats: () => StageStats;
      readonly firstHits: () => ReturnType<Stage['firstHits']>;
      readonly cast: Stage['cast'];
      /** What is not named becomes as at the beginning. */
      readonly setLook: (look: Partial<Look>) => void;
    };
  }
}

const kPoolBytes = 224 * 2 ** 20;
const kSmallPoolBytes = 96 * 2 ** 20; // of phones: see poolBytes()
const kLinkMs = 400; // the address follows the view not more often than this
const kSettledMs = 700; // without movement or boxes to come: rays meet what they can meet
const kMaxPixelRatio = 2;
const kFarthest = 2 ** 29; // level-0 voxels: half of where worlds end
const kLatestMs = Date.UTC(2199, 11, 31, 23, 59); // as links have it

const http = makeHttp();
const options = readOptions(location.search, navigator.languages);
const say = (key: TextKey, ...values: string[]): string => text(options.language, key, ...values);

// First of all: what goes wrong from here on is read in it.
setUpPanel(options, say);

class Viewer {
  readonly #canvas = byId('picture', HTMLCanvasElement);
  readonly #status = new StatusLine(byId('status', HTMLParagraphElement), say);
  readonly #place: PlaceFile;
  readonly stage: Stage;
  readonly #controls: Controls;
  readonly #overlay: Overlay;
  readonly #appearance: Appearance;
  readonly #credit: string;
  readonly #squareAt: ReturnType<typeof squareNames> | undefined;
  /** What the facts are of. */
  #asked: Pick | undefined;
  #projection: WorldProjection | undefined;
  #toolbox: Toolbox | undefined;
  /** A view that was chosen by its name, for as long as nobody moves it. */
  #showing: { readonly named: NamedView; readonly view: Viewpoint } | undefined;
  #linkedMs = 0;
  #isLinkDue = false;
  #isLookDue = true;
  #isOverlayDue = true;
  /** Since when nothing has moved and nothing is to come; undefined when tools know. */
  #stillSinceMs: number | undefined;
  timeMs: number;
  view: Viewpoint;

  constructor(place: PlaceFile, appearance: Appearance) {
    this.#place = place;
    this.#appearance = appearance;
    const { squares } = place;
    this.#squareAt =
      squares === undefined ? undefined : squareNames(async () => (await load(squares)).json());
    this.#credit = [place.attribution, place.licence].filter((part) => part !== '').join(' · ');
    const named = place.views[0]!;
    const first = this.#toViewpoint(named);
    const state = fromLink(location.hash, { view: first, timeMs: place.timeMs });
    this.view = state.view;
    if (isSameView(this.view, first)) this.#showing = { named, view: this.view };
    this.timeMs = state.timeMs;
    const worker = new Worker(new URL('viewer/worker.js', document.baseURI), { type: 'module' });
    this.stage = new Stage(this.#canvas, worker, addressed(place), appearance, poolBytes(), {
      onOpened: (facts) => this.#opened(facts),
      onFailure: (failure) => this.#status.showTrouble(failure),
      onEnded: (failure) => this.#status.end(failure),
      onFrame: () => this.#status.showProgress(this.stage.waiting),
    });
    this.#overlay = new Overlay(this.#canvas);
    const host = {
      setView: (view: Viewpoint): void => this.setView(view),
      pointAt: (x: number, y: number): Vec3 | undefined => this.#pickAt(x, y)?.point,
      onClick: (x: number, y: number): void => this.#click(this.#pickAt(x, y)),
    };
    this.#controls = new Controls(this.#canvas, this.view, host, options.hasControls);
  }

  look(look: Partial<Look>): void {
    this.stage.setLook({ ...kDefaultLook, ...look });
  }

  setView(wanted: Viewpoint): void {
    const inside = (v: number): number => clamp(v, -kFarthest, kFarthest);
    const [x, y, z] = wanted.position;
    const view = { ...wanted, position: [inside(x), inside(y), inside(z)] as const };
    this.view = view;
    this.#controls.view = view;
    this.stage.setCamera(toCamera(view));
    this.#stillSinceMs = performance.now();
    this.#changed();
  }

  #show(named: NamedView): void {
    this.setView(this.#toViewpoint(named));
    this.#showing = { named, view: this.view };
  }

  #toViewpoint(named: NamedView): Viewpoint {
    const at = { position: named.position, headingDeg: 0, pitchDeg: 0, fovDeg: named.fovDeg };
    const view = lookingAt(at, named.target);
    if (named.frame === undefined) return view;
    const picture = this.#canvas.getBoundingClientRect();
    const panel = byId('panel', HTMLElement).getBoundingClientRect();
    const aspect = Math.max(picture.width, 1) / Math.max(picture.height, 1);
    return fitted(view, named.frame, aspect, coveredShare(picture, panel));
  }

  setTime(wantedMs: number): void {
    const timeMs = clamp(wantedMs, 0, kLatestMs);
    this.timeMs = timeMs;
    this.stage.setTime(timeMs);
    showTime(timeMs, this.stage.sun, say, options.language);
    this.#toolbox?.timeChanged();
    this.#changed();
  }

  start(): void {
    setText(byId('title', HTMLHeadingElement), this.#place.title);
    document.title = `${this.#place.title} · Terravox`;
    this.#canvas.setAttribute('aria-label', say('pictureOf', this.#place.title));
    this.#canvas.classList.toggle('fixed', !options.hasControls);
    setText(byId('attribution', HTMLParagraphElement), this.#credit);
    this.#setUpInputs();
    followLook(parseWords(location.hash));
    new ResizeObserver(() => this.#resize()).observe(this.#canvas);
    this.#resize();
    this.setTime(this.timeMs);
    window.addEventListener('hashchange', () => this.#followLink());
    requestAnimationFrame((nowMs) => this.#frame(nowMs));
  }

  #frame(nowMs: number): void {
    this.#controls.frame(nowMs);
    if (this.#isLookDue) {
      this.#isLookDue = false;
      const look = chosenLook();
      this.stage.setLook(this.#toolbox?.look(look) ?? look);
    }
    this.stage.frame(nowMs);
    if (this.#isOverlayDue) {
      this.#isOverlayDue = false;
      this.#overlay.draw(toCamera(this.view), this.#shapes());
    }
    this.#settle(nowMs);
    // Before the place is there nobody knows the words of tools.
    if (this.#isLinkDue && this.#toolbox !== undefined && nowMs - this.#linkedMs > kLinkMs) {
      this.#isLinkDue = false;
      this.#linkedMs = nowMs;
      history.replaceState(null, '', this.#link());
    }
    requestAnimationFrame((next) => this.#frame(next));
  }

  #link(): string {
    const words = { ...lookWords(), ...this.#toolbox?.words() };
    return toLink({ view: this.view, timeMs: this.timeMs }, words);
  }

  // Tools cast their rays again when all that the view needs has come.
  #settle(nowMs: number): void {
    if (this.stage.waiting > 0) this.#stillSinceMs = nowMs;
    if (this.#stillSinceMs === undefined || nowMs - this.#stillSinceMs < kSettledMs) return;
    this.#stillSinceMs = undefined;
    this.#toolbox?.settled();
  }

  #shapes(): readonly Shape[] {
    const toolbox = this.#toolbox;
    if (toolbox === undefined) return [];
    return toolbox.takesClicks ? [...toolbox.shapes(), { kind: 'cross' }] : toolbox.shapes();
  }

  #changed(): void {
    this.#isLinkDue = true;
    this.#isOverlayDue = true;
  }

  #lookChanged(): void {
    this.#isLookDue = true;
    this.#changed();
  }

  #resize(): void {
    const ratio = Math.min(window.devicePixelRatio, kMaxPixelRatio);
    const width = Math.max(1, Math.round(this.#canvas.clientWidth * ratio));
    const height = Math.max(1, Math.round(this.#canvas.clientHeight * ratio));
    if (this.#canvas.width !== width || this.#canvas.height !== height) {
      this.#canvas.width = width;
      this.#canvas.height = height;
    }
    // A whole place stays whole.
    if (this.#showing?.view === this.view) this.#show(this.#showing.named);
    else this.setView(this.view);
  }

  #opened({ world }: Facts): void {
    this.#projection = new WorldProjection(world);
    const context: ToolContext = {
      say,
      numbers: numberText(options.language, world.voxelM),
      world,
      appearance: this.#appearance,
      cast: (rays) => this.stage.cast(rays),
      camera: () => toCamera(this.view),
      aspect: () => this.#canvas.width / this.#canvas.height,
      middle: () => this.#pickMiddle(),
      timeMs: () => this.timeMs,
      turnTo: (headingDeg, pitchDeg) => {
        const { view } = this;
        this.setView(turned(view, headingDeg - view.headingDeg, pitchDeg - view.pitchDeg));
      },
      changed: () => this.#changed(),
      lookChanged: () => this.#lookChanged(),
    };
    const section = byId('tools', HTMLElement);
    this.#toolbox = new Toolbox(context, section);
    this.#toolbox.follow(parseWords(location.hash));
    section.hidden = false;
    this.setTime(this.timeMs);
  }

  #followLink(): void {
    const state = fromLink(location.hash, { view: this.view, timeMs: this.timeMs });
    const words = parseWords(location.hash);
    followLook(words);
    this.#toolbox?.follow(words);
    this.#lookChanged();
    this.setView(state.view);
    this.setTime(state.timeMs);
  }

  #pickAt(x: number, y: number): Pick | undefined {
    const box = this.#canvas.getBoundingClientRect();
    const ratio = this.#canvas.width / Math.max(1, box.width);
    return this.stage.pick(Math.floor((x - box.left) * ratio), Math.floor((y - box.top) * ratio));
  }

  #pickMiddle(): Pick | undefined {
    const { width, height } = this.#canvas;
    return this.stage.pick(Math.floor(width / 2), Math.floor(height / 2));
  }

  #click(pick: Pick | undefined): void {
    if (this.#toolbox?.takesClicks === true) {
      if (pick !== undefined) this.#toolbox.click(pick);
    } else if (this.#projection !== undefined) this.#showFacts(pick, this.#projection);
  }

  #showFacts(pick: Pick | undefined, projection: WorldProjection): void {
    const show = (square: string): void =>
      showFacts(pick, square, projection, this.#appearance, say, options.language);
    this.#asked = pick;
    show('');
    if (pick === undefined) return;
    this.#squareAt?.(toPosition(pick, projection)).then(
      (square) => {
        if (square !== '' && this.#asked === pick && areFactsShown()) show(square);
      },
      (error: Error) => this.#status.showTrouble({ kind: 'missing', message: error.message }),
    );
  }

  #setUpInputs(): void {
    const { views } = this.#place;
    const choice = byId('views', HTMLSelectElement);
    choice.replaceChildren(...toOptions(views.map(({ name }, i) => [String(i), name])));
    choice.addEventListener('change', () => this.#show(views[Number(choice.value)]!));
    setUpTime((timeMs) => this.setTime(timeMs));
    setUpLook(() => this.#lookChanged());
    byId('save', HTMLButtonElement).addEventListener('click', () =>
      savePicture(this.#canvas, toCamera(this.view), this.#shapes(), this.#credit),
    );
    setUpFacts(() => this.#canvas.focus());
    byId('search-text', HTMLInputElement).placeholder = say('goToHint');
    setUpSearch(
      () => this.#projection,
      (place, projection) => this.setView(toView(place, projection, this.view)),
      say('goToFailed'),
    );
    const address = (): string => new URL(this.#link(), location.href).href;
    const code = (): string => embedCode(location.href, this.#link(), this.#place.title);
    const copied = (id: string, content: () => string, done: TextKey): void => {
      copyOnClick(byId(id, HTMLButtonElement), content, [say(done), say('copyFailed')]);
    };
    copied('link', address, 'linkCopied');
    copied('embed', code, 'embedCopied');
  }
}

// Addresses in place.json are relative to the page, not to the worker.
function addressed({ archive }: PlaceFile): Place {
  const absolute = (url: string): string => new URL(url, document.baseURI).href;
  if ('server' in archive) return serverPlace(absolute(archive.server), archive.coarsest);
  if ('url' in archive) return { url: absolute(archive.url) };
  return { parts: archive.parts.map(({ url, bytes }) => ({ url: absolute(url), bytes })) };
}

// Phones share their memory with the graphics processor.
function poolBytes(): number {
  const memoryGb = (navigator as { deviceMemory?: number }).deviceMemory ?? 8;
  return memoryGb <= 4 ? kSmallPoolBytes : kPoolBytes;
}

async function load(name: string): Promise<Reply> {
  const reply = await fetchWithToken(http, new URL(name, document.baseURI), `read ${name}`, say);
  if (reply.response.ok) return reply;
  throw new Error(`read ${name}: the host answers ${reply.status}; is the site complete?`);
}

async function start(): Promise<Viewer> {
  if (location.protocol === 'file:') {
    byId('panel', HTMLDivElement).hidden = true;
    throw new Error(say('fromDisk'));
  }
  const [file, appearance] = await Promise.all([load('place.json'), load('appearance.bin')]);
  const place = readPlaceFile(await file.json());
  const viewer = new Viewer(place, await readAppearance(await appearance.bytes()));
  viewer.start();
  if ('server' in place.archive) {
    watchServer(http, new URL(place.archive.server, document.baseURI).href, say, viewer);
  }
  return viewer;
}

const started = start();
window.terravox = {
  ready: started.then((viewer) => viewer.stage.ready),
  stats: () => viewer().stage.stats(),
  firstHits: () => viewer().stage.firstHits(),
  cast: (rays) => viewer().stage.cast(rays),
  setLook: (look) => viewer().look(look),
};
// Whoever waits for it sees the reason; others see the message below.
window.terravox.ready.catch(() => {});
function viewer(): Viewer {
  if (current === undefined) throw new Error('the viewer has not been started yet');
  return current;
}
let current: Viewer | undefined;
started.then(
  (viewer) => (current = viewer),
  (error: unknown) => {
    const status = byId('status', HTMLParagraphElement);
    status.classList.add('trouble');
    setText(status, `${say('failed')}: ${error instanceof Error ? error.message : String(error)}`);
  },
);
