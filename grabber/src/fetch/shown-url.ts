/**
 * An address as it may stand in messages: without a password, and with its query hidden where the
 * query looks like a signature or key, which redirects to object stores carry.
 */
export function shownUrl(text: string): string {
  if (!URL.canParse(text)) return text.slice(0, 200);
  const url = new URL(text);
  if (url.username !== '' || url.password !== '') {
    url.username = '';
    url.password = '';
  }
  for (const name of [...url.searchParams.keys()]) {
    if (/sig|token|key|secret|credential|password|auth/i.test(name)) {
      url.searchParams.set(name, '...');
    }
  }
  return url.href;
}
