#include "raytracer/core/animate/video.hpp"

#include <algorithm>
#include <string_view>

#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"
#include "common/util/process.hpp"
#include "common/util/text.hpp"

namespace terravox::animate {

FrameNames::FrameNames(std::string pattern) : m_pattern(std::move(pattern)) {
    const auto refuse = [&] {
        throw util::UsageError(
            "name the frames: -o " + m_pattern +
            "; allowed: one %d or %0Nd (N from 1 to 9) in the file's name, such as "
            "frames/%04d.png");
    };
    const std::size_t at = m_pattern.find('%');
    if (at == std::string::npos || m_pattern.find('%', at + 1) != std::string::npos ||
        m_pattern.find('/', at) != std::string::npos)
        refuse();
    std::size_t end = at + 1;
    if (m_pattern.compare(end, 1, "0") == 0) {
        const char digit = end + 1 < m_pattern.size() ? m_pattern[end + 1] : ' ';
        if (digit < '1' || digit > '9')
            refuse();
        m_digits = static_cast<std::size_t>(digit - '0');
        end += 2;
    }
    if (m_pattern.compare(end, 1, "d") != 0)
        refuse();
    m_before = m_pattern.substr(0, at);
    m_after = m_pattern.substr(end + 1);
}

std::filesystem::path FrameNames::of(int frame) const {
    const std::string digits = std::to_string(frame);
    return m_before + std::string(m_digits > digits.size() ? m_digits - digits.size() : 0, '0') +
           digits + m_after;
}

bool FrameNames::matches(const std::filesystem::path& file) const {
    const std::filesystem::path first = of(0);
    std::error_code ignored;
    const std::filesystem::path folder =
        std::filesystem::weakly_canonical(std::filesystem::absolute(first).parent_path(), ignored);
    if (file.parent_path() != folder)
        return false;
    const std::string name = file.filename().string();
    const std::string before = std::filesystem::path(m_before).filename().string();
    if (name.size() <= before.size() + m_after.size() || !name.starts_with(before) ||
        !name.ends_with(m_after))
        return false;
    const auto number =
        std::string_view(name).substr(before.size(), name.size() - before.size() - m_after.size());
    return number.find_first_not_of("0123456789") == std::string_view::npos;
}

std::filesystem::path FrameNames::ledger() const {
    const std::filesystem::path frames = m_before + "frames" + m_after;
    return frames.parent_path() / ("." + frames.filename().string() + ".done");
}

namespace {

bool ends_in(const std::string& text, std::initializer_list<const char*> endings) {
    return std::any_of(endings.begin(), endings.end(),
                       [&](const char* e) { return text.ends_with(e); });
}

}  // namespace

void check_video(const std::filesystem::path& file, const FrameNames& frames,
                 const std::string& program) {
    const std::string attempt = "make the video " + file.string() + ": ";
    if (!ends_in(file.string(), {".mp4", ".mkv", ".mov"}))
        throw util::UsageError(attempt +
                               "its ending names no kind of video; allowed: .mp4, .mkv, .mov");
    if (!ends_in(frames.pattern(), {".png", ".jpg", ".jpeg"}))
        throw util::UsageError(attempt + "of " + frames.pattern() +
                               "; allowed: frames in .png or .jpg");
    if (util::find_program(program).empty())
        throw util::UsageError(
            attempt + program +
            " is not installed; without --video the frames are made all the same");
    util::check_writable(file);
}

void make_video(const std::filesystem::path& file, const FrameNames& frames, int count, double fps,
                const std::string& program) {
    util::AtomicFile out(file);
    // Absolute, since ffmpeg takes text before a colon as a protocol, and a leading dash as an
    // option.
    const std::string pictures = std::filesystem::absolute(frames.pattern()).string();
    const std::string target = std::filesystem::absolute(out.temporary_path()).string();
    util::Process ffmpeg(
        {.command = {
             program, "-nostdin", "-hide_banner", "-loglevel", "error", "-y", "-f", "image2",
             "-framerate", util::number_text(fps), "-start_number", "0", "-i", pictures,
             "-frames:v", std::to_string(count), "-c:v", "libx264", "-crf", "17", "-preset", "slow",
             // Players require even sizes and subsampled chroma; the colour space is stated.
             "-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2,scale=out_color_matrix=bt709", "-pix_fmt",
             "yuv420p", "-colorspace", "bt709", "-color_primaries", "bt709", "-color_trc",
             "iec61966-2-1", "-movflags", "+faststart", target}});
    if (const int status = ffmpeg.wait(); status != 0)
        throw util::Error("make the video " + file.string() + ": " + program +
                          " failed with status " + std::to_string(status));
    out.commit();
}

}  // namespace terravox::animate
