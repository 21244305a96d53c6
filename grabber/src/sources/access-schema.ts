import { z } from 'zod';

/** What the fields of [access] may hold; also the text of the error when they do not. */
export const kAccessAllowed = {
  access: 'a table [access] with kind = "template", "stac" or "wfs" and the fields of that kind',
  'access.kind':
    '"template" (an address per square), "stac" (STAC API) or "wfs" (OGC Web Feature Service)',
  'access.urls':
    'http(s) addresses, best first, with {E} and {N} (kilometres), {x} and {y} (metres) or ' +
    '{name}, and the names under [access.variables]',
  'access.variables':
    'tables [access.variables.<name>] with about, pattern (regular expression), allowed ' +
    '(text), and value or values',
  'access.items': 'http(s) address of the items of a STAC collection, .../collections/<id>/items',
  'access.page_size': 'an integer from 1 to 10000, items a reply',
  'access.assets':
    'tables [[access.assets]], best first, with key, href or media_type (regular ' +
    'expressions) and, for archives, member',
  'access.sign': 'http(s) address with {href}, that answers {"href": ...} for it',
  'access.url': 'http(s) address of the service, without parameters',
  'access.type': 'name of a feature type, such as namespace:layer',
  'access.crs': 'EPSG:<number>, the CRS of the layer, where it is not that of the source',
  'access.axes': '"en" or "ne", the order of coordinates in BBOX and replies',
  'access.url_field': 'field that holds the address; or else urls',
  'access.name_field': 'field that holds the name',
  'access.name_pattern':
    'regular expression with the groups (?<E>) and (?<N>) in kilometres or (?<x>) and ' +
    '(?<y>) in metres',
  'access.name_corner': '"sw" or "nw", the corner that names refer to',
  'access.block_field': 'field that holds the part of the survey',
  'access.block_pattern': 'regular expression with the group (?<block>)',
  'access.edition_field': 'field that shows which of two features of a square is newer',
  'access.published_field': 'field that holds the date of the survey',
} as const;

const regExp = z.string().min(1).max(500).refine(isRegExp);
const webAddress = z.string().refine((text) => /^https?:\/\//i.test(text) && URL.canParse(text));
const field = z.string().min(1).max(100);

const variableSchema = z
  .strictObject({
    about: z.string().min(1).max(200),
    pattern: regExp,
    allowed: z.string().min(1).max(300),
    /** The value unless the user gives another. */
    value: z.string().min(1).optional(),
    /** All possible values: when the user gives none, each is tried until the square is found. */
    values: z.array(z.string().min(1)).min(1).max(200).optional(),
  })
  .refine(({ value, values }) => value === undefined || values === undefined)
  .refine(({ pattern, value, values }) => {
    const all = [...(values ?? []), ...(value === undefined ? [] : [value])];
    return !isRegExp(pattern) || all.every((one) => matches(pattern, one));
  });

const variables = z.record(z.string().regex(/^[a-z][a-z0-9_]*$/), variableSchema).default({});
const naming = {
  name_pattern: regExp.refine(hasCorner).optional(),
  name_corner: z.enum(['sw', 'nw']).default('sw'),
};

const templateAccess = z.strictObject({
  kind: z.literal('template'),
  urls: z.array(z.string()).min(1).max(10),
  variables,
});

const assetSchema = z
  .strictObject({
    key: regExp.optional(),
    href: regExp.optional(),
    media_type: regExp.optional(),
    member: z.string().min(1).optional(),
  })
  .refine(
    ({ key, href, media_type }) =>
      key !== undefined || href !== undefined || media_type !== undefined,
  );

const stacAccess = z.strictObject({
  kind: z.literal('stac'),
  items: webAddress,
  page_size: z.int().min(1).max(10_000).default(100),
  assets: z.array(assetSchema).min(1).max(10),
  sign: webAddress.refine((text) => text.includes('{href}')).optional(),
  ...naming,
});

const wfsAccess = z
  .strictObject({
    kind: z.literal('wfs'),
    url: webAddress.refine((text) => !text.includes('?')),
    type: field,
    crs: z
      .string()
      .regex(/^EPSG:\d{4,6}$/)
      .optional(),
    axes: z.enum(['en', 'ne']).default('en'),
    page_size: z.int().min(1).max(10_000).default(1000),
    url_field: field.optional(),
    urls: z.array(z.string()).min(1).max(10).optional(),
    variables,
    name_field: field,
    block_field: field.optional(),
    block_pattern: regExp.refine((text) => text.includes('(?<block>')).optional(),
    edition_field: field.optional(),
    published_field: field.optional(),
    ...naming,
  })
  .superRefine((access, context) => {
    if ((access.url_field === undefined) === (access.urls === undefined)) {
      context.addIssue({
        code: 'custom',
        path: ['url_field'],
        message: 'both url_field and urls, or neither',
      });
    }
    if (access.name_pattern === undefined) {
      context.addIssue({ code: 'custom', path: ['name_pattern'] });
    }
  });

export const accessSchema = z.discriminatedUnion('kind', [templateAccess, stacAccess, wfsAccess]);

export type Access = z.infer<typeof accessSchema>;
export type StacAccess = z.infer<typeof stacAccess>;
export type WfsAccess = z.infer<typeof wfsAccess>;
export type AssetChoice = z.infer<typeof assetSchema>;
export type SourceVariable = z.infer<typeof variableSchema>;
export type SourceVariables = Readonly<Record<string, SourceVariable>>;

/** Whether the pattern matches all of the text. */
export function matches(pattern: string, text: string): boolean {
  return new RegExp(`^(?:${pattern})$`).test(text);
}

export function isRegExp(pattern: string): boolean {
  try {
    new RegExp(pattern);
    return true;
  } catch {
    return false;
  }
}

function hasCorner(pattern: string): boolean {
  const has = (name: string): boolean => pattern.includes(`(?<${name}>`);
  return (has('E') && has('N')) || (has('x') && has('y'));
}
