/**
 * The token of a voxel server: asked for where the server requires one, kept in the tab under the
 * name that the server's map uses too, and sent to the page's own origin alone.
 */
import { kTokenKey, type TokenStore } from '../../http/api.js';
import { send, type Http, type Reply } from '../../http/http.js';
import { element, setText } from '../../dom.js';
import type { Place } from '../data/protocol.js';
import type { Say } from './texts.js';

/** What a header can hold. */
const kTokenText = /^[\x21-\x7e]+$/;

/** Where the browser keeps nothing for pages, the token is known to this one alone. */
const kept = new Map<string, string>();
export const tokenStore: TokenStore = {
  getItem: (name) => storage()?.getItem(name) ?? kept.get(name) ?? null,
  setItem: (name, value) => {
    kept.set(name, value);
    storage()?.setItem(name, value);
  },
  removeItem: (name) => {
    kept.delete(name);
    storage()?.removeItem(name);
  },
};

function storage(): Storage | undefined {
  try {
    return sessionStorage;
  } catch {
    return undefined; // The user's settings forbid it.
  }
}

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
    tokenStore.setItem(kTokenKey, await askForToken(say, token !== null));
  }
}

const wantsToken = (headers: Headers): boolean =>
  /^bearer\b/i.test(headers.get('WWW-Authenticate') ?? '');

/** @param wasRefused whether a token was tried already */
function askForToken(say: Say, wasRefused: boolean): Promise<string> {
  const field = element('input', { type: 'password', autocomplete: 'off', required: '' });
  const title = element('h2', { id: 'token-title' });
  setText(title, say(wasRefused ? 'tokenRefused' : 'tokenRequired'));
  const form = element(
    'form',
    { method: 'dialog' },
    title,
    element('p', {}, say('tokenHelp')),
    element('label', {}, say('token'), field),
    element('button', {}, say('useToken')),
  );
  const dialog = element('dialog', { id: 'token', 'aria-labelledby': 'token-title' }, form);
  document.body.append(dialog);
  dialog.showModal();
  // Without a token there is nothing behind the dialog.
  dialog.addEventListener('cancel', (event) => event.preventDefault());
  return new Promise((resolve) => {
    form.addEventListener('submit', (event) => {
      event.preventDefault();
      dialog.remove();
      resolve(field.value.trim());
    });
  });
}
