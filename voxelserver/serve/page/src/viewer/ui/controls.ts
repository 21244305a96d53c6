/**
 * Mouse, keys, wheel, touch on the canvas, as movements of a viewpoint. Keys are read
 * by their place on the keyboard, so that WASD lies under the left hand everywhere.
 */
import { type Vec2, along, clamp, distance, dot, minus, scaled, type Vec3 } from '../../vec3.js';
import { fingersMoved, findMiddle, type Fingers } from './fingers.js';
import { computeForward, moved, orbited, turned, zoomed, type Viewpoint } from './navigation.js';

export type ControlsHost = {
  setView(view: Viewpoint): void;
  /** What is seen at a place of the window, CSS pixels; undefined: sky. */
  pointAt(x: number, y: number): Vec3 | undefined;
  /** A click or tap that moved nothing. */
  onClick(x: number, y: number): void;
};

const kClickPx = 5;
const kTurnDegPerPx = 0.15;
const kKeyTurnDegPerS = 60;
const kSlow = 0.2;
const kFast = 5;
const kWheelZoom = 0.0015;
const kMinSpeed = 4; // level-0 voxels a second
const kMaxSpeed = 5000;
const kFirstSpeed = 60;
const kSpeedShare = 0.4; // of the distance ahead, each second
const kLongestStepS = 0.1;

const kMoves: Readonly<Record<string, Vec3>> = {
  KeyW: [0, 0, 1],
  KeyS: [0, 0, -1],
  KeyA: [-1, 0, 0],
  KeyD: [1, 0, 0],
  KeyE: [0, 1, 0],
  KeyQ: [0, -1, 0],
  PageUp: [0, 1, 0],
  PageDown: [0, -1, 0],
};
const kTurns: Readonly<Record<string, Vec2>> = {
  ArrowLeft: [-1, 0],
  ArrowRight: [1, 0],
  ArrowUp: [0, 1],
  ArrowDown: [0, -1],
};

type Pointer = { x: number; y: number };

export class Controls {
  readonly #host: ControlsHost;
  /** What movements begin with; set by the host after each change. */
  view: Viewpoint;
  readonly #canvas: HTMLCanvasElement;
  readonly #keys = new Set<string>();
  readonly #pointers = new Map<number, Pointer>();
  /** Level-0 voxels a second at which keys move. */
  speed = kFirstSpeed;
  #travelledPx = 0;
  #orbitCentre: Vec3 | undefined;
  #betweenFingers: Vec3 | undefined;
  #lastMs = 0;

