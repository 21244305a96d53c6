#pragma once

#include <filesystem>
#include <string>

#include "raytracer/core/animate/frame_names.hpp"

namespace terravox::animate {

/// Finds a program by its name: in PATH, or at that path if the name contains a slash.
/// @return empty if it is not found
[[nodiscard]] std::filesystem::path find_program(const std::string& name);

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
