#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <string>

#include "common/util/error.hpp"
#include "raytracer/core/animate/animation.hpp"

namespace terravox::animate {

/// Which frames are done, and of which scenes: a text file with a line for each, so that an
/// interrupted run can continue, and frames whose scene has changed since are rendered anew. Not
/// thread-safe, but several processes, on several machines too, may add to one file: each line is
/// appended under a lock (flock, which network file systems support; one that does not must append
/// whole lines). A reader uses the lines that the file had when it was opened.
class FrameLedger {
public:
    /// Reads the existing lines; lines that cannot be parsed (cut off, damaged) are ignored.
    /// @throws Error when it cannot be read
    explicit FrameLedger(std::filesystem::path file);
    [[nodiscard]] bool is_done(int frame, std::uint64_t fingerprint) const;
    /// Adds a line; it is on the disk when this returns.
    /// @throws Error
    void add(int frame, std::uint64_t fingerprint);

private:
    std::filesystem::path m_file;
    std::map<int, std::uint64_t> m_done;
};

/// A hash of a text. Ref: Fowler, Noll & Vo, FNV-1a, 64 bit.
[[nodiscard]] std::uint64_t to_fingerprint(const std::string& text) noexcept;

/// Renders a scene to a picture, completely or not at all, replacing one that may exist.
/// @return kDone, or kHoles when the picture was written with holes
/// @throws Error, UsageError
using RenderPicture =
    std::function<util::ExitCode(const scene::Scene& scene, const std::filesystem::path& picture)>;

struct FrameOptions {
    std::string pattern;  ///< pattern of the frames' names: see FrameNames
    int first = 0;        ///< first frame
    int last = -1;        ///< last frame, inclusive; -1: the animation's last
    int every = 1;        ///< render only every n-th frame, from `first` on, for a preview
    bool again = false;   ///< render frames again that are done
    /// Writes the numbers of the frames that are still to be rendered to standard output, one per
    /// line, and renders none.
    bool list = false;
    bool quiet = false;
    /// Identifies the input data: frames of other inputs do not count as done.
    std::string inputs;
    std::string video;  ///< video file to make of all frames; empty: none
    std::string ffmpeg = "ffmpeg";
};

/// Renders the frames of an animation, in order. A frame that exists, is done, and was made of the
/// same scene and inputs by the same version of the program is kept, so that an interrupted run can
/// continue; one with holes is tried again.
/// @return kHoles when a frame rendered now has holes (then no video is made)
/// @throws what `render` throws; UsageError before anything is rendered
[[nodiscard]] util::ExitCode render_frames(const Animation& animation, const scene::Scene& base,
                                           const FrameOptions& options,
                                           const RenderPicture& render);

}  // namespace terravox::animate
