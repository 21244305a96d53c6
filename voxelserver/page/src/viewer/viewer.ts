import { formatLatLon, parsePlace } from '../coordinates.js';
import { byId, copy, element, setFacts, setText } from '../dom.js';
import { WorldProjection } from '../world-projection.js';
import type { Facts, Failure, Place } from './data/protocol.js';
import { readAppearance, unpackAppearance, type Appearance } from './draw/appearance.js';
import type { Vec3 } from './draw/camera.js';
import { kDefaultLook, type Look } from './draw/renderer.js';
import { Stage, type Pick, type StageStats } from './stage.js';
import { Controls } from './ui/controls.js';
import { fromLink, toLink } from './ui/link.js';
import { cameraOf, lookingAt, type Viewpoint } from './ui/navigation.js';
import { readPlaceFile, type NamedView, type PlaceFile } from './ui/place-file.js';
import { fetchWithToken, serverPlace } from './ui/server-access.js';
import { watchServer } from './ui/server-watch.js';
import { languageOf, text, type TextKey } from './ui/texts.js';

/** The viewer of a site (docs/formats/site.md): opens place.json, and lets people fly around. */

declare global {
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

const kDayMs = 86_400_000;
const kMinuteMs = 60_000;
const kPoolBytes = 224 * 2 ** 20;
const kSmallPoolBytes = 96 * 2 ** 20; // of phones: see poolBytes()
const kLinkMs = 400; // the address follows the view not more often than this
const kMaxPixelRatio = 2;
const kFarthest = 2 ** 29; // level-0 voxels: half of where worlds end
const kLatestMs = Date.UTC(2199, 11, 31, 23, 59); // as links have it

const language = languageOf(navigator.languages);
const say = (key: TextKey, ...values: string[]): string => text(language, key, ...values);

class Viewer {
  readonly #canvas = byId('picture', HTMLCanvasElement);
  readonly #status = byId('status', HTMLParagraphElement);
  readonly #place: PlaceFile;
  readonly #stage: Stage;
  readonly #controls: Controls;
  readonly #appearance: Appearance;
  #projection: WorldProjection | undefined;
  #linkedMs = 0;
  #isLinkDue = false;
  #trouble = '';
  #hasEnded = false;
  timeMs: number;
  view: Viewpoint;

  constructor(place: PlaceFile, appearance: Appearance) {
    this.#place = place;
    this.#appearance = appearance;
    const first = viewpointOf(place.views[0]!);
    const state = fromLink(location.hash, { view: first, timeMs: place.timeMs });
    this.view = state.view;
    this.timeMs = state.timeMs;
    const worker = new Worker(new URL('worker.js', import.meta.url), { type: 'module' });
    this.#stage = new Stage(this.#canvas, worker, addressed(place), appearance, poolBytes(), {
      onOpened: (facts) => this.#opened(facts),
      onFailure: (failure) => this.#showTrouble(failure),
      onEnded: (failure) => {
        this.#hasEnded = true;
        this.#showTrouble(failure);
      },
      onFrame: () => this.#showProgress(),
    });
    this.#controls = new Controls(this.#canvas, this.view, {
      setView: (view) => this.setView(view),
      pointAt: (x, y) => this.#pickAt(x, y)?.point,
      onClick: (x, y) => this.#showPick(this.#pickAt(x, y)),
    });
  }

  get ready(): Promise<void> {
    return this.#stage.ready;
  }

  stats(): StageStats {
    return this.#stage.stats();
  }

  firstHits(): ReturnType<Stage['firstHits']> {
    return this.#stage.firstHits();
  }

  cast(rays: Parameters<Stage['cast']>[0]): ReturnType<Stage['cast']> {
    return this.#stage.cast(rays);
  }

  look(look: Partial<Look>): void {
    this.#stage.setLook({ ...kDefaultLook, ...look });
  }

  setView(wanted: Viewpoint): void {
    const inside = (v: number): number => Math.min(Math.max(v, -kFarthest), kFarthest);
    const [x, y, z] = wanted.position;
    const view = { ...wanted, position: [inside(x), inside(y), inside(z)] as const };
    this.view = view;
    this.#controls.view = view;
    this.#stage.setCamera(cameraOf(view));
    this.#isLinkDue = true;
  }

  setTime(wantedMs: number): void {
    const timeMs = Math.min(Math.max(wantedMs, 0), kLatestMs);
    this.timeMs = timeMs;
    this.#stage.setTime(timeMs);
    this.#isLinkDue = true;
    showTime(timeMs);
    const { altitudeDeg, azimuthDeg } = this.#stage.sun;
    setText(
      byId('sun', HTMLParagraphElement),
      say('sun', altitudeDeg.toFixed(1), azimuthDeg.toFixed(0)),
    );
  }

  start(): void {
    setText(byId('title', HTMLHeadingElement), this.#place.title);
    document.title = `${this.#place.title} · Terravox`;
    const credit = [this.#place.attribution, this.#place.licence].filter((part) => part !== '');
    setText(byId('attribution', HTMLParagraphElement), credit.join(' · '));
    setText(this.#status, say('loading'));
    this.#fillPanel();
    new ResizeObserver(() => this.#resize()).observe(this.#canvas);
    this.#resize();
    this.setTime(this.timeMs);
    window.addEventListener('hashchange', () => this.#followLink());
    requestAnimationFrame((nowMs) => this.#frame(nowMs));
  }

  #frame(nowMs: number): void {
    this.#controls.frame(nowMs);
    this.#stage.frame(nowMs);
    if (this.#isLinkDue && nowMs - this.#linkedMs > kLinkMs) {
      this.#isLinkDue = false;
      this.#linkedMs = nowMs;
      history.replaceState(null, '', toLink({ view: this.view, timeMs: this.timeMs }));
    }
    requestAnimationFrame((next) => this.#frame(next));
  }

  #resize(): void {
    const ratio = Math.min(window.devicePixelRatio, kMaxPixelRatio);
    const width = Math.max(1, Math.round(this.#canvas.clientWidth * ratio));
    const height = Math.max(1, Math.round(this.#canvas.clientHeight * ratio));
    if (this.#canvas.width !== width || this.#canvas.height !== height) {
      this.#canvas.width = width;
      this.#canvas.height = height;
    }
    this.setView(this.view);
  }

  #opened({ world }: Facts): void {
    this.#projection = new WorldProjection(world);
    this.setTime(this.timeMs);
  }

  #followLink(): void {
    const state = fromLink(location.hash, { view: this.view, timeMs: this.timeMs });
    this.setView(state.view);
    this.setTime(state.timeMs);
  }

  #pickAt(x: number, y: number): Pick | undefined {
    const box = this.#canvas.getBoundingClientRect();
    const ratio = this.#canvas.width / Math.max(1, box.width);
    return this.#stage.pick(Math.floor((x - box.left) * ratio), Math.floor((y - box.top) * ratio));
  }

  #showPick(pick: Pick | undefined): void {
    const section = byId('place', HTMLElement);
    section.hidden = pick === undefined;
    if (pick === undefined || this.#projection === undefined) return;
    const { world } = this.#projection;
    const units = world.unitsPerVoxel;
    const [easting, northing] = [pick.point[0] * units, -pick.point[2] * units];
    const degrees = this.#projection.toLatLon(easting, northing);
    const colour = pick.colour;
    setFacts(byId('facts', HTMLDListElement), [
      [say('easting'), easting.toFixed(1)],
      [say('northing'), northing.toFixed(1)],
      [say('height'), `${(pick.point[1] * world.voxelM).toFixed(1)} m`],
      [say('latitude'), degrees === undefined ? '' : formatLatLon(degrees.latDeg, degrees.lonDeg)],
      [say('material'), this.#appearance.materials[pick.material]?.name ?? ''],
      [say('colour'), colour === undefined ? '' : `rgb(${colour.join(', ')})`],
      [say('level'), `${(2 ** pick.level * world.voxelM).toFixed(2)} m`],
      [say('inSun'), say(pick.isInSun ? 'yes' : 'no')],
    ]);
  }

  #showTrouble(failure: Failure): void {
    this.#trouble = failure.message;
    this.#status.classList.add('trouble');
    setText(this.#status, failure.message);
  }

  #showProgress(): void {
    const { waiting } = this.#stage;
    // What failed has been read by now, unless the place cannot be read any more.
    if (this.#trouble !== '' && (waiting > 0 || this.#hasEnded)) return;
    this.#trouble = '';
    this.#status.classList.remove('trouble');
    setText(this.#status, waiting > 0 ? say('refining', String(waiting)) : '');
  }

  #fillPanel(): void {
    for (const target of document.querySelectorAll<HTMLElement>('[data-text]'))
      setText(target, say(target.dataset['text'] as TextKey));
    document.documentElement.lang = language;
    const views = byId('views', HTMLSelectElement);
    views.replaceChildren(
      ...this.#place.views.map((view, i) => element('option', { value: String(i) }, view.name)),
    );
    views.addEventListener('change', () => {
      const named = this.#place.views[Number(views.value)];
      if (named !== undefined) this.setView(viewpointOf(named));
    });
    const date = byId('date', HTMLInputElement);
    const time = byId('time', HTMLInputElement);
    const changed = (): void => {
      const day = date.valueAsNumber;
      if (Number.isFinite(day)) this.setTime(day + time.valueAsNumber * kMinuteMs);
    };
    date.addEventListener('input', changed);
    time.addEventListener('input', changed);
    const looks = ['shadows', 'textures', 'material-colours'] as const;
    for (const id of looks)
      byId(id, HTMLInputElement).addEventListener('input', () => this.#setLook());
    byId('save', HTMLButtonElement).addEventListener('click', () => this.#save());
    byId('link', HTMLButtonElement).addEventListener('click', () => void this.#copyLink());
    byId('close', HTMLButtonElement).addEventListener('click', () => this.#showPick(undefined));
    const search = byId('search-text', HTMLInputElement);
    search.placeholder = say('goToHint');
    byId('search', HTMLFormElement).addEventListener('submit', (event) => {
      event.preventDefault();
      this.#goTo(search.value);
    });
  }

  #setLook(): void {
    const isOn = (id: string): boolean => byId(id, HTMLInputElement).checked;
    this.#stage.setLook({
      ...kDefaultLook,
      shadows: isOn('shadows'),
      textures: isOn('textures'),
      colourMix: isOn('material-colours') ? 0 : kDefaultLook.colourMix,
    });
  }

  #goTo(words: string): void {
    const projection = this.#projection;
    if (projection === undefined) return;
    const found = parsePlace(words, projection);
    const error = byId('search-error', HTMLSpanElement);
    setText(error, typeof found === 'string' ? found : '');
    if (typeof found === 'string') return;
    const [x, z] = projection.toVoxel(found.easting, found.northing);
    const { min, max } = projection.world;
    const middle = (min[1] + max[1]) / 2;
    const away = Math.max(60, max[1] - min[1]);
    const from: Vec3 = [x, middle + away, z + away];
    this.setView(lookingAt({ ...this.view, position: from }, [x, middle, z]));
  }

  #save(): void {
    this.#canvas.toBlob((blob) => {
      if (blob === null) return;
      const link = element('a', { download: 'terravox.png' });
      link.href = URL.createObjectURL(blob);
      link.click();
      URL.revokeObjectURL(link.href);
    });
  }

  async #copyLink(): Promise<void> {
    const address = new URL(toLink({ view: this.view, timeMs: this.timeMs }), location.href).href;
    if (!(await copy(address))) return;
    setText(byId('link', HTMLButtonElement), say('linkCopied'));
    setTimeout(() => setText(byId('link', HTMLButtonElement), say('link')), 2000);
  }
}

function showTime(timeMs: number): void {
  const date = byId('date', HTMLInputElement);
  const time = byId('time', HTMLInputElement);
  const day = Math.floor(timeMs / kDayMs) * kDayMs;
  date.valueAsNumber = day;
  time.valueAsNumber = Math.round((timeMs - day) / kMinuteMs);
  const clock = new Date(timeMs).toISOString().slice(11, 16);
  setText(byId('clock', HTMLOutputElement), `${clock} ${say('utc')}`);
}

function viewpointOf(named: NamedView): Viewpoint {
  const at = { position: named.position, headingDeg: 0, pitchDeg: 0, fovDeg: named.fovDeg };
  return lookingAt(at, named.target);
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

async function load(name: string): Promise<Response> {
  const response = await fetchWithToken(new URL(name, document.baseURI), say);
  if (!response.ok)
    throw new Error(`read ${name}: the host answers ${response.status}; is the site complete?`);
  return response;
}

async function start(): Promise<Viewer> {
  const [file, appearance] = await Promise.all([load('place.json'), load('appearance.bin')]);
  const place = readPlaceFile(await file.json());
  const viewer = new Viewer(place, readAppearance(await unpackAppearance(appearance.body!)));
  viewer.start();
  if ('server' in place.archive)
    watchServer(new URL(place.archive.server, document.baseURI).href, say, viewer);
  return viewer;
}

const started = start();
window.terravox = {
  ready: started.then((viewer) => viewer.ready),
  stats: () => viewer().stats(),
  firstHits: () => viewer().firstHits(),
  cast: (rays) => viewer().cast(rays),
  setLook: (look) => viewer().look(look),
};
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
