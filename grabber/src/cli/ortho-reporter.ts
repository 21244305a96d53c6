import type { RetryNotice } from '../fetch/retry.js';
import type { Made } from '../ortho/make-orthophoto.js';
import { formatBytes, type Output } from './output.js';

export type OrthoTally = {
  readonly made: number;
  readonly kept: number;
  readonly missing: number;
  readonly failed: number;
};

/** Reports the progress of orthophotos, as text or as JSON. */
export type OrthoReporter = {
  would(square: string): void;
  made(square: string, made: Made): void;
  failed(square: string, code: string, message: string): void;
  retry(notice: RetryNotice): void;
  summary(tally: OrthoTally): void;
};

/**
 * @param json  one object a line to standard output; else results there and troubles to standard
 * error
 */
export function orthoReporter(output: Output, json: boolean): OrthoReporter {
  return json ? jsonReporter(output) : textReporter(output);
}

function textReporter(output: Output): OrthoReporter {
  return {
    would: (square) => output.outLine(square),
    made(square, made) {
      if (made.state === 'missing') return output.errLine(`hole: ${made.reason}`);
      const { file, image } = made;
      output.outLine(
        `made ${square}  ${formatBytes(file.bytes)}  ${image.width_px} x ` +
          `${image.height_px} pixels  ${file.path}`,
      );
      for (const warning of made.warnings) output.errLine(`warning: ${square}: ${warning}`);
    },
    failed: (square, code, message) => output.errLine(`error: ${square} ${code}: ${message}`),
    retry: ({ error, retry, wait_ms }) =>
      output.errLine(`retry ${retry} in ${(wait_ms / 1000).toFixed(1)} s: ${error.message}`),
    summary: ({ made, kept, missing, failed }) =>
      output.outLine(`${made} made, ${kept} already there, ${missing} missing, ${failed} failed`),
  };
}

function jsonReporter(output: Output): OrthoReporter {
  const line = (fields: Readonly<Record<string, unknown>>): void =>
    output.outLine(JSON.stringify(fields));
  return {
    would: (square) => line({ event: 'would', square }),
    made: (square, made) => line({ event: 'orthophoto', square, ...made }),
    failed: (square, code, message) =>
      line({ event: 'orthophoto', state: 'failed', square, code, message }),
    retry: ({ error, retry, wait_ms }) =>
      line({ event: 'retry', retry, wait_ms, code: error.code, message: error.message }),
    summary: (tally) => line({ event: 'summary', ...tally }),
  };
}
