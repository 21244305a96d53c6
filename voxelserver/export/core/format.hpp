#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace terravox::exports {

/// Formats that a world can be converted to.
enum class Format : std::uint8_t { kArchive, kAnvil, kVox, kVdb, kGlb, kPly };

/// Names for --to, with the extension of the output: "archive (.tvx), ...".
[[nodiscard]] std::string formats();
/// @param name for --to; empty: by the extension of `out`, where none means a Minecraft world's
/// folder
/// @throws UsageError
[[nodiscard]] Format format_of(const std::string& name, const std::filesystem::path& out);
[[nodiscard]] std::string_view name_of(Format format) noexcept;

}  // namespace terravox::exports
