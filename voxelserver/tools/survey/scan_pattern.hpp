#pragma once

#include <cstdint>

#include "voxelserver/tools/survey/hash.hpp"
#include "voxelserver/tools/survey/plane.hpp"

namespace terravox::survey {

/// One laser pulse, identified by the point where it would hit the bare ground.
struct Pulse {
    Vec2 foot;                ///< on the ground, place frame
    Vec2 lean;                ///< metres towards the aircraft for each metre up
    double angle_deg = 0;     ///< from straight down; positive to the right of the flight
    double time_s = 0;        ///< adjusted standard GPS time
    std::uint64_t key = 0;    ///< source of all randomness of this pulse
    std::uint16_t strip = 0;  ///< point source id, [1, 65535]
    bool forward = false;     ///< direction of the mirror
    bool strip_edge = false;  ///< first or last of its scan line
};

/// The flight of the aircraft: parallel strips that overlap by about 30 %, flown to and fro, at a
/// small angle to north; scan lines across each strip. The pattern covers the whole plane and
/// depends on seed and density only, so that every square sees its part of the same flight.
class ScanPattern {
public:
    /// @param density pulses on each square metre, averaged over strips and overlaps
    ScanPattern(std::uint64_t seed, double density);

    static constexpr double kFlightHeight_m = 1200;
    static constexpr double kSwath_m = 660;
    static constexpr double kStripDistance_m = 470;
    static constexpr double kSpeed_m_s = 60;
    /// Greatest lean of any pulse: metres sideways for each metre up.
    static constexpr double kMaxLean = 0.5 * kSwath_m / kFlightHeight_m;

    /// Calls visit(pulse) for each pulse that may hit the ground in `area`, strip by strip, scan
    /// line by scan line in the order of the flight. A few pulses just outside of the area are
    /// visited too.
    template <class Visit>
    void visit(const Box2& area, const Visit& visit) const;

private:
    struct Line {
        std::int64_t strip = 0;
        std::int64_t number = 0;
        double forward_m = 0;
    };
    /// The part of a scan line within an area, as pulse numbers [first, last].
    struct Range {
        std::int64_t first = 0;
        std::int64_t last = -1;
    };
    struct Span {
        std::int64_t first = 0;
        std::int64_t last = -1;
    };

    [[nodiscard]] Span strips_over(const Box2& area) const noexcept;
    [[nodiscard]] Span lines_over(const Box2& area) const noexcept;
    [[nodiscard]] Line line(std::int64_t strip, std::int64_t number) const noexcept;
    [[nodiscard]] Range clip(const Line& line, const Box2& area) const noexcept;
    [[nodiscard]] Pulse pulse(const Line& line, std::int64_t number) const noexcept;
    [[nodiscard]] static Vec2 place(double across_m, double forward_m) noexcept;
    [[nodiscard]] static bool flown_north(std::int64_t strip) noexcept { return (strip & 1) == 0; }

    std::uint64_t m_seed;
    double m_spacing_m;  ///< between pulses of a line and between lines, on average
    std::int64_t m_pulses_per_line;
};

template <class Visit>
void ScanPattern::visit(const Box2& area, const Visit& visit) const {
    const Span strips = strips_over(area);
    const Span lines = lines_over(area);
    for (auto s = strips.first; s <= strips.last; ++s) {
        const std::int64_t step = flown_north(s) ? 1 : -1;
        for (auto n = step > 0 ? lines.first : lines.last; n >= lines.first && n <= lines.last;
             n += step) {
            const Line scan = line(s, n);
            const Range range = clip(scan, area);
            for (auto i = range.first; i <= range.last; ++i)
                visit(pulse(scan, i));
        }
    }
}

}  // namespace terravox::survey
