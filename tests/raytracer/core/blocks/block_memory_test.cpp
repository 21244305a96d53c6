// Boxes that arrive when memory ends at any one allocation: whoever waits for one gets it or a
// hole, or the program ends with a line. Nobody waits for ever.
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <string>

#include "raytracer/core/blocks/block_manager.hpp"
#include "tests/catch.hpp"
#include "tests/common/child_process.hpp"
#include "tests/common/scarce_memory.hpp"
#include "tests/common/voxel/array_world.hpp"

using namespace terravox;
using terravox::test::ArrayWorld;

namespace {

constexpr unsigned kHangs_s = 300;
constexpr int kBoxes = 6;
constexpr std::size_t kPlenty_bytes = std::size_t{256} << 20;

/// Waits for boxes as a processor does.
class Waiting final : public blocks::BlockListener {
public:
    bool on_block_loaded(const voxel::BoxKey&, std::uint64_t) noexcept override {
        ++m_told;
        m_told.notify_all();
        return false;
    }
    void wait_for_all(int boxes) const {
        for (int told = m_told; told < boxes; told = m_told)
            m_told.wait(told);
    }

private:
    std::atomic<int> m_told = 0;
};

voxel::BoxKey to_key(int box) {
    return {0, box, 0, 0};
}

}  // namespace

TEST_CASE("without memory nobody waits for a box for ever", "[raytracer][world]") {
    ArrayWorld world({0, 0, 0}, {kBoxes * voxel::kBoxSizeX, 4, 4});
    world.fill({0, 0, 0}, {kBoxes * voxel::kBoxSizeX, 2, 4}, voxel::Material::kRock);
    int done = 0;
    int ended = 0;
    for (std::size_t allocations = 0; allocations < 250; ++allocations) {
        const test::ChildEnd end = test::run_in_child([&]() noexcept {
            ::alarm(kHangs_s);
            Waiting waiting;
            blocks::BlockManager blocks(world, kPlenty_bytes, 1);
            const test::ScarceMemory scarce(allocations);
            for (int box = 0; box < kBoxes / 2; ++box)
                blocks.wait_for(to_key(box), waiting, 0);
            waiting.wait_for_all(kBoxes / 2);
            for (int box = kBoxes / 2; box < kBoxes; ++box)
                (void)blocks.get(to_key(box));
        });
        INFO("after " << allocations << " allocations: " << end.error_output);
        REQUIRE(WIFEXITED(end.status));
        if (WEXITSTATUS(end.status) == 0) {
            ++done;
            continue;
        }
        ++ended;
        REQUIRE(WEXITSTATUS(end.status) == 1);
        REQUIRE(end.error_output.starts_with("terravox: out of memory"));
    }
    CHECK(done > 20);
    CHECK(ended > 20);
}
