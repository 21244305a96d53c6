/**
 * A place on a canvas: asks the worker for the boxes that the camera needs, keeps them in the
 * pools, traces and shows the picture. Knows nothing of controls.
 */
import type { Vec2 } from '../vec3.js';
import type { Failure } from '../http/errors.js';
import type { Facts } from './data/facts.js';
import type { TransferStats } from '../http/http.js';
import type { FromWorker, Place, ToWorker } from './data/protocol.js';
import type { Appearance } from './draw/appearance.js';
import { makeColumnTable } from './draw/column-table.js';
import { checkLook, type Camera } from './draw/look.js';
import {
  kDefaultLook,
  Renderer,
  type CastRay,
  type FirstHits,
  type Look,
} from './draw/renderer.js';
import { adaptationEv, skyLight } from './draw/sky-light.js';
import { kNowhere, sunPosition, type SunPosition } from './draw/sun-position.js';
import { Pace, Passes } from './passes.js';
import { Supply } from './supply.js';
import { cameraAtPixel, makePick, type Pick } from './pick.js';

export type { Pick } from './pick.js';
export type { CastRay } from './draw/renderer.js';

export type StageEvents = {
  readonly onOpened: (facts: Facts) => void;
  /** Something that a person should know; the stage goes on without it. */
  readonly onFailure: (failure: Failure) => void;
  /** The world cannot be read any more. */
  readonly onEnded: (failure: Failure) => void;
  /** After each frame that was shown. */
  readonly onFrame: () => void;
};

export type StageStats = {
  readonly requests: number;
  readonly bytes: number;
  readonly columns: number;
  readonly waiting: number;
  readonly poolBytes: number;
  /** [0, 1]. */
  readonly poolFill: number;
  readonly samples: number;
  readonly size: Vec2;
  /** Of the last whole pass. */
  readonly passMs: number;
  readonly frames: number;
  readonly isComplete: boolean;
  readonly detail: number;
  /** Of the first whole picture, once that stands. */
  readonly first: FirstPicture | undefined;
};

export type FirstPicture = {
  /** Since the page was opened. */
  readonly ms: number;
  /** Of boxes; the page's own files come on top. */
  readonly requests: number;
  readonly bytes: number;
};

const kSettledMs = 250; // without movement: the picture counts as still
const kNoWorker = 'start viewer/worker.js: it cannot be loaded; is the site complete?';
const kAdaptation = 0.75;
// Of a still picture. More of them change nothing that is seen, and would keep the processor, and a
// battery, at work for as long as the page is open.
const kEnoughSamples = 256;
// Of what is read back: nothing is left to chance.
const kExact = { cutOuts: false, softSun: false } as const;
// Low-discrepancy places in a pixel. Ref: Roberts, "The unreasonable effectiveness of quasirandom
// sequences", 2018.
const kJitter = [0.7548776662466927, 0.5698402909980532] as const;

export class Stage {
  readonly #gl: WebGL2RenderingContext;
  readonly #canvas: HTMLCanvasElement;
  readonly #poolBytes: number;
  readonly #worker: Worker;
  readonly #appearance: Appearance;
  readonly #events: StageEvents;
  #supply: Supply;
  #passes: Passes;
  readonly #pace = new Pace();
  #renderer: Renderer | undefined;
  #facts: Facts | undefined;
  #camera: Camera | undefined;
  #look: Look = kDefaultLook;
  #timeMs = 0;
  #movedMs = -Infinity;
  #readyMs: number | undefined;
  #first: FirstPicture | undefined;
  #hasEnded = false;
  #workerStats: TransferStats | undefined;
  #resolveReady: () => void = () => {};
  #rejectReady: (reason: Error) => void = () => {};
  /** Resolves with the first whole picture; rejects when the world cannot be read. */
  readonly ready = new Promise<void>((resolve, reject) => {
    this.#resolveReady = resolve;
    this.#rejectReady = reject;
  });

