import type { Source } from './source.js';
import { templatesOf } from './source.js';

/** A variable of an address cannot stand in its host, so that a value cannot choose whom to talk to. */
function withoutVariables(template: string): URL {
  return new URL(template.replace(/\{[^}]*\}/g, '0'));
}

export function hostOfTemplate(template: string): string {
  return withoutVariables(template).hostname.toLowerCase();
}

export function originOfTemplate(template: string): string {
  return withoutVariables(template).origin;
}

/** Host names, without port and in lower case, that a source's configuration allows to talk to; sorted. */
export function hostsOf(source: Source): string[] {
  return [...new Set([...addressesOf(source).map(hostOfTemplate), ...source.hosts])].sort();
}

/** Those that may hear the source's secrets: where its own addresses lead, not all that it may talk to. */
export function secretOriginsOf(source: Source): string[] {
  return [...new Set(addressesOf(source).map(originOfTemplate))].sort();
}

function addressesOf(source: Source): string[] {
  const { access } = source;
  const addresses = [...templatesOf(source)];
  if (access.kind === 'stac') addresses.push(access.items, ...(access.sign === undefined ? [] : [access.sign]));
  if (access.kind === 'wfs') addresses.push(access.url);
  return addresses;
}
