import type { Vec2, Vec3 } from '../vec3.js';
import { nameOfColumn, type ColumnKey } from './data/columns.js';
import { pixelRad, type Camera } from './draw/look.js';
import { LevelCut } from './draw/level-cut.js';
import { Residency, type Plan } from './draw/residency.js';
import { TexturePools, type ColumnData } from './draw/texture-pools.js';
import { ViewCut } from './view-cut.js';
import type { World } from '../replies.js';

// Pixels that a voxel may cover: coarse first, so that the whole picture stands early.
const kDetails = [8, 4, 2, 1] as const;
const kLastStep = kDetails.length - 1;
const kPlanMs = 200; // between two plans while columns come in
const kRetryMs = 5000; // a column that failed is not asked for again before
const kMaxFailures = 2;
// Pools that are too small: steps of coarseness, each of which saves about half of the boxes, and
// how full they may be for a step back.
const kCoarser = 1.4;
const kRoomy = 0.4;
const kMaxCoarser = 64;

/** What boxes are needed for. */
export type NeededView = {
  readonly camera: Camera;
  readonly observer: Vec3 | undefined;
  /** Pixels. */
  readonly size: Vec2;
};

export type NewPlan = {
  readonly cut: LevelCut;
  readonly plan: Plan;
  /** It shows other boxes than the plan before. */
  readonly isOther: boolean;
};

/** Which boxes are in the pools, which are wanted next, and how fine they are. Sends nothing. */
export class Supply {
  readonly pools: TexturePools;
  readonly #residency: Residency;
  /** When a column could not be read, and how often in a row. */
  readonly #failures = new Map<string, { readonly atMs: number; readonly count: number }>();
  #plan: Plan | undefined;
  #plannedMs = 0;
  /** The view, or what is in the pools, has changed since the plan was made. */
  #isDue = true;
  /** Of kDetails. */
  #step = 0;
  /** Above 1 where the pools are too small for the view: voxels may cover more pixels then. */
  #coarser = 1;
  /** A column did not fit since the last plan. */
  #isFull = false;

  constructor(gl: WebGL2RenderingContext, poolBytes: number) {
    this.pools = new TexturePools(gl, poolBytes);
    this.#residency = new Residency(this.pools);
  }

  get plan(): Plan | undefined {
    return this.#plan;
  }

  /** Columns in the pools. */
  get size(): number {
    return this.#residency.size;
  }

  /** Pixels that a voxel may cover. */
  get detail(): number {
    return kDetails[this.#step]! * this.#coarser;
  }

  /** Whether all that was planned is there. */
  get isPlanned(): boolean {
    return this.#plan?.isComplete === true && !this.#isDue;
  }

  /** The same at the last detail: not where the plan is that of the detail before. */
  get isComplete(): boolean {
    return this.isPlanned && this.#step === kLastStep;
  }

  changed(): void {
    this.#isDue = true;
  }

  /** @return undefined where none is due yet */
  replan(world: World, { camera, observer, size }: NeededView, nowMs: number): NewPlan | undefined {
    const waitMs = this.#plan === undefined ? 0 : kPlanMs;
    if (!this.#isDue || nowMs - this.#plannedMs < waitMs) return undefined;
    if (this.#isFull) this.#coarser = Math.min(kMaxCoarser, this.#coarser * kCoarser);
    this.#isFull = false;
    const [width, height] = size;
    const rad = pixelRad(camera, height);
    const view = { eye: camera.position, observer, pixelRad: rad, detail: this.detail };
    const viewCut = new ViewCut(world, view, world.levels - 1, camera, width / height);
    // The last picture is exactly the ray tracer's; the ones before spend nothing on what is out of
    // view.
    const cut = this.#step === kLastStep ? new LevelCut(world, view, world.levels - 1) : viewCut;
    const plan = this.#residency.plan(cut, ({ level, bx, bz }) => viewCut.isInView(level, bx, bz));
    const isOther = !isSameShown(this.#plan, plan);
    this.#plan = plan;
    this.#plannedMs = nowMs;
    this.#isDue = false;
    return { cut, plan, isOther };
  }

  /** What is to be asked for: without what has failed just now. */
  wanted(nowMs: number): readonly ColumnKey[] {
    const hasRested = (key: ColumnKey): boolean =>
      nowMs - (this.#failures.get(nameOfColumn(key))?.atMs ?? -Infinity) >= kRetryMs;
    return this.#plan?.wanted.filter(hasRested) ?? [];
  }

  /** The picture of all that was planned stands. @param isSharp at the full size */
  advance(isSharp: boolean): void {
    this.#refineIfRoomy();
    // The first picture is shown sharp before requests for the next one compete with its passes.
    if (this.#step === kLastStep || !(this.#step > 0 || isSharp)) return;
    this.#step += 1;
    this.#isDue = true;
  }

  // A step back from coarse voxels where the pools have room once more.
  #refineIfRoomy(): void {
    if (this.#coarser === 1) return;
    while (this.#residency.dropOldest());
    if (this.pools.fill >= kRoomy) return;
    this.#coarser = Math.max(1, this.#coarser / kCoarser);
    this.#isDue = true;
  }

  /**
   * Tried again after a while; what fails again is a hole, as in the ray tracer's pictures, so that
   * all else goes on.
   */
  fail(key: ColumnKey, world: World): void {
    const name = nameOfColumn(key);
    const count = (this.#failures.get(name)?.count ?? 0) + 1;
    this.#failures.set(name, { atMs: performance.now(), count });
    if (count >= kMaxFailures) this.#storeHole(key, world);
    else setTimeout(() => this.changed(), kRetryMs);
  }

  /** Makes room where there is none by dropping what was used longest ago. */
  store(key: ColumnKey, data: ColumnData, world: World): void {
    this.#failures.delete(nameOfColumn(key));
    // Asked for twice, when a list was on its way to the worker while the column came.
    if (this.#residency.has(key)) return;
    for (;;) {
      const column = this.pools.store(data);
      if (column !== undefined) {
        this.#residency.add(key, column);
        break;
      }
      if (this.#residency.dropOldest()) continue;
      // Larger than all of the pools, or the picture cannot become coarser: a hole takes no room,
      // and is not asked for again.
      if (this.size === 0 || this.#coarser >= kMaxCoarser) return this.#storeHole(key, world);
      // All that is there is part of the picture: the next plan makes it coarser.
      this.#isFull = true;
      break;
    }
    this.#isDue = true;
  }

  #storeHole(key: ColumnKey, world: World): void {
    if (this.#residency.has(key)) return;
    const high = 256 * 2 ** key.level;
    const byBegin = Math.floor(world.min[1] / high);
    const count = Math.ceil(world.max[1] / high) - byBegin;
    const boxes = Array.from({ length: count }, () => 'hole' as const);
    this.#residency.add(key, this.pools.store({ byBegin, boxes })!);
    this.#isDue = true;
  }
}

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
