/**
 * Points, lines and labels over the picture. Each has a dark rim and a light core, or a light text
 * on a dark ground, so that it can be seen on any picture.
 */
import { type Vec2, clamp, type Vec3 } from '../../vec3.js';
import { element, getContext2d } from '../../dom.js';
import type { Camera } from '../draw/look.js';
import { clipped, projectSegment, projectPoint, spotOfDirection, type Spot } from './projection.js';

export type Tone = 'usual' | 'good' | 'bad' | 'sun';

/** Places are level-0 voxels; directions are those of points at an infinite distance. */
export type Shape =
  | { readonly kind: 'line'; readonly points: readonly Vec3[]; readonly tone: Tone }
  | { readonly kind: 'point'; readonly at: Vec3; readonly tone: Tone; readonly label?: string }
  | { readonly kind: 'label'; readonly at: Vec3; readonly label: string }
  | { readonly kind: 'sky-line'; readonly directions: readonly Vec3[]; readonly tone: Tone }
  | {
      readonly kind: 'sky-point';
      readonly direction: Vec3;
      readonly tone: Tone;
      readonly radiusPx: number;
      readonly label?: string;
    }
  /** In the middle of the picture. */
  | { readonly kind: 'cross' };

/** Of a picture; `scale`: its pixels in a CSS pixel. */
export type Sheet = {
  readonly context: CanvasRenderingContext2D;
  readonly size: Vec2;
  readonly scale: number;
};

type Box = readonly [number, number, number, number];

const kTones: Readonly<Record<Tone, string>> = {
  usual: '#ffe14d',
  good: '#6ff08f',
  bad: '#ff8a7a',
  sun: '#ffc24d',
};
const kRim = 'rgb(0 0 0 / 75%)';
const kGround = 'rgb(16 20 24 / 88%)';
const kText = '#ffffff';
const kFontPx = 13;
const kLabelPx = 20;
const kPadPx = 6;
const kPointPx = 5;
const kCrossPx = 11;

/** A canvas over the picture, which is there only while it has something to show. */
export class Overlay {
  readonly #picture: HTMLCanvasElement;
  #canvas: HTMLCanvasElement | undefined;

  constructor(picture: HTMLCanvasElement) {
    this.#picture = picture;
  }

  draw(camera: Camera, shapes: readonly Shape[]): void {
    if (shapes.length === 0) {
      this.#canvas?.remove();
      this.#canvas = undefined;
      return;
    }
    this.#canvas ??= this.#add();
    const canvas = this.#canvas;
    const { width, height } = this.#picture;
    // A new size clears the canvas, too.
    canvas.width = width;
    canvas.height = height;
    const scale = width / Math.max(1, this.#picture.clientWidth);
    paint({ context: getContext2d(canvas), size: [width, height], scale }, camera, shapes);
  }

  #add(): HTMLCanvasElement {
    const canvas = element('canvas', { id: 'overlay', 'aria-hidden': 'true' });
    this.#picture.after(canvas);
    return canvas;
  }
}

export function paint(sheet: Sheet, camera: Camera, shapes: readonly Shape[]): void {
  const { context, size } = sheet;
  context.lineCap = 'round';
  context.lineJoin = 'round';
  context.textBaseline = 'middle';
  context.font = `600 ${kFontPx * sheet.scale}px system-ui, sans-serif`;
  const labels: { at: Spot; text: string }[] = [];
  for (const shape of shapes) {
    switch (shape.kind) {
      case 'line':
        drawLine(sheet, projectSegments(camera, size, shape.points), shape.tone);
        break;
      case 'sky-line':
        drawLine(sheet, projectSkySegments(camera, size, shape.directions), shape.tone);
        break;
      case 'point':
      case 'sky-point': {
        const isPoint = shape.kind === 'point';
        const at = isPoint
          ? projectPoint(camera, size, shape.at)
          : spotOfDirection(camera, size, shape.direction);
        if (at === undefined || !isInside(at, size)) break;
        drawPoint(sheet, at, shape.tone, isPoint ? kPointPx : shape.radiusPx);
        if (shape.label !== undefined) labels.push({ at, text: shape.label });
        break;
      }
      case 'label': {
        const at = projectPoint(camera, size, shape.at);
        if (at !== undefined && isInside(at, size)) labels.push({ at, text: shape.label });
        break;
      }
      case 'cross':
        drawCross(sheet);
        break;
    }
  }
  drawLabels(sheet, labels);
}

