#pragma once

#include <sys/inotify.h>
#include <unistd.h>

#include <array>
#include <cstddef>
#include <filesystem>
#include <stdexcept>

namespace terravox::test {

/// Detects when a file is opened, by any thread and library (inotify).
class OpenWatch {
public:
    explicit OpenWatch(const std::filesystem::path& file)
        : m_events(::inotify_init1(IN_NONBLOCK | IN_CLOEXEC)) {
        if (m_events < 0 || ::inotify_add_watch(m_events, file.c_str(), IN_OPEN) < 0)
            throw std::runtime_error("watch " + file.string());
    }
    ~OpenWatch() { ::close(m_events); }
    OpenWatch(const OpenWatch&) = delete;
    OpenWatch& operator=(const OpenWatch&) = delete;

    /// Whether it was opened since the last call.
    [[nodiscard]] bool was_opened() const {
        alignas(inotify_event) std::array<std::byte, 4096> events{};
        bool any = false;
        while (::read(m_events, events.data(), events.size()) > 0)
            any = true;
        return any;
    }

private:
    int m_events;
};

}  // namespace terravox::test
