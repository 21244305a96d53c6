/** All texts of the viewer, in all languages. */

/** A text, or one for each form that goes with a number, which is the first value. */
type Entry = string | (Partial<Record<Intl.LDMLPluralRule, string>> & { readonly other: string });

/** Each text in English and in Slovene. */
const kTexts = {
  loading: ['Loading the place', 'Nalagam kraj'],
  refining: [
    { one: 'Refining: {0} column to come', other: 'Refining: {0} columns to come' },
    {
      one: 'Ostrim: manjka še {0} stolpec',
      two: 'Ostrim: manjkata še {0} stolpca',
      few: 'Ostrim: manjkajo še {0} stolpci',
      other: 'Ostrim: manjka še {0} stolpcev',
    },
  ],
  failed: ['The place cannot be shown', 'Kraja ni mogoče prikazati'],
  fromDisk: [
    'opened from a disk, this page may not read its files. Run terravox view FOLDER, ' +
      'or copy the folder to a web host.',
    'z diska odprta stran ne sme brati svojih datotek. Zaženite terravox view MAPA ' +
      'ali kopirajte mapo na spletni strežnik.',
  ],
  tokenRequired: ['The server requires a token', 'Strežnik zahteva žeton'],
  tokenRefused: ['The server does not take this token', 'Strežnik tega žetona ne sprejme'],
  tokenHelp: [
    'It was started with a token file. The token stays in this tab until the tab is closed.',
    'Zagnan je bil z datoteko z žetonom. Žeton ostane v tem zavihku, dokler ga ne zaprete.',
  ],
  token: ['Token', 'Žeton'],
  useToken: ['Use it', 'Uporabi'],
  map: ['Map', 'Zemljevid'],
  serverMaking: [
    'The server makes boxes: {0} now, {1} waiting, {2} made',
    'Strežnik dela škatle: {0} zdaj, {1} čaka, {2} narejenih',
  ],
  serverPrepares: ['prepared {0} of {1}', 'pripravljenih {0} od {1}'],
  serverFailed: [
    '{0} could not be made; its log says why',
    '{0} ni bilo mogoče narediti; razlog je v dnevniku strežnika',
  ],
  serverGone: [
    'The server does not answer. Trying again …',
    'Strežnik ne odgovarja. Poskušam znova …',
  ],
  serverBusy: [
    'The server is too busy. Trying again …',
    'Strežnik je preobremenjen. Poskušam znova …',
  ],
  serverToken: [
    'The server requires another token: load the page again.',
    'Strežnik zahteva drug žeton: naložite stran znova.',
  ],
  help: [
    'Drag to turn, right-drag to orbit, W A S D to fly, E and Q up and down, ' +
      'wheel to come closer; click, or Enter for the middle, for facts.',
    'Vlecite za obračanje, z desno tipko za kroženje, W A S D za letenje, E in Q gor in dol, ' +
      'kolesce za približevanje; kliknite za podatke, Enter jih pokaže za sredino.',
  ],
  date: ['Date', 'Datum'],
  time: ['Time of day', 'Ura'],
  utc: ['UTC', 'UTC'],
  sun: ['Sun: {0}° high, azimuth {1}°', 'Sonce: višina {0}°, azimut {1}°'],
  views: ['Views', 'Pogledi'],
  goTo: ['Go to', 'Pojdi na'],
  goToHint: ['easting, northing or lat, lon', 'E, N ali širina, dolžina'],
  goToFailed: [
    'Write two numbers: easting, northing, or latitude, longitude.',
    'Vpišite dve števili: koordinati E in N ali zemljepisno širino in dolžino.',
  ],
  picture: ['Save picture', 'Shrani sliko'],
  link: ['Copy link', 'Kopiraj povezavo'],
  linkCopied: ['Link copied', 'Povezava kopirana'],
  embed: ['Copy embed code', 'Kopiraj kodo za vdelavo'],
  embedCopied: ['Code copied', 'Koda kopirana'],
  copyFailed: ['Could not copy', 'Kopiranje ni uspelo'],
  ownPage: ['Open in a page of its own', 'Odpri na samostojni strani'],
  close: ['Close', 'Zapri'],
  panel: ['Panel', 'Plošča'],
  hidePanel: ['Hide panel', 'Skrij ploščo'],
  showPanel: ['Show panel', 'Pokaži ploščo'],
  pictureOf: ['Picture of the place: {0}', 'Slika kraja: {0}'],
  place: ['Place', 'Točka'],
  easting: ['Easting', 'Koordinata E'],
  northing: ['Northing', 'Koordinata N'],
  height: ['Height', 'Višina'],
  latLon: ['Latitude, longitude', 'Širina, dolžina'],
  material: ['Material', 'Material'],
  lidarClass: ['LiDAR class', 'Razred LiDAR'],
  square: ['LiDAR square', 'Kvadrat LiDAR'],
  colour: ['Colour', 'Barva'],
  level: ['Voxel', 'Voksel'],
  inSun: ['In the sun', 'Na soncu'],
  inSight: ['Seen by the observer', 'Vidno opazovalcu'],
  yes: ['yes', 'da'],
  no: ['no', 'ne'],
  look: ['Picture', 'Slika'],
  shadows: ['Shadows', 'Sence'],
  textures: ['Textures', 'Teksture'],
  materialColours: ['Colours of materials', 'Barve materialov'],
  tools: ['Tools', 'Orodja'],
  addMiddle: ['Add middle of picture', 'Dodaj sredino slike'],
  addMiddleHint: [
    'Click in the picture, or add the point at its cross.',
    'Kliknite na sliko ali dodajte točko pri križcu.',
  ],
  nothingThere: [
    'There is only sky in the middle of the picture.',
    'Na sredini slike je samo nebo.',
  ],
  tooManyPoints: ['No more than {0} points.', 'Največje število točk je {0}.'],
  undo: ['Undo point', 'Razveljavi točko'],
  clear: ['Clear', 'Počisti'],
  points: ['Points', 'Točke'],
  'tool.measure': ['Measure', 'Merjenje'],
  'measure.slope': ['Slope distance', 'Poševna dolžina'],
  'measure.horizontal': ['Horizontal', 'Vodoravna dolžina'],
  'measure.height': ['Height difference', 'Višinska razlika'],
  'measure.gradient': ['Slope', 'Naklon'],
  'measure.azimuth': ['Azimuth', 'Azimut'],
  'measure.closed': ['Closed: area and perimeter', 'Sklenjeno: ploščina in obseg'],
  'measure.area': ['Horizontal area', 'Vodoravna ploščina'],
  'measure.perimeter': ['Horizontal perimeter', 'Vodoravni obseg'],
  'tool.profile': ['Height profile', 'Višinski profil'],
  'profile.chart': [
    'Height profile; arrow keys move along it',
    'Višinski profil; puščični tipki premikata točko po njem',
  ],
  'profile.at': ['at {0}: {1} high', 'pri {0}: višina {1}'],
  'profile.gap': ['at {0}: nothing there', 'pri {0}: tam ni ničesar'],
  'profile.none': [
    'Nothing has been read along the line yet.',
    'Vzdolž črte še ni prebranih podatkov.',
  ],
  'profile.length': ['Length', 'Dolžina'],
  'profile.lowest': ['Lowest', 'Najnižje'],
  'profile.highest': ['Highest', 'Najvišje'],
  'profile.ascent': ['Up in all', 'Skupni vzpon'],
  'profile.descent': ['Down in all', 'Skupni spust'],
  'profile.exaggeration': ['Heights exaggerated', 'Previšanje'],
  'profile.voxel': ['Coarsest voxel', 'Največji voksel'],
  'profile.csv': ['Download CSV', 'Prenesi CSV'],
  'tool.section': ['Section plane', 'Prerez'],
  'section.kind': ['Plane', 'Ravnina'],
  'section.off': ['None', 'Brez'],
  'section.vertical': ['Vertical', 'Navpična'],
  'section.horizontal': ['Horizontal', 'Vodoravna'],
  'section.azimuth': ['Cuts away towards', 'Odreže v smeri'],
  'section.position': ['Position', 'Položaj'],
  'section.height': ['Height', 'Višina'],
  'section.flip': ['Flip', 'Obrni'],
  'section.middle': ['Through middle of picture', 'Skozi sredino slike'],
  'tool.sight': ['Line of sight', 'Vidnost'],
  'sight.sets': ['A click sets', 'Klik postavi'],
  'sight.observer': ['the observer', 'opazovalca'],
  'sight.target': ['the target', 'cilj'],
  'sight.eye': ['Eye above ground, m', 'Oči nad tlemi, m'],
  'sight.shade': ['Shade what the observer cannot see', 'Osenči, česar opazovalec ne vidi'],
  'sight.distance': ['Distance', 'Razdalja'],
  'sight.clear': ['The observer sees the target.', 'Opazovalec vidi cilj.'],
  'sight.blocked': [
    'The observer does not see the target: something is in the way after {0}.',
    'Opazovalec ne vidi cilja: pogled zastre ovira na razdalji {0}.',
  ],
  'sight.obstacle': ['Obstacle', 'Ovira'],
  'sight.eyeLabel': ['Observer', 'Opazovalec'],
  'sight.targetLabel': ['Target', 'Cilj'],
  'sight.middle': ['Set middle of picture', 'Postavi na sredino slike'],
  'sight.hint': [
    'Click in the picture, or set the point at its cross.',
    'Kliknite na sliko ali postavite točko h križcu.',
  ],
  'tool.layers': ['Layers', 'Sloji'],
  'layer.select': ['Colours show', 'Barve kažejo'],
  'layer.none': ['the true picture', 'pravo sliko'],
  'layer.height': ['heights', 'višine'],
  'layer.material': ['materials', 'materiale'],
  'layer.class': ['LiDAR classes', 'razrede LiDAR'],
  'layer.level': ['sizes of voxels', 'velikosti vokslov'],
  'layer.from': ['From, m', 'Od, m'],
  'layer.to': ['To, m', 'Do, m'],
  'layer.fit': ['Range of the view', 'Razpon pogleda'],
  'layer.legend': ['Legend', 'Legenda'],
  'layer.wrongRange': [
    'The range must begin below its end.',
    'Začetek razpona mora biti pod njegovim koncem.',
  ],
  'tool.sun': ['Sun path', 'Pot sonca'],
  'sun.show': ['Draw the path of the day', 'Nariši pot tega dne'],
  'sun.rise': ['Sunrise', 'Sončni vzhod'],
  'sun.noon': ['Noon', 'Poldne'],
  'sun.set': ['Sunset', 'Sončni zahod'],
  'sun.length': ['Day length', 'Dolžina dneva'],
  'sun.noRise': ['The sun stays below the horizon.', 'Sonce ves dan ostane pod obzorjem.'],
  'sun.noSet': ['The sun stays above the horizon.', 'Sonce ves dan ostane nad obzorjem.'],
  'sun.noonValue': ['{0}, {1}° high', '{0}, višina {1}°'],
  'sun.edgeValue': ['{0}, azimuth {1}°', '{0}, azimut {1}°'],
  'sun.hours': ['{0} h {1} min', '{0} h {1} min'],
  'sun.note': [
    'Upper edge of the sun on a level horizon, refraction at sea level included; times are UTC.',
    'Zgornji rob sonca na ravnem obzorju; upoštevan je lom svetlobe v zraku ' +
      'na višini morske gladine. Časi so UTC.',
  ],
  'sun.turn': ['Turn to the sun', 'Obrni k soncu'],
  'class.0': ['Never classified', 'Nikoli razvrščeno'],
  'class.1': ['Unclassified', 'Nerazvrščeno'],
  'class.2': ['Ground', 'Tla'],
  'class.3': ['Low vegetation', 'Nizko rastje'],
  'class.4': ['Medium vegetation', 'Srednje visoko rastje'],
  'class.5': ['High vegetation', 'Visoko rastje'],
  'class.6': ['Building', 'Stavba'],
  'class.7': ['Low noise', 'Nizki šum'],
  'class.9': ['Water', 'Voda'],
  'class.10': ['Rail', 'Železnica'],
  'class.11': ['Road surface', 'Cestišče'],
  'class.13': ['Wire guard', 'Zaščitna vrv'],
  'class.14': ['Wire conductor', 'Električni vodnik'],
  'class.15': ['Transmission tower', 'Daljnovodni steber'],
  'class.16': ['Wire connector', 'Izolator'],
  'class.17': ['Bridge deck', 'Most'],
  'class.18': ['High noise', 'Visoki šum'],
  'class.-1': ['Other classes', 'Drugi razredi'],
  'class.256': ['No class', 'Brez razreda'],
  'class.other': ['Class {0}', 'Razred {0}'],
  'material.air': ['air', 'zrak'],
  'material.rock': ['rock', 'skala'],
  'material.soil': ['soil', 'prst'],
  'material.ground': ['ground', 'tla'],
  'material.grass': ['grass', 'trava'],
  'material.low_vegetation': ['low vegetation', 'nizko rastje'],
  'material.medium_vegetation': ['medium vegetation', 'srednje visoko rastje'],
  'material.high_vegetation': ['high vegetation', 'visoko rastje'],
  'material.wall': ['wall', 'stena'],
  'material.roof': ['roof', 'streha'],
  'material.orange_roof': ['orange roof', 'oranžna streha'],
  'material.grey_roof': ['grey roof', 'siva streha'],
  'material.flat_roof': ['flat roof', 'ravna streha'],
  'material.water': ['water', 'voda'],
  'material.bridge': ['bridge', 'most'],
  'material.road': ['road', 'cesta'],
  'material.concrete': ['concrete', 'beton'],
  'material.rail': ['rail', 'tir'],
  'material.wire': ['wire', 'žica'],
  'material.tower': ['tower', 'stolp'],
  'material.object': ['object', 'predmet'],
  'material.sand': ['sand', 'pesek'],
  'material.snow': ['snow', 'sneg'],
  'material.unknown': ['unknown', 'neznano'],
  'material.trunk': ['trunk', 'deblo'],
  'material.glass': ['glass', 'steklo'],
  'material.ice': ['ice', 'led'],
  'material.lava': ['lava', 'lava'],
  'material.lamp': ['lamp', 'svetilka'],
  'material.wood': ['wood', 'les'],
  'material.masonry': ['masonry', 'zidovina'],
  'material.plain': ['plain', 'gladko'],
  'material.solar_panel': ['solar panel', 'sončni panel'],
  'trouble.missing': [
    'The host lacks a file of this place. Upload all of its files, or publish the place again.',
    'Na strežniku manjka datoteka tega kraja. Naložite vse datoteke ali kraj znova objavite.',
  ],
  'trouble.refused': [
    'The host does not let this page read the place. Its files must be readable for all.',
    'Strežnik tej strani ne dovoli branja kraja. Datoteke morajo biti berljive za vse.',
  ],
  'trouble.no-range': [
    'The host does not send parts of files, which this page needs. ' +
      'Move the place to a host that answers range requests.',
    'Strežnik ne pošilja delov datotek, ki jih ta stran potrebuje. ' +
      'Prenesite kraj na strežnik, ki podpira zahteve po delih (Range).',
  ],
  'trouble.cors': [
    'The host cannot be reached, or does not let this page read the place. ' +
      'Check the connection; whoever runs the host can allow this page to read.',
    'Strežnik ni dosegljiv ali tej strani ne dovoli branja kraja. ' +
      'Preverite povezavo; dostop lahko dovoli skrbnik strežnika.',
  ],
  'trouble.timeout': [
    'The host does not answer. Check the connection, then load the page again.',
    'Strežnik se ne odziva. Preverite povezavo in stran znova naložite.',
  ],
  'trouble.changed': [
    'The place has been published anew. Load the page again.',
    'Kraj je bil medtem na novo objavljen. Stran znova naložite.',
  ],
  'trouble.damaged': [
    'A part of the place cannot be read. ' +
      'Load the page again; if that does not help, upload or publish the place again.',
    'Dela kraja ni mogoče prebrati. Stran znova naložite; ' +
      'če to ne pomaga, kraj znova prenesite na strežnik ali objavite.',
  ],
  'trouble.too-large': [
    'A part of the place is too large for a browser.',
    'Del kraja je prevelik za brskalnik.',
  ],
  'trouble.server': [
    'The host has a fault, or too much to do. Load the page again later.',
    'Na strežniku je prišlo do napake ali pa je preobremenjen. Stran pozneje znova naložite.',
  ],
} as const satisfies Readonly<Record<string, readonly [en: Entry, sl: Entry]>>;

