// The block manager with a world that prefers requests for many boxes at once.
#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "raytracer/core/blocks/block_manager.hpp"
#include "raytracer/core/shade/view.hpp"
#include "tests/catch.hpp"
#include "tests/raytracer/landscape.hpp"

using namespace terravox;
using terravox::test::ArrayWorld;
using terravox::test::landscape;
using terravox::test::small_scene;
using terravox::test::to_bytes;

namespace {

constexpr std::size_t kBatchMemory_bytes = std::size_t{256} << 20;
using Keys = std::vector<voxel::BoxKey>;

/// The landscape, in batches. Requests are recorded; each answer may be delayed.
class BatchWorld final : public voxel::World {
public:
    /// How a world answers a batch.
    enum class Way { kGood, kBackwards, kForgets, kThrows, kTwice };
    explicit BatchWorld(int batch, Way way = Way::kGood) : m_batch(batch), m_way(way) {}

    [[nodiscard]] const voxel::WorldInfo& info() const noexcept override { return m_inner->info(); }
    [[nodiscard]] std::shared_ptr<const voxel::Box> box(const voxel::BoxKey& key) override {
        return m_inner->box(key);
    }
    [[nodiscard]] voxel::ColumnExtent column(int level, std::int32_t bx, std::int32_t bz) override {
        return m_inner->column(level, bx, bz);
    }
    [[nodiscard]] int preferred_batch() const noexcept override { return m_batch; }
    void boxes(std::span<const voxel::BoxKey> keys, const voxel::TakeBox& take) override {
        Keys order(keys.begin(), keys.end());
        {
            const std::lock_guard lock(m_mutex);
            m_batches.push_back(order);
        }
        if (m_way == Way::kBackwards)
            std::reverse(order.begin(), order.end());
        if (m_way == Way::kForgets || m_way == Way::kThrows)
            order.resize(order.size() / 2);
        for (const voxel::BoxKey& key : order) {
            wait_for_leave();
            World::boxes(std::span(&key, 1), take);
            if (m_way == Way::kTwice)
                World::boxes(std::span(&key, 1), take);
        }
        if (m_way == Way::kThrows)
            throw 42;
    }

    ArrayWorld& inner() noexcept { return *m_inner; }
    [[nodiscard]] std::vector<Keys> batches() const {
        const std::lock_guard lock(m_mutex);
        return m_batches;
    }
    void hold() { allow(0); }
    void release() { allow(-1); }
    /// So many answers from now on; negative: any number.
    void allow(int answers) {
        const std::lock_guard lock(m_mutex);
        m_leave = answers;
        m_allowed.notify_all();
    }

private:
    void wait_for_leave() {
        std::unique_lock lock(m_mutex);
        m_allowed.wait(lock, [&] { return m_leave != 0; });
        if (m_leave > 0)
            --m_leave;
    }
    std::unique_ptr<ArrayWorld> m_inner = landscape();
    const int m_batch;
    const Way m_way;
    mutable std::mutex m_mutex;
    std::condition_variable m_allowed;
    std::vector<Keys> m_batches;
    int m_leave = -1;
};

struct Ear final : blocks::BlockListener {
    bool on_block_loaded(const voxel::BoxKey&, std::uint64_t) noexcept override {
        return ++count > 0;
    }
    std::atomic<int> count{0};
};

template <class Condition>
void until(const Condition& condition) {
    while (!condition())
        std::this_thread::yield();
}

Keys list_keys(const BatchWorld& world) {
    Keys out;
    const auto range = voxel::boxes_over(world.info().bounds, 0);
    for (int bx = range.min.bx; bx < range.max.bx; ++bx)
        for (int by = range.min.by; by < range.max.by; ++by)
            for (int bz = range.min.bz; bz < range.max.bz; ++bz)
                out.push_back({0, bx, by, bz});
    return out;
}

}  // namespace

TEST_CASE("boxes with waiters are requested together, in the order of the waits",
          "[raytracer][world][batch]") {
    BatchWorld world(8);
    const Keys keys = list_keys(world);
    REQUIRE(keys.size() > 20);
    world.hold();
    Ear ear;
    blocks::BlockManager blocks(world, kBatchMemory_bytes, 1);
    blocks.wait_for(keys[0], ear, 0);
    until([&] { return world.batches().size() == 1; });
    for (std::size_t i = 1; i < 20; ++i)
        blocks.wait_for(keys[i], ear, i);
    world.release();
    until([&] { return ear.count == 20; });
    CHECK(world.batches() == std::vector<Keys>{{keys[0]},
                                               {keys.begin() + 1, keys.begin() + 9},
                                               {keys.begin() + 9, keys.begin() + 17},
                                               {keys.begin() + 17, keys.begin() + 20}});
    blocks.forget(ear);
}

