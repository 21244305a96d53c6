#include "raytracer/animate/render_frames.hpp"

#include <algorithm>
#include <cstdio>
#include <map>

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

/// What a run that was killed has left beside its frames: unfinished files of util::AtomicFile, ".NAME.part-..." with the frame's ending.
/// Those of a frame go when it has been made; others may be those of another run at work on other frames.
class Leftovers {
public:
    explicit Leftovers(std::filesystem::path folder) {
        std::error_code failed;
        if (folder.empty()) folder = ".";
        for (std::filesystem::directory_iterator it(folder, failed), end; !failed && it != end; it.increment(failed)) {
            const std::string name = it->path().filename().string();
            const std::size_t part = name.find(".part-");
            if (name.starts_with('.') && part != std::string::npos && part > 1)
                m_files.emplace(name.substr(1, part - 1) + it->path().extension().string(), it->path());
        }
    }
    void remove_of(const std::filesystem::path& picture) const {
        std::error_code ignored;
        const auto [first, last] = m_files.equal_range(picture.filename().string());
        for (auto it = first; it != last; ++it) std::filesystem::remove(it->second, ignored);
    }

private:
    std::multimap<std::string, std::filesystem::path> m_files;  ///< by the name of the frame
};

}  // namespace

ExitCode render_frames(const Animation& animation, const Scene& base, const FrameOptions& options, const RenderPicture& render) {
    const FrameNames names(options.pattern);
    const int last = options.last < 0 ? animation.frames() - 1 : options.last;
    check(animation, options, last);
    if (!options.video.empty()) check_video(options.video, names, options.ffmpeg);
    FrameLedger ledger(names.ledger());
    const Leftovers leftovers(names.ledger().parent_path());
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
        leftovers.remove_of(picture);
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
