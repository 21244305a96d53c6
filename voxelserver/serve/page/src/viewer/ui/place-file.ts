/**
 * place.json (docs/formats/site.md): what a site shows, as `terravox publish` writes it. Read with
 * the eyes of a stranger: only known fields, of the types and sizes that they may have.
 */
import { JsonReader, type Fields } from '../../json.js';
import type { Block, Vec3 } from '../../vec3.js';
import type { FilePart } from '../data/range-file.js';

export type NamedView = Readonly<ReturnType<typeof readView>>;

export type PlaceFile = Readonly<ReturnType<typeof parsePlaceFile>>;
/** @throws Error that names the field */
export const readPlaceFile = (json: unknown): PlaceFile => parsePlaceFile(json);

const kMaxText = 4096;
const kMaxViews = 256;
const kMaxParts = 4096;
const kMaxLevel = 20;
const kFarthest = 2 ** 30;

function fail(what: string): never {
  throw new Error(`read place.json: ${what}; publish the place again`);
}

const read = new JsonReader(fail);
const parseText = (value: unknown, what: string): string => read.text(value, what, kMaxText);

function parsePlaceFile(json: unknown) {
  const place = read.fields(json, 'the file');
  if (place['version'] !== 1) fail(`version = ${String(place['version'])}; this page reads 1`);
  const views = read.list(place['views'], 'views', kMaxViews).map(readView);
  if (views.length === 0) fail('there is no view');
  const squares = place['squares'];
  return {
    title: parseText(place['title'], 'title'),
    attribution: parseText(place['attribution'], 'attribution'),
    licence: parseText(place['licence'], 'licence'),
    archive: readArchive(read.fields(place['archive'], 'archive')),
    /** The first one is shown at the beginning. */
    views,
    /** UTC, milliseconds since 1970. */
    timeMs: read.number(place['time_ms'], 'time_ms', 0, 1e13),
    /** Address of the LiDAR squares, relative to the page. */
    squares: squares === undefined ? undefined : parseText(squares, 'squares'),
  };
}

type PlaceArchive =
  | { readonly url: string }
  | { readonly parts: readonly FilePart[] }
  /** A voxel server, and the coarsest level that may be requested of it. */
  | { readonly server: string; readonly coarsest: number };

function readArchive(archive: Fields): PlaceArchive {
  const { server, parts } = archive;
  if (server !== undefined) {
    const coarsest = read.whole(archive['coarsest'], 'archive.coarsest', kMaxLevel);
    return { server: parseText(server, 'archive.server'), coarsest };
  }
  if (parts === undefined) return { url: parseText(archive['url'], 'archive.url') };
  return { parts: read.list(parts, 'archive.parts', kMaxParts).map(readPart) };
}

function readPart(value: unknown): FilePart {
  const part = read.fields(value, 'archive.parts');
  return {
    url: parseText(part['url'], 'url'),
    bytes: read.number(part['bytes'], 'bytes', 1, Number.MAX_SAFE_INTEGER),
  };
}

function readView(value: unknown) {
  const view = read.fields(value, 'views');
  return {
    name: parseText(view['name'], 'name'),
    /** Level-0 voxels. */
    position: readPoint(view, 'position'),
    target: readPoint(view, 'target'),
    fovDeg: read.number(view['fov_deg'], 'fov_deg', 5, 120),
    /** Level-0 voxels that the picture shows whole, in this direction, whatever its shape is. */
    frame: view['frame'] === undefined ? undefined : readFrame(read.fields(view['frame'], 'frame')),
  };
}

function readFrame(frame: Fields): Block {
  const [min, max] = [readPoint(frame, 'min'), readPoint(frame, 'max')];
  if (min.some((v, a) => v >= max[a]!)) fail('a frame is empty');
  return { min, max };
}

function readPoint(fields: Fields, name: string): Vec3 {
  return read.vec3(fields[name], name, kFarthest);
}
