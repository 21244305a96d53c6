import { join } from 'node:path';

/** Where things lie in a store folder. */
export type StoreLayout = {
  readonly root: string;
  readonly manifest: string;
  readonly lock: string;
};

export function storeLayout(root: string): StoreLayout {
  return { root, manifest: join(root, 'manifest.json'), lock: join(root, '.grabber.lock') };
}

/** Relative to the store with forward slashes, so that a store can be moved between systems. */
export function lidarFile(source: string, square: string, compressed: boolean): string {
  return `lidar/${source}/${square}${compressed ? '.laz' : '.las'}`;
}

/** The dot keeps an unfinished file out of listings that look for LAZ files. */
export function partialFile(source: string, square: string): string {
  return `lidar/${source}/.${square}.part`;
}
