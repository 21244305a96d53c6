import type { HttpClient } from '../../fetch/http-client.js';
import { redactError, withoutSecrets, type Redact } from '../../fetch/redact.js';
import type { CatalogueSquare, Catalogue, Region } from '../../model/store.js';
import type { GrabberError } from '../../util/errors.js';
import type { Source } from '../source.js';
import { toSettings, type CatalogueOptions, type CatalogueSettings } from './listing.js';
import { stacCatalogue } from './stac-catalogue.js';
import { templateCatalogue } from './template-catalogue.js';
import { wfsCatalogue } from './wfs-catalogue.js';

/**
 * Opens the catalogue of a source. Contacts no host yet; its errors show no secret.
 * @throws GrabberError USAGE for variables that are missing or not allowed
 */
export function openCatalogue(
  source: Source,
  http: HttpClient,
  options: CatalogueOptions = {},
): Catalogue {
  const { onLeftOut } = options;
  const redacted =
    onLeftOut === undefined
      ? {}
      : { onLeftOut: (error: GrabberError) => onLeftOut(redactError(error, http.redact)) };
  const catalogue = makeCatalogue(source, http, toSettings({ ...options, ...redacted }));
  const { locate } = catalogue;
  return {
    ...catalogue,
    find: (region, signal) => findWithoutSecrets(catalogue, http.redact, region, signal),
    ...(locate === undefined
      ? {}
      : { locate: (...parameters) => withoutSecrets(http.redact, () => locate(...parameters)) }),
  };
}

async function* findWithoutSecrets(
  catalogue: Catalogue,
  redact: Redact,
  region: Region,
  signal: AbortSignal,
): AsyncGenerator<CatalogueSquare> {
  try {
    yield* catalogue.find(region, signal);
  } catch (error) {
    throw redactError(error, redact);
  }
}

function makeCatalogue(source: Source, http: HttpClient, settings: CatalogueSettings): Catalogue {
  const { access } = source;
  switch (access.kind) {
    case 'template':
      return templateCatalogue(source, settings);
    case 'stac':
      return stacCatalogue(source, access, http, settings);
    case 'wfs':
      return wfsCatalogue(source, access, http, settings);
  }
}
