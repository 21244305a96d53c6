#include "raytracer/python/interruptible.hpp"

namespace terravox::python {

LeftThreads& LeftThreads::all() {
    static LeftThreads threads;
    return threads;
}

void LeftThreads::add(std::thread thread) {
    const std::lock_guard lock(m_mutex);
    m_threads.push_back(std::move(thread));
}

void LeftThreads::join() {
    std::vector<std::thread> threads;
    {
        const std::lock_guard lock(m_mutex);
        threads = std::exchange(m_threads, {});
    }
    for (std::thread& thread : threads)
        thread.join();
}

}  // namespace terravox::python
