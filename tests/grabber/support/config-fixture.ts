import { mkdir, writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import type { TestContext } from 'node:test';
import { temporaryFolder } from './store-fixture.js';

/**
 * A source "here" of LiDAR squares, served by this machine.
 * @param access lines of its [access]
 */
export function sourceHere(access: string, missingStatus = 403): string {
  return `id = "here"
title = "Here"
licence = "CC BY 4.0"
attribution = "Us"
crs = "EPSG:3794"
square_m = 1000
extent_m = [400000, 50000, 500000, 150000]
class_table = "asprs"
max_concurrent = 2
missing_status = [${missingStatus}]
allow_private_addresses = true

[access]
${access}
`;
}

/** Squares at an address each. */
export function templateAccess(base: string): string {
  return `kind = "template"\nurls = ["${base}/TM_{E}_{N}.laz"]`;
}

/** A configuration with that source alone. */
export async function configFolder(t: TestContext, access: string): Promise<string> {
  const folder = await temporaryFolder(t);
  await mkdir(join(folder, 'sources'));
  await writeFile(join(folder, 'sources', 'here.toml'), sourceHere(access));
  return folder;
}
