#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <string>

#include "common/voxel/world.hpp"
#include "tests/bench/entries/scale_land.hpp"

namespace terravox::bench {

/// A square piece of the synthetic land as a world, its middle at the origin: the same place
/// whatever its size. Boxes of level 0 come from the land, all others by the rule of the levels
/// from the four below. Once made a box is kept as a file; boxes that no edge of the world touches
/// are shared by worlds of all sizes. Damaged files are made again. Thread-safe.
class ScaleWorld final : public voxel::World {
public:
    static constexpr int kLevels = 8;
    static constexpr std::uint64_t kSeed = 28;

    /// @param side_km    edge of the square, 1 to 100
    /// @param kept_boxes folder; made when it is missing @throws Error
    ScaleWorld(int side_km, const std::filesystem::path& kept_boxes);

    [[nodiscard]] const voxel::WorldInfo& info() const noexcept override { return m_info; }
    [[nodiscard]] std::shared_ptr<const voxel::Box> box(const voxel::BoxKey& key) override;
    [[nodiscard]] voxel::ColumnExtent column(int level, std::int32_t bx, std::int32_t bz) override;

    /// A level-0 box, never from a file.
    [[nodiscard]] std::shared_ptr<const voxel::Box> make_finest(const voxel::BoxKey& key) const;
    [[nodiscard]] const Land& land() const noexcept { return m_land; }

    struct Prepared {
        std::size_t boxes[kLevels] = {},
                    bytes[kLevels] = {};  ///< of each level, kept before or not
        std::size_t made = 0;             ///< boxes that were not kept
    };
    /// Keeps every box, level by level; files that are there are not read. @param said is called
    /// now and then with a line on the progress @throws Error
    Prepared prepare(int threads, const std::function<void(const std::string&)>& said);

private:
    [[nodiscard]] std::shared_ptr<const voxel::Box> make(const voxel::BoxKey& key);
    [[nodiscard]] std::filesystem::path file_of(const voxel::BoxKey& key) const;
    [[nodiscard]] bool inside(std::int32_t x, std::int32_t z) const noexcept;
    Land m_land{kSeed};
    voxel::WorldInfo m_info;
    std::filesystem::path m_kept;
    std::atomic<std::size_t> m_made{0};
};

}  // namespace terravox::bench
