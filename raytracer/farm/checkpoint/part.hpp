#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace terravox::farm {

/// One of several coordinators' shares of a picture's tiles: "2/5" is the second of five. Every
/// tile belongs to exactly one part. Parts are interleaved in both directions, so that each has its
/// share of sky, ground and expensive regions.
struct Part {
    static constexpr std::uint32_t kMaxParts = 65'536;
    static constexpr const char* kAllowed = "I/N, part I of N, 1/1 to 65536/65536";

    std::uint32_t index = 1, count = 1;  ///< 1 <= index <= count

    /// @return nullopt for anything but kAllowed
    [[nodiscard]] static std::optional<Part> parse(const std::string& text);
    /// @param column, row of the tile in its grid
    [[nodiscard]] bool has(std::uint32_t column, std::uint32_t row) const noexcept;
    friend bool operator==(const Part&, const Part&) = default;
};

}  // namespace terravox::farm
