#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

namespace terravox::lidar {

/// The entropy decoder of LASzip, as far as needed to read a chunk table. Damaged input gives wrong
/// symbols, never undefined behaviour. Ref: Said, "Introduction to Arithmetic Coding", HP
/// Laboratories HPL-2004-76, 2004 (adaptive models of 15 and 13 bits).
class RangeDecoder {
public:
    /// Adaptive symbol frequencies; the probabilities used for decoding are updated from them at
    /// intervals.
    class SymbolModel {
    public:
        explicit SymbolModel(std::uint32_t symbols);

    private:
        friend class RangeDecoder;
        void update();
        std::vector<std::uint32_t> m_counts;
        /// The cumulative probability of all smaller symbols, in units of 2^-15.
        std::vector<std::uint32_t> m_below;
        std::uint32_t m_total = 0;
        std::uint32_t m_cycle = 0;
        std::uint32_t m_until_update = 0;
    };
    class BitModel {
        friend class RangeDecoder;
        void update();
        std::uint32_t m_zeros = 1;
        std::uint32_t m_total = 2;
        std::uint32_t m_zero_share = 1U << 12;
        std::uint32_t m_cycle = 4;
        std::uint32_t m_until_update = 4;
    };

    /// @param next_byte  returns the next input byte; throws at the end of the input
    explicit RangeDecoder(std::function<std::uint8_t()> next_byte);
    std::uint32_t symbol(SymbolModel& model);
    std::uint32_t bit(BitModel& model);
    /// @param count  1 to 32
    std::uint32_t bits(std::uint32_t count);

private:
    void refill();
    std::function<std::uint8_t()> m_next_byte;
    std::uint32_t m_value = 0;
    std::uint32_t m_length = 0xFFFFFFFF;
};

/// LASzip's decoder of 32-bit integers as corrections of a prediction, with two contexts.
class IntegerDecoder {
public:
    explicit IntegerDecoder(RangeDecoder& decoder);
    /// @param context  0 or 1
    std::int32_t next(std::int32_t predicted, std::size_t context);

private:
    std::uint32_t correction(std::size_t context);
    RangeDecoder& m_decoder;
    std::array<RangeDecoder::SymbolModel, 2> m_widths;
    RangeDecoder::BitModel m_zero_or_one;
    std::vector<RangeDecoder::SymbolModel> m_high_bits;  ///< index: width - 1
};

}  // namespace terravox::lidar
