#pragma once

#include <exception>
#include <optional>
#include <system_error>
#include <thread>

namespace terravox::thread {

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

}  // namespace terravox::thread