  /** @throws Error when the browser lacks what is needed */
  constructor(
    canvas: HTMLCanvasElement,
    worker: Worker,
    place: Place,
    appearance: Appearance,
    poolBytes: number,
    events: StageEvents,
  ) {
    const gl = canvas.getContext('webgl2', {
      alpha: false,
      antialias: false,
      depth: false,
      powerPreference: 'high-performance',
      preserveDrawingBuffer: true,
    });
    if (gl === null) throw new Error('draw the place: this browser has no WebGL 2');
    this.#gl = gl;
    this.#canvas = canvas;
    this.#poolBytes = poolBytes;
    this.#worker = worker;
    this.#appearance = appearance;
    this.#events = events;
    this.#supply = new Supply(gl, poolBytes);
    this.#passes = new Passes(gl, this.#pace);
    // Without this the browser never gives the context back.
    canvas.addEventListener('webglcontextlost', (event) => event.preventDefault());
    canvas.addEventListener('webglcontextrestored', () => this.#guarded(() => this.#rebuild()));
    worker.onmessage = (event: MessageEvent<FromWorker>) =>
      this.#guarded(() => this.#receive(event.data));
    worker.onerror = (event) => this.#end({ kind: 'missing', message: event.message ?? kNoWorker });
    // Whoever waits for it sees the reason; others have seen the message.
    this.ready.catch(() => {});
    this.#send({ type: 'open', place });
  }

  // What goes wrong in a handler of events would be lost.
  #guarded(handle: () => void): void {
    try {
      handle();
    } catch (error) {
      const message = error instanceof Error ? error.message : String(error);
      this.#end({ kind: 'damaged', message });
    }
  }

  // All that lay on the graphics processor is gone: boxes are asked for again.
  #rebuild(): void {
    this.#supply = new Supply(this.#gl, this.#poolBytes);
    this.#passes = new Passes(this.#gl, this.#pace);
    if (this.#facts === undefined) return;
    this.#makeRenderer(this.#facts);
    this.#restart();
  }

