/** Where programs of GDAL find their tables when they are not installed where they were built for. */
const kData = ['GDAL_DATA', 'PROJ_DATA', 'PROJ_LIB'] as const;

/**
 * The environment of programs outside this one, which read what strangers made: nothing of ours goes in, no tokens, no
 * proxies, no library paths.
 * @param home a folder where it may write what it likes
 */
export function programEnvironment(home: string): Record<string, string> {
  const path = process.env['PATH'] ?? '/usr/local/bin:/usr/bin:/bin';
  const data = kData.flatMap((name) => (process.env[name] === undefined ? [] : [[name, process.env[name]] as const]));
  return { PATH: path, HOME: home, TMPDIR: home, LANG: 'C.UTF-8', LC_ALL: 'C.UTF-8', ...Object.fromEntries(data) };
}
