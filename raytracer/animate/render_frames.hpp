#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "common/util/error.hpp"
#include "raytracer/animate/animation.hpp"

namespace terravox::animate {

/// Renders a scene to a picture, whole or not at all, over the one that may be there.
/// @return kDone, or kHoles when it was written with holes @throws Error, UsageError
using RenderPicture =
    std::function<util::ExitCode(const scene::Scene& scene, const std::filesystem::path& picture)>;

struct FrameOptions {
    std::string pattern;  ///< of the frames' names: FrameNames
    int first = 0;        ///< frame to begin with
    int last = -1;        ///< last frame, counts too; -1: the animation's
    int every = 1;        ///< only each n-th, from `first` on: for a look at it
    bool again = false;   ///< frames that are done are made once more
    bool list = false;  ///< writes the numbers of the frames that are still to be made to standard
                        ///< output, one a line, and makes none
    bool quiet = false;
    std::string
        inputs;  ///< names what is looked at: frames of something else are not taken for done
    std::string video;  ///< file to make of all frames; empty: none
    std::string ffmpeg = "ffmpeg";
};

/// The frames of an animation, in order. One that is there, done, and of the same scene, inputs and
/// version of the program is left as it is, so that a run that was cut off goes on; one with holes
/// is tried again.
/// @return kHoles when a frame made now has some (then no video is made) @throws what `render`
/// throws; UsageError before anything is rendered
[[nodiscard]] util::ExitCode render_frames(const Animation& animation, const scene::Scene& base,
                                           const FrameOptions& options,
                                           const RenderPicture& render);

}  // namespace terravox::animate
