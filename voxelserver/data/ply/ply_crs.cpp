#include "voxelserver/data/ply/ply_crs.hpp"

#include <algorithm>
#include <string_view>
#include <vector>

#include "common/geo/proj_check.hpp"
#include "common/util/error.hpp"
#include "common/util/log.hpp"
#include "voxelserver/data/ply/ply_format.hpp"
#include "voxelserver/data/pointcloud/file_bytes.hpp"

namespace terravox::ply {
namespace {

/// Whether a text is EPSG:n or EPSG:n+m. Any other text in a file is parsed as WKT: PROJ strings
/// are accepted from users only.
bool is_epsg(std::string_view text) {
    constexpr std::string_view kAuthority = "EPSG:";
    constexpr std::string_view kNumbers = "0123456789+";
    return text.starts_with(kAuthority) && text.size() > kAuthority.size() &&
           text.find_first_not_of(kNumbers, kAuthority.size()) == std::string_view::npos;
}

geo::Crs crs_from(const std::string& text) {
    return is_epsg(text) ? geo::Crs::from_text(text) : geo::Crs::from_wkt(text);
}

std::string text_of(const std::filesystem::path& file) {
    constexpr std::uint64_t kMaxBytes = 64 * 1024;
    const pointcloud::FileBytes bytes(file);
    if (bytes.size() > kMaxBytes)
        bytes.fail(std::to_string(bytes.size()) + " bytes; a .prj file has at most 65536");
    std::vector<unsigned char> text(static_cast<std::size_t>(bytes.size()));
    bytes.read(0, text);
    return {text.begin(), text.end()};
}

}  // namespace

std::optional<geo::Crs> crs_of(const std::filesystem::path& file, const std::string& comment) {
    std::filesystem::path side_file = file;
    side_file.replace_extension(PlyFormat::kSideEnding);
    std::error_code failed;
    const bool has_side_file = std::filesystem::exists(side_file, failed);
    if (comment.empty() && !has_side_file)
        return std::nullopt;
    try {
        return crs_from(comment.empty() ? text_of(side_file) : comment);
    } catch (const geo::ProjUnusableError&) {
        throw;
    } catch (const util::Error& e) {
        util::log_info("{}: {}; --crs sets one", file.string(), e.what());
        return std::nullopt;
    }
}

}  // namespace terravox::ply
