#include "raytracer/animate/render_frames.hpp"

#include <algorithm>
#include <cstdio>

#include "common/util/version.hpp"
#include "raytracer/animate/frame_ledger.hpp"
#include "raytracer/animate/frame_names.hpp"
#include "raytracer/animate/video.hpp"
#include "raytracer/scene/scene_io.hpp"

namespace terravox {
namespace {

void check(const Animation& animation, const FrameOptions& o, int last) {
    const auto refuse = [&](const char* flag, int value, int least) {
        throw UsageError(std::string("render the frames: ") + flag + " = " + std::to_string(value) + "; allowed: " + std::to_string(least) + " to "
            + std::to_string(animation.frames() - 1));
    };
    if (o.first < 0 || o.first >= animation.frames()) refuse("first", o.first, 0);
    if (last < o.first || last >= animation.frames()) refuse("last", last, o.first);
    if (o.every < 1) throw UsageError("render the frames: every = " + std::to_string(o.every) + "; allowed: 1 and more");
    if (!o.video.empty() && (o.first != 0 || last != animation.frames() - 1 || o.every != 1))
        throw UsageError("render the frames: a video is made of all frames; leave out --first, --last and --every");
}

// What a picture depends on: not how many threads make it.
std::uint64_t fingerprint(const Scene& scene, const std::string& inputs) {
    return fingerprint_of(to_toml(what_shows(scene)) + "\n" + inputs + "\n" + kVersion);
}

bool is_there(const std::filesystem::path& picture) {
    std::error_code failed;
    return std::filesystem::is_regular_file(picture, failed) && std::filesystem::file_size(picture, failed) > 0 && !failed;
}

}  // namespace

ExitCode render_frames(const Animation& animation, const Scene& base, const FrameOptions& options, const RenderPicture& render) {
    const FrameNames names(options.pattern);
    const int last = options.last < 0 ? animation.frames() - 1 : options.last;
    check(animation, options, last);
    if (!options.video.empty()) check_video(options.video, names, options.ffmpeg);
    FrameLedger ledger(names.ledger());
    int made = 0, with_holes = 0, kept = 0;
    for (int frame = options.first; frame <= last; frame += std::min(options.every, last - frame + 1)) {
        const Scene scene = animation.at(frame, base);
        const std::uint64_t print = fingerprint(scene, options.inputs);
        const std::filesystem::path picture = names.of(frame);
        if (!options.again && ledger.is_done(frame, print) && is_there(picture)) {
            ++kept;
            continue;
        }
        if (!options.quiet) std::fprintf(stderr, "frame %d of %d: %s\n", frame + 1, animation.frames(), picture.c_str());
        const ExitCode code = render(scene, picture);
        if (code == ExitCode::kDone) ledger.add(frame, print);
        else if (code == ExitCode::kHoles) ++with_holes;
        else return code;
        ++made;
    }
    if (!options.quiet) std::fprintf(stderr, "%d frames made, %d were done before\n", made, kept);
    if (with_holes > 0) return ExitCode::kHoles;
    if (!options.video.empty()) make_video(options.video, names, animation.frames(), animation.fps(), options.ffmpeg);
    return ExitCode::kDone;
}

}  // namespace terravox
