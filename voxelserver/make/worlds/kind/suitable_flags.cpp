#include "voxelserver/make/worlds/kind/suitable_flags.hpp"

#include "common/util/error.hpp"

namespace terravox::worlds {

void check_flags(const std::string& input, std::string_view noun, std::string_view suitable,
                 std::span<const std::string> given) {
    const std::string padded = " " + std::string(suitable) + " ";
    for (const std::string& flag : given) {
        if (padded.find(" " + flag + " ") != std::string::npos)
            continue;
        throw util::UsageError(
            "open the world " + input + ": " + flag + " with " + std::string(noun) +
            "; allowed: " + (suitable.empty() ? "none such" : std::string(suitable)));
    }
}

}  // namespace terravox::worlds
