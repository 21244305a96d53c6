#pragma once

#include <string>

namespace terravox::util {

/// Whole numbers from `first` to `last`, both included.
struct IntRange {
    int first = 0;
    int last = 0;
    [[nodiscard]] int count() const noexcept { return last - first + 1; }
    bool operator==(const IntRange&) const = default;
};

/// Parses "4-9" or "4".
/// @param what begins the message
/// @throws UsageError outside `allowed`
[[nodiscard]] IntRange parse_range(const std::string& what, const std::string& text,
                                   IntRange allowed);

}  // namespace terravox::util
