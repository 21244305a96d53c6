import { kStates, type State } from '../model/square.js';

/**
 * How a state is shown in a terminal: a letter, and a colour of the 256-colour palette near the one
 * that QGIS shows.
 */
export type StateSymbol = { readonly letter: string; readonly colour: number };

export const kStateSymbols: Readonly<Record<State, StateSymbol>> = {
  known: { letter: '.', colour: 245 },
  wanted: { letter: 'w', colour: 221 },
  fetching: { letter: 'f', colour: 208 },
  fetched: { letter: 'F', colour: 75 },
  verified: { letter: 'V', colour: 34 },
  converted: { letter: 'C', colour: 22 },
  missing: { letter: 'm', colour: 97 },
  failed: { letter: 'X', colour: 160 },
};

/**
 * Where several squares share a place of a picture, the first of these that is among them is shown:
 * trouble must not vanish.
 */
export const kShownFirst: readonly State[] = [
  'failed',
  'missing',
  'fetching',
  'fetched',
  'wanted',
  'verified',
  'converted',
  'known',
];

export type PictureStyle = { readonly colour: boolean };

const kEscape = '\u001b[';
export const kReset = `${kEscape}0m`;
export const foreground = (colour: number): string => `${kEscape}38;5;${colour}m`;
export const background = (colour: number): string => `${kEscape}48;5;${colour}m`;

/** What the letters or colours mean, of the states that are there. */
export function legend(present: ReadonlySet<State>, { colour }: PictureStyle): string {
  const parts = kStates
    .filter((state) => present.has(state))
    .map((state) => {
      const { letter, colour: number } = kStateSymbols[state];
      return `${colour ? `${foreground(number)}█${kReset}` : letter} ${state}`;
    });
  return parts.join('  ');
}
