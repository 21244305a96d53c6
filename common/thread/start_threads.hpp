#pragma once

#include <condition_variable>
#include <cstddef>
#include <exception>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <system_error>
#include <thread>
#include <type_traits>
#include <utility>
#include <vector>

#include "common/util/error.hpp"

namespace terravox::thread {

/// Starts `count` threads that run `work`, for use in a constructor: either all of them are
/// started, or none.
///
/// When the system refuses a thread, the threads that already run are stopped and joined. Otherwise
/// the destructor of the vector would terminate the program, since the destructor of an object does
/// not run when its constructor throws.
/// @param threads  empty
/// @param work     copied to each thread
/// @param stop     makes `work` return soon; called at most once
/// @throws std::system_error when a thread cannot be started, std::bad_alloc
template <class Work, class Stop>
void start_threads(std::vector<std::thread>& threads, std::size_t count, const Work& work,
                   const Stop& stop) {
    try {
        threads.reserve(count);
        while (threads.size() < count)
            threads.emplace_back(work);
    } catch (...) {
        stop();
        for (std::thread& t : threads)
            t.join();
        threads.clear();
        throw;
    }
}

/// Adds a thread to a vector whose threads the caller joins. On failure the vector is unchanged.
/// @param what  what the thread is for, for the message: "a picture"
/// @throws Error when the system refuses the thread; std::bad_alloc
template <class Work>
void add_thread(std::vector<std::thread>& threads, const char* what, Work&& work) {
    try {
        threads.emplace_back(std::forward<Work>(work));
    } catch (const std::system_error&) {
        throw util::Error("start a thread for {}: {}", what,
                          util::to_message(std::current_exception()));
    }
}

/// @return a thread that runs `work`
/// @throws as add_thread
template <class Work>
[[nodiscard]] std::thread start_thread(const char* what, Work&& work) {
    std::vector<std::thread> one;
    add_thread(one, what, std::forward<Work>(work));
    return std::move(one.front());
}

/// Runs `work` on a thread of its own and waits for its end. For work that needs the stack that the
/// system gives to threads (8 MiB) and is called on a thread of a library that gives less:
/// CivetWeb's threads have 100 KiB, of which voxelization alone takes two thirds.
/// @param work     returns a value
/// @param refused  called instead where the system refuses the thread
/// @return what the one that was called returns
/// @throws what it throws
template <class Work, class Refused>
[[nodiscard]] auto on_new_thread(const Work& work, const Refused& refused) -> decltype(work()) {
    std::optional<decltype(work())> result;
    std::exception_ptr failure;
    std::thread thread;
    try {
        thread = std::thread([&] {
            try {
                result.emplace(work());
            } catch (...) {
                failure = std::current_exception();
            }
        });
    } catch (const std::system_error&) {
        return refused();
    }
    thread.join();
    if (failure)
        std::rethrow_exception(failure);
    return *std::move(result);
}

/// Makes an uninterruptible call, such as a DNS lookup, on a thread of its own, and stops waiting
/// for it on request.
/// @param call must own all that it accesses: it keeps running, detached, when the stop request
/// comes first
/// @return nullopt when stopped before the call has returned
/// @throws whatever the call throws
template <class Call>
[[nodiscard]] std::optional<std::invoke_result_t<Call&>> call_until_stopped(
    Call call, const std::stop_token& stop) {
    struct Outcome {
        std::mutex mutex;
        std::condition_variable_any came;
        std::optional<std::invoke_result_t<Call&>> value;
        std::exception_ptr failure;
    };
    const auto outcome = std::make_shared<Outcome>();
    std::thread([outcome, call = std::move(call)]() mutable {
        std::optional<std::invoke_result_t<Call&>> value;
        std::exception_ptr failure;
        try {
            value = call();
        } catch (...) {
            failure = std::current_exception();
        }
        const std::lock_guard lock(outcome->mutex);
        outcome->value = std::move(value);
        outcome->failure = failure;
        outcome->came.notify_all();
    }).detach();
    std::unique_lock lock(outcome->mutex);
    const auto ended = [&] { return outcome->value || outcome->failure; };
    if (!outcome->came.wait(lock, stop, ended))
        return std::nullopt;
    if (outcome->failure)
        std::rethrow_exception(outcome->failure);
    return std::move(outcome->value);
}

}  // namespace terravox::thread
