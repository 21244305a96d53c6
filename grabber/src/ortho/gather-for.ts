import { AssetCache } from './asset-cache.js';
import type { Gather } from './piece.js';
import type { OrthoSource } from './schema.js';
import { stacGather } from './stac.js';
import { templateGather } from './template.js';
import { wmsGather } from './wms.js';
import { wmtsGather } from './wmts.js';

/** How pictures of a source are gathered, and the whole files that it keeps meanwhile. */
export function gatherFor(
  source: OrthoSource,
  cacheFolder: string,
): { readonly gather: Gather; readonly cache: AssetCache } {
  const cache = new AssetCache(cacheFolder);
  const { access } = source;
  switch (access.kind) {
    case 'wms':
      return { gather: wmsGather(source, access), cache };
    case 'wmts':
      return { gather: wmtsGather(source, access), cache };
    case 'stac':
      return { gather: stacGather(source, access, cache), cache };
    case 'template':
      return { gather: templateGather(source, access, cache), cache };
  }
}
