import { usage, GrabberError } from '../util/errors.js';
import type { BoundsM } from '../model/store.js';

/**
 * A square of a source's kilometre grid, or a file known only by its name (then without a corner).
 */
export type Square = {
  readonly name: string;
  /** South-west corner, metres in the source's CRS. */
  readonly corner: { readonly east_m: number; readonly north_m: number } | undefined;
};

export type { BoundsM };

/** What is known of the grid; ad-hoc templates have no extent. */
export type Grid = {
  readonly square_m: number;
  readonly extent_m: BoundsM | undefined;
};

/** A typing error must not become a million requests to a portal. */
export const kMaxSquares = 20_000;

const kGridName = /^(-?\d{1,5})_(-?\d{1,5})$/;

export function squareAt(east_m: number, north_m: number): Square {
  return { name: `${east_m / 1000}_${north_m / 1000}`, corner: { east_m, north_m } };
}

/** @param name `E_N`, the south-west corner in kilometres, such as 462_101 */
export function parseSquare(name: string, grid: Grid): Square {
  const match = kGridName.exec(name);
  if (match === null) {
    throw usage(`read square name: "${name}"; allowed: E_N in kilometres, such as 462_101`);
  }
  const square = squareAt(Number(match[1]) * 1000, Number(match[2]) * 1000);
  const { east_m, north_m } = square.corner ?? { east_m: 0, north_m: 0 };
  if (east_m % grid.square_m !== 0 || north_m % grid.square_m !== 0) {
    throw usage(
      `read square name: "${name}"; allowed: multiples of the square size, ` +
        `${grid.square_m / 1000} km`,
    );
  }
  checkExtent(
    `read square name: "${name}"`,
    [east_m, north_m, east_m + grid.square_m, north_m + grid.square_m],
    grid,
  );
  return square;
}

/** Catches degrees, swapped axes and the wrong country before any request is sent. */
function checkExtent(shown: string, box: BoundsM, grid: Grid): void {
  if (grid.extent_m === undefined) return;
  const [west, south, east, north] = grid.extent_m;
  if (box[0] < east && box[2] > west && box[1] < north && box[3] > south) return;
  throw usage(
    `${shown} lies outside the source; allowed: ${west},${south},${east},${north} ` +
      '(west,south,east,north in metres)',
  );
}

/** Values of a source's own placeholders, such as block = b_35. */
export type Variables = Readonly<Record<string, string>>;

/** `{name}` or `{x:06}`: the second pads with zeros to six digits. */
const kPlaceholder = /\{([A-Za-z_][A-Za-z0-9_]*)(?::0(\d))?\}/g;

/** E and N are kilometres, x and y metres, both of the south-west corner; name is `E_N`. */
export const kGridPlaceholders = ['E', 'N', 'x', 'y', 'name'] as const;
export type GridPlaceholder = (typeof kGridPlaceholders)[number];

export function isGridPlaceholder(name: string): name is GridPlaceholder {
  return (kGridPlaceholders as readonly string[]).includes(name);
}

export function listPlaceholders(template: string): string[] {
  return [...new Set([...template.matchAll(kPlaceholder)].map((match) => match[1] ?? ''))];
}

/** @return why the template cannot be used, or undefined when it can */
export function templateProblem(
  template: string,
  variableNames: readonly string[],
): string | undefined {
  const allowed = [...kGridPlaceholders, ...variableNames];
  const unknown = listPlaceholders(template).find((name) => !allowed.includes(name));
  if (unknown !== undefined) {
    return `placeholder {${unknown}}; allowed: ${allowed.map((name) => `{${name}}`).join(' ')}`;
  }
  if (/[{}]/.test(template.replace(kPlaceholder, ''))) {
    return 'a brace that opens or closes no placeholder; allowed: {name} or zero-padded {x:06}';
  }
  const used = listPlaceholders(template);
  const placed =
    used.includes('name') ||
    (used.includes('E') && used.includes('N')) ||
    (used.includes('x') && used.includes('y'));
  if (!placed) {
    return 'no placeholder that differs by square; allowed: {E} and {N}, {x} and {y}, or {name}';
  }
  const sample = template.replace(kPlaceholder, '0');
  if (!URL.canParse(sample) || !['http:', 'https:'].includes(new URL(sample).protocol)) {
    return 'no web address; allowed: http://... or https://...';
  }
  if (/^[a-z]+:\/\/[^/?#]*\{/i.test(template)) {
    return 'a placeholder in the host; allowed: in path and parameters only';
  }
  return undefined;
}

export function expandTemplate(template: string, square: Square, variables: Variables): string {
  return template.replace(kPlaceholder, (_whole, name: string, width: string | undefined) => {
    const value = isGridPlaceholder(name) ? gridValue(name, square) : variables[name];
    if (value === undefined) {
      throw new GrabberError(
        'TEMPLATE',
        `expand url template "${template}" for square ${square.name}: {${name}} has no ` +
          'value; allowed: any text',
      );
    }
    return encodeURIComponent(width === undefined ? value : value.padStart(Number(width), '0'));
  });
}

function gridValue(name: GridPlaceholder, square: Square): string | undefined {
  if (name === 'name') return square.name;
  if (square.corner === undefined) return undefined;
  const { east_m, north_m } = square.corner;
  const values = { E: east_m / 1000, N: north_m / 1000, x: east_m, y: north_m };
  return String(values[name]);
}

/**
 * Reads file names made by the template's last path segment, without their extension.
 * @return a function from a stem such as TM_462_101 to the corner, undefined when it does not fit
 */
export function stemReader(
  template: string,
): (stem: string) => { east_m: number; north_m: number } | undefined {
  const segment = template
    .slice(template.lastIndexOf('/') + 1)
    .replace(/(\.copc)?\.(laz|las|zlas)$/i, '');
  let pattern = '';
  let last = 0;
  const seen = new Set<string>();
  for (const match of segment.matchAll(kPlaceholder)) {
    const name = match[1] ?? '';
    pattern += escapeRegExp(segment.slice(last, match.index)) + groupFor(name, seen);
    last = match.index + match[0].length;
  }
  const whole = new RegExp(`^${pattern}${escapeRegExp(segment.slice(last))}$`, 'i');
  return (stem) => {
    const groups = whole.exec(stem)?.groups;
    if (groups === undefined) return undefined;
    const east_m =
      groups['E'] !== undefined ? Number(groups['E']) * 1000 : Number(groups['x'] ?? NaN);
    const north_m =
      groups['N'] !== undefined ? Number(groups['N']) * 1000 : Number(groups['y'] ?? NaN);
    return Number.isFinite(east_m) && Number.isFinite(north_m) ? { east_m, north_m } : undefined;
  };
}

function groupFor(name: string, seen: Set<string>): string {
  if (name === 'name') return `${groupFor('E', seen)}_${groupFor('N', seen)}`;
  if (!isGridPlaceholder(name)) return '.+?';
  if (seen.has(name)) return `\\k<${name}>`;
  seen.add(name);
  return `(?<${name}>-?\\d+)`;
}

function escapeRegExp(text: string): string {
  return text.replace(/[.*+?^${}()|[\]\\]/g, '\\$&');
}
