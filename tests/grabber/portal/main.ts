import { parseArgs } from 'node:util';
import { parseFaults } from './faults.js';
import { startPortal } from './portal.js';

/**
 * Serves a folder of squares as an open-data portal until SIGTERM or SIGINT. Prints its address as
 * one line.
 *   node dist-test/tests/grabber/portal/main.js --root DIR [--port N] [--faults transient=0.1]
 *     [--seed N] [--rate BYTES_PER_S] [--crs EPSG:3794]
 */
const { values } = parseArgs({
  options: {
    root: { type: 'string' },
    port: { type: 'string', default: '0' },
    faults: { type: 'string', default: '' },
    seed: { type: 'string', default: '1' },
    rate: { type: 'string' },
    crs: { type: 'string', default: 'EPSG:3794' },
  },
});
if (values.root === undefined) {
  throw new Error('start portal: --root is missing; allowed: a folder of files');
}

const portal = await startPortal({
  root: values.root,
  port: Number(values.port),
  faults: parseFaults(values.faults),
  seed: Number(values.seed),
  crs: values.crs,
  ...(values.rate === undefined ? {} : { rate_bytes_per_s: Number(values.rate) }),
});
for (const signal of ['SIGTERM', 'SIGINT'] as const) {
  process.once(signal, () => void portal.close());
}
process.stdout.write(`${portal.base}\n`);
