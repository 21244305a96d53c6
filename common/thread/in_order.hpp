#pragma once

#include <oneapi/tbb/parallel_pipeline.h>
#include <oneapi/tbb/task_arena.h>

#include <atomic>
#include <cstddef>
#include <exception>
#include <memory>
#include <utility>

#include "common/thread/parallel.hpp"

namespace terravox::thread {

/// Calls use(i, make(i)) for each i in [0, count): make() runs on at most `threads` threads (0 =
/// one per core), use() runs serially in ascending order, with at most twice as many items in
/// flight as there are threads. The output is therefore independent of the number of threads.
/// @throws what the first failing call threw
template <class Make, class Use>
void in_order(std::size_t count, int threads, const Make& make, const Use& use) {
    namespace tbb = oneapi::tbb;
    using Made = decltype(make(std::size_t{0}));
    struct Item {
        std::size_t index;
        Made made;
    };
    using ItemPtr = std::shared_ptr<Item>;
    const int max_threads = thread_count(threads);
    tbb::task_arena arena(max_threads);
    std::size_t next = 0;
    // When a filter throws, TBB leaks the items in flight: exceptions are therefore held back until
    // the pipeline has ended.
    std::atomic<bool> failed{false};
    std::exception_ptr failure;
    const auto try_to = [&](const auto& work) {
        try {
            if (!failed)
                work();
        } catch (...) {
            if (!failed.exchange(true))
                failure = std::current_exception();
        }
    };
    arena.execute([&] {
        tbb::parallel_pipeline(
            static_cast<std::size_t>(max_threads) * 2,
            tbb::make_filter<void, std::size_t>(tbb::filter_mode::serial_in_order,
                                                [&](tbb::flow_control& control) {
                                                    const bool ends = next == count || failed;
                                                    if (ends)
                                                        control.stop();
                                                    return ends ? count : next++;
                                                }) &
                tbb::make_filter<std::size_t, ItemPtr>(
                    tbb::filter_mode::parallel,
                    [&](std::size_t i) {
                        ItemPtr item;
                        try_to([&] { item = std::make_shared<Item>(Item{i, make(i)}); });
                        return item;
                    }) &
                tbb::make_filter<ItemPtr, void>(
                    tbb::filter_mode::serial_in_order, [&](const ItemPtr& item) {
                        if (item)
                            try_to([&] { use(item->index, std::move(item->made)); });
                    }));
    });
    if (failure)
        std::rethrow_exception(failure);
}

}  // namespace terravox::thread
