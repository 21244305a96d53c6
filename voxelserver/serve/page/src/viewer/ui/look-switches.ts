/** Switches of how the picture is drawn, and their words in the link. */
import { byId } from '../../dom.js';
import { kDefaultLook, type Look } from '../draw/renderer.js';
import type { Words } from './link.js';

/** A switch, its word in the link, and whether it is on at the beginning. */
const kSwitches = [
  { id: 'shadows', word: 'shadows', isOn: true },
  { id: 'textures', word: 'textures', isOn: true },
  { id: 'material-colours', word: 'materials', isOn: false },
] as const;

export function setUpLook(onChange: () => void): void {
  for (const { id } of kSwitches) findInput(id).addEventListener('input', onChange);
}

export function chosenLook(): Look {
  return {
    ...kDefaultLook,
    shadows: findInput('shadows').checked,
    textures: findInput('textures').checked,
    colourMix: findInput('material-colours').checked ? 0 : kDefaultLook.colourMix,
  };
}

export function lookWords(): Words {
  const changed = kSwitches.filter(({ id, isOn }) => findInput(id).checked !== isOn);
  return Object.fromEntries(changed.map(({ word, isOn }) => [word, isOn ? '0' : '1']));
}

export function followLook(words: URLSearchParams): void {
  for (const { id, word, isOn } of kSwitches) {
    const value = words.get(word);
    findInput(id).checked = value === '0' || value === '1' ? value === '1' : isOn;
  }
}

function findInput(id: (typeof kSwitches)[number]['id']): HTMLInputElement {
  return byId(id, HTMLInputElement);
}
