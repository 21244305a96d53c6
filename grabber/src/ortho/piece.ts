import { GrabberError, oneLine } from '../util/errors.js';
import type { Downloader } from './download.js';
import type { Gdal } from './gdal.js';
import type { Target } from './target.js';
import { decodeText, readStart } from '../util/files.js';

/** What the samples of a pixel are. */
export type Channels = 'rgb' | 'rgba' | 'grey' | 'greya' | 'palette' | 'other';

/** A picture on disk with its place: in its tags, or in a world file. */
export type Piece = {
  readonly path: string;
  readonly kind: ImageKind;
  readonly channels: Channels;
  /** Null: the file's own. */
  readonly crs: string | null;
};

/** Pieces that together cover a target, in the order in which they are laid over each other. */
export type Gathered = {
  readonly pieces: readonly Piece[];
  /** What to record as the place where they came from. */
  readonly url: string;
  /**
   * The grid that all pieces share, so that they can be joined without a seam first; undefined =
   * each has its own.
   */
  readonly grid: Target | undefined;
  /** Metres a pixel of the pieces, in the target's CRS; as far as known. */
  readonly resolution_m: number | undefined;
  /** Of the pictures, ISO 8601 date or year, where known. */
  readonly date: string | undefined;
  readonly warnings: readonly string[];
};

/** What a kind of source needs to gather pieces. */
export type GatherContext = {
  /** Of this one picture; removed afterwards. */
  readonly folder: string;
  /** Of the whole run: whole files that several squares need. */
  readonly cache: string;
  readonly gdal: Gdal;
  readonly download: Downloader;
  readonly time: string | undefined;
  /** Requests at a time. */
  readonly concurrency: number;
};

/** @return undefined when the source has nothing there */
export type Gather = (
  target: Target,
  context: GatherContext,
  signal: AbortSignal,
) => Promise<Gathered | undefined>;

/**
 * The size of a JPEG stands behind its profiles and previews, which have at most 64 KiB a segment.
 */
const kMaxBeforeSize_bytes = 16 << 20;

type ImageProbe = {
  readonly kind: ImageKind;
  readonly width_px: number;
  readonly height_px: number;
  readonly channels: Channels;
};

/**
 * Looks into a picture that came from somewhere: its kind by its bytes, its size. The start of JPEG
 * and PNG is read here, since a square may have hundreds; whatever else the bytes hold, GDAL sees
 * them only after their size was found to be sane.
 */
export async function probeImage(
  path: string,
  shown: string,
  gdal: Gdal,
  signal: AbortSignal,
): Promise<ImageProbe> {
  const kind = await readImageKind(path, shown);
  if (kind.driver === 'PNG' || kind.driver === 'JPEG') {
    const start = await readStart(path, kMaxBeforeSize_bytes);
    const found = kind.driver === 'PNG' ? pngFacts(start) : jpegFacts(start);
    if (found !== undefined) return { kind, ...found };
    throw new GrabberError(
      'NOT_IMAGE',
      `read the picture ${shown}: a ${kind.driver} that is cut short or damaged; allowed: ` +
        'a whole one',
    );
  }
  const facts = await gdal.info(path, kind, {}, signal);
  return {
    kind,
    width_px: facts.width_px,
    height_px: facts.height_px,
    channels: toChannels(facts.bands.map((band) => band.interpretation)),
  };
}

export function requireSize(
  probe: ImageProbe,
  width_px: number,
  height_px: number,
  shown: string,
): void {
  if (probe.width_px === width_px && probe.height_px === height_px) return;
  throw new GrabberError(
    'NOT_IMAGE',
    `read the picture ${shown}: ${probe.width_px} x ${probe.height_px} pixels; allowed: ` +
      `${width_px} x ${height_px}, as requested`,
  );
}

export function toChannels(bands: readonly string[]): Channels {
  const all = bands.join(' ');
  if (all === 'Red Green Blue') return 'rgb';
  if (all === 'Red Green Blue Alpha') return 'rgba';
  if (all === 'Gray') return 'grey';
  if (all === 'Gray Alpha') return 'greya';
  return all === 'Palette' ? 'palette' : 'other';
}

/** By the type of colour in a PNG's header. */
const kPngChannels = ['grey', undefined, 'rgb', 'palette', 'greya', undefined, 'rgba'] as const;

/** Ref: ISO/IEC 15948:2004 (PNG), 11.2.2 and 11.3.2.1. */
function pngFacts(bytes: Buffer): Omit<ImageProbe, 'kind'> | undefined {
  if (bytes.length < 45 || bytes.toString('latin1', 12, 16) !== 'IHDR') return undefined;
  const channels = kPngChannels[bytes.readUInt8(25)];
  if (channels === undefined) return undefined;
  // A colour that stands for "nothing" becomes a mask band, which the plain kinds do not have.
  const marked =
    channels === 'rgb' && bytes.subarray(33, Math.min(bytes.length, 4096)).includes('tRNS');
  return {
    width_px: bytes.readUInt32BE(16),
    height_px: bytes.readUInt32BE(20),
    channels: marked ? 'other' : channels,
  };
}

/** By the number of components in a frame header. */
const kJpegChannels: Readonly<Record<number, Channels>> = { 1: 'grey', 3: 'rgb' };

/** Ref: ITU-T T.81 (JPEG), B.1.1 and B.2.2: the frame header among the segments. */
function jpegFacts(bytes: Buffer): Omit<ImageProbe, 'kind'> | undefined {
  for (let at = 2; at + 10 < bytes.length;) {
    if (bytes.readUInt8(at) !== 0xff) return undefined;
    const marker = bytes.readUInt8(at + 1);
    if (marker === 0xff) {
      ++at;
      continue;
    }
    const frame = marker >= 0xc0 && marker <= 0xcf && ![0xc4, 0xc8, 0xcc].includes(marker);
    if (frame) {
      return {
        width_px: bytes.readUInt16BE(at + 7),
        height_px: bytes.readUInt16BE(at + 5),
        channels: kJpegChannels[bytes.readUInt8(at + 9)] ?? 'other',
      };
    }
    at += 2 + bytes.readUInt16BE(at + 2);
  }
  return undefined;
}

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
  const text = decodeText([start.subarray(0, kSniffBytes)]).trimStart();
  const exception = /Exception/i.test(text) ? exceptionText(text) : undefined;
  if (exception !== undefined) {
    throw new GrabberError(
      'MAP_SERVICE',
      `request the picture ${shown}: the server says "${exception}"; allowed: a picture`,
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
