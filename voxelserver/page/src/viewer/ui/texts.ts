/** All texts of the viewer, in all languages. */

const kEnglish = {
  loading: 'Loading the place',
  refining: 'Refining: {0} boxes of columns to come',
  failed: 'The place cannot be shown',
  tokenRequired: 'The server requires a token',
  tokenRefused: 'The server does not take this token',
  tokenHelp:
    'It was started with a token file. The token stays in this tab until the tab is closed.',
  token: 'Token',
  useToken: 'Use it',
  map: 'Map',
  serverMaking: 'The server makes boxes: {0} now, {1} waiting, {2} made',
  serverPrepares: 'prepared {0} of {1}',
  serverFailed: '{0} could not be made; its log says why',
  serverGone: 'The server does not answer. Trying again …',
  serverBusy: 'The server is too busy. Trying again …',
  serverToken: 'The server requires another token: load the page again.',
  help:
    'Drag to turn, right-drag to orbit, W A S D to fly, E and Q up and down, ' +
    'wheel to come closer; click for facts.',
  date: 'Date',
  time: 'Time of day',
  utc: 'UTC',
  sun: 'Sun: {0}° high, azimuth {1}°',
  views: 'Views',
  goTo: 'Go to',
  goToHint: 'easting, northing or lat, lon',
  picture: 'Save picture',
  link: 'Copy link',
  linkCopied: 'Link copied',
  close: 'Close',
  place: 'Place',
  easting: 'Easting',
  northing: 'Northing',
  height: 'Height',
  latitude: 'Latitude',
  longitude: 'Longitude',
  material: 'Material',
  colour: 'Colour',
  level: 'Voxel',
  inSun: 'In the sun',
  yes: 'yes',
  no: 'no',
  shadows: 'Shadows',
  textures: 'Textures',
  materialColours: 'Colours of materials',
} as const;

export type TextKey = keyof typeof kEnglish;

const kSlovene: Readonly<Record<TextKey, string>> = {
  loading: 'Nalagam kraj',
  refining: 'Ostrim: še {0} stolpcev',
  failed: 'Kraja ni mogoče prikazati',
  tokenRequired: 'Strežnik zahteva žeton',
  tokenRefused: 'Strežnik tega žetona ne sprejme',
  tokenHelp:
    'Zagnan je bil z datoteko z žetonom. Žeton ostane v tem zavihku, dokler ga ne zaprete.',
  token: 'Žeton',
  useToken: 'Uporabi',
  map: 'Zemljevid',
  serverMaking: 'Strežnik dela škatle: {0} zdaj, {1} čaka, {2} narejenih',
  serverPrepares: 'pripravljenih {0} od {1}',
  serverFailed: '{0} ni bilo mogoče narediti; razlog je v dnevniku strežnika',
  serverGone: 'Strežnik ne odgovarja. Poskušam znova …',
  serverBusy: 'Strežnik je preobremenjen. Poskušam znova …',
  serverToken: 'Strežnik zahteva drug žeton: naložite stran znova.',
  help:
    'Vlecite za obračanje, z desno tipko za kroženje, W A S D za letenje, E ' +
    'in Q gor in dol, kolesce za približevanje; kliknite za podatke.',
  date: 'Datum',
  time: 'Ura',
  utc: 'UTC',
  sun: 'Sonce: višina {0}°, azimut {1}°',
  views: 'Pogledi',
  goTo: 'Pojdi na',
  goToHint: 'easting, northing ali širina, dolžina',
  picture: 'Shrani sliko',
  link: 'Kopiraj povezavo',
  linkCopied: 'Povezava kopirana',
  close: 'Zapri',
  place: 'Točka',
  easting: 'Easting',
  northing: 'Northing',
  height: 'Višina',
  latitude: 'Širina',
  longitude: 'Dolžina',
  material: 'Material',
  colour: 'Barva',
  level: 'Voksel',
  inSun: 'Na soncu',
  yes: 'da',
  no: 'ne',
  shadows: 'Sence',
  textures: 'Teksture',
  materialColours: 'Barve materialov',
};

const kTables = { en: kEnglish, sl: kSlovene } as const;
export type Language = keyof typeof kTables;

/** @param wanted language tags, most wanted first, as of navigator.languages */
export function languageOf(wanted: readonly string[]): Language {
  for (const tag of wanted) {
    const language = tag.slice(0, 2).toLowerCase();
    if (language === 'en' || language === 'sl') return language;
  }
  return 'en';
}

/** @param values for {0}, {1} ... */
export function text(language: Language, key: TextKey, ...values: readonly string[]): string {
  return kTables[language][key].replace(/\{(\d)\}/g, (_, i: string) => values[Number(i)] ?? '');
}
