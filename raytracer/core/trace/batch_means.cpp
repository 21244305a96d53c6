#include "raytracer/core/trace/batch_means.hpp"

#include <cmath>

namespace terravox::trace {

void BatchMeans::add(float value) noexcept {
    m_sums[m_batches] += value;
    ++m_in_last;
    if (m_in_last < m_batch_size)
        return;
    m_in_last = 0;
    ++m_batches;
    if (m_batches == kMostBatches)
        join_pairs();
}

double BatchMeans::error() const noexcept {
    if (m_batches < 2)
        return 0;
    const auto batches = static_cast<double>(m_batches);
    double mean = 0;
    for (std::size_t i = 0; i < m_batches; ++i)
        mean += static_cast<double>(m_sums[i]);
    mean /= batches;
    double squares = 0;
    for (std::size_t i = 0; i < m_batches; ++i) {
        const double deviation = static_cast<double>(m_sums[i]) - mean;
        squares += deviation * deviation;
    }
    // The variance of one batch's mean stands for as many numbers as the batch has.
    const auto size = static_cast<double>(m_batch_size);
    const double of_batch = squares / (batches - 1) / (size * size);
    const double numbers = batches * size + static_cast<double>(m_in_last);
    return std::sqrt(of_batch * size / numbers);
}

void BatchMeans::join_pairs() noexcept {
    constexpr std::size_t kLeft = kMostBatches / 2;
    for (std::size_t i = 0; i < kLeft; ++i)
        m_sums[i] = m_sums[2 * i] + m_sums[2 * i + 1];
    for (std::size_t i = kLeft; i < kMostBatches; ++i)
        m_sums[i] = 0;
    m_batches = kLeft;
    m_batch_size *= 2;
}

}  // namespace terravox::trace
