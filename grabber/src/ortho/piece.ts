import { GrabberError } from '../util/errors.js';
import type { Downloader } from './download.js';
import type { Gdal } from './gdal.js';
import { readImageKind, readStart, type ImageKind } from './image-kind.js';
import type { Target } from './target.js';

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

/** Ref: ISO/IEC 15948:2004 (PNG), 11.2.2 and 11.3.2.1. */
function pngFacts(bytes: Buffer): Omit<ImageProbe, 'kind'> | undefined {
  if (bytes.length < 45 || bytes.toString('latin1', 12, 16) !== 'IHDR') return undefined;
  const names: Readonly<Record<number, Channels>> = {
    0: 'grey',
    2: 'rgb',
    3: 'palette',
    4: 'greya',
    6: 'rgba',
  };
  const channels = names[bytes.readUInt8(25)];
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
