#pragma once

#include <optional>
#include <set>
#include <vector>

namespace terravox::country {

/// Which task comes next on a machine that runs several at once. Neighbouring shards read the same
/// squares, so a place goes on with the neighbour of the task that it has finished, and places
/// begin far from each other: squares are then decoded once, and never by two at the same time. Not
/// thread-safe.
class TaskQueue {
public:
    /// @param waiting numbers of tasks
    explicit TaskQueue(const std::vector<int>& waiting)
        : m_waiting(waiting.begin(), waiting.end()) {}

    [[nodiscard]] bool empty() const noexcept { return m_waiting.empty(); }
    /// Takes a task.
    /// @param after the task that the place has finished; 0: none
    /// @return nullopt: none is waiting
    [[nodiscard]] std::optional<int> take(int after);
    /// A task that was taken has ended.
    void ended(int number) { m_running.erase(number); }
    /// It has ended, and is to be taken again.
    void put_back(int number) {
        ended(number);
        m_waiting.insert(number);
    }

private:
    std::set<int> m_waiting;
    std::set<int> m_running;
};

}  // namespace terravox::country
