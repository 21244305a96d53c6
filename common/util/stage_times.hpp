#pragma once

#include <chrono>
#include <cstdint>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

namespace terravox::util {

/// Measures the seconds since its construction.
class Stopwatch {
public:
    [[nodiscard]] double seconds() const noexcept {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - m_start).count();
    }

private:
    std::chrono::steady_clock::time_point m_start = std::chrono::steady_clock::now();
};

/// Accumulates time by named stage. Thread-safe. Stages keep the order in which they first
/// occurred.
class StageTimes {
public:
    struct Stage {
        std::string name;
        double seconds = 0;       ///< summed over threads: may exceed the wall time
        std::uint64_t count = 0;  ///< number of times the stage ran
    };

    void add(const std::string& name, double seconds);
    [[nodiscard]] std::vector<Stage> stages() const;

    /// Times a scope and adds its duration on destruction, excluding that of nested scopes on the
    /// same thread: no second is counted twice.
    class Scope {
    public:
        Scope(StageTimes& times, std::string name)
            : m_times(times), m_name(std::move(name)), m_around(std::exchange(innermost(), this)) {}
        ~Scope() {
            const double seconds = m_clock.seconds();
            innermost() = m_around;
            if (m_around != nullptr)
                m_around->m_inside += seconds;
            m_times.add(m_name, seconds - m_inside);
        }
        Scope(const Scope&) = delete;
        Scope& operator=(const Scope&) = delete;
        /// Attributes a part of this scope's time to another stage: for stages that alternate too
        /// often to be scopes.
        void hand_over(const std::string& name, double seconds) {
            m_inside += seconds;
            m_times.add(name, seconds);
        }

    private:
        static Scope*& innermost() noexcept {
            thread_local Scope* scope = nullptr;
            return scope;
        }
        StageTimes& m_times;
        std::string m_name;
        Stopwatch m_clock;
        Scope* m_around;
        double m_inside = 0;
    };

    /// Times a scope including nested scopes, whatever stages those belong to.
    class Clock {
    public:
        Clock(StageTimes& times, std::string name) : m_times(times), m_name(std::move(name)) {}
        ~Clock() { m_times.add(m_name, m_clock.seconds()); }
        Clock(const Clock&) = delete;
        Clock& operator=(const Clock&) = delete;

    private:
        StageTimes& m_times;
        std::string m_name;
        Stopwatch m_clock;
    };

private:
    mutable std::mutex m_mutex;
    std::vector<Stage> m_stages;
};

}  // namespace terravox::util
