/**
 * The token of a voxel server: asked for where the server requires one, kept in the tab under the
 * name that the server's map uses too, and sent to the page's own origin alone.
 */
import { kTokenKey } from '../../http/api.js';
import { send, type Http, type Reply } from '../../http/http.js';
import { askForToken, tokenStore } from '../../token.js';
import type { Place } from '../data/protocol.js';
import type { Say } from './texts.js';

/** What a header can hold. */
const kTokenText = /^[\x21-\x7e]+$/;

/** @throws Error for a server of another origin, which must not get the token */
export function serverPlace(server: string, coarsest: number): Place {
  if (new URL(server).origin !== location.origin) {
    throw new Error('read place.json: a server of another origin; allowed: that of the page');
  }
  const token = tokenStore.getItem(kTokenKey);
  return { server, coarsest, ...(token === null ? {} : { token }) };
}

/**
 * Fetches a file of the page's own host with the token of the tab; asks the user for one until the
 * host takes it.
 */
export async function fetchWithToken(http: Http, url: URL, name: string, say: Say): Promise<Reply> {
  const { signal } = new AbortController();
  for (;;) {
    const token = tokenStore.getItem(kTokenKey);
    const isOwn = url.origin === location.origin;
    const isSent = token !== null && isOwn && kTokenText.test(token);
    const headers: HeadersInit = isSent ? { Authorization: `Bearer ${token}` } : {};
    const reply = await send(http, url.href, name, { headers }, signal);
    if (!isOwn || reply.status !== 401 || !wantsToken(reply.headers)) return reply;
    reply.cancel();
    const texts = {
      title: say(token !== null ? 'tokenRefused' : 'tokenRequired'),
      help: say('tokenHelp'),
      label: say('token'),
      use: say('useToken'),
    };
    tokenStore.setItem(kTokenKey, await askForToken(texts));
  }
}

const wantsToken = (headers: Headers): boolean =>
  /^bearer\b/i.test(headers.get('WWW-Authenticate') ?? '');
