#include "raytracer/core/blocks/load_queue.hpp"

#include <algorithm>
#include <cstddef>
#include <vector>

#include "tests/catch.hpp"

using namespace terravox;
using blocks::LoadQueue;
using blocks::MemoryUse;

namespace {

using Keys = std::vector<voxel::BoxKey>;

// A quarter of it, the room for unread boxes, is ten boxes.
constexpr std::size_t kBox_bytes = 100;
constexpr std::size_t kMemory_bytes = 40 * kBox_bytes;

voxel::BoxKey to_key(int number) {
    return {0, number, 0, 0};
}

/// The boxes [first, end).
Keys keys(int first, int end) {
    Keys out;
    for (int number = first; number < end; ++number)
        out.push_back(to_key(number));
    return out;
}

LoadQueue make_queue(std::size_t batch, std::size_t loaders) {
    return LoadQueue({kMemory_bytes, batch, loaders});
}

void add_requested(LoadQueue& queue, const Keys& boxes) {
    for (const voxel::BoxKey& box : boxes)
        queue.add_requested(box);
}

/// The next request, when `used_boxes` are in memory, `unseen_boxes` of them unread.
LoadQueue::Request take(LoadQueue& queue, std::size_t used_boxes = 0, std::size_t unseen_boxes = 0,
                        const Keys& known = {}) {
    const MemoryUse memory{used_boxes * kBox_bytes, unseen_boxes * kBox_bytes, kBox_bytes};
    const auto is_known = [&known](const voxel::BoxKey& box) {
        return std::find(known.begin(), known.end(), box) != known.end();
    };
    LoadQueue::Request request;
    request.keys = keys(1000, 1003);  // from an earlier request
    const bool is_taken = queue.take(memory, is_known, request);
    CHECK(is_taken == !request.keys.empty());
    return request;
}

void complete(LoadQueue& queue, const LoadQueue::Request& request) {
    for (std::size_t i = 0; i < request.keys.size(); ++i)
        queue.on_box_loaded();
    queue.finish(request);
}

}  // namespace

TEST_CASE("boxes with a waiter are taken in their order, and before prefetched ones",
          "[raytracer][world][queue]") {
    LoadQueue queue = make_queue(2, 1);
    queue.replace_prefetched(keys(10, 12));
    add_requested(queue, keys(0, 3));

    const LoadQueue::Request first = take(queue);
    CHECK(first.keys == keys(0, 2));
    CHECK_FALSE(first.prefetched);
    complete(queue, first);

    // A request has boxes of one kind, even where there is room for more.
    const LoadQueue::Request second = take(queue);
    CHECK(second.keys == keys(2, 3));
    CHECK_FALSE(second.prefetched);
    complete(queue, second);

    const LoadQueue::Request third = take(queue);
    CHECK(third.keys == keys(10, 12));
    CHECK(third.prefetched);
    complete(queue, third);
    CHECK(take(queue).keys.empty());
}

TEST_CASE("boxes with a waiter are limited to a quarter of the memory, but the first of a request",
          "[raytracer][world][queue]") {
    struct Case {
        const char* name;
        std::size_t unseen_boxes;
        std::size_t taken;
    };
    const auto c = GENERATE(values<Case>({
        {"no unread box", 0, 10},
        {"some unread boxes", 7, 3},
        {"a full quarter", 10, 1},
        {"more than a quarter", 11, 0},
    }));
    DYNAMIC_SECTION(c.name) {
        LoadQueue queue = make_queue(100, 1);
        add_requested(queue, keys(0, 50));
        CHECK(take(queue, c.unseen_boxes, c.unseen_boxes).keys ==
              keys(0, static_cast<int>(c.taken)));
    }
}

TEST_CASE("prefetching stops at three quarters of the memory", "[raytracer][world][queue]") {
    struct Case {
        const char* name;
        std::size_t used_boxes;
        std::size_t taken;
    };
    const auto c = GENERATE(values<Case>({
        {"empty memory", 0, 29},  // with a thirtieth box it would be full
        {"some boxes", 20, 9},
        {"one box fits", 29, 1},
        {"no box fits", 30, 0},
    }));
    DYNAMIC_SECTION(c.name) {
        LoadQueue queue = make_queue(100, 1);
        queue.replace_prefetched(keys(0, 50));
        CHECK(take(queue, c.used_boxes).keys == keys(0, static_cast<int>(c.taken)));
    }
}

TEST_CASE("boxes under way count as memory until they have arrived", "[raytracer][world][queue]") {
    LoadQueue queue = make_queue(8, 3);
    add_requested(queue, keys(0, 24));
    const LoadQueue::Request first = take(queue);
    CHECK(first.keys.size() == 8);
    CHECK(take(queue).keys.size() == 2);
    for (int i = 0; i < 6; ++i)
        queue.on_box_loaded();
    CHECK(take(queue).keys.size() == 6);
}
