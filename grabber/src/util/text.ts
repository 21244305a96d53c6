/**
 * Characters by which a text could speak to the terminal or reorder what is next to it, for a class
 * of a regular expression: control characters (C0, DEL, C1), line and paragraph separators,
 * bidirectional marks, embeddings, overrides and isolates. The same as in
 * common/util/text.hpp.
 */
export const kHarmful = '\\p{Cc}\\u2028\\u2029\\u061c\\u200e\\u200f\\u202a-\\u202e\\u2066-\\u2069';

const kInLines = new RegExp(`(?![\\n\\t])[${kHarmful}]`, 'gu');
const kInALine = new RegExp(`(?!\\t)[${kHarmful}]`, 'gu');

/**
 * Makes text of unknown origin safe for a terminal: harmful characters become visible escapes.
 * All have the form \u001b, which means the same in JSON, so that JSON stays valid. Line breaks and
 * tabs are left.
 */
export function printable(text: string): string {
  return text.replace(kInLines, toEscape);
}

/** The same for one line: line breaks become escapes, too. */
export function printableLine(text: string): string {
  return text.replace(kInALine, toEscape);
}

function toEscape(character: string): string {
  return `\\u${character.charCodeAt(0).toString(16).padStart(4, '0')}`;
}

/**
 * Orders texts by their UTF-16 code units, whatever the language of the system.
 * @return below 0 when `a` comes first, above 0 when `b` does, 0 for equal texts
 */
export function compareText(a: string, b: string): number {
  if (a < b) return -1;
  return a > b ? 1 : 0;
}
