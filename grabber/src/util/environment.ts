/** Variables with the data folders of GDAL's programs, for installations that were moved. */
const kData = ['GDAL_DATA', 'PROJ_DATA', 'PROJ_LIB'] as const;

/**
 * The environment of external programs, which read untrusted files: no tokens, proxies or library
 * paths are passed on.
 * @param home a folder in which the program may write
 */
export function programEnvironment(home: string): Record<string, string> {
  const path = process.env['PATH'] ?? '/usr/local/bin:/usr/bin:/bin';
  const data = kData.flatMap((name) =>
    process.env[name] === undefined ? [] : [[name, process.env[name]] as const],
  );
  return {
    PATH: path,
    HOME: home,
    TMPDIR: home,
    LANG: 'C.UTF-8',
    LC_ALL: 'C.UTF-8',
    ...Object.fromEntries(data),
  };
}
