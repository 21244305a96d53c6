#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "voxelserver/out/export/core/format.hpp"

namespace terravox::exports {

/// Formats that a world can be converted to, in the order of help texts.
[[nodiscard]] std::span<const Format* const> formats() noexcept;

/// Names for --to, with the extension of the output: "archive (.tvx), ...".
[[nodiscard]] std::string allowed_formats();

/// @param name for --to; empty: by the extension of `out`, where none means a Minecraft world's
/// folder
/// @throws UsageError
[[nodiscard]] const Format& find_format_by(std::string_view name, const std::filesystem::path& out);

}  // namespace terravox::exports
