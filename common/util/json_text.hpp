#pragma once

#include <nlohmann/json_fwd.hpp>

#include <string_view>

namespace terravox::util {

/// Lists and objects in each other: more than any format needs that the programs read.
inline constexpr int kMaxJsonLevels = 64;

/// Whether more than so many lists and objects lie in each other. Reads the text once, which need
/// not be JSON; brackets in strings do not count.
[[nodiscard]] bool has_more_json_levels(std::string_view text, int levels) noexcept;

/// Parses JSON of a stranger. Writing, copying and comparing a value take stack for each of its
/// levels, so their number is limited before anything is parsed. (A callback of the parser could
/// count them, too, but with one the parser looks through a whole list at the end of each object in
/// it.)
/// @return a discarded value for what is no JSON, or has more levels
[[nodiscard]] nlohmann::json parse_json(std::string_view text, int levels = kMaxJsonLevels);

}  // namespace terravox::util