  #makeRenderer({ world }: Facts): void {
    const { voxelM, levels } = world;
    this.#renderer = new Renderer(this.#gl, this.#supply.pools, this.#appearance, voxelM, levels);
    this.#lightUp();
  }

  get facts(): Facts | undefined {
    return this.#facts;
  }

  /** Columns that the picture still lacks. */
  get waiting(): number {
    return this.#supply.plan?.wanted.length ?? 0;
  }

  get sun(): SunPosition {
    return sunPosition(this.#timeMs, this.#facts?.world.centre ?? kNowhere);
  }

  setCamera(camera: Camera): void {
    this.#camera = camera;
    this.#moved();
    this.#supply.changed();
  }

  /** @throws Error for numbers that no picture can be drawn with */
  setLook(look: Look): void {
    checkLook(look);
    // Around an observer there is detail, too.
    if (look.observer !== this.#look.observer) this.#supply.changed();
    this.#look = { ...look, exposureEv: this.#look.exposureEv };
    this.#restart();
  }

  /** @param timeMs UTC, milliseconds since 1970 */
  setTime(timeMs: number): void {
    if (timeMs === this.#timeMs) return;
    this.#timeMs = timeMs;
    this.#lightUp();
    this.#moved();
  }

  /** One turn of the page's loop. */
  frame(nowMs: number): void {
    const [renderer, camera] = [this.#renderer, this.#camera];
    if (this.#gl.isContextLost()) return;
    const hasEnded = this.#passes.poll(nowMs);
    if (renderer === undefined || camera === undefined || hasEnded === undefined) return;
    if (hasEnded) this.#finish();
    this.#replan(renderer, camera, nowMs);
    const { plan, isComplete } = this.#supply;
    if (plan === undefined) return;
    const isBare = plan.shown.length === 0;
    // Until the first column is there, one picture of the sky is enough.
    if (isBare && renderer.samples > 0) return;
    const isMoving = nowMs - this.#movedMs < kSettledMs;
    const isEnough = renderer.samples >= kEnoughSamples && isComplete;
    if (isEnough && this.#passes.isWhole(isMoving)) return;
    const band = this.#passes.next(nowMs, this.#size, isMoving);
    if (band.y === 0) renderer.resize(band.size);
    const n = renderer.samples;
    renderer.trace(camera, this.#look, [frac(n, kJitter[0]), frac(n, kJitter[1])], band);
    if (this.#passes.given(band, isBare)) renderer.show(this.#look);
    this.#passes.mark(nowMs);
  }

  get #size(): Vec2 {
    return [this.#canvas.width, this.#canvas.height];
  }

  /** What is seen at a place of the canvas, in its pixels; undefined: sky. */
  pick(x: number, y: number): Pick | undefined {
    const renderer = this.#renderer;
    const camera = this.#camera;
    if (renderer === undefined || camera === undefined || !this.#canRead()) return undefined;
    const [width, height] = this.#size;
    const view = cameraAtPixel(camera, width, height, x, y);
    const hits = renderer.firstHits(view, this.#look, [1, 1]);
    return makePick(hits, 0, camera.position, view.forward, this.#look);
  }

  /**
   * Follows rays to their first hits, at the detail that is loaded: through nothing that is solid,
   * be it water, glass or leaves, and as if there were no section. A ray that starts inside of a
   * voxel meets it at once; in water or glass it goes on to where that ends. The picture goes on
   * undisturbed.
   * @param rays 0 to 4096
   * @return the hit of each ray; undefined: none within its length, or there is no picture yet
   * @throws Error for more rays
   */
  cast(rays: readonly CastRay[]): readonly (Pick | undefined)[] {
    const camera = this.#camera;
    if (this.#renderer === undefined || camera === undefined || !this.#canRead()) {
      return rays.map(() => undefined);
    }
    const look = { ...this.#look, ...kExact, section: undefined };
    const hits = this.#renderer.cast(rays, camera, look);
    return rays.map((ray, i) => makePick(hits, i, ray.origin, ray.direction, look));
  }

  /**
   * What each pixel of the canvas shows, with leaves without holes and the sun as a point: nothing
   * is left to chance. Undefined before there is a picture.
   */
  firstHits(): (FirstHits & { readonly size: Vec2 }) | undefined {
    const size = this.#size;
    if (this.#renderer === undefined || this.#camera === undefined || !this.#canRead()) {
      return undefined;
    }
    const look = { ...this.#look, ...kExact };
    return { ...this.#renderer.firstHits(this.#camera, look, size), size };
  }

  stats(): StageStats {
    this.#send({ type: 'stats' });
    return {
      requests: this.#workerStats?.requests ?? 0,
      bytes: this.#workerStats?.bytes ?? 0,
      columns: this.#supply.size,
      waiting: this.waiting,
      poolBytes: this.#supply.pools.bytes,
      poolFill: this.#supply.pools.fill,
      samples: this.#renderer?.samples ?? 0,
      size: this.#size,
      passMs: this.#passes.state.passMs,
      frames: this.#passes.state.count,
      isComplete: this.#supply.isComplete,
      detail: this.#supply.detail,
      first: this.#first,
    };
  }

  #canRead(): boolean {
    return this.#supply.plan !== undefined && !this.#gl.isContextLost();
  }

  #moved(): void {
    this.#movedMs = performance.now();
    this.#restart();
  }

  #restart(): void {
    this.#renderer?.restart();
    this.#passes.restart();
  }

  #finish(): void {
    if (this.#supply.isPlanned) {
      this.#beReady();
      this.#supply.advance(this.#passes.state.isSharp);
    }
    this.#events.onFrame();
  }

  #beReady(): void {
    if (this.#readyMs !== undefined) return;
    this.#readyMs = performance.now();
    this.#resolveReady();
    // The reply comes before requests for the next detail are counted.
    this.#send({ type: 'stats' });
  }

  #lightUp(): void {
    if (this.#renderer === undefined) return;
    const light = skyLight(this.#appearance, this.sun);
    this.#renderer.setLight(light);
    this.#look = { ...this.#look, exposureEv: adaptationEv(light, kAdaptation) };
  }

  #replan(renderer: Renderer, camera: Camera, nowMs: number): void {
    const view = { camera, observer: this.#look.observer, size: this.#size };
    const made = this.#supply.replan(this.#facts!.world, view, nowMs);
    if (made === undefined) return;
    if (made.isOther) {
      renderer.setColumns(makeColumnTable(made.plan.shown), made.cut.entry, made.cut.coarsest);
      this.#restart();
    }
    const columns = this.#supply.wanted(nowMs);
    this.#send({ type: 'want', columns });
  }

  #receive(message: FromWorker): void {
    switch (message.type) {
      case 'opened':
        this.#facts = message.facts;
        this.#makeRenderer(message.facts);
        this.#events.onOpened(message.facts);
        return;
      case 'column': {
        // The column itself would keep its arrays in memory for as long as it is in the pools.
        const { level, bx, bz, byBegin, boxes } = message.column;
        const key = { level, bx, bz };
        this.#supply.store(key, { byBegin, boxes }, this.#facts!.world);
        this.#send({ type: 'taken', bytes: message.bytes });
        return;
      }
      case 'failed':
        this.#supply.fail(message.column, this.#facts!.world);
        this.#events.onFailure(message.failure);
        return;
      case 'ended':
        this.#end(message.failure);
        return;
      case 'stats':
        this.#workerStats = message.stats;
        if (this.#readyMs !== undefined) {
          this.#first ??= {
            ms: this.#readyMs,
            requests: message.stats.requests,
            bytes: message.stats.bytes,
          };
        }
        return;
    }
  }

  #end(failure: Failure): void {
    this.#hasEnded = true;
    this.#rejectReady(new Error(failure.message));
    this.#events.onEnded(failure);
  }

  #send(message: ToWorker): void {
    if (!this.#hasEnded) this.#worker.postMessage(message);
  }
}

const frac = (n: number, by: number): number => (n * by + 0.5) % 1;
