/** Numbers as people read them, in the language of the page: measures with sensible digits. */
import type { Language } from './texts.js';

export type NumberText = {
  number(value: number, decimals: number): string;
  /** Metres with the digits that voxels of this size justify, kilometres from 10 km on. */
  length(metres: number): string;
  area(squareMetres: number): string;
};

const kKilometreFrom = 10_000;
const kHectareFrom = 10_000;
const kSquareKilometreFrom = 1e6;

/** @param voxelM edge of the finest voxels */
export function numberText(language: Language, voxelM: number): NumberText {
  const formats = new Map<number, Intl.NumberFormat>();
  const number = (value: number, decimals: number): string => {
    let format = formats.get(decimals);
    if (format === undefined) {
      format = new Intl.NumberFormat(language, {
        minimumFractionDigits: decimals,
        maximumFractionDigits: decimals,
        useGrouping: false,
      });
      formats.set(decimals, format);
    }
    // What rounds to zero has no sign.
    return format.format(Number(value.toFixed(decimals)) === 0 ? 0 : value);
  };
  const decimals = lengthDecimals(voxelM);
  return {
    number,
    length: (metres) =>
      Math.abs(metres) >= kKilometreFrom
        ? `${number(metres / 1000, 3)} km`
        : `${number(metres, decimals)} m`,
    area: (m2) => {
      if (m2 >= kSquareKilometreFrom) return `${number(m2 / 1e6, 3)} km²`;
      if (m2 >= kHectareFrom) return `${number(m2 / 1e4, 2)} ha`;
      return `${number(m2, m2 < 100 ? decimals : 0)} m²`;
    },
  };
}

/** Decimals of metres that voxels of this size justify, 0 to 3. */
export function lengthDecimals(voxelM: number): number {
  return Math.min(3, Math.max(0, Math.round(-Math.log10(voxelM) + 0.5)));
}
