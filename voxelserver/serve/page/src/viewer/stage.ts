/**
 * A place on a canvas: asks the worker for the boxes that the camera needs, keeps them in the
 * pools, traces and shows the picture. Knows nothing of controls.
 */
import type {
  ColumnKey,
  Facts,
  Failure,
  FromWorker,
  Place,
  Stats,
  ToWorker,
} from './data/protocol.js';
import type { Appearance } from './draw/appearance.js';
import { pixelRad, type Camera } from './draw/camera.js';
import { DrawClock } from './draw/clock.js';
import { makeColumnTable } from './draw/column-table.js';
import { LevelCut } from './draw/level-cut.js';
import { Pace } from './draw/pace.js';
import { checkLook } from './draw/look.js';
import {
  kDefaultLook,
  Renderer,
  type CastRay,
  type FirstHits,
  type Look,
} from './draw/renderer.js';
import { Residency, type Plan } from './draw/residency.js';
import { adaptationEv, skyLight } from './draw/sky-light.js';
import { kNowhere, sunPosition, type SunPosition } from './draw/sun-position.js';
import { TexturePools, type BoxData, type ColumnData } from './draw/texture-pools.js';
import { ViewCut } from './view-cut.js';
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
  readonly size: readonly [number, number];
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

// Pixels that a voxel may cover: coarse first, so that the whole picture stands early.
const kDetails = [8, 4, 2, 1] as const;
const kSettledMs = 250; // without movement: the picture counts as still
const kPlanMs = 200; // between two plans while columns come in
const kRetryMs = 5000; // a column that failed is not asked for again before
const kMaxFailures = 2;
const kNoWorker = 'start viewer/worker.js: it cannot be loaded; is the site complete?';
const kAdaptation = 0.75;
// Of a still picture. More of them change nothing that is seen, and would keep the processor, and a
// battery, at work for as long as the page is open.
const kEnoughSamples = 256;
// Pools that are too small: steps of coarseness, each of which saves about half of the boxes, and
// how full they may be for a step back.
const kCoarser = 1.4;
const kRoomy = 0.4;
const kMaxCoarser = 64;
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
  #pools: TexturePools;
  #residency: Residency;
  #clock: DrawClock;
  readonly #pace = new Pace();
  /** When a column could not be read, and how often in a row. */
  readonly #failures = new Map<string, { atMs: number; count: number }>();
  #renderer: Renderer | undefined;
  #facts: Facts | undefined;
  #camera: Camera | undefined;
  #look: Look = kDefaultLook;
  #timeMs = 0;
  #plan: Plan | undefined;
  #cut: LevelCut | undefined;
  #stage = 0;
  /** Above 1 where the pools are too small for the view: voxels may cover more pixels then. */
  #coarser = 1;
  /** A column did not fit since the last plan. */
  #isFull = false;
  #isPlanDue = true;
  #plannedMs = 0;
  #movedMs = -Infinity;
  #generation = 0;
  #bandY = 0;
  #hasCoarse = false;
  /** Whether the newest pass is at the full size. */
  #isSharp = false;
  #readyMs: number | undefined;
  #first: FirstPicture | undefined;
  #pixelsGiven = 0;
  #passStartedMs = 0;
  #passMs = 0;
  #frames = 0;
  #hasEnded = false;
  #workerStats: Stats | undefined;
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
    this.#pools = new TexturePools(gl, { bytes: poolBytes });
    this.#residency = new Residency(this.#pools);
    this.#clock = new DrawClock(gl);
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
    this.#pools = new TexturePools(this.#gl, { bytes: this.#poolBytes });
    this.#residency = new Residency(this.#pools);
    this.#clock = new DrawClock(this.#gl);
    this.#plan = undefined;
    this.#cut = undefined;
    this.#stage = 0;
    this.#isPlanDue = true;
    if (this.#facts === undefined) return;
    this.#makeRenderer(this.#facts);
    this.#restart();
  }

  #makeRenderer({ world }: Facts): void {
    const { voxelM, levels } = world;
    this.#renderer = new Renderer(this.#gl, this.#pools, this.#appearance, voxelM, levels);
    this.#lightUp();
  }

  get facts(): Facts | undefined {
    return this.#facts;
  }

  /** Columns that the picture still lacks. */
  get waiting(): number {
    return this.#plan?.wanted.length ?? 0;
  }

  get sun(): SunPosition {
    return sunPosition(this.#timeMs, this.#facts?.world.centre ?? kNowhere);
  }

  setCamera(camera: Camera): void {
    this.#camera = camera;
    this.#moved();
    this.#isPlanDue = true;
  }

  /** @throws Error for numbers that no picture can be drawn with */
  setLook(look: Look): void {
    checkLook(look);
    // Around an observer there is detail, too.
    if (look.observer !== this.#look.observer) this.#isPlanDue = true;
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
    const renderer = this.#renderer;
    if (this.#gl.isContextLost()) return;
    const ms = this.#clock.finished(nowMs);
    if (renderer === undefined || this.#camera === undefined || ms === undefined) return;
    if (ms > 0) this.#finish(nowMs, ms);
    if (this.#isPlanDue && nowMs - this.#plannedMs >= (this.#plan === undefined ? 0 : kPlanMs)) {
      this.#replan(nowMs);
    }
    if (this.#plan === undefined) return;
    const isBare = this.#plan.shown.length === 0;
    // Until the first column is there, one picture of the sky is enough.
    if (isBare && renderer.samples > 0) return;
    const full: readonly [number, number] = [this.#canvas.width, this.#canvas.height];
    const isMoving = nowMs - this.#movedMs < kSettledMs;
    // After each change a coarse picture first, so that something stands at once.
    const isCoarse = isMoving || !this.#hasCoarse;
    const isWhole = !isCoarse && this.#isSharp && this.#bandY === 0;
    if (isWhole && renderer.samples >= kEnoughSamples && this.#isComplete) return;
    const size = isCoarse ? this.#pace.movingSize(full) : full;
    if (this.#bandY === 0 || isCoarse) {
      renderer.resize(size);
      this.#bandY = 0;
      this.#passStartedMs = nowMs;
    }
    const rows = isCoarse ? size[1] : Math.min(this.#pace.bandRows(size[0]), size[1] - this.#bandY);
    const n = renderer.samples;
    const jitter = [frac(n, kJitter[0]), frac(n, kJitter[1])] as const;
    renderer.trace(this.#camera, this.#look, jitter, { y: this.#bandY, height: rows });
    this.#hasCoarse = true;
    this.#isSharp = !isCoarse;
    // The sky alone says nothing of how long pixels take.
    this.#pixelsGiven = isBare ? 0 : rows * size[0];
    this.#bandY += rows;
    if (this.#bandY >= size[1]) {
      this.#bandY = 0;
      renderer.show(this.#look);
    }
    this.#clock.mark(nowMs);
  }

  /** What is seen at a place of the canvas, in its pixels; undefined: sky. */
  pick(x: number, y: number): Pick | undefined {
    const renderer = this.#renderer;
    const camera = this.#camera;
    if (renderer === undefined || camera === undefined || !this.#canRead()) return undefined;
    const [width, height] = [this.#canvas.width, this.#canvas.height];
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
  firstHits(): (FirstHits & { readonly size: readonly [number, number] }) | undefined {
    const { width, height } = this.#canvas;
    if (this.#renderer === undefined || this.#camera === undefined || !this.#canRead()) {
      return undefined;
    }
    const look = { ...this.#look, ...kExact };
    return {
      ...this.#renderer.firstHits(this.#camera, look, [width, height]),
      size: [width, height],
    };
  }

  stats(): StageStats {
    this.#send({ type: 'stats' });
    return {
      requests: this.#workerStats?.requests ?? 0,
      bytes: this.#workerStats?.bytes ?? 0,
      columns: this.#residency.size,
      waiting: this.waiting,
      poolBytes: this.#pools.bytes,
      poolFill: this.#pools.fill,
      samples: this.#renderer?.samples ?? 0,
      size: [this.#canvas.width, this.#canvas.height],
      passMs: this.#passMs,
      frames: this.#frames,
      isComplete: this.#isComplete,
      detail: kDetails[this.#stage]! * this.#coarser,
      first: this.#first,
    };
  }

  // Not where the plan is that of the detail before.
  get #isComplete(): boolean {
    return (
      this.#plan?.isComplete === true && !this.#isPlanDue && this.#stage === kDetails.length - 1
    );
  }

  #canRead(): boolean {
    return this.#plan !== undefined && !this.#gl.isContextLost();
  }

  #moved(): void {
    this.#movedMs = performance.now();
    this.#restart();
  }

  #restart(): void {
    this.#renderer?.restart();
    this.#hasCoarse = false;
    this.#bandY = 0;
  }

  #finish(nowMs: number, ms: number): void {
    if (this.#pixelsGiven > 0) this.#pace.learn(this.#pixelsGiven, ms);
    if (this.#bandY !== 0) return;
    this.#passMs = nowMs - this.#passStartedMs;
    ++this.#frames;
    if (this.#plan?.isComplete === true && !this.#isPlanDue) {
      this.#beReady();
      this.#refineIfRoomy();
      // The first picture is shown sharp before requests for the next one compete with its passes.
      const isShown = this.#stage > 0 || this.#isSharp;
      if (isShown && this.#stage < kDetails.length - 1) {
        ++this.#stage;
        this.#isPlanDue = true;
      }
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

  // A step back from coarse voxels where the pools have room once more.
  #refineIfRoomy(): void {
    if (this.#coarser === 1) return;
    while (this.#residency.dropOldest());
    if (this.#pools.fill >= kRoomy) return;
    this.#coarser = Math.max(1, this.#coarser / kCoarser);
    this.#isPlanDue = true;
  }

  #lightUp(): void {
    if (this.#renderer === undefined) return;
    const light = skyLight(this.#appearance, this.sun);
    this.#renderer.setLight(light);
    this.#look = { ...this.#look, exposureEv: adaptationEv(light, kAdaptation) };
  }

  #replan(nowMs: number): void {
    const facts = this.#facts!.world;
    const camera = this.#camera!;
    if (this.#isFull) this.#coarser = Math.min(kMaxCoarser, this.#coarser * kCoarser);
    this.#isFull = false;
    const height = this.#canvas.height;
    const view = {
      eye: camera.position,
      observer: this.#look.observer,
      pixelRad: pixelRad(camera, height),
      detail: kDetails[this.#stage]! * this.#coarser,
    };
    const aspect = this.#canvas.width / height;
    const viewCut = new ViewCut(facts, view, facts.levels - 1, camera, aspect);
    // The last picture is exactly the ray tracer's; the ones before spend nothing on what is out of
    // view.
    const isLast = this.#stage === kDetails.length - 1;
    const cut = isLast ? new LevelCut(facts, view, facts.levels - 1) : viewCut;
    const plan = this.#residency.plan(cut, ({ level, bx, bz }) => viewCut.isInView(level, bx, bz));
    this.#plannedMs = nowMs;
    this.#isPlanDue = false;
    if (this.#cut === undefined || !isSameShown(this.#plan, plan)) {
      this.#renderer!.setColumns(makeColumnTable(plan.shown), cut.entry, cut.coarsest);
      this.#restart();
    }
    this.#cut = cut;
    this.#plan = plan;
    const columns = plan.wanted.filter(
      (key) => !(nowMs - (this.#failures.get(toName(key))?.atMs ?? -Infinity) < kRetryMs),
    );
    this.#send({ type: 'want', generation: ++this.#generation, columns });
  }

  #receive(message: FromWorker): void {
    switch (message.type) {
      case 'opened':
        this.#facts = message.facts;
        this.#makeRenderer(message.facts);
        this.#events.onOpened(message.facts);
        return;
      case 'column': {
        const boxes = message.column.boxes.map((box): BoxData | 'air' | 'hole' =>
          box === 'air' ? 'air' : 'hole' in box ? 'hole' : box,
        );
        // The column itself would keep its arrays in memory for as long as it is in the pools.
        const { level, bx, bz, byBegin } = message.column;
        const key = { level, bx, bz };
        this.#failures.delete(toName(key));
        this.#store(key, { byBegin, boxes });
        this.#send({ type: 'taken', bytes: message.bytes });
        return;
      }
      case 'failed':
        this.#fail(message.column);
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

  // Tried again after a while; what fails again is a hole, as in the ray tracer's pictures, so that
  // all else goes on.
  #fail(key: ColumnKey): void {
    const name = toName(key);
    const count = (this.#failures.get(name)?.count ?? 0) + 1;
    this.#failures.set(name, { atMs: performance.now(), count });
    if (count >= kMaxFailures) this.#storeHole(key);
    else setTimeout(() => (this.#isPlanDue = true), kRetryMs);
  }

  #storeHole(key: ColumnKey): void {
    const { min, max } = this.#facts!.world;
    const high = 256 * 2 ** key.level;
    const byBegin = Math.floor(min[1] / high);
    const count = Math.ceil(max[1] / high) - byBegin;
    this.#store(key, { byBegin, boxes: Array.from({ length: count }, () => 'hole' as const) });
  }

  // Makes room where there is none by dropping what was used longest ago.
  #store(key: ColumnKey, data: ColumnData): void {
    // Asked for twice, when a list was on its way to the worker while the column came.
    if (this.#residency.has(key)) return;
    for (;;) {
      const column = this.#pools.store(data);
      if (column !== undefined) {
        this.#residency.add(key, column);
        this.#isPlanDue = true;
        return;
      }
      if (this.#residency.dropOldest()) continue;
      // Larger than all of the pools, or the picture cannot become coarser: a hole takes no room,
      // and is not asked for again.
      if (this.#residency.size === 0 || this.#coarser >= kMaxCoarser) {
        this.#storeHole(key);
        return;
      }
      // All that is there is part of the picture: the next plan makes it coarser.
      this.#isFull = true;
      this.#isPlanDue = true;
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
const toName = (key: ColumnKey): string => `${key.level}/${key.bx}/${key.bz}`;

function isSameShown(a: Plan | undefined, b: Plan): boolean {
  if (a === undefined || a.shown.length !== b.shown.length) return false;
  return a.shown.every((column, i) => {
    const other = b.shown[i]!;
    return (
      column.level === other.level &&
      column.bx === other.bx &&
      column.bz === other.bz &&
      column.boxes === other.boxes
    );
  });
}
