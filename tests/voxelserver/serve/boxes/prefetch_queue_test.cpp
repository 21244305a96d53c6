#include "voxelserver/serve/boxes/box_cache.hpp"

#include <cstdint>
#include <thread>
#include <vector>

#include "tests/catch.hpp"

using namespace terravox;
using boxes::PrefetchQueue;
using voxel::BoxKey;

namespace {

BoxKey box(std::int32_t bx) {
    return {0, bx, 0, 0};
}

bool all(const BoxKey&) {
    return true;
}

std::vector<BoxKey> take_all(PrefetchQueue& queue) {
    std::vector<BoxKey> out;
    while (queue.size() > 0)
        out.push_back(queue.take().value());
    return out;
}

}  // namespace

TEST_CASE("the wanted key that was added last is prefetched first, and each is queued once",
          "[voxelserver][boxes]") {
    PrefetchQueue queue(10);
    queue.add({box(1), box(2), box(1)}, all);
    queue.add({box(1)}, all);
    queue.add({box(3), box(4)}, [](const BoxKey& key) { return key != box(3); });
    CHECK(queue.size() == 3);
    CHECK(take_all(queue) == std::vector<BoxKey>{box(4), box(2), box(1)});
    queue.add({box(1)}, all);
    CHECK(take_all(queue) == std::vector<BoxKey>{box(1)});
}

TEST_CASE("a full prefetch queue drops its oldest keys, which can then be added again",
          "[voxelserver][boxes]") {
    PrefetchQueue queue(2);
    queue.add({box(1), box(2), box(3)}, all);
    CHECK(queue.size() == 2);
    queue.add({box(1)}, all);
    CHECK(take_all(queue) == std::vector<BoxKey>{box(1), box(3)});
}

TEST_CASE("a closed prefetch queue yields no keys and accepts none", "[voxelserver][boxes]") {
    PrefetchQueue queue(10);
    queue.add({box(1)}, all);
    queue.close();
    queue.close();
    queue.add({box(2)}, all);
    CHECK(queue.size() == 1);
    CHECK_FALSE(queue.take().has_value());
}

TEST_CASE("adding a key, and closing, end the wait for a key to prefetch", "[voxelserver][boxes]") {
    PrefetchQueue queue(10);
    std::vector<BoxKey> taken;
    std::thread taking([&] {
        while (const auto key = queue.take())
            taken.push_back(*key);
    });
    queue.add({box(1)}, all);
    while (queue.size() > 0)
        std::this_thread::yield();
    queue.close();
    taking.join();
    CHECK(taken == std::vector<BoxKey>{box(1)});
}
