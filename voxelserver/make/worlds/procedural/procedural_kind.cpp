#include "voxelserver/make/worlds/procedural/procedural_world.hpp"

#include <charconv>
#include <filesystem>

#include "common/util/error.hpp"

namespace terravox::worlds {
namespace {

/// A file of that name takes precedence.
bool is_generated(const std::string& input) {
    std::error_code failed;
    const auto type = std::filesystem::status(input, failed).type();
    if (type != std::filesystem::file_type::not_found)
        return false;
    return input == "generated" || input.starts_with("generated:");
}

/// It reads no file: its text and options define everything.
voxel::Fingerprint state_of_nothing(const worlds::WorldOptions& /*options*/) {
    return {};
}

std::unique_ptr<voxel::World> open_generated(const OpenRequest& request) {
    procedural::Settings settings = request.options.generated;
    settings.voxel_m = request.options.voxel_m;
    const std::string& input = request.input();
    if (const auto colon = input.find(':'); colon != std::string::npos) {
        const std::string seed = input.substr(colon + 1);
        const char* const end = seed.data() + seed.size();
        const auto read = std::from_chars(seed.data(), end, settings.seed);
        if (seed.empty() || read.ec != std::errc{} || read.ptr != end) {
            throw util::UsageError(
                "open the world {}: the seed is '{}'; allowed: 0 to 18446744073709551615", input,
                seed);
        }
    }
    return procedural::open_procedural_world(settings);
}

}  // namespace

constinit const WorldKind kProceduralKind{
    .noun = "a generated world",
    .input = "generated:SEED",
    .recognises = is_generated,
    .open = open_generated,
    .state = state_of_nothing,
    .flags =
        "--voxel --generated-water-level --generated-world-height --generated-harmonics "
        "--generated-frequency --generated-smoothness --generated-trees",
    .is_path = false,
    .farm_access = FarmAccess::kBySeed,
};

}  // namespace terravox::worlds
