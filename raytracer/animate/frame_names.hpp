#pragma once

#include <filesystem>
#include <string>

namespace terravox::animate {

/// Names of numbered pictures: a path with one %d, or %0Nd for N digits and zeros before.
class FrameNames {
public:
    /// @throws UsageError for another pattern
    explicit FrameNames(std::string pattern);
    [[nodiscard]] std::filesystem::path of(int frame) const;
    [[nodiscard]] const std::string& pattern() const noexcept { return m_pattern; }
    /// Where it is noted which frames are done: a hidden file beside them.
    [[nodiscard]] std::filesystem::path ledger() const;

private:
    std::string m_pattern, m_before, m_after;
    std::size_t m_digits = 0;
};

}  // namespace terravox::animate