TEST_CASE("a box of a batch is available as soon as it has arrived", "[raytracer][world][batch]") {
    BatchWorld world(8);
    const Keys keys = list_keys(world);
    world.hold();
    Ear ear;
    blocks::BlockManager blocks(world, kBatchMemory_bytes, 1);
    blocks.prefetch(keys);
    until([&] { return world.batches().size() == 1; });
    CHECK(world.batches()[0] == Keys(keys.begin(), keys.begin() + 8));
    blocks.wait_for(keys[1], ear, 1);  // it is on its way
    world.allow(2);
    until([&] { return ear.count == 1; });
    CHECK(blocks.find(keys[0]) != nullptr);
    CHECK(blocks.find(keys[2]) == nullptr);
    CHECK(world.batches().size() == 1);
    world.release();
    until([&] { return blocks.stats().entries == keys.size(); });
    blocks.forget(ear);
}

TEST_CASE("boxes that a world fails over, forgets or gives twice hold up no others",
          "[raytracer][world][batch]") {
    struct Case {
        const char* name;
        BatchWorld::Way way;
    };
    const auto c = GENERATE(values<Case>({{"good", BatchWorld::Way::kGood},
                                          {"backwards", BatchWorld::Way::kBackwards},
                                          {"forgets half", BatchWorld::Way::kForgets},
                                          {"ends with an error", BatchWorld::Way::kThrows},
                                          {"twice", BatchWorld::Way::kTwice}}));
    DYNAMIC_SECTION(c.name) {
        BatchWorld world(8, c.way);
        const Keys keys = list_keys(world);
        world.inner().make_hole(keys[3]);
        world.inner().make_hole(keys[4], [] { throw 42; });
        Ear ear;
        blocks::BlockManager blocks(world, kBatchMemory_bytes, 2);
        for (const auto& key : keys)
            blocks.wait_for(key, ear, 0);
        until([&] { return ear.count == static_cast<int>(keys.size()); });
        const bool lossy = c.way == BatchWorld::Way::kForgets || c.way == BatchWorld::Way::kThrows;
        CHECK((lossy ? blocks.hole_count() > 2 : blocks.hole_count() == 2));
        CHECK(blocks.get(keys[3])->hole);
        CHECK(blocks.get(keys[4])->hole);
        std::uint64_t loaded = 0;
        for (const auto& level : blocks.stats().levels)
            loaded += level.loaded;
        CHECK(loaded == keys.size());
        blocks.forget(ear);
    }
}

TEST_CASE(
    "a picture is the same whether boxes arrive alone or in batches, in any order, with any memory",
    "[raytracer][world][batch][deterministic]") {
    const auto picture = [](voxel::World& world, std::size_t memory_bytes, int loaders) {
        scene::Scene scene = small_scene();
        // With a byte of memory nearly each ray loads its boxes again.
        scene.output.size_px = {49, 27};
        blocks::BlockManager blocks(world, memory_bytes, loaders);
        const shade::View view = shade::make_view(scene, blocks);
        render::prefetch_visible(view, blocks);
        output::Film film(scene.output.size_px[0], scene.output.size_px[1]);
        processors::ThreadProcessor processor(view, blocks, 2);
        (void)render::render_film({view, processor, true, {}}, film);
        return to_bytes(film);
    };
    static const std::string reference = picture(*landscape(), kBatchMemory_bytes, 1);
    struct Case {
        const char* name;
        int batch;
        BatchWorld::Way way;
        std::size_t memory_bytes;
        int loaders;
    };
    const auto c = GENERATE(values<Case>({
        {"5, backwards", 5, BatchWorld::Way::kBackwards, kBatchMemory_bytes, 8},
        {"32, a byte of memory", 32, BatchWorld::Way::kGood, 1, 8},
        {"7, little memory, backwards", 7, BatchWorld::Way::kBackwards, 100'000, 3},
    }));
    DYNAMIC_SECTION(c.name) {
        BatchWorld world(c.batch, c.way);
        CHECK((picture(world, c.memory_bytes, c.loaders) == reference));
    }
}
