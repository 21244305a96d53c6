#include "voxelserver/data/lidar/compatible.hpp"

#include <algorithm>
#include <array>
#include <string>

namespace terravox::lidar {
namespace {

/// Size of the description of one extra-bytes field.
constexpr std::uint64_t kDescriptionBytes = 192;
constexpr std::uint32_t kNowhere = 0xFFFFFFFF;

// Bytes per value. Types 1-10 are scalars, 11-20 pairs and 21-30 triples of them; for type 0 the
// size is stored separately.
std::optional<std::uint32_t> value_bytes(std::uint8_t type, std::uint8_t reported) {
    constexpr std::array<std::uint32_t, 10> kBytes = {1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
    if (type == 0)
        return reported;
    if (type > 3 * kBytes.size())
        return std::nullopt;
    return kBytes[(type - 1U) % kBytes.size()] * ((type - 1U) / kBytes.size() + 1);
}

}  // namespace

std::optional<CompatibleBytes> find_compatible_bytes(const pointcloud::FileBytes& file,
                                                     const std::vector<VariableRecord>& records,
                                                     int point_format, std::uint32_t extra_bytes) {
    const auto find = [&](const char* user, int id) {
        return std::find_if(records.begin(), records.end(),
                            [&](const VariableRecord& r) { return r.id == id && r.user == user; });
    };
    const bool can =
        point_format == 1 || point_format == 3 || point_format == 4 || point_format == 5;
    const auto descriptions = find("LASF_Spec", 4);
    if (!can || find("lascompatible", 22204) == records.end() || descriptions == records.end())
        return std::nullopt;
    std::uint32_t returns = kNowhere;
    std::uint32_t classification = kNowhere;
    std::uint32_t flags = kNowhere;
    std::uint32_t infrared = kNowhere;
    std::uint32_t at = 0;
    for (std::uint64_t i = 0; i < descriptions->bytes / kDescriptionBytes; ++i) {
        const std::uint64_t description = descriptions->at + i * kDescriptionBytes;
        const auto name = file.at<std::array<char, 32>>(description + 4);
        const std::string text(name.begin(), std::find(name.begin(), name.end(), '\0'));
        const auto bytes = value_bytes(file.at<std::uint8_t>(description + 2),
                                       file.at<std::uint8_t>(description + 3));
        if (!bytes)
            return std::nullopt;
        const auto take = [&](const char* wanted, std::uint32_t size, std::uint32_t& where) {
            if (text == wanted && at + size <= extra_bytes)
                where = at;
        };
        take("LAS 1.4 extended returns", 1, returns);
        take("LAS 1.4 classification", 1, classification);
        take("LAS 1.4 flags and channel", 1, flags);
        take("LAS 1.4 NIR band", 2, infrared);
        at += *bytes;
    }
    if (returns == kNowhere || classification == kNowhere || flags == kNowhere)
        return std::nullopt;
    return CompatibleBytes{returns, classification, flags,
                           infrared == kNowhere ? std::nullopt : std::optional(infrared)};
}

}  // namespace terravox::lidar
