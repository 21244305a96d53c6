#include "voxelserver/out/country/task_queue.hpp"

namespace terravox::country {
namespace {

/// Numbers that follow each other, both included.
struct Run {
    int first = 0;
    int last = -1;
    [[nodiscard]] int count() const noexcept { return last - first + 1; }
};

Run longest_run(const std::set<int>& numbers) {
    Run longest;
    Run run;
    for (const int number : numbers) {
        if (run.count() > 0 && number == run.last + 1)
            run.last = number;
        else
            run = {number, number};
        if (run.count() > longest.count())
            longest = run;
    }
    return longest;
}

}  // namespace

std::optional<int> TaskQueue::take(int after) {
    if (m_waiting.empty())
        return std::nullopt;
    int number = after + 1;
    if (after == 0 || !m_waiting.contains(number)) {
        const Run run = longest_run(m_waiting);
        const bool follows = m_running.contains(run.first - 1);
        number = follows ? run.first + run.count() / 2 : run.first;
    }
    m_waiting.erase(number);
    m_running.insert(number);
    return number;
}

}  // namespace terravox::country
