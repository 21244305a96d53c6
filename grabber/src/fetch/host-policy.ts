import { lookup as systemLookup, type LookupAddress, type LookupOptions } from 'node:dns';
import type { LookupFunction } from 'node:net';
import ipaddr from 'ipaddr.js';
import { GrabberError } from '../util/errors.js';
import { shownUrl } from './shown-url.js';

/** Whom one source's requests may talk to. */
export type HostAccess = {
  /** Lower case; "host:port" means this port, "host" alone any port of it. */
  readonly hosts: readonly string[];
  /** Loopback, link-local and private ranges too. */
  readonly allowPrivate: boolean;
};

/** All addresses of a name, as `dns.lookup` with `all` gives them; tests put their own in its place. */
export type Resolve = (
  name: string,
  options: LookupOptions & { all: true },
  done: (error: NodeJS.ErrnoException | null, addresses: LookupAddress[]) => void,
) => void;

/** Ranges that lead into an office or this machine, but to a machine. */
const kPrivateRanges = ['loopback', 'private', 'linkLocal', 'uniqueLocal', 'carrierGradeNat'];

/**
 * Reads an address that a request is about to go to.
 * @throws GrabberError HOST_REFUSED unless it is http(s), without a password, and its host is one of the source's
 */
export function checkUrl(text: string, access: HostAccess): URL {
  const refuse = (what: string, allowed: string): GrabberError =>
    new GrabberError('HOST_REFUSED', `fetch ${shownUrl(text)}: ${what}; allowed: ${allowed}`);
  if (!URL.canParse(text)) throw refuse('no address', 'http(s)://host/path');
  const url = new URL(text);
  if (url.protocol !== 'http:' && url.protocol !== 'https:') throw refuse(`scheme ${url.protocol}`, 'http: or https:');
  if (url.username !== '' || url.password !== '') throw refuse('a user name or password in it', 'secret headers instead');
  checkLiteral(text, url, access, refuse);
  if (!access.hosts.includes(url.host) && !access.hosts.includes(url.hostname)) {
    throw refuse(`host ${url.host} is not one of its source's`, access.hosts.join(', ') || 'none');
  }
  return url;
}

/** A numeric host passes no name service, so it is judged here; one in disguise (decimal, octal, mapped) never passes. */
function checkLiteral(
  text: string,
  url: URL,
  access: HostAccess,
  refuse: (what: string, allowed: string) => GrabberError,
): void {
  const host = url.hostname.replace(/^\[|\]$/g, '');
  if (!ipaddr.isValid(host)) return;
  if (!access.allowPrivate) throw refuse(`numeric host ${url.hostname}`, 'names');
  if (!text.toLowerCase().includes(`//${url.hostname}`)) throw refuse('a disguised numeric host', 'dotted decimal');
  if (ipaddr.process(host).toString() !== ipaddr.parse(host).toString()) throw refuse('IPv4 within IPv6', 'IPv4');
  if (!addressAllowed(host, access)) throw refuse(`address ${host}`, 'addresses of single machines');
}

/** @param address numeric, as the name service gave it */
export function addressAllowed(address: string, access: HostAccess): boolean {
  if (!ipaddr.isValid(address)) return false;
  const range = ipaddr.process(address).range();
  return range === 'unicast' || (access.allowPrivate && kPrivateRanges.includes(range));
}

/**
 * Resolves names at the moment a connection is made, and gives only addresses that may be talked to: a check before
 * that could be passed by a name that resolves differently the second time.
 */
export function policedLookup(access: () => HostAccess, resolve: Resolve = systemLookup): LookupFunction {
  return (name, options, done) => {
    resolve(name, { ...options, all: true }, (error, found) => {
      if (error !== null) return done(error, []);
      const addresses = found.filter(({ address }) => addressAllowed(address, access()));
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
    `connect to ${name}: it leads to ${shown}; allowed: public addresses (allow_private_addresses of its source, --allow-private)`,
  );
}
