import type { Source } from './source.js';
import { templatesOf } from './source.js';

/** A variable of an address cannot stand in its host, so that a value cannot choose whom to talk to. */
export function hostOfTemplate(template: string): string {
  return new URL(template.replace(/\{[^}]*\}/g, '0')).hostname.toLowerCase();
}

/** Host names, without port and in lower case, that a source's configuration allows to talk to; sorted. */
export function hostsOf(source: Source): string[] {
  const { access } = source;
  const addresses = [...templatesOf(source)];
  if (access.kind === 'stac') addresses.push(access.items, ...(access.sign === undefined ? [] : [access.sign]));
  if (access.kind === 'wfs') addresses.push(access.url);
  return [...new Set([...addresses.map(hostOfTemplate), ...source.hosts])].sort();
}
