#pragma once

#include <array>
#include <atomic>
#include <condition_variable>
#include <map>
#include <mutex>
#include <set>
#include <string>
#include <utility>

#include "common/util/error.hpp"
#include "common/voxel/box_builder.hpp"
#include "common/voxel/world.hpp"

namespace terravox::test {

/// Fills so much of the stack, in frames of a page.
[[gnu::noinline]] inline void take_stack(std::size_t bytes) {
    constexpr std::size_t kPage_bytes = 4096;
    if (bytes < kPage_bytes)
        return;
    volatile char page[kPage_bytes];
    for (std::size_t i = 0; i < kPage_bytes; i += 64)
        page[i] = 1;
    take_stack(bytes - kPage_bytes);
    page[0] = page[64];
}

/// 2 x 3 x 2 boxes of which the topmost are air, with three levels. Counts what it makes, can fail,
/// and can be held up.
class FakeWorld final : public voxel::ProvenanceWorld {
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
        if (key.level > 0) {
            const auto made = [&](const voxel::BoxKey& child) {
                return voxel::boxes_over(m_info.bounds, child.level).contains(child) ? box(child)
                                                                                     : nullptr;
            };
            return voxel::downsample(key, voxel::Pyramid::children(key, made));
        }
        ++requests;
        {
            std::unique_lock lock(m_mutex);
            m_changed.wait(lock, [&] { return !m_held; });
        }
        take_stack(stack_bytes);
        if (failing.contains(key))
            throw util::Error(fail_with);
        if (key.by >= 1)
            return nullptr;
        voxel::BoxBuilder builder;
        for (int x = -1; x <= voxel::kBoxSizeX; ++x)
            for (int z = -1; z <= voxel::kBoxSizeZ; ++z)
                builder.add(x, z, -1, 20 + (x * 7 + z * 3 + key.bx + key.level) % 11, true);
        return builder.build(key, [](int x, int y, int z) {
            voxel::VoxelAttr attr;
            attr.source_class = static_cast<std::uint8_t>(x ^ y ^ z);
            return attr;
        });
    }

    [[nodiscard]] voxel::ColumnExtent column(int level, std::int32_t bx, std::int32_t bz) override {
        if (columns_fail)
            throw util::Error("no column today");
        const auto range = voxel::boxes_over(m_info.bounds, level);
        if (bx < range.min.bx || bx >= range.max.bx || bz < range.min.bz || bz >= range.max.bz)
            return {};
        return {range.min.by, range.max.by};
    }

    /// A box depends on its own box column and the one to the east.
    [[nodiscard]] voxel::BoxWithInputs box_with_inputs(const voxel::BoxKey& key) override {
        return {box(key), {key.bx, key.bz, key.bx + 2, key.bz + 1}};
    }
    [[nodiscard]] voxel::Fingerprint fingerprint(const voxel::InputExtent& reach) const override {
        voxel::Fingerprint out{1, 2};
        for (const auto& [column, version] : versions)
            if (column.first >= reach.min_bx && column.first < reach.max_bx &&
                column.second >= reach.min_bz && column.second < reach.max_bz) {
                out[0] = out[0] * 1000003 + static_cast<std::uint64_t>(version);
                out[1] ^= out[0];
            }
        return out;
    }

    void hold() { set_held(true); }  ///< box() waits from now on
    void release() { set_held(false); }

    std::atomic<int> requests{0};     ///< calls of box()
    std::set<voxel::BoxKey> failing;  ///< set before the first request
    std::string fail_with =
        "decode the square 'a\"b': damaged\xff";  ///< what those of `failing` throw
    std::size_t stack_bytes = 0;                  ///< that box() takes
    bool columns_fail = false;
    std::map<std::pair<int, int>, int>
        versions;  ///< of box columns that have changed; set before the first request

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
