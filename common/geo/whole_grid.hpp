#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

namespace terravox::geo {

/// Whether an Esri ASCII grid ends before its last value. GDAL finds rows by reading those before
/// them; behind the end of the file each row doubles the number of attempts, which takes for ever.
/// Reads the file once, and stops where it has enough.
/// @param values of all rows, by the header
/// @return what is missing; nullopt: nothing, but for as many values as the header has words
/// @throws Error when the file cannot be read
[[nodiscard]] std::optional<std::string> find_lost_values_of_grid(const std::filesystem::path& file,
                                                                  std::uint64_t values);

}  // namespace terravox::geo
