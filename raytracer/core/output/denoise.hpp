#pragma once

#include "raytracer/core/output/film.hpp"

namespace terravox::output {

/// Checks that denoising is possible; to be called before any work is done.
/// @throws UsageError where Open Image Denoise cannot be loaded
void check_can_denoise();

/// Denoises the film's colours with Intel Open Image Denoise, guided by albedo and normals, which
/// must be present (the sharper they are, the more detail is kept). Alpha, depth and layers are not
/// changed. The result is the same in each run on a machine, but not to the last bit on CPUs with
/// other vector instructions: it is the only step of a picture with this property.
/// @param threads at least 1
/// @throws UsageError as above; Error when the film has no layers, or the library fails
void denoise(Film& film, int threads);

}  // namespace terravox::output
