import type { HttpClient } from '../../fetch/http-client.js';
import type { Catalogue } from '../../model/store.js';
import type { Source } from '../source.js';
import { settingsOf, type CatalogueOptions } from './options.js';
import { stacCatalogue } from './stac-catalogue.js';
import { templateCatalogue } from './template-catalogue.js';
import { wfsCatalogue } from './wfs-catalogue.js';

/** What a source has. Asks nobody yet. @throws GrabberError USAGE for variables that are missing or not allowed */
export function openCatalogue(source: Source, http: HttpClient, options: CatalogueOptions = {}): Catalogue {
  const settings = settingsOf(options);
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
