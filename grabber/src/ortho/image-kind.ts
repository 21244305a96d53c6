import { open } from 'node:fs/promises';
import { GrabberError, oneLine } from '../util/errors.js';

/** A picture by its first bytes, never by its name. `driver` is GDAL's name for it. */
export type ImageKind = {
  readonly driver: 'GTiff' | 'JPEG' | 'PNG' | 'JP2OpenJPEG';
  readonly extension: 'tif' | 'jpg' | 'png' | 'jp2';
  /** Ending of its world file. */
  readonly world: 'tfw' | 'jgw' | 'pgw' | 'j2w';
};

const kSniffBytes = 4096;
const kKinds: { readonly magic: readonly string[]; readonly kind: ImageKind }[] = [
  {
    magic: ['49492a00', '4d4d002a', '49492b00', '4d4d002b'],
    kind: { driver: 'GTiff', extension: 'tif', world: 'tfw' },
  },
  { magic: ['ffd8ff'], kind: { driver: 'JPEG', extension: 'jpg', world: 'jgw' } },
  { magic: ['89504e470d0a1a0a'], kind: { driver: 'PNG', extension: 'png', world: 'pgw' } },
  {
    magic: ['0000000c6a502020', 'ff4fff51'],
    kind: { driver: 'JP2OpenJPEG', extension: 'jp2', world: 'j2w' },
  },
];

export const kGeoTiff: ImageKind = { driver: 'GTiff', extension: 'tif', world: 'tfw' };

export function detectImageKind(start: Uint8Array): ImageKind | undefined {
  const hex = Buffer.from(start.subarray(0, 8)).toString('hex');
  return kKinds.find(({ magic }) => magic.some((one) => hex.startsWith(one)))?.kind;
}

/**
 * @throws GrabberError NOT_IMAGE; or MAP_SERVICE with its words, where a server reports an
 * exception with status 200
 */
export function requireImage(start: Uint8Array, shown: string): ImageKind {
  const kind = detectImageKind(start);
  if (kind !== undefined) return kind;
  const text = Buffer.from(start.subarray(0, kSniffBytes))
    .toString('utf8')
    .replace(/^\uFEFF/, '')
    .trimStart();
  const exception = /Exception/i.test(text) ? exceptionText(text) : undefined;
  if (exception !== undefined) {
    throw new GrabberError(
      'MAP_SERVICE',
      `request the picture ${shown}: the server says "${exception}"; allowed: a picture`,
      {
        retryable: false,
      },
    );
  }
  const begins =
    start.length === 0 ? 'nothing (0 bytes)' : JSON.stringify(oneLine(text.slice(0, 60)));
  throw new GrabberError(
    'NOT_IMAGE',
    `read the picture ${shown}: it starts with ${begins}; allowed: TIFF, JPEG, PNG or JPEG 2000`,
  );
}

export async function readImageKind(path: string, shown: string): Promise<ImageKind> {
  return requireImage(await readStart(path, kSniffBytes), shown);
}

/** The first bytes of a file; all, where it has no more than these. */
export async function readStart(path: string, max_bytes: number): Promise<Buffer> {
  const file = await open(path, 'r');
  try {
    const { size } = await file.stat();
    const { buffer, bytesRead } = await file.read(
      Buffer.alloc(Math.min(size, max_bytes)),
      0,
      Math.min(size, max_bytes),
      0,
    );
    return buffer.subarray(0, bytesRead);
  } finally {
    await file.close();
  }
}

/** The words of a WMS ServiceException or an OWS ExceptionReport. */
function exceptionText(xml: string): string | undefined {
  const element = /<(?:\w+:)?(?:ServiceException|ExceptionText)\b([^>]*)>([\s\S]*?)<\//i.exec(xml);
  if (element === null) return undefined;
  const code = /(?:code|exceptionCode)="([^"]{1,60})"/i.exec(xml)?.[1];
  const said = oneLine((element[2] ?? '').replace(/<!\[CDATA\[|\]\]>/g, ''))
    .replace(/ +/g, ' ')
    .slice(0, 300);
  return (
    [code, said].filter((part) => part !== undefined && part !== '').join(': ') ||
    'exception without a text'
  );
}
