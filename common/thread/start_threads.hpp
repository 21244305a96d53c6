#pragma once

#include <cstddef>
#include <thread>
#include <vector>

namespace terravox::thread {

/// Starts `count` threads that run `work`, for a constructor: all of them, or none.
/// Where the system refuses one, those that run already are asked to stop and joined. Without that the destructor of the
/// vector would end the program, as that of the object does not run when its constructor throws.
/// @param threads  empty
/// @param work     copied to each thread
/// @param stop     makes `work` return soon; called at most once
/// @throws std::system_error when a thread cannot be started, std::bad_alloc
template <class Work, class Stop>
void start_threads(std::vector<std::thread>& threads, std::size_t count, const Work& work, const Stop& stop) {
    try {
        threads.reserve(count);
        while (threads.size() < count) threads.emplace_back(work);
    } catch (...) {
        stop();
        for (std::thread& t : threads) t.join();
        threads.clear();
        throw;
    }
}

}  // namespace terravox::thread
