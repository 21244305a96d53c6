import { z } from 'zod';
import { templateProblem } from './url-template.js';

/** Folder names in the store, so no dots, slashes or capitals. */
export const kSourceId = /^[a-z0-9][a-z0-9-]{0,39}$/;
export const kSourceIdAllowed = 'lower-case letters, digits and "-", at most 40, such as si-lss';

/** What each field of a source file may hold; also the text of the error when it does not. */
export const kAllowed = {
  id: `${kSourceIdAllowed}, the same as the file name`,
  title: 'text of 1 to 200 characters',
  licence: 'text of 1 to 200 characters',
  attribution: 'text of 1 to 200 characters',
  crs: 'EPSG:<number>, such as EPSG:3794',
  square_m: 'a multiple of 1000 from 1000 to 100000, metres',
  extent_m: '[west, south, east, north] in metres with west < east and south < north',
  class_table: 'lower-case letters, digits and "-", the name of a file in config/classes',
  url: 'http(s) address with {E} and {N} (kilometres), {x} and {y} (metres) or {name}, and the names under [variables]',
  max_concurrent: 'an integer from 1 to 32, requests at a time',
  missing_status: 'a list of HTTP statuses from 400 to 499',
  variables: 'tables [variables.<name>] with about, pattern (regular expression) and allowed (text)',
} as const;

const text = z.string().min(1).max(200);

const variableSchema = z.strictObject({
  about: text,
  pattern: z.string().refine(isRegExp),
  allowed: text,
});

export const sourceSchema = z
  .strictObject({
    id: z.string().regex(kSourceId),
    title: text,
    licence: text,
    attribution: text,
    crs: z.string().regex(/^EPSG:\d{4,6}$/),
    square_m: z.int().min(1000).max(100_000).multipleOf(1000),
    extent_m: z
      .tuple([z.number(), z.number(), z.number(), z.number()])
      .refine(([west, south, east, north]) => west < east && south < north),
    class_table: z.string().regex(kSourceId),
    url: z.string(),
    max_concurrent: z.int().min(1).max(32),
    missing_status: z.array(z.int().min(400).max(499)),
    variables: z.record(z.string().regex(/^[a-z][a-z0-9_]*$/), variableSchema).default({}),
  })
  .superRefine((source, context) => {
    const problem = templateProblem(source.url, Object.keys(source.variables));
    if (problem !== undefined) context.addIssue({ code: 'custom', path: ['url'], message: problem });
  });

/** One open-data portal whose files have an address per square. */
export type Source = z.infer<typeof sourceSchema>;
export type SourceVariable = z.infer<typeof variableSchema>;

function isRegExp(pattern: string): boolean {
  try {
    new RegExp(pattern);
    return true;
  } catch {
    return false;
  }
}
