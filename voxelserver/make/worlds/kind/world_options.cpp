#include "voxelserver/make/worlds/kind/world_options.hpp"

#include <string>

#include "common/util/error.hpp"
#include "common/util/text.hpp"

namespace terravox::procedural {
namespace {

using util::number_text;

void check_range(const char* field, double value, double min, double max) {
    if (value >= min && value <= max)
        return;
    throw util::UsageError("generate the world: {} = {}; allowed: {} to {}", field,
                           number_text(value), number_text(min), number_text(max));
}

}  // namespace

void check(const Settings& s) {
    check_range("water_level", s.water_level, -4096, 4096);
    check_range("world_height", s.world_height, 8, 4096);
    check_range("harmonics", s.harmonics, 1, 16);
    check_range("frequency", s.frequency, 1e-5, 0.1);
    check_range("smoothness", s.smoothness, 0, 1);
    if (!(s.voxel_m > 0))
        throw util::UsageError("generate the world: voxel_m = {}; allowed: above 0, up to 1000",
                               number_text(s.voxel_m));
    check_range("voxel_m", s.voxel_m, 0, 1000);
}

}  // namespace terravox::procedural

namespace terravox::worlds {

void check_flags(const std::string& input, std::string_view noun, std::string_view suitable,
                 std::span<const std::string> given) {
    const std::string padded = " " + std::string(suitable) + " ";
    for (const std::string& flag : given) {
        if (padded.find(" " + flag + " ") != std::string::npos)
            continue;
        throw util::UsageError("open the world {}: {} with {}; allowed: {}", input, flag, noun,
                               suitable.empty() ? "none such" : std::string(suitable));
    }
}

}  // namespace terravox::worlds
