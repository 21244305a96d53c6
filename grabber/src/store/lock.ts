import { open, readFile } from 'node:fs/promises';
import { hostname } from 'node:os';
import { GrabberError, systemCode } from '../util/errors.js';
import { removeIfThere } from '../util/files.js';

/**
 * Two runs on one store would write to the same files, so a run holds a lock file.
 * A lock whose process has ended on this machine is taken over; one from another machine cannot be judged and stands.
 * @return releases the lock
 */
export async function lockStore(path: string, signal: AbortSignal): Promise<() => Promise<void>> {
  signal.throwIfAborted();
  const own = `${process.pid} ${hostname()}\n`;
  for (let attempt = 0; attempt < 2; ++attempt) {
    try {
      const file = await open(path, 'wx');
      await file.writeFile(own);
      await file.close();
      return () => removeIfThere(path);
    } catch (error) {
      if (systemCode(error) !== 'EEXIST') throw error;
    }
    const holder = await readHolder(path);
    if (holder === undefined) continue;
    if (holder.host !== hostname() || isRunning(holder.pid)) throw lockedError(path, holder);
    await removeIfThere(path);
  }
  throw new GrabberError('STORE_LOCKED', `lock store: ${path} changed hands twice; allowed: one grabber at a time`);
}

type Holder = { readonly pid: number; readonly host: string };

async function readHolder(path: string): Promise<Holder | undefined> {
  try {
    const [pid, host] = (await readFile(path, 'utf8')).trim().split(' ');
    return { pid: Number(pid), host: host ?? '' };
  } catch (error) {
    if (systemCode(error) === 'ENOENT') return undefined;
    throw error;
  }
}

function isRunning(pid: number): boolean {
  if (!Number.isInteger(pid) || pid <= 0) return true;
  try {
    process.kill(pid, 0);
    return true;
  } catch (error) {
    // EPERM: it runs, but belongs to another user.
    return systemCode(error) !== 'ESRCH';
  }
}

function lockedError(path: string, holder: Holder): GrabberError {
  return new GrabberError(
    'STORE_LOCKED',
    `lock store: process ${holder.pid} on ${holder.host} holds ${path}; allowed: one grabber at a time (remove the file if that process is gone)`,
  );
}
