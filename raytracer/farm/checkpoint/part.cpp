#include "raytracer/farm/checkpoint/part.hpp"

#include <charconv>
#include <numeric>

namespace terravox::farm {
namespace {

/// Number of parts by which a row is shifted against the one above. It is close to the golden
/// section of their number, so that no direction in the picture favours a part, and coprime to it,
/// so that all shifts occur.
std::uint32_t shift_of(std::uint32_t count) noexcept {
    auto shift = static_cast<std::uint32_t>(static_cast<double>(count) * 0.6180339887498949);
    while (shift > 1 && std::gcd(shift, count) != 1)
        --shift;
    return shift > 0 ? shift : 1;
}

}  // namespace

std::optional<Part> Part::parse(const std::string& text) {
    Part part;
    const char* const end = text.data() + text.size();
    const auto first = std::from_chars(text.data(), end, part.index);
    if (first.ec != std::errc{} || first.ptr == end || *first.ptr != '/')
        return std::nullopt;
    const auto second = std::from_chars(first.ptr + 1, end, part.count);
    if (second.ec != std::errc{} || second.ptr != end)
        return std::nullopt;
    if (part.index < 1 || part.index > part.count || part.count > kMaxParts)
        return std::nullopt;
    return part;
}

bool Part::has(std::uint32_t column, std::uint32_t row) const noexcept {
    return (column + std::uint64_t{row} * shift_of(count)) % count == index - 1;
}

}  // namespace terravox::farm
