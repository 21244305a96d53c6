#pragma once

#include "raytracer/output/film.hpp"

namespace terravox::output {

/// @throws UsageError where Open Image Denoise cannot be loaded: to be asked before any work is
/// done
void check_can_denoise();

/// Takes the noise out of the film's colours through Intel Open Image Denoise, guided by albedo and
/// normals, which must be there (the sharper they are, the more detail stays). Alpha, depth and
/// layers stay. The result is the same in each run on a machine, but not to the last bit on CPUs
/// with other vector instructions: the one step of a picture of which that is so.
/// @param threads at least 1  @throws UsageError as above; Error when the film has no layers, or
/// the library fails
void denoise(Film& film, int threads);

}  // namespace terravox::output
