#pragma once

#include <array>
#include <cstddef>

namespace terravox::trace {

/// The standard error of the mean of a sequence whose neighbours are spread evenly, as those of a
/// scrambled (0,2)-sequence are: means of batches of 2^k successive numbers vary less than as many
/// independent numbers would. 8 to 15 batches are compared, so they grow with the sequence.
/// Ref: Yeh and Schmeiser, "Simulation output analysis via dynamic batch means", WSC 2000.
///
/// The mean of all batches is nearer to the truth than independent ones would be, too, so the error
/// is rather too large than too small.
class BatchMeans {
public:
    void add(float value) noexcept;
    /// Standard error of the mean of all numbers so far; 0 with fewer than two.
    [[nodiscard]] double error() const noexcept;

private:
    static constexpr std::size_t kMostBatches = 16;
    void join_pairs() noexcept;

    std::array<float, kMostBatches> m_sums{};  ///< of batches; the last one may be incomplete
    std::size_t m_batches = 0;                 ///< complete ones
    std::size_t m_batch_size = 1;
    std::size_t m_in_last = 0;  ///< numbers in the incomplete batch
};

}  // namespace terravox::trace
