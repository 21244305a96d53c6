/**
 * Names of the LiDAR squares of a place, for whoever asks what is at a point. The list is fetched
 * with the first question.
 */
import { readSquares, squareContains, type Position, type Square } from '../../squares.js';

export class SquareNames {
  readonly #fetchList: (() => Promise<unknown>) | undefined;
  #list: Promise<readonly Square[]> | undefined;

  /** @param fetchList undefined: the place has none, or nobody knows them */
  constructor(fetchList: (() => Promise<unknown>) | undefined) {
    this.#fetchList = fetchList;
  }

  /**
   * @param at easting and northing in units of the CRS
   * @return '' for no square
   * @throws Error where the list cannot be read; the next question tries again
   */
  async at(at: Position): Promise<string> {
    const fetchList = this.#fetchList;
    if (fetchList === undefined) return '';
    this.#list ??= fetchList().then(readSquares);
    try {
      const list = await this.#list;
      return list.find((square) => squareContains(square, at))?.name ?? '';
    } catch (error) {
      this.#list = undefined;
      throw error;
    }
  }
}
