import { readFile } from 'node:fs/promises';
import { parse } from 'smol-toml';
import { z } from 'zod';
import { GrabberError, describeError } from '../util/errors.js';

const licencesSchema = z.strictObject({
  licence: z.array(
    z.strictObject({ name: z.string().min(1).max(200), url: z.url({ protocol: /^https?$/ }) }),
  ),
});

/**
 * Where the text of a licence stands, by its name as the sources have it.
 * @param path of licences.toml
 */
export async function loadLicenceAddresses(
  path: string,
  signal: AbortSignal,
): Promise<ReadonlyMap<string, string>> {
  try {
    const { licence } = licencesSchema.parse(
      parse(await readFile(path, { encoding: 'utf8', signal })),
    );
    return new Map(licence.map(({ name, url }) => [name, url]));
  } catch (error) {
    signal.throwIfAborted();
    const why =
      error instanceof z.ZodError
        ? (error.issues[0]?.message ?? 'not valid')
        : describeError(error);
    throw new GrabberError(
      'CONFIG',
      `read licences ${path}: ${why}; allowed: [[licence]] tables with name and url`,
      { cause: error },
    );
  }
}