export type TextKey = keyof typeof kTexts;

export const kLanguages = ['en', 'sl'] as const;
export type Language = (typeof kLanguages)[number];
export const kTextKeys = Object.keys(kTexts) as readonly TextKey[];

/** A text in the language of the page. */
export type Say = (key: TextKey, ...values: readonly string[]) => string;

/** @param wanted language tags, most wanted first, as of navigator.languages */
export function chooseLanguage(wanted: readonly string[]): Language {
  for (const tag of wanted) {
    const language = kLanguages.find((known) => known === tag.slice(0, 2).toLowerCase());
    if (language !== undefined) return language;
  }
  return 'en';
}

/** @param values for {0}, {1} ...; the first one chooses the form where a text has several */
export function text(language: Language, key: TextKey, ...values: readonly string[]): string {
  const entry: Entry = kTexts[key][kLanguages.indexOf(language)]!;
  return chosen(language, entry, values[0]).replace(
    /\{(\d)\}/g,
    (_, i: string) => values[Number(i)] ?? '',
  );
}

function chosen(language: Language, entry: Entry, count: string | undefined): string {
  if (typeof entry === 'string') return entry;
  const form = new Intl.PluralRules(language).select(Number(count));
  return entry[form] ?? entry.other;
}

/** The name of a material of config/materials.toml; of others the name that the place gives. */
export function materialName(say: Say, name: string): string {
  const key = `material.${name}` as TextKey;
  return kTextKeys.includes(key) ? say(key) : name.replaceAll('_', ' ');
}

/** The name of a LiDAR class by its ASPRS number. */
export function className(say: Say, number: number): string {
  const key = `class.${number}` as TextKey;
  return kTextKeys.includes(key) ? say(key) : say('class.other', String(number));
}
