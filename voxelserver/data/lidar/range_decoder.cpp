#include "voxelserver/data/lidar/range_decoder.hpp"

#include <algorithm>

namespace terravox::lidar {
namespace {

constexpr std::uint32_t kSymbolBits = 15;
constexpr std::uint32_t kBitBits = 13;
constexpr std::uint32_t kShortest = 1U << 24;
/// Number of high bits of a correction that are coded with a model; the rest are stored directly.
constexpr std::uint32_t kMaxHighBits = 8;

}  // namespace

RangeDecoder::SymbolModel::SymbolModel(std::uint32_t symbols)
    : m_counts(symbols, 1), m_below(symbols), m_cycle(symbols) {
    update();
    m_cycle = m_until_update = (symbols + 6) / 2;
}

void RangeDecoder::SymbolModel::update() {
    const auto symbols = static_cast<std::uint32_t>(m_counts.size());
    m_total += m_cycle;
    if (m_total > 1U << kSymbolBits) {
        m_total = 0;
        for (std::uint32_t& n : m_counts)
            m_total += n = (n + 1) / 2;
    }
    const std::uint32_t scale = 0x80000000U / m_total;
    std::uint32_t sum = 0;
    for (std::uint32_t i = 0; i < symbols; ++i) {
        m_below[i] = (scale * sum) >> (31 - kSymbolBits);
        sum += m_counts[i];
    }
    m_cycle = std::min(5 * m_cycle / 4, (symbols + 6) * 8);
    m_until_update = m_cycle;
}

void RangeDecoder::BitModel::update() {
    m_total += m_cycle;
    if (m_total > 1U << kBitBits) {
        m_total = (m_total + 1) / 2;
        m_zeros = (m_zeros + 1) / 2;
        if (m_zeros == m_total)
            ++m_total;
    }
    m_zero_share = (m_zeros * (0x80000000U / m_total)) >> (31 - kBitBits);
    m_cycle = std::min(5 * m_cycle / 4, 64U);
    m_until_update = m_cycle;
}

RangeDecoder::RangeDecoder(std::function<std::uint8_t()> next_byte)
    : m_next_byte(std::move(next_byte)) {
    for (int i = 0; i < 4; ++i)
        m_value = m_value << 8 | m_next_byte();
}

void RangeDecoder::refill() {
    // Only damaged data give a length of 0; after four bytes any length is sufficient or stays 0.
    for (int i = 0; i < 4 && m_length < kShortest; ++i) {
        m_value = m_value << 8 | m_next_byte();
        m_length <<= 8;
    }
    m_length = std::max(m_length, kShortest);
}

std::uint32_t RangeDecoder::symbol(SymbolModel& model) {
    const std::uint32_t whole = m_length;
    m_length >>= kSymbolBits;
    const std::uint32_t share = m_value / m_length;
    const auto above = std::upper_bound(model.m_below.begin() + 1, model.m_below.end(), share);
    const auto found = static_cast<std::size_t>(above - model.m_below.begin()) - 1;
    const std::uint32_t from = model.m_below[found] * m_length;
    const std::uint32_t to = above == model.m_below.end() ? whole : *above * m_length;
    m_value -= from;
    m_length = to - from;
    refill();
    ++model.m_counts[found];
    if (--model.m_until_update == 0)
        model.update();
    return static_cast<std::uint32_t>(found);
}

std::uint32_t RangeDecoder::bit(BitModel& model) {
    const std::uint32_t zero = model.m_zero_share * (m_length >> kBitBits);
    const std::uint32_t out = m_value >= zero ? 1 : 0;
    if (out == 0) {
        m_length = zero;
        ++model.m_zeros;
    } else {
        m_value -= zero;
        m_length -= zero;
    }
    refill();
    if (--model.m_until_update == 0)
        model.update();
    return out;
}

std::uint32_t RangeDecoder::bits(std::uint32_t count) {
    constexpr std::uint32_t kMaxAtOnce = 19;
    if (count > kMaxAtOnce) {
        const std::uint32_t low = bits(16);
        return bits(count - 16) << 16 | low;
    }
    m_length >>= count;
    const std::uint32_t out = m_value / m_length;
    m_value -= m_length * out;
    refill();
    return out;
}

IntegerDecoder::IntegerDecoder(RangeDecoder& decoder)
    : m_decoder(decoder), m_widths{RangeDecoder::SymbolModel(33), RangeDecoder::SymbolModel(33)} {
    for (std::uint32_t width = 1; width < 32; ++width)
        m_high_bits.emplace_back(1U << std::min(width, kMaxHighBits));
}

std::uint32_t IntegerDecoder::correction(std::size_t context) {
    // A correction of width k lies in [-(2^k - 1), -2^(k-1)] or [2^(k-1) + 1, 2^k]; width 0 is 0
    // or 1.
    const std::uint32_t width = m_decoder.symbol(m_widths[context]);
    if (width == 0)
        return m_decoder.bit(m_zero_or_one);
    if (width == 32)
        return 0x80000000U;
    std::uint32_t value = m_decoder.symbol(m_high_bits[width - 1]);
    if (width > kMaxHighBits) {
        const std::uint32_t low = width - kMaxHighBits;
        value = value << low | m_decoder.bits(low);
    }
    return value >= 1U << (width - 1) ? value + 1 : value - ((1U << width) - 1);
}

std::int32_t IntegerDecoder::next(std::int32_t predicted, std::size_t context) {
    return static_cast<std::int32_t>(static_cast<std::uint32_t>(predicted) + correction(context));
}

}  // namespace terravox::lidar
