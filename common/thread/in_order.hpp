#pragma once

#include <oneapi/tbb/parallel_pipeline.h>
#include <oneapi/tbb/task_arena.h>

#include <atomic>
#include <cstddef>
#include <exception>
#include <memory>
#include <utility>

#include "common/thread/parallel.hpp"
#include "common/thread/tsan_order.hpp"

namespace terravox::thread {

/// Calls use(i, make(i)) for each i in [0, count): make() runs on at most `threads` threads (0 =
/// one per core) and no more than there are cores, use() runs serially in ascending order, with at
/// most twice as many items in flight as there are threads. The output is therefore independent of
/// the number of threads.
/// @throws what the first failing call threw; std::bad_alloc
template <class Make, class Use>
void in_order(std::size_t count, int threads, const Make& make, const Use& use) {
    namespace tbb = oneapi::tbb;
    using Made = decltype(make(std::size_t{0}));
    struct Item {
        std::size_t index;
        Made made;
        TsanOrder order;  // between make() and use()
    };
    using ItemPtr = std::shared_ptr<Item>;
    const int max_threads = task_thread_count(threads);
    check_memory_for_tasks();
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
    const auto run = [&] {
        TsanTasks tasks;
        TsanOrder inputs;
        TsanOrder outputs;
        const auto next_index = [&](tbb::flow_control& control) {
            const TsanTasks::Task task(tasks);
            const TsanSerialTask serial(inputs);
            const bool ends = next == count || failed;
            if (ends)
                control.stop();
            return ends ? count : next++;
        };
        const auto make_item = [&](std::size_t i) {
            const TsanTasks::Task task(tasks);
            ItemPtr item;
            try_to([&] {
                item = std::make_shared<Item>(Item{i, make(i), {}});
                item->order.precede();
            });
            return item;
        };
        const auto use_item = [&](const ItemPtr& item) {
            const TsanTasks::Task task(tasks);
            const TsanSerialTask serial(outputs);
            if (!item)
                return;
            item->order.follow();
            try_to([&] { use(item->index, std::move(item->made)); });
        };
        using tbb::filter_mode;
        tbb::parallel_pipeline(
            static_cast<std::size_t>(max_threads) * 2,
            tbb::make_filter<void, std::size_t>(filter_mode::serial_in_order, next_index) &
                tbb::make_filter<std::size_t, ItemPtr>(filter_mode::parallel, make_item) &
                tbb::make_filter<ItemPtr, void>(filter_mode::serial_in_order, use_item));
    };
    arena.execute(run);
    if (failure)
        std::rethrow_exception(failure);
}

}  // namespace terravox::thread
