#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "raytracer/core/tiles/tile.hpp"

namespace terravox::output {

/// Ref: Appleby, "MurmurHash3" 2011: MurmurHash3_x86_32.
[[nodiscard]] std::uint32_t murmur3_32(std::string_view bytes, std::uint32_t seed = 0) noexcept;

/// The number that stands for a name in the pixels: its hash as the bits of a float, with the
/// exponent changed so that it is an ordinary number (neither zero, denormal, infinite nor NaN,
/// which compositing programs do not preserve).
[[nodiscard]] std::uint32_t cryptomatte_id(std::string_view name) noexcept;

/// One set of mattes of a picture: which of the named things cover each pixel, so that a
/// compositing program can cut each of them out with its soft edge. Channels: three layers of two
/// ranks, by descending coverage; a rank is the id of a thing and its share. Ref: Friedman, Jones,
/// "Fully automatic ID mattes with support for motion blur and transparency", SIGGRAPH 2015
/// posters; Psyop, "Cryptomatte specification" version 1.2. Safe to share between threads.
class Cryptomatte {
public:
    static constexpr std::size_t kChannels = 2 * tiles::Matte::kMax;

    /// @param type such as "CryptoMaterial"; the channels are called CryptoMaterial00.r and so on
    /// @param names by Matte::object; a number beyond the end is "unknown"
    Cryptomatte(std::string type, const std::vector<std::string>& names);

    [[nodiscard]] static std::vector<std::string> channel_names(const std::string& type);
    /// The metadata of the set: cryptomatte/<7 digits>/name, hash, conversion, manifest.
    [[nodiscard]] std::vector<std::pair<std::string, std::string>> metadata() const;
    /// The channels of one pixel; ranks of equal share are ordered by id.
    [[nodiscard]] std::array<float, kChannels> find_ranks(const tiles::Matte& matte) const noexcept;

private:
    std::string m_type;
    std::string m_manifest;
    std::vector<std::uint32_t> m_ids;
    std::uint32_t m_unknown;
};

}  // namespace terravox::output
