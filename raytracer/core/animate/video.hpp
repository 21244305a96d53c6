#pragma once

#include <filesystem>
#include <string>

namespace terravox::animate {

/// Names of numbered pictures: a path with one %d, or %0Nd for N digits with leading zeros.
class FrameNames {
public:
    /// @throws UsageError for another pattern
    explicit FrameNames(std::string pattern);
    [[nodiscard]] std::filesystem::path of(int frame) const;
    /// Whether a file has the name of a frame, of any number, in the folder of the frames.
    /// @param file a canonical path
    [[nodiscard]] bool matches(const std::filesystem::path& file) const;
    [[nodiscard]] const std::string& pattern() const noexcept { return m_pattern; }
    /// File that records which frames are done: a hidden file next to the frames.
    [[nodiscard]] std::filesystem::path ledger() const;

private:
    std::string m_pattern;
    std::string m_before;
    std::string m_after;
    std::size_t m_digits = 0;
};

/// Checks that a video can be made.
/// @throws UsageError when the frames are not in a format for videos (.png, .jpg), the file's
/// extension is no video format, or `program` is not installed
void check_video(const std::filesystem::path& file, const FrameNames& frames,
                 const std::string& program = "ffmpeg");

/// Makes a video of frames 0 to count - 1 with ffmpeg; completely or not at all.
/// @throws Error when it fails
void make_video(const std::filesystem::path& file, const FrameNames& frames, int count, double fps,
                const std::string& program = "ffmpeg");

}  // namespace terravox::animate
