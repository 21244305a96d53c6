#include "common/util/linear_light.hpp"

#include <algorithm>
#include <array>

#include "common/util/det_math.hpp"

namespace terravox::util {
namespace {

double to_linear_value(double srgb) {
    return srgb <= 0.04045 ? srgb / 12.92 : det::pow((srgb + 0.055) / 1.055, 2.4);
}

struct Tables {
    std::array<std::uint16_t, 256> linear{};
    std::array<std::uint8_t, kBrightest + 1> srgb{};
};

// The inverse uses the boundaries between adjacent values (at v + 1/2), instead of 65536
// evaluations of pow().
const Tables& tables() {
    static const Tables made = [] {
        Tables out;
        std::size_t next = 0;
        for (int v = 0; v < 256; ++v) {
            const auto i = static_cast<std::size_t>(v);
            out.linear[i] =
                static_cast<std::uint16_t>(to_linear_value(v / 255.0) * kBrightest + 0.5);
            const auto end =
                v == 255
                    ? out.srgb.size()
                    : static_cast<std::size_t>(to_linear_value((v + 0.5) / 255) * kBrightest + 0.5);
            while (next < end)
                out.srgb[next++] = static_cast<std::uint8_t>(v);
        }
        return out;
    }();
    return made;
}

}  // namespace

std::uint32_t to_linear(std::uint8_t srgb) noexcept {
    return tables().linear[srgb];
}

std::uint8_t to_srgb(std::uint32_t linear) noexcept {
    return tables().srgb[std::min(linear, kBrightest)];
}

}  // namespace terravox::util
