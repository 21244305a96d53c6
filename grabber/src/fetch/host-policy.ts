import { lookup as systemLookup, type LookupAddress, type LookupOptions } from 'node:dns';
import type { LookupFunction } from 'node:net';
import ipaddr from 'ipaddr.js';
import { buildConnector } from 'undici';
import { GrabberError } from '../util/errors.js';
import { shownUrl } from './redact.js';

/** The hosts that the requests of one source may contact. */
export type HostAccess = {
  /** Lower case; "host:port" means this port, "host" alone any port of it. */
  readonly hosts: readonly string[];
  /**
   * Origins, as URL.origin writes them, that may resolve to loopback, link-local and private
   * ranges: those that the user has named. Another port of the same machine is another service,
   * which is not permitted.
   */
  readonly privateOrigins: readonly string[];
};

/**
 * All addresses of a name, as `dns.lookup` with `all` gives them; tests replace it.
 */
export type Resolve = (
  name: string,
  options: LookupOptions & { all: true },
  done: (error: NodeJS.ErrnoException | null, addresses: LookupAddress[]) => void,
) => void;

/** Ranges of single machines (no multicast, for example) in a private network or on this host. */
const kPrivateRanges = ['loopback', 'private', 'linkLocal', 'uniqueLocal', 'carrierGradeNat'];

/**
 * Reads an address that a request is about to go to.
 * @throws GrabberError HOST_REFUSED unless it is http(s), without a password, and its host is one
 *   of the source's
 */
export function checkUrl(text: string, access: HostAccess): URL {
  const refuse = (what: string, allowed: string): GrabberError =>
    new GrabberError('HOST_REFUSED', `fetch ${shownUrl(text)}: ${what}; allowed: ${allowed}`);
  if (!URL.canParse(text)) throw refuse('no address', 'http(s)://host/path');
  const url = new URL(text);
  if (url.protocol !== 'http:' && url.protocol !== 'https:') {
    throw refuse(`scheme ${url.protocol}`, 'http: or https:');
  }
  if (url.username !== '' || url.password !== '') {
    throw refuse('a user name or password in it', 'secret headers instead');
  }
  checkLiteral(text, url, access, refuse);
  if (!isListed(url, access.hosts)) {
    throw refuse(`host ${url.host} is not one of its source's`, access.hosts.join(', ') || 'none');
  }
  return url;
}

/** @param hosts as in HostAccess */
export function isListed(url: URL, hosts: readonly string[]): boolean {
  return hosts.includes(url.host) || hosts.includes(url.hostname);
}

/**
 * Checks a numeric host, which the name service never sees. A disguised one (decimal, octal,
 * mapped) is always refused.
 */
function checkLiteral(
  text: string,
  url: URL,
  access: HostAccess,
  refuse: (what: string, allowed: string) => GrabberError,
): void {
  const host = url.hostname.replace(/^\[|\]$/g, '');
  if (!ipaddr.isValid(host)) return;
  const allowPrivate = access.privateOrigins.includes(url.origin);
  if (!allowPrivate) {
    throw refuse(`numeric host ${url.host}`, ['names', ...access.privateOrigins].join(', '));
  }
  if (!text.toLowerCase().includes(`//${url.hostname}`)) {
    throw refuse('a disguised numeric host', 'dotted decimal');
  }
  if (ipaddr.process(host).toString() !== ipaddr.parse(host).toString()) {
    throw refuse('IPv4 within IPv6', 'IPv4');
  }
  if (!addressAllowed(host, allowPrivate)) {
    throw refuse(`address ${host}`, 'addresses of single machines');
  }
}

/**
 * @param address      numeric, as the name service gave it
 * @param allowPrivate whether loopback, link-local and private ranges are allowed, too
 */
export function addressAllowed(address: string, allowPrivate: boolean): boolean {
  if (!ipaddr.isValid(address)) return false;
  const range = ipaddr.process(address).range();
  return range === 'unicast' || (allowPrivate && kPrivateRanges.includes(range));
}

/** Connects to public addresses, and for the private origins of the access also to private ones. */
export function policedConnector(
  access: () => HostAccess,
  timeout_ms: number,
  resolve: Resolve = systemLookup,
): buildConnector.connector {
  const connectPublic = buildConnector({
    timeout: timeout_ms,
    lookup: policedLookup(false, resolve),
  });
  const connectAny = buildConnector({ timeout: timeout_ms, lookup: policedLookup(true, resolve) });
  return (options, done) => {
    const { origin } = new URL(`${options.protocol}//${options.host ?? options.hostname}`);
    const connect = access().privateOrigins.includes(origin) ? connectAny : connectPublic;
    connect(options, done);
  };
}

/**
 * Resolves names at the moment a connection is made, and returns permitted addresses only: a name
 * could pass an earlier check and resolve differently the second time (DNS rebinding).
 */
export function policedLookup(allowPrivate: boolean, resolve: Resolve): LookupFunction {
  return (name, options, done) => {
    resolve(name, { ...options, all: true }, (error, found) => {
      if (error !== null) return done(error, []);
      const addresses = found.filter(({ address }) => addressAllowed(address, allowPrivate));
      const [first] = addresses;
      if (first === undefined) return done(refusedName(name, found), []);
      if (options.all === true) done(null, addresses);
      else done(null, first.address, first.family);
    });
  };
}

function refusedName(name: string, found: readonly LookupAddress[]): NodeJS.ErrnoException {
  const shown = found.map(({ address }) => address).join(', ') || 'nowhere';
  return new GrabberError(
    'HOST_REFUSED',
    `connect to ${name}: it leads to ${shown}; allowed: public addresses, and others for ` +
      'the addresses that a source ' +
      'with allow_private_addresses names, or that --allow-private was given for',
  );
}
