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

/** Where a host named without a scheme may be asked: at its port, or else at those of http and https. */
export function originsOfHost(host: string): string[] {
  return ['http', 'https'].map((scheme) => new URL(`${scheme}://${host}`).origin);
}

/** Host names in lower case, without port unless the source names one, that its configuration allows to talk to; sorted. */
export function hostsOf(source: Source): string[] {
  return [...new Set([...addressesOf(source).map(hostOfTemplate), ...source.hosts])].sort();
}

/** Those that may hear the source's secrets: where its own addresses lead, not all that it may talk to. */
export function secretOriginsOf(source: Source): string[] {
  return [...new Set(addressesOf(source).map(originOfTemplate))].sort();
}

/** Those that may lead to private addresses: all that a source names when it allows that, else none. */
export function privateOriginsOf(source: Source): string[] {
  if (!source.allow_private_addresses) return [];
  return [...new Set([...secretOriginsOf(source), ...source.hosts.flatMap(originsOfHost)])].sort();
}

function addressesOf(source: Source): string[] {
  const { access } = source;
  const addresses = [...templatesOf(source)];
  if (access.kind === 'stac') addresses.push(access.items, ...(access.sign === undefined ? [] : [access.sign]));
  if (access.kind === 'wfs') addresses.push(access.url);
  return addresses;
}
