// A reporter of node's test runner: writes tests that are skipped to the file that TERRAVOX_SKIPS
// names, for config/setup/test_tools.sh, and shows nothing.
import { appendFileSync } from 'node:fs';
import { basename } from 'node:path';

/** Options of node that show results as ever, and write skipped tests down where that is wanted. */
export const kReporters = [
    '--test-reporter=spec',
    '--test-reporter-destination=stdout',
    ...(process.env.TERRAVOX_SKIPS
        ? [`--test-reporter=${import.meta.url}`, '--test-reporter-destination=stderr']
        : []),
];

/** @param {AsyncIterable<{type: string, data: any}>} events */
// eslint-disable-next-line require-yield
export default async function* skips(events) {
    for await (const { type, data } of events) {
        if (type !== 'test:pass' || data.skip === undefined) continue;
        const reason = typeof data.skip === 'string' ? data.skip : 'without a reason';
        const columns = [basename(data.file ?? '').replace(/\.m?js$/, ''), data.name, reason];
        const line = columns.map((column) => column.replace(/\s+/g, ' ')).join('\t');
        appendFileSync(process.env.TERRAVOX_SKIPS, `${line}\n`);
    }
}
