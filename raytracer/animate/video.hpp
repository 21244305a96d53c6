#pragma once

#include <filesystem>
#include <string>

#include "raytracer/animate/frame_names.hpp"

namespace terravox::animate {

/// Where a program is found by its name: in PATH, or as it is when it holds a slash. @return empty:
/// nowhere
[[nodiscard]] std::filesystem::path find_program(const std::string& name);

/// @throws UsageError when the frames are no pictures that a video is made of (.png, .jpg), the
/// file's ending names no kind of video, or `program` is not installed
void check_video(const std::filesystem::path& file, const FrameNames& frames,
                 const std::string& program = "ffmpeg");

/// Makes a video of frames 0 to count - 1 through ffmpeg; whole or not at all. @throws Error when
/// it fails
void make_video(const std::filesystem::path& file, const FrameNames& frames, int count, double fps,
                const std::string& program = "ffmpeg");

}  // namespace terravox::animate
