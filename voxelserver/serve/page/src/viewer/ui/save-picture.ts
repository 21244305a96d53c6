/** The picture as a file: with what is drawn over it, and always with the names of its sources. */
import { download, element, getContext2d } from '../../dom.js';
import type { Camera } from '../draw/look.js';
import { drawText, paint, type Shape, type Sheet } from './overlay.js';

const kCreditPx = 20;
const kPadPx = 6;
const kName = 'terravox.png';

export function savePicture(
  picture: HTMLCanvasElement,
  camera: Camera,
  shapes: readonly Shape[],
  credit: string,
): void {
  pictureWith(picture, camera, shapes, credit).toBlob((blob) => {
    if (blob !== null) download(blob, kName);
  });
}

function pictureWith(
  picture: HTMLCanvasElement,
  camera: Camera,
  shapes: readonly Shape[],
  credit: string,
): HTMLCanvasElement {
  const { width, height } = picture;
  const canvas = element('canvas', { width, height });
  const context = getContext2d(canvas);
  context.drawImage(picture, 0, 0);
  const scale = width / Math.max(1, picture.clientWidth);
  const sheet: Sheet = { context, size: [width, height], scale };
  paint(sheet, camera, shapes);
  if (credit !== '') drawCredit(sheet, credit);
  return canvas;
}

function drawCredit(sheet: Sheet, credit: string): void {
  const { context, size, scale } = sheet;
  const wanted = context.measureText(credit).width + 2 * kPadPx * scale;
  const width = Math.min(wanted, size[0]);
  const [right, bottom] = size;
  drawText(sheet, credit, [right - width, bottom - kCreditPx * scale, right, bottom]);
}
