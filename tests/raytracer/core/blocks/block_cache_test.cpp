#include "raytracer/core/blocks/block_cache.hpp"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "tests/catch.hpp"

using namespace terravox;
using blocks::Block;
using blocks::BlockCache;
using blocks::BlockPin;

namespace {

// Of a block of air.
constexpr std::size_t kBlock_bytes = Block::kOverhead_bytes;

voxel::BoxKey key(int number) {
    return {0, number, 0, 0};
}

bool is_in_memory(BlockCache& cache, int number) {
    const BlockCache::Entry* const entry = cache.find(key(number));
    return entry && entry->block;
}

BlockCache::Entry& insert(BlockCache& cache, int number) {
    return cache.insert(key(number), std::make_shared<const Block>());
}

std::size_t evict(BlockCache& cache) {
    std::vector<BlockPin> evicted;
    cache.evict(evicted);
    return evicted.size();
}

struct Listener final : blocks::BlockListener {
    bool on_block_loaded(const voxel::BoxKey&, std::uint64_t) noexcept override { return true; }
};

}  // namespace

TEST_CASE("the least recently used boxes are evicted, until the others are within the limit",
          "[raytracer][world][cache]") {
    BlockCache cache(2 * kBlock_bytes);
    for (int number = 0; number < 4; ++number)
        insert(cache, number);
    CHECK_FALSE(cache.touch(*cache.find(key(0))));
    CHECK(evict(cache) == 2);
    CHECK(is_in_memory(cache, 0));
    CHECK_FALSE(is_in_memory(cache, 1));
    CHECK_FALSE(is_in_memory(cache, 2));
    CHECK(is_in_memory(cache, 3));
    CHECK(cache.stats().entries == 2);
    CHECK(cache.stats().bytes == 2 * kBlock_bytes);
    CHECK(cache.stats().levels[0].evicted == 2);
}

TEST_CASE("a box that is needed is not evicted", "[raytracer][world][cache]") {
    BlockCache cache(1);
    const BlockPin pinned = insert(cache, 0).block;
    insert(cache, 1).getters = 1;
    cache.set_unseen(insert(cache, 2));
    insert(cache, 3);
    insert(cache, 4);  // the most recently used box stays
    CHECK(evict(cache) == 1);
    CHECK_FALSE(is_in_memory(cache, 3));
    CHECK(cache.stats().entries == 4);
    CHECK(cache.stats().peak_bytes == 4 * kBlock_bytes);
}

TEST_CASE("removed waits take entries along that nothing else needs", "[raytracer][world][cache]") {
    BlockCache cache(10 * kBlock_bytes);
    const Listener listener;
    Listener waiting;
    Listener other;
    for (int number = 0; number < 4; ++number)
        cache.make_entry(key(number)).waits.push_back({&waiting, 7});
    cache.make_entry(key(0)).waits.push_back({&waiting, 8});
    cache.make_entry(key(1)).waits.push_back({&other, 7});
    cache.make_entry(key(2)).loading = true;

    CHECK_FALSE(cache.remove_waits(listener, std::nullopt));
    CHECK(cache.contains(key(3)));
    CHECK_FALSE(cache.remove_waits(waiting, 7));
    CHECK(cache.make_entry(key(0)).waits.size() == 1);
    CHECK(cache.make_entry(key(1)).waits.size() == 1);
    CHECK(cache.make_entry(key(2)).waits.empty());
    CHECK_FALSE(cache.contains(key(3)));
    CHECK_FALSE(cache.remove_waits(waiting, std::nullopt));
    CHECK_FALSE(cache.contains(key(0)));

    cache.set_unseen(insert(cache, 5));
    CHECK(cache.remove_waits(waiting, std::nullopt));
    CHECK(cache.memory_use().unseen_bytes == 0);
}
