#include "voxelserver/serve/map/png.hpp"

#include "common/png/png.hpp"
#include "common/util/error.hpp"

namespace terravox::map {

std::string png_of(std::span<const Rgba8> pixels, int width, int height) {
    constexpr int kMaxSide = 8192;
    constexpr int kChannels = 4;
    static_assert(sizeof(Rgba8) == kChannels);
    if (width < 1 || height < 1 || width > kMaxSide || height > kMaxSide)
        throw util::Error("write a PNG of " + std::to_string(width) + " x " +
                          std::to_string(height) + " pixels: allowed: 1 to " +
                          std::to_string(kMaxSide) + " a side");
    const auto* samples = reinterpret_cast<const std::uint8_t*>(pixels.data());
    return png::encode({samples, pixels.size() * kChannels}, {width, height, kChannels});
}

}  // namespace terravox::map
