#pragma once

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <set>
#include <string>

#include "common/util/error.hpp"
#include "common/voxel/box_builder.hpp"
#include "common/voxel/world.hpp"

namespace terravox::test {

/// 2 x 3 x 2 boxes of which the topmost are air, with three levels. Counts what it makes, can fail, and can be held up.
class FakeWorld final : public voxel::World {
public:
    FakeWorld() {
        m_info.title = "a <fake> \"world\"";
        m_info.bounds = {{0, -256, -64}, {128, 512, 64}};
        m_info.voxel_m = 0.5;
        m_info.levels = 3;
        m_info.licence = "CC0";
        m_info.attribution = "nobody & nothing";
    }

    [[nodiscard]] const voxel::WorldInfo& info() const noexcept override { return m_info; }

    [[nodiscard]] std::shared_ptr<const voxel::Box> box(const voxel::BoxKey& key) override {
        ++asked;
        {
            std::unique_lock lock(m_mutex);
            m_changed.wait(lock, [&] { return !m_held; });
        }
        if (failing.contains(key)) throw Error("decode the square 'a\"b': damaged\xff");
        if (key.by >= 1) return nullptr;
        voxel::BoxBuilder builder;
        for (int x = -1; x <= voxel::kBoxSizeX; ++x)
            for (int z = -1; z <= voxel::kBoxSizeZ; ++z) builder.add(x, z, -1, 20 + (x * 7 + z * 3 + key.bx + key.level) % 11, true);
        return builder.build(key, [](int x, int y, int z) {
            voxel::VoxelAttr attr;
            attr.source_class = static_cast<std::uint8_t>(x ^ y ^ z);
            return attr;
        });
    }

    [[nodiscard]] voxel::ColumnExtent column(int level, std::int32_t bx, std::int32_t bz) override {
        if (columns_fail) throw Error("no column today");
        const auto range = voxel::boxes_over(m_info.bounds, level);
        if (bx < range.min.bx || bx >= range.max.bx || bz < range.min.bz || bz >= range.max.bz) return {};
        return {range.min.by, range.max.by};
    }

    void hold() { set_held(true); }      ///< box() waits from now on
    void release() { set_held(false); }

    std::atomic<int> asked{0};         ///< calls of box()
    std::set<voxel::BoxKey> failing;   ///< set before anyone asks
    bool columns_fail = false;

private:
    void set_held(bool held) {
        const std::lock_guard lock(m_mutex);
        m_held = held;
        m_changed.notify_all();
    }
    voxel::WorldInfo m_info;
    std::mutex m_mutex;
    std::condition_variable m_changed;
    bool m_held = false;
};

}  // namespace terravox::test
