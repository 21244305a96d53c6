#pragma once

#include <chrono>
#include <cstdint>
#include <mutex>
#include <string>
#include <vector>

namespace terravox::util {

/// Adds up where the time goes, by named stage. Thread-safe. Stages keep the order in which they were first seen.
class StageTimes {
public:
    struct Stage {
        std::string name;
        double seconds = 0;       ///< summed over threads: may exceed the wall time
        std::uint64_t count = 0;  ///< how many times the stage ran
    };

    void add(const std::string& name, double seconds);
    [[nodiscard]] std::vector<Stage> stages() const;

    /// Times a scope and adds it on destruction.
    class Scope {
    public:
        Scope(StageTimes& times, std::string name)
            : m_times(times), m_name(std::move(name)), m_start(std::chrono::steady_clock::now()) {}
        ~Scope() { m_times.add(m_name, std::chrono::duration<double>(std::chrono::steady_clock::now() - m_start).count()); }
        Scope(const Scope&) = delete;
        Scope& operator=(const Scope&) = delete;

    private:
        StageTimes& m_times;
        std::string m_name;
        std::chrono::steady_clock::time_point m_start;
    };

private:
    mutable std::mutex m_mutex;
    std::vector<Stage> m_stages;
};

}  // namespace terravox::util
