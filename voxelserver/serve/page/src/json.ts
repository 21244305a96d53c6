import type { Vec3 } from './vec3.js';

/** JSON of unknown origin, read field by field. */
export type Fields = Readonly<Record<string, unknown>>;

export const isFields = (value: unknown): value is Fields =>
  typeof value === 'object' && value !== null && !Array.isArray(value);
export const isNumber = (value: unknown): value is number =>
  typeof value === 'number' && Number.isFinite(value);

// Where a lack is no mistake: what is missing, or of another type, counts as empty.
export const toText = (value: unknown): string => (typeof value === 'string' ? value : '');
export const toNumber = (value: unknown): number => (isNumber(value) ? value : 0);
export const toList = (value: unknown): readonly unknown[] =>
  Array.isArray(value) ? (value as unknown[]) : [];

export type Numbers<N extends string> = Readonly<Record<N, number>>;

/**
 * @param names in JSON with underscores: limitBytes is limit_bytes
 * @return undefined where there is no such object; what it lacks is 0
 */
export function toNumbers<N extends string>(
  value: unknown,
  names: readonly N[],
): Numbers<N> | undefined {
  if (!isFields(value)) return undefined;
  const inJson = (name: string): string => name.replace(/[A-Z]/g, (c) => `_${c.toLowerCase()}`);
  const found = names.map((name) => [name, toNumber(value[inJson(name)])] as const);
  return Object.fromEntries(found) as Numbers<N>;
}

/** Where a lack is a mistake: `fail` is called with the field and what is wrong with it. */
export class JsonReader {
  readonly #fail: (what: string) => never;

  constructor(fail: (what: string) => never) {
    this.#fail = fail;
  }

  fields(value: unknown, what: string): Fields {
    return isFields(value) ? value : this.#fail(`${what} is no object`);
  }

  /** @param max items */
  list(value: unknown, what: string, max: number): readonly unknown[] {
    if (Array.isArray(value) && value.length <= max) return value;
    return this.#fail(`${what} is no list of at most ${max}`);
  }

  /** @param max characters */
  text(value: unknown, what: string, max: number): string {
    if (typeof value === 'string' && value.length <= max) return value;
    return this.#fail(`${what} is no text of at most ${max}`);
  }

  number(value: unknown, what: string, min: number, max: number): number {
    if (typeof value === 'number' && value >= min && value <= max) return value;
    return this.#fail(`${what} = ${String(value)}; allowed: ${min} to ${max}`);
  }

  whole(value: unknown, what: string, max: number, min = 0): number {
    const v = this.number(value, what, min, max);
    return Number.isInteger(v) ? v : this.#fail(`${what} = ${v} is no whole number`);
  }

  /** @param far the largest component */
  vec3(value: unknown, what: string, far: number): Vec3 {
    const [x, y, z, ...more] = this.list(value, what, 3).map((v) =>
      this.number(v, what, -far, far),
    );
    if (x === undefined || y === undefined || z === undefined || more.length > 0) {
      return this.#fail(`${what} has no 3 numbers`);
    }
    return [x, y, z];
  }
}
