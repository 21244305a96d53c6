import { httpTargets } from './targets/http-targets.js';
import { lasTargets, zipTarget } from './targets/point-targets.js';
import { geometryTargets, storeTarget, vectorTargets } from './targets/store-targets.js';
import type { Target } from './targets/target.js';
import { capabilitiesTarget, replyTargets, tomlTargets } from './targets/text-targets.js';

export type { Target } from './targets/target.js';

/** All of them; files they need are made here, except those that need GDAL. */
export function allTargets(): Target[] {
  return [
    ...lasTargets(),
    zipTarget(),
    ...geometryTargets(),
    storeTarget(),
    ...httpTargets(),
    ...tomlTargets(),
    ...replyTargets(),
    capabilitiesTarget(),
    ...vectorTargets(),
  ];
}
