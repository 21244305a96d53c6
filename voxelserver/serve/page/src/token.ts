import { element } from './dom.js';
import type { TokenStore } from './http/api.js';

/** The token of a voxel server: where the tab keeps it, and how its user is asked for it. */

/** Where the browser keeps nothing for pages, the token is known to this one alone. */
export const tokenStore = openStore();

function openStore(): TokenStore {
  try {
    return sessionStorage;
  } catch {
    // The user's settings forbid it.
    const kept = new Map<string, string>();
    return {
      getItem: (name) => kept.get(name) ?? null,
      setItem: (name, value) => void kept.set(name, value),
      removeItem: (name) => void kept.delete(name),
    };
  }
}

export type TokenTexts = Readonly<Record<'title' | 'help' | 'label' | 'use', string>>;

/** Without a token there is nothing behind the dialog: it stays until there is one. */
export function askForToken({ title, help, label, use }: TokenTexts): Promise<string> {
  const id = 'token-text';
  const field = element('input', { id, type: 'password', autocomplete: 'off', required: '' });
  const form = element(
    'form',
    { method: 'dialog' },
    element('h2', { id: 'token-title' }, title),
    element('p', {}, help),
    element('label', {}, label, ' ', field),
    ' ',
    element('button', {}, use),
  );
  const dialog = element('dialog', { id: 'token', 'aria-labelledby': 'token-title' }, form);
  document.body.append(dialog);
  dialog.showModal();
  dialog.addEventListener('cancel', (event) => event.preventDefault());
  return new Promise((resolve) => {
    form.addEventListener('submit', (event) => {
      event.preventDefault();
      dialog.remove();
      resolve(field.value.trim());
    });
  });
}
