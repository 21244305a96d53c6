#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "common/voxel/world.hpp"

namespace terravox::boxes {

/// A box in the form in which it is cached and sent.
struct KeptBox {
    std::uint64_t checksum = 0;  ///< checksum of the box (Box::checksum); 0 for air
    /// Hash of the frame's bytes, which may differ between versions of zstd.
    std::uint64_t frame_hash = 0;
    /// The zstd frame of the box's blob; nullptr: known to be air.
    std::shared_ptr<const std::string> frame;
    voxel::InputExtent reach;  ///< extent of all inputs that affected it

    [[nodiscard]] bool air() const noexcept { return frame == nullptr; }
    [[nodiscard]] std::size_t memory_bytes() const noexcept {
        return sizeof *this + (frame ? sizeof *frame + frame->capacity() : 0);
    }
};
using KeptBoxPtr = std::shared_ptr<const KeptBox>;  ///< never nullptr unless documented

/// The box columns of level 0 that a box covers.
/// @return saturated for keys that are outside of any possible world
[[nodiscard]] inline voxel::InputExtent footprint(const voxel::BoxKey& key) noexcept {
    const auto scaled = [&](std::int64_t value) {
        constexpr std::int64_t kFarthest = std::int64_t{1} << 30;
        const std::int64_t out = value * (std::int64_t{1} << key.level);
        return static_cast<std::int32_t>(out < -kFarthest  ? -kFarthest
                                         : out > kFarthest ? kFarthest
                                                           : out);
    };
    return {scaled(key.bx), scaled(key.bz), scaled(std::int64_t{key.bx} + 1),
            scaled(std::int64_t{key.bz} + 1)};
}

}  // namespace terravox::boxes
