import type { IncomingMessage, ServerResponse } from 'node:http';
import { drawPattern, encodePng } from './pattern.js';

export type WmsOptions = {
  readonly layer: string;
  readonly crs: readonly string[];
  /** Those whose northing comes first in version 1.3.0. */
  readonly northingFirst?: readonly string[];
  readonly mostPixels: number;
  /** A ServiceException instead of a picture, with status 200 as map servers do. */
  readonly refuse?: string;
};

/**
 * A map server that draws the synthetic picture.
 * @return whether the request was for it (path /wms)
 */
export function wmsHandler(
  options: WmsOptions,
): (request: IncomingMessage, response: ServerResponse) => boolean {
  return (request, response) => {
    const url = new URL(request.url ?? '/', 'http://portal');
    if (url.pathname !== '/wms') return false;
    const words = new Map(
      [...url.searchParams].map(([name, value]) => [name.toUpperCase(), value]),
    );
    const wrong = options.refuse ?? problem(words, options);
    if (wrong === undefined) {
      const [width, height] = [Number(words.get('WIDTH')), Number(words.get('HEIGHT'))];
      const png = encodePng(drawPattern(parseBounds(words, options), width, height), width, height);
      response
        .writeHead(200, { 'content-type': 'image/png', 'content-length': String(png.length) })
        .end(png);
    } else {
      response.writeHead(200, { 'content-type': 'text/xml' });
      response.end(
        '<?xml version="1.0"?><ServiceExceptionReport><ServiceException ' +
          `code="Wrong">${wrong}</ServiceException></ServiceExceptionReport>`,
      );
    }
    return true;
  };
}

function parseBounds(words: ReadonlyMap<string, string>, options: WmsOptions): number[] {
  const box = (words.get('BBOX') ?? '').split(',').map(Number);
  const crs = words.get('CRS') ?? '';
  const swapped = words.get('VERSION') === '1.3.0' && (options.northingFirst ?? []).includes(crs);
  return swapped ? [box[1] ?? 0, box[0] ?? 0, box[3] ?? 0, box[2] ?? 0] : box;
}

function problem(words: ReadonlyMap<string, string>, options: WmsOptions): string | undefined {
  const crs = words.get(words.get('VERSION') === '1.3.0' ? 'CRS' : 'SRS') ?? '';
  if (words.get('REQUEST') !== 'GetMap' || words.get('SERVICE') !== 'WMS') return 'no GetMap';
  if (words.get('LAYERS') !== options.layer) return `no layer ${words.get('LAYERS') ?? ''}`;
  if (!options.crs.includes(crs)) return `no CRS ${crs}`;
  const sides = ['WIDTH', 'HEIGHT'].map((name) => Number(words.get(name)));
  if (sides.some((side) => !(side >= 1 && side <= options.mostPixels))) {
    return `picture of ${sides.join(' x ')}`;
  }
  return words.has('STYLES') && words.has('FORMAT') ? undefined : 'STYLES and FORMAT are missing';
}
