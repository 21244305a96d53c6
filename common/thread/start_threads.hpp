#pragma once

#include <cstddef>
#include <exception>
#include <string>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "common/util/end_of_program.hpp"
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
        throw util::Error(std::string("start a thread for ") + what + ": " +
                          util::message_of(std::current_exception()));
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

}  // namespace terravox::thread
