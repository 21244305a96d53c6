import { GrabberError } from '../util/errors.js';

const kLabels = new Map<string, string>();
const kMaxLabels = 1000;

export type Row = Readonly<Record<string, unknown>>;

/**
 * Reads columns of one row, each with its type: a damaged or foreign row is an error that names it,
 * never a guess.
 */
export class RowReader {
  readonly #row: Row;
  readonly #shown: string;

  /** @param shown names the row in messages, such as "squares si-lss/si-lss/462_101" */
  constructor(row: Row, shown: string) {
    this.#row = row;
    this.#shown = shown;
  }

  text(column: string): string {
    return this.textOrNull(column) ?? this.fail(column, 'text');
  }

  textOrNull(column: string): string | null {
    const value = this.#row[column];
    return value === null || typeof value === 'string' ? value : this.fail(column, 'text');
  }

  /** Reads text that many rows share; all rows refer to one copy. */
  labelOrNull(column: string): string | null {
    const text = this.textOrNull(column);
    if (text === null) return null;
    const known = kLabels.get(text);
    if (known !== undefined) return known;
    if (kLabels.size >= kMaxLabels) kLabels.clear();
    kLabels.set(text, text);
    return text;
  }

  /** From 0 to 2^53 - 1. */
  count(column: string): number {
    return this.countOrNull(column) ?? this.fail(column, 'a count');
  }

  countOrNull(column: string): number | null {
    const value = this.#row[column];
    if (value === null || (Number.isSafeInteger(value) && (value as number) >= 0)) {
      return value as number | null;
    }
    return this.fail(column, 'an integer from 0 to 2^53 - 1');
  }

  number(column: string): number {
    const value = this.#row[column];
    return typeof value === 'number' && Number.isFinite(value)
      ? value
      : this.fail(column, 'a finite number');
  }

  isNull(column: string): boolean {
    return this.#row[column] === null;
  }

  readChoice<T extends string>(column: string, allowed: readonly T[]): T {
    const value = this.#row[column];
    return allowed.find((one) => one === value) ?? this.fail(column, allowed.join(', '));
  }

  matching(column: string, pattern: RegExp, allowed: string): string {
    const value = this.text(column);
    return pattern.test(value) ? value : this.fail(column, allowed);
  }

  /** A JSON list. */
  texts(column: string): string[] {
    const allowed = 'a JSON list of texts';
    let value: unknown;
    try {
      value = JSON.parse(this.text(column));
    } catch (error) {
      if (error instanceof GrabberError) throw error;
      return this.fail(column, allowed);
    }
    if (Array.isArray(value) && value.every((one) => typeof one === 'string')) {
      return value;
    }
    return this.fail(column, allowed);
  }

  fail(column: string, allowed: string): never {
    const shown = shownValue(this.#row[column]).slice(0, 200);
    throw new GrabberError(
      'STORE_DAMAGED',
      `read ${this.#shown}: ${column} is ${shown}; allowed: ${allowed}`,
    );
  }
}

function shownValue(value: unknown): string {
  if (value === undefined) return 'missing';
  return value instanceof Uint8Array ? `${value.length} bytes` : JSON.stringify(value);
}