  /** @param isEnabled whether people can move the picture; clicks count always */
  constructor(canvas: HTMLCanvasElement, view: Viewpoint, host: ControlsHost, isEnabled = true) {
    this.view = view;
    this.#canvas = canvas;
    this.#host = host;
    canvas.addEventListener('keydown', (event) => {
      if (event.key === 'Enter') this.#clickMiddle();
    });
    if (!isEnabled) {
      canvas.addEventListener('click', (event) => host.onClick(event.clientX, event.clientY));
      return;
    }
    canvas.addEventListener('keydown', (event) => this.#keyDown(event));
    canvas.addEventListener('keyup', (event) => this.#keys.delete(event.code));
    canvas.addEventListener('blur', () => this.#keys.clear());
    canvas.addEventListener('pointerdown', (event) => this.#pointerDown(event));
    canvas.addEventListener('pointermove', (event) => this.#pointerMove(event));
    canvas.addEventListener('pointerup', (event) => this.#pointerUp(event));
    canvas.addEventListener('pointercancel', (event) => this.#pointers.delete(event.pointerId));
    canvas.addEventListener('wheel', (event) => this.#wheel(event), { passive: false });
    canvas.addEventListener('contextmenu', (event) => event.preventDefault());
  }

  /** One turn of the page's loop: moves as long as keys are held. */
  frame(nowMs: number): void {
    const seconds = Math.min((nowMs - this.#lastMs) / 1000, kLongestStepS);
    this.#lastMs = nowMs;
    if (this.#keys.size === 0) return;
    const has = (code: string): boolean => this.#keys.has(code);
    const slow = has('AltLeft') || has('AltRight') ? kSlow : 1;
    const haste = has('ShiftLeft') || has('ShiftRight') ? kFast : slow;
    let view = this.view;
    for (const code of this.#keys) {
      const by = kMoves[code];
      if (by !== undefined) view = moved(view, scaled(by, this.speed * haste * seconds));
      const turn = kTurns[code];
      if (turn !== undefined) {
        const degrees = kKeyTurnDegPerS * seconds;
        view = turned(view, turn[0] * degrees, turn[1] * degrees);
      }
    }
    if (view !== this.view) this.#host.setView(view);
  }

  #clickMiddle(): void {
    const box = this.#canvas.getBoundingClientRect();
    this.#host.onClick(box.left + box.width / 2, box.top + box.height / 2);
  }

  #keyDown(event: KeyboardEvent): void {
    if (event.ctrlKey || event.metaKey) return;
    if (event.code === 'Equal' || event.code === 'NumpadAdd') this.#zoom(1 / 1.1);
    else if (event.code === 'Minus' || event.code === 'NumpadSubtract') this.#zoom(1.1);
    else if (
      kMoves[event.code] !== undefined ||
      kTurns[event.code] !== undefined ||
      isHaste(event.code)
    ) {
      if (kMoves[event.code] !== undefined && !event.repeat) this.#setSpeed();
      this.#keys.add(event.code);
    } else return;
    event.preventDefault();
  }

  // Slow between houses, fast high up: by the distance of what is in the middle of the picture.
  #setSpeed(): void {
    const box = this.#canvas.getBoundingClientRect();
    const seen = this.#host.pointAt(box.left + box.width / 2, box.top + box.height / 2);
    if (seen === undefined) return;
    this.speed = clamp(distance(this.view.position, seen) * kSpeedShare, kMinSpeed, kMaxSpeed);
  }

  #zoom(factor: number): void {
    this.#host.setView(zoomed(this.view, factor));
  }

  #pointerDown(event: PointerEvent): void {
    this.#canvas.setPointerCapture(event.pointerId);
    this.#pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    this.#travelledPx = 0;
    const isOrbit = event.button !== 0 || event.shiftKey;
    this.#orbitCentre = isOrbit ? this.#host.pointAt(event.clientX, event.clientY) : undefined;
    const fingers = this.#fingers();
    if (fingers === undefined) return;
    this.#betweenFingers = this.#host.pointAt(...findMiddle(fingers));
  }

  #pointerMove(event: PointerEvent): void {
    const pointer = this.#pointers.get(event.pointerId);
    if (pointer === undefined) return;
    const before = this.#fingers();
    const [dx, dy] = [event.clientX - pointer.x, event.clientY - pointer.y];
    pointer.x = event.clientX;
    pointer.y = event.clientY;
    this.#travelledPx += Math.hypot(dx, dy);
    if (this.#travelledPx < kClickPx) return;
    const after = this.#fingers();
    if (before === undefined || after === undefined) this.#drag(dx, dy);
    else this.#pinch(before, after);
  }

  #pinch(before: Fingers, after: Fingers): void {
    const { view } = this;
    const centre = this.#betweenFingers;
    const distance = centre === undefined ? this.speed / kSpeedShare : measureDepth(view, centre);
    const { clientHeight } = this.#canvas;
    this.#host.setView(fingersMoved(view, before, after, centre, distance, clientHeight));
  }

  /** The first two; undefined for one or none. */
  #fingers(): Fingers | undefined {
    const [first, second] = this.#pointers.values();
    return first === undefined || second === undefined ? undefined : [{ ...first }, { ...second }];
  }

  #drag(dx: number, dy: number): void {
    const { view } = this;
    const perPx = kTurnDegPerPx * (view.fovDeg / 45);
    const centre = this.#orbitCentre;
    this.#host.setView(
      centre === undefined
        ? turned(view, -dx * perPx, dy * perPx)
        : orbited(view, centre, dx * perPx * 2, -dy * perPx * 2),
    );
  }

  #pointerUp(event: PointerEvent): void {
    this.#pointers.delete(event.pointerId);
    if (this.#travelledPx < kClickPx && event.button === 0) {
      this.#host.onClick(event.clientX, event.clientY);
    }
  }

  #wheel(event: WheelEvent): void {
    event.preventDefault();
    const by = Math.exp(-event.deltaY * kWheelZoom) - 1;
    const target = this.#host.pointAt(event.clientX, event.clientY);
    const { view } = this;
    if (target === undefined) {
      this.#host.setView(moved(view, [0, 0, this.speed * by]));
      return;
    }
    const position = along(view.position, [minus(target, view.position), Math.min(by, 0.8)]);
    this.#host.setView({ ...view, position });
  }
}

const isHaste = (code: string): boolean => code.startsWith('Shift') || code.startsWith('Alt');

// Along the line of sight; not less than a voxel.
const measureDepth = (view: Viewpoint, point: Vec3): number =>
  Math.max(dot(minus(point, view.position), computeForward(view)), 1);
