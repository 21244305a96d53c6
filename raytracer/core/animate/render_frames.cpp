#include "raytracer/core/animate/render_frames.hpp"

#include <fcntl.h>
#include <signal.h>
#include <sys/file.h>
#include <unistd.h>
#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <span>
#include <sstream>
#include <utility>

#include "common/util/files.hpp"
#include "common/util/numbers.hpp"
#include "common/util/toml_file.hpp"
#include "common/util/version.hpp"
#include "raytracer/core/animate/video.hpp"
#include "raytracer/core/material/appearance.hpp"
#include "raytracer/core/scene/scene_io.hpp"

namespace terravox::animate {
namespace {

/// Appends text in one piece, and has it on the disk on return. Machines that share a folder append
/// one after the other: over NFS, O_APPEND alone may lose one of two simultaneous lines; the lock
/// also refreshes the file's length.
void append(const std::filesystem::path& file, const std::string& text, int frame) {
    const auto fail = [&](const char* what) {
        throw util::Error("note that frame " + std::to_string(frame) + " is done: " +
                          file.string() + " cannot be " + what + ": " + std::strerror(errno));
    };
    const util::Descriptor out(util::open_to_write(file, O_WRONLY | O_CREAT | O_APPEND, 0666,
                                                   "note that frame " + std::to_string(frame) +
                                                       " is done: " + file.string() +
                                                       " cannot be written"));
    while (::flock(out.get(), LOCK_EX) != 0) {
        if (errno == ENOSYS || errno == EOPNOTSUPP || errno == ENOLCK || errno == EINVAL)
            break;  // a file system without locks
        if (errno != EINTR)
            fail("locked");
    }
    errno = util::write_all(out.get(), std::as_bytes(std::span(text)));
    if (errno != 0)
        fail("written");
    if (::fsync(out.get()) != 0 && errno != EINVAL && errno != ENOTSUP)
        fail("written");
}

}  // namespace

FrameLedger::FrameLedger(std::filesystem::path file) : m_file(std::move(file)) {
    constexpr std::size_t kMax_bytes = 64U << 20;  // far more than any animation needs
    std::error_code failed;
    if (!std::filesystem::exists(m_file, failed))
        return;
    std::istringstream in(util::read_text(m_file, kMax_bytes, [&](const std::string& what) {
        throw util::Error("go on with the frames: " + m_file.string() +
                          " is no list of frames: " + what + "; remove it to make all anew");
    }));
    for (std::string line; std::getline(in, line);) {
        int frame = 0;
        std::uint64_t fingerprint = 0;
        const char* end = line.data() + line.size();
        const auto number = std::from_chars(line.data(), end, frame);
        if (number.ec != std::errc{} || number.ptr == end || *number.ptr != ' ')
            continue;
        const auto print = std::from_chars(number.ptr + 1, end, fingerprint, 16);
        // All 16 digits are required: a line that was cut off has fewer.
        if (print.ec == std::errc{} && print.ptr == end && print.ptr - number.ptr == 17)
            m_done[frame] = fingerprint;
    }
}

bool FrameLedger::is_done(int frame, std::uint64_t fingerprint) const {
    const auto found = m_done.find(frame);
    return found != m_done.end() && found->second == fingerprint;
}

void FrameLedger::add(int frame, std::uint64_t fingerprint) {
    std::string digits(16, '0');
    for (std::size_t i = 0; i < 16; ++i)
        digits[15 - i] = "0123456789abcdef"[fingerprint >> (4 * i) & 15];
    std::error_code ignored;
    if (!m_file.parent_path().empty())
        std::filesystem::create_directories(m_file.parent_path(), ignored);
    // Starts a new line, whatever an interrupted run has left.
    append(m_file, "\n" + std::to_string(frame) + " " + digits + "\n", frame);
    m_done[frame] = fingerprint;
}

std::uint64_t to_fingerprint(const std::string& text) noexcept {
    std::uint64_t out = 0xcbf29ce484222325U;
    for (const char c : text)
        out = (out ^ static_cast<unsigned char>(c)) * 0x100000001b3U;
    return out;
}

namespace {

void check(const Animation& animation, const FrameOptions& o, int last) {
    const auto refuse = [&](const char* flag, int value, int least) {
        throw util::UsageError(std::string("render the frames: ") + flag + " = " +
                               std::to_string(value) + "; allowed: " + std::to_string(least) +
                               " to " + std::to_string(animation.frames() - 1));
    };
    if (o.first < 0 || o.first >= animation.frames())
        refuse("first", o.first, 0);
    if (last < o.first || last >= animation.frames())
        refuse("last", last, o.first);
    if (o.every < 1)
        throw util::UsageError("render the frames: every = " + std::to_string(o.every) +
                               "; allowed: 1 and more");
    if (!o.video.empty() && (o.first != 0 || last != animation.frames() - 1 || o.every != 1))
        throw util::UsageError(
            "render the frames: a video is made of all frames; leave out --first, --last and "
            "--every");
}

// A hash of what a picture depends on; the number of threads is not part of it.
std::uint64_t fingerprint(const scene::Scene& scene, const std::string& inputs) {
    const std::filesystem::path file = material::find_materials(scene.quality.materials);
    const std::string materials =
        util::read_text(file, util::kMaxToml_bytes, "read the materials " + file.string());
    return to_fingerprint(scene::to_toml(scene::what_shows(scene)) + "\n" + inputs + "\n" +
                          materials + "\n" + kVersion);
}

bool is_there(const std::filesystem::path& picture) {
    std::error_code failed;
    return std::filesystem::is_regular_file(picture, failed) &&
           std::filesystem::file_size(picture, failed) > 0 && !failed;
}

/// Files that a killed run has left next to its frames: unfinished files of util::AtomicFile,
/// ".NAME.part-PID-..." with the frame's extension. Those of a frame are removed when it has been
/// rendered, except those of a run that is still active.
class Leftovers {
public:
    explicit Leftovers(std::filesystem::path folder) {
        std::error_code failed;
        if (folder.empty())
            folder = ".";
        for (std::filesystem::directory_iterator it(folder, failed), end; !failed && it != end;
             it.increment(failed)) {
            const std::string name = it->path().filename().string();
            const std::size_t part = name.find(".part-");
            if (name.starts_with('.') && part != std::string::npos && part > 1 &&
                !at_work(name.substr(part + 6)))
                m_files.emplace(name.substr(1, part - 1) + it->path().extension().string(),
                                it->path());
        }
    }
    void remove_frame(const std::filesystem::path& picture) const {
        std::error_code ignored;
        const auto [first, last] = m_files.equal_range(picture.filename().string());
        for (auto it = first; it != last; ++it)
            std::filesystem::remove(it->second, ignored);
    }

private:
    /// Whether the process that writes a file is still running.
    /// @param rest what follows ".part-"; nothing is known about other programs' files, so they are
    /// kept
    static bool at_work(const std::string& rest) {
        std::string_view text = rest;
        const auto pid = util::take_number<int>(text);
        if (!pid || *pid <= 0 || !text.starts_with('-'))
            return true;
        return ::kill(*pid, 0) == 0 || errno == EPERM;
    }
    std::multimap<std::string, std::filesystem::path> m_files;  ///< by the name of the frame
};

}  // namespace

util::ExitCode render_frames(const Animation& animation, const scene::Scene& base,
                             const FrameOptions& options, const RenderPicture& render) {
    const FrameNames names(options.pattern);
    const int last = options.last < 0 ? animation.frames() - 1 : options.last;
    check(animation, options, last);
    if (!options.video.empty())
        check_video(options.video, names, options.ffmpeg);
    FrameLedger ledger(names.ledger());
    const Leftovers leftovers(names.ledger().parent_path());
    // Before any is rendered, so that an error in a later frame is reported now.
    std::map<int, std::uint64_t> prints;
    for (int frame = options.first; frame <= last;
         frame += std::min(options.every, last - frame + 1))
        prints[frame] = fingerprint(animation.at(frame, base), options.inputs);
    int made = 0;
    int with_holes = 0;
    int kept = 0;
    for (const auto& [frame, print] : prints) {
        const scene::Scene scene = animation.at(frame, base);
        const std::filesystem::path picture = names.of(frame);
        if (!options.again && ledger.is_done(frame, print) && is_there(picture)) {
            ++kept;
            continue;
        }
        if (options.list) {
            std::printf("%d\n", frame);
            continue;
        }
        if (!options.quiet)
            std::fprintf(stderr, "frame %d of %d: %s\n", frame + 1, animation.frames(),
                         picture.c_str());
        const util::ExitCode code = render(scene, picture);
        leftovers.remove_frame(picture);
        if (code == util::ExitCode::kDone)
            ledger.add(frame, print);
        else if (code == util::ExitCode::kHoles)
            ++with_holes;
        else
            return code;
        ++made;
    }
    if (options.list)
        return util::ExitCode::kDone;
    if (!options.quiet)
        std::fprintf(stderr, "%d frames made, %d were done before\n", made, kept);
    if (with_holes > 0)
        return util::ExitCode::kHoles;
    if (!options.video.empty())
        make_video(options.video, names, animation.frames(), animation.fps(), options.ffmpeg);
    return util::ExitCode::kDone;
}

}  // namespace terravox::animate
