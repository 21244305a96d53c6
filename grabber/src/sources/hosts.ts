import type { Source } from './source.js';
import { listTemplates } from './source.js';

/**
 * Replaces the variables of an address. None can stand in its host, so that a value cannot choose
 * the host.
 */
function withoutVariables(template: string): URL {
  return new URL(template.replace(/\{[^}]*\}/g, '0'));
}

export function hostOfTemplate(template: string): string {
  return withoutVariables(template).hostname.toLowerCase();
}

export function originOfTemplate(template: string): string {
  return withoutVariables(template).origin;
}

/** Origins of a host without a scheme: its port if it has one, else those of http and https. */
export function originsOfHost(host: string): string[] {
  return ['http', 'https'].map((scheme) => new URL(`${scheme}://${host}`).origin);
}

/**
 * Hosts that a source may contact, in lower case, without a port unless the source names one;
 * sorted.
 */
export function listHosts(source: Source): string[] {
  return [...new Set([...listAddresses(source).map(hostOfTemplate), ...source.hosts])].sort();
}

/**
 * Origins that may receive the source's secrets: those of its own addresses, not all permitted
 * hosts.
 */
export function listSecretOrigins(source: Source): string[] {
  return [...new Set(listAddresses(source).map(originOfTemplate))].sort();
}

/**
 * Origins that may resolve to private addresses: all that a source names when it allows them, else
 * none.
 */
export function listPrivateOrigins(source: Source): string[] {
  if (!source.allow_private_addresses) return [];
  return [
    ...new Set([...listSecretOrigins(source), ...source.hosts.flatMap(originsOfHost)]),
  ].sort();
}

function listAddresses(source: Source): string[] {
  const { access } = source;
  const addresses = [...listTemplates(source)];
  if (access.kind === 'stac') {
    addresses.push(access.items, ...(access.sign === undefined ? [] : [access.sign]));
  }
  if (access.kind === 'wfs') addresses.push(access.url);
  return addresses;
}