function projectSegments(
  camera: Camera,
  size: Vec2,
  points: readonly Vec3[],
): (readonly [Spot, Spot])[] {
  return points
    .slice(1)
    .map((to, i) => projectSegment(camera, size, points[i]!, to))
    .filter((segment) => segment !== undefined);
}

function projectSkySegments(
  camera: Camera,
  size: Vec2,
  directions: readonly Vec3[],
): (readonly [Spot, Spot])[] {
  const spots = directions.map((direction) => spotOfDirection(camera, size, direction));
  return spots
    .slice(1)
    .map((to, i) => {
      const from = spots[i];
      return from === undefined || to === undefined ? undefined : clipped(from, to, size);
    })
    .filter((segment) => segment !== undefined);
}

// A wide dark rim below a narrow light core.
function strokeTwice({ context, scale }: Sheet, [rim, core]: Vec2, colour: string): void {
  context.lineWidth = rim * scale;
  context.strokeStyle = kRim;
  context.stroke();
  context.lineWidth = core * scale;
  context.strokeStyle = colour;
  context.stroke();
}

function drawLine(sheet: Sheet, segments: readonly (readonly [Spot, Spot])[], tone: Tone): void {
  const { context } = sheet;
  context.beginPath();
  for (const [from, to] of segments) {
    context.moveTo(...from);
    context.lineTo(...to);
  }
  strokeTwice(sheet, [5, 2.5], kTones[tone]);
}

function drawPoint({ context, scale }: Sheet, at: Spot, tone: Tone, radiusPx: number): void {
  context.beginPath();
  context.arc(...at, radiusPx * scale, 0, 2 * Math.PI);
  context.fillStyle = kTones[tone];
  context.fill();
  context.lineWidth = 2 * scale;
  context.strokeStyle = kRim;
  context.stroke();
}

function drawCross(sheet: Sheet): void {
  const { context, size, scale } = sheet;
  const [x, y] = [size[0] / 2, size[1] / 2];
  const [inner, outer] = [3 * scale, kCrossPx * scale];
  context.beginPath();
  for (const side of [-1, 1]) {
    context.moveTo(x + side * inner, y);
    context.lineTo(x + side * outer, y);
    context.moveTo(x, y + side * inner);
    context.lineTo(x, y + side * outer);
  }
  strokeTwice(sheet, [4, 1.5], kText);
}

// Above what they belong to, inside the picture; what would cover an earlier one is left out.
function drawLabels(sheet: Sheet, labels: readonly { at: Spot; text: string }[]): void {
  const { context, size, scale } = sheet;
  const taken: Box[] = [];
  for (const { at, text } of labels) {
    const width = context.measureText(text).width + 2 * kPadPx * scale;
    const height = kLabelPx * scale;
    const x = clamp(at[0] - width / 2, 0, size[0] - width);
    const y = Math.max(at[1] - height - 9 * scale, 0);
    const box: Box = [x, y, x + width, y + height];
    if (taken.some((other) => isOverlap(other, box))) continue;
    taken.push(box);
    drawText(sheet, text, box);
  }
}

/** A text on its dark ground. */
export function drawText(
  { context, scale }: Sheet,
  text: string,
  [x, y, right, bottom]: Box,
): void {
  context.beginPath();
  context.roundRect(x, y, right - x, bottom - y, 4 * scale);
  context.fillStyle = kGround;
  context.fill();
  context.fillStyle = kText;
  context.fillText(text, x + kPadPx * scale, (y + bottom) / 2);
}

function isOverlap(a: Box, b: Box): boolean {
  return a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3];
}

function isInside([x, y]: Spot, [width, height]: Vec2): boolean {
  return x >= 0 && y >= 0 && x <= width && y <= height;
}
