#include "voxelserver/data/pointcloud/formats/files.hpp"

#include <algorithm>
#include <array>
#include <span>
#include <string_view>

#include "common/util/error.hpp"
#include "common/util/files.hpp"
#include "common/util/text.hpp"
#include "voxelserver/data/pointcloud/file_bytes.hpp"
#include "voxelserver/data/pointcloud/formats/list.hpp"

namespace terravox::pointcloud {
namespace {

namespace fs = std::filesystem;

/// The members of a format that this file uses; open.cpp uses the rest.
struct Row {
    std::string_view name;
    std::span<const std::string_view> endings;
    std::string_view side_ending;
    Recognition (*recognise)(std::string_view head) noexcept;
};

template <PointFormat... Each>
constexpr std::array<Row, sizeof...(Each)> make_rows(const std::tuple<Each...>& /*formats*/) {
    return {Row{Each::kName, Each::kEndings, Each::kSideEnding, Each::recognise}...};
}

constexpr auto kRows = make_rows(Formats());

bool has_ending(const Row& row, const fs::path& file) {
    return std::find(row.endings.begin(), row.endings.end(), util::lower_extension(file)) !=
           row.endings.end();
}

std::optional<std::size_t> find_format(const fs::path& file) {
    const std::string head = util::read_start(file, kHeadBytes);
    for (std::size_t i = 0; i < kRows.size(); ++i) {
        if (kRows[i].recognise(head) != Recognition::kUnknown)
            return i;
    }
    for (std::size_t i = 0; i < kRows.size(); ++i) {
        if (has_ending(kRows[i], file))
            return i;
    }
    return std::nullopt;
}

}  // namespace

bool is_point_file(const fs::path& file) {
    return find_format(file).has_value();
}

bool is_point_file_of_folder(const fs::path& file) {
    const auto row =
        std::find_if(kRows.begin(), kRows.end(), [&](const Row& r) { return has_ending(r, file); });
    return row != kRows.end() &&
           row->recognise(util::read_start(file, kHeadBytes)) != Recognition::kOther;
}

std::vector<fs::path> expand_point_files(const std::vector<fs::path>& paths) {
    std::vector<std::string_view> endings;
    for (const Row& row : kRows)
        endings.insert(endings.end(), row.endings.begin(), row.endings.end());
    return util::expand_folders(paths, endings, "LiDAR data", is_point_file_of_folder);
}

std::optional<fs::path> find_side_file(const fs::path& file) {
    const auto format = find_format(file);
    if (!format || kRows[*format].side_ending.empty())
        return std::nullopt;
    fs::path side_file = file;
    side_file.replace_extension(kRows[*format].side_ending);
    std::error_code failed;
    return fs::is_regular_file(side_file, failed) ? std::optional(side_file) : std::nullopt;
}

std::size_t find_format_by(const fs::path& file) {
    const auto found = find_format(file);
    if (!found)
        FileBytes(file).fail("no known format; allowed: " + format_names());
    return *found;
}

std::string format_names() {
    std::string out;
    for (const Row& row : kRows)
        out += (out.empty() ? "" : ", ") + std::string(row.name);
    return out;
}

}  // namespace terravox::pointcloud
