#include "voxelserver/make/voxelize/points/vertical_datums.hpp"

#include <cctype>
#include <set>
#include <string>

#include "common/util/letter_case.hpp"
#include "common/util/log.hpp"

namespace terravox::voxelize {
namespace {

// Programs spell one name in many ways: "NGF-IGN69", "NGF - IGN69".
std::string plain(const std::string& name) {
    std::string out;
    for (const char c : name)
        if (std::isalnum(static_cast<unsigned char>(c)) != 0)
            out += util::lower_case(c);
    return out;
}

}  // namespace

void warn_of_mixed_datums(std::span<const pointcloud::PointCloudInfo> infos) {
    constexpr std::size_t kNamed = 4;
    std::set<std::string> seen;
    std::string named;
    for (const pointcloud::PointCloudInfo& info : infos) {
        const auto datum = info.crs ? info.crs->vertical_datum() : std::nullopt;
        if (!datum || !seen.insert(plain(*datum)).second || seen.size() > kNamed)
            continue;
        named += (named.empty() ? "" : ", ") + info.path.string() + " from '" + *datum + "'";
    }
    if (seen.size() < 2)
        return;
    if (seen.size() > kNamed)
        named += " and " + std::to_string(seen.size() - kNamed) + " more";
    util::log_warn(
        "heights are measured from different datums and not converted, so files may not meet: {}; "
        "--crs sets one for all files",
        named);
}

}  // namespace terravox::voxelize
