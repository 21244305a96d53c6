import { browserEnvironment } from '../../http/environment.js';
import type { FromWorker, ToWorker } from './protocol.js';
import { Session } from './session.js';

/** Entry of the worker that reads boxes: a Session behind its messages (protocol.ts). */

// The types of workers exclude those of pages, and the project is checked with the latter.
type WorkerScope = {
  postMessage(message: FromWorker, transfer: ArrayBuffer[]): void;
  onmessage: ((event: MessageEvent<ToWorker>) => void) | null;
  readonly location: { readonly href: string };
};

const scope = self as unknown as WorkerScope;
const session = new Session(
  (message, transfer) => scope.postMessage(message, transfer),
  browserEnvironment(),
  scope.location.href,
);
scope.onmessage = (event) => session.handle(event.data);
