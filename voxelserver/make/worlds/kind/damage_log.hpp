#pragma once

#include <cstdint>
#include <mutex>
#include <set>
#include <string>
#include <vector>

namespace terravox::worlds {

/// Damage found in a world: each line once, sorted, regardless of the order in which threads found
/// them. Thread-safe. Keeps kMaxLines, and counts any further ones.
class DamageLog {
public:
    static constexpr std::size_t kMaxLines = 10'000;

    /// @return whether the line is new
    bool add(std::string line) {
        const std::lock_guard lock(m_mutex);
        if (m_lines.size() >= kMaxLines) {
            if (!m_lines.contains(line))
                ++m_more;  // the same line may be counted twice here
            return false;
        }
        return m_lines.insert(std::move(line)).second;
    }
    [[nodiscard]] std::vector<std::string> lines() const {
        const std::lock_guard lock(m_mutex);
        std::vector<std::string> out(m_lines.begin(), m_lines.end());
        if (m_more > 0)
            out.push_back("and more than these " + std::to_string(kMaxLines));
        return out;
    }

private:
    mutable std::mutex m_mutex;
    std::set<std::string> m_lines;
    std::uint64_t m_more = 0;
};

}  // namespace terravox::worlds
