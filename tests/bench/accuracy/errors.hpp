#pragma once

#include <cstddef>
#include <vector>

namespace terravox::bench {

/// Differences between found and true values. Not thread-safe.
class Errors {
public:
    void add(double found_minus_true) { m_values.push_back(static_cast<float>(found_minus_true)); }
    void add(const Errors& others) {
        m_values.insert(m_values.end(), others.m_values.begin(), others.m_values.end());
    }
    [[nodiscard]] std::size_t count() const noexcept { return m_values.size(); }
    // All of these are NaN without any value.
    [[nodiscard]] double rmse() const noexcept;
    [[nodiscard]] double bias() const noexcept;   ///< the mean
    [[nodiscard]] double worst() const noexcept;  ///< greatest size
    /// The size that a share of the differences does not exceed. @param share (0, 1]
    [[nodiscard]] double size_at(double share) const;

private:
    std::vector<float> m_values;
};

/// How often a condition held. NaN when it was never tested.
struct Share {
    std::size_t held = 0;
    std::size_t asked = 0;
    void add(bool holds) noexcept {
        held += holds ? 1U : 0U;
        ++asked;
    }
    [[nodiscard]] double value() const noexcept;
};

/// Two sets of columns: how much they agree.
struct Overlap {
    std::size_t both = 0;
    std::size_t either = 0;
    void add(bool found, bool real) noexcept {
        both += found && real ? 1U : 0U;
        either += found || real ? 1U : 0U;
    }
    [[nodiscard]] double iou()
        const noexcept;  ///< intersection over union; NaN when both sets are empty
};

}  // namespace terravox::bench
