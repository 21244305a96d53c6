#include "voxelserver/make/voxelize/columns/file_plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

namespace terravox::voxelize {
namespace {

constexpr std::size_t kSquaresShare = 3;
constexpr std::size_t kPartsShare = 8;
constexpr std::size_t kColumnsShare = 6;
// The memory that one box needs: with less, every step would decode again.
constexpr std::size_t kMinParts = std::size_t{8} << 20;
constexpr std::size_t kMinColumns = std::size_t{16} << 20;

double width_of(const SquareSource& source) {
    return static_cast<double>(source.bounds.max_x) - source.bounds.min_x;
}
double depth_of(const SquareSource& source) {
    return static_cast<double>(source.bounds.max_z) - source.bounds.min_z;
}

// Whether a file can be kept whole, and binned in half as much additional memory: small voxels have
// more patches than points.
bool fits(const SquareSource& source, std::size_t limit_bytes) {
    constexpr double kPatchBytes = sizeof(store::PatchEntry);
    constexpr double kBinningBytes = 64;
    constexpr double kRunBytes = 32;
    constexpr double kAround = 16384;
    const auto points = static_cast<double>(source.info.point_count);
    const double width = width_of(source);
    const double depth = depth_of(source);
    const double patches =
        std::min((width / grid::kPatchSize + 3) * (depth / grid::kPatchSize + 3), points);
    const double spacing = std::sqrt(width * depth / std::max(points, 1.0));
    const double run = std::max(1.0, grid::kPatchSize / (2 * spacing + 1e-3));
    const auto limit = static_cast<double>(limit_bytes);
    return points * sizeof(store::VoxelPoint) + patches * kPatchBytes + kAround < limit &&
           patches * kBinningBytes + points / run * kRunBytes < limit / 2;
}

/// CRSs as text. Writing one takes longer than all else, and thousands of files have the same one.
class CrsTexts {
public:
    const std::string& of(const geo::Crs& crs) {
        const auto [text, is_new] = m_texts.try_emplace(&crs.ogr());
        if (is_new)
            text->second = crs.wkt();
        return text->second;
    }

private:
    std::map<const OGRSpatialReference*, std::string> m_texts;
};

std::string recipe_text(const SquareSource& source, const SquareRecipe& recipe, CrsTexts& crs) {
    const grid::Frame& frame = recipe.frame;
    const Settings::Points& filters = recipe.settings.points;
    std::string out = "points 3|" + crs.of(frame.crs()) + "|" + crs.of(*source.info.crs) + "|";
    for (const double v : {frame.units_per_voxel(), frame.voxel_m(), source.vertical_metres,
                           source.lowest, source.highest})
        out += fmt::format("{}|", v);  // every digit
    for (const bool flag : {filters.drop_withheld, filters.drop_overlap, source.has_colour})
        out += flag ? 'y' : 'n';
    out += std::to_string(source.colour_shift);
    for (const BrightnessScale::Line& line : source.brightness.lines())
        out += fmt::format("|{}:{}", line.number, line.bright_ground);
    for (const ClassMeaning& m : recipe.classes.meaning)
        out += m.role == Role::kDrop ? 'd' : 'k';
    return out;
}

// A block and the patches around it take at most a quarter of their share, unless a single patch is
// larger.
int block_patches_of(const SquareSource& source, std::size_t parts_bytes) {
    const double columns = std::max(width_of(source) * depth_of(source), 1.0);
    const double patch_bytes = static_cast<double>(source.info.point_count) *
                                   sizeof(store::VoxelPoint) / columns * grid::kPatchColumns +
                               2 * sizeof(store::PatchEntry);
    const double patches = static_cast<double>(parts_bytes) / 4 / patch_bytes;
    return std::max(1, static_cast<int>(std::sqrt(patches)) - 2);
}

}  // namespace

PointMemory share_memory(std::size_t memory_bytes, std::span<const SquareSource> files) {
    PointMemory out{memory_bytes / kSquaresShare, std::max(memory_bytes / kPartsShare, kMinParts),
                    std::max(memory_bytes / kColumnsShare, kMinColumns)};
    const auto fitting = std::count_if(files.begin(), files.end(),
                                       [&](const SquareSource& s) { return fits(s, out.squares); });
    if (fitting == static_cast<std::ptrdiff_t>(files.size()))
        return out;
    const std::size_t given = fitting == 0 ? out.squares : out.squares / 2;
    out.squares -= given;
    out.parts += given;
    return out;
}

std::vector<PartedFile> plan_files(std::span<const SquareSource> files, const PointMemory& memory,
                                   const SquareRecipe* recipe) {
    std::vector<PartedFile> out;
    CrsTexts crs;
    for (const SquareSource& source : files) {
        PartedFile file;
        file.source = &source;
        if (recipe != nullptr)
            file.name = store::square_name(source.info.path, source.identity,
                                           recipe_text(source, *recipe, crs));
        file.kept_whole = fits(source, memory.squares);
        if (!file.kept_whole)
            file.block_patches = block_patches_of(source, memory.parts);
        out.push_back(std::move(file));
    }
    return out;
}

}  // namespace terravox::voxelize
