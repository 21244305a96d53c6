import { element, getContext2d } from './dom.js';
import type { SquareState } from './squares.js';

/**
 * Hatches, so that no state is shown by colour alone. Colours come from app.css, which draws the
 * same for the legend.
 */

export type Hatch = 'dots' | 'rising' | 'falling' | 'cross';
export type Sign = {
  readonly letter: string;
  readonly hatch: Hatch;
  readonly colour: string;
};

export const kStateSigns: Readonly<Record<SquareState, Sign>> = {
  wanted: { letter: 'W', hatch: 'dots', colour: '--wanted' },
  fetched: { letter: 'F', hatch: 'falling', colour: '--fetched' },
  prepared: { letter: 'P', hatch: 'rising', colour: '--prepared' },
  failed: { letter: '!', hatch: 'cross', colour: '--failed' },
};
export const kMemorySign: Sign = { letter: 'M', hatch: 'rising', colour: '--memory' };
export const kDiskSign: Sign = { letter: 'D', hatch: 'dots', colour: '--disk' };

const kTilePx = 12;

/** @return a repeating fill, half of it transparent */
export function hatchPattern(hatch: Hatch, colour: string): CanvasPattern | string {
  const canvas = element('canvas', { width: kTilePx, height: kTilePx });
  const context = getContext2d(canvas);
  context.strokeStyle = colour;
  context.fillStyle = colour;
  context.lineWidth = 1.3;
  context.globalAlpha = 0.1;
  context.fillRect(0, 0, kTilePx, kTilePx);
  context.globalAlpha = 0.65;
  drawHatch(context, hatch);
  return context.createPattern(canvas, 'repeat') ?? colour;
}

// Each stroke is drawn beyond the corners, so that the repeated tile has no gaps.
function drawHatch(context: CanvasRenderingContext2D, hatch: Hatch): void {
  context.beginPath();
  if (hatch === 'dots') {
    context.arc(kTilePx / 2, kTilePx / 2, 1.4, 0, 2 * Math.PI);
    context.fill();
    return;
  }
  for (const shift of [-kTilePx, 0, kTilePx]) {
    if (hatch !== 'falling') {
      context.moveTo(shift - 1, kTilePx + 1);
      context.lineTo(shift + kTilePx + 1, -1);
    }
    if (hatch !== 'rising') {
      context.moveTo(shift - 1, -1);
      context.lineTo(shift + kTilePx + 1, kTilePx + 1);
    }
  }
  context.stroke();
}
