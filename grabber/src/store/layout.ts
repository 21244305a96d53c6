import { join } from 'node:path';
import type { RecordKey } from '../model/store.js';
import { GrabberError } from '../util/errors.js';

/** Where things lie in a store folder. */
export function storeLayout(root: string): { root: string; database: string; lock: string } {
  return { root, database: join(root, 'fishnet.gpkg'), lock: join(root, '.grabber.lock') };
}

export type FileKind = 'lidar' | 'ortho';

/** Part of a path: no slashes, no control characters; a dot in front would hide it, or lead up. */
export const kNamePattern = /^[^./\\\p{Cc}][^/\\\p{Cc}]{0,199}$/u;
const kNameAllowed = '1 to 200 characters without "/", "\\", control characters, or "." in front';

/** A part of a path that kNamePattern allows, for patterns of whole paths. */
const kPart = String.raw`[^./\\\p{Cc}][^/\\\p{Cc}]*`;

/** Paths of finished files, as `kPlaces` makes them. */
export const kFilePath: Readonly<
  Record<FileKind, { readonly pattern: RegExp; readonly allowed: string }>
> = {
  lidar: {
    pattern: new RegExp(`^lidar/${kPart}/${kPart}\\.(laz|las|zlas)$`, 'u'),
    allowed: 'lidar/<source>/<name>.laz, .las or .zlas',
  },
  ortho: {
    pattern: new RegExp(`^ortho/${kPart}/${kPart}/${kPart}\\.tif$`, 'u'),
    allowed: 'ortho/<source>/<grid>/<name>.tif',
  },
};
/** Of finished files, without the dot. */
export const kFileExtensions: Readonly<Record<FileKind, readonly string[]>> = {
  lidar: ['laz', 'las', 'zlas'],
  ortho: ['tif'],
};

/** Relative to the store with forward slashes, so that a store can be moved between systems. */
export const kPlaces = {
  /** @param extension without its dot: "laz", "las", "zlas", "tif" */
  finished(kind: FileKind, key: RecordKey, extension: string): string {
    const allowed = kFileExtensions[kind];
    if (!allowed.includes(extension)) throw refuse('extension', extension, allowed.join(', '));
    return `${toFolder(kind, key)}/${checkedName('name', key.name)}.${extension}`;
  },
  /** The dot keeps it out of listings that look for LAZ files and images. */
  unfinished: (kind: FileKind, key: RecordKey): string =>
    `${toFolder(kind, key)}/.${checkedName('name', key.name)}.part`,
};

/** Of an unfinished file that comes as a member of an archive: where the archive arrives. */
export function archiveBeside(unfinished: string): string {
  return unfinished.replace(/\.part$/, '.zip.part');
}

function toFolder(kind: FileKind, key: RecordKey): string {
  const source = checkedName('source', key.source);
  const grid = checkedName('grid', key.grid);
  return kind === 'lidar' ? `lidar/${source}` : `ortho/${source}/${grid}`;
}

/** @throws GrabberError STORE_CONFLICT: catalogues and folders of the user bring names too */
export function checkedName(what: string, name: string): string {
  if (!kNamePattern.test(name)) throw refuse(what, name, kNameAllowed);
  return name;
}

function refuse(what: string, value: string, allowed: string): GrabberError {
  return new GrabberError(
    'STORE_CONFLICT',
    `place a file in the store: ${what} is ${JSON.stringify(value)}; allowed: ${allowed}`,
  );
}
