#include "tests/bench/entries/scale_world.hpp"

#include <fstream>
#include <optional>
#include <system_error>
#include <vector>

#include "common/thread/parallel.hpp"
#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"
#include "common/voxel/box_builder.hpp"
#include "common/voxel/downsample.hpp"
#include "tests/bench/entries/scale_noise.hpp"

namespace terravox::bench {
namespace {

using voxel::Box;
using voxel::BoxKey;
using voxel::Material;
using voxel::VoxelAttr;

constexpr int kSideWithMargin = voxel::kBoxSizeX + 2;
/// Part of the folder's name: a change of the land or of the rule of the levels needs another one.
constexpr const char* kVersionOfBoxes = "1";

void add_column(voxel::BoxBuilder& builder, int x, int z, const LandColumn& c) noexcept {
    builder.add(x, z, -1, c.ground, true);  // from below the world: its underside is never visible
    if (c.water > c.ground)
        builder.add(x, z, c.ground, c.water, false);
    for (const LandRun& run : c.runs)
        if (!run.empty())
            builder.add(x, z, run.y0, run.y1, !see_through(run.material));
}

VoxelAttr attr_of(Material material, voxel::Rgb8 colour, double brightness) noexcept {
    VoxelAttr out;
    out.material = material;
    out.flags = VoxelAttr::kHasColour;
    out.colour = shaded(colour, brightness);
    return out;
}

VoxelAttr look_at(const LandColumn& c, int y, std::uint64_t voxel_hash) noexcept {
    const double brightness = c.shade * (0.96 + 0.08 * unit_of(voxel_hash, 0));
    if (y < c.ground - 3)
        return attr_of(Material::kRock, {0x80, 0x7a, 0x70}, brightness);
    if (y < c.ground - 1)
        return attr_of(Material::kSoil, {0x76, 0x60, 0x48}, brightness);
    if (y < c.ground)
        return attr_of(c.surface, c.colour, brightness);
    if (y < c.water)
        return attr_of(Material::kWater, {0x3a, 0x60, 0x70}, 1);
    for (const LandRun& run : c.runs) {
        if (y < run.y0 || y >= run.y1)
            continue;
        const double leafy = see_through(run.material) ? 0.8 + 0.4 * unit_of(voxel_hash, 1) : 1;
        return y == run.y1 - 1 ? attr_of(run.material, run.colour, brightness * leafy)
                               : attr_of(run.beneath, run.colour_beneath, brightness * leafy);
    }
    return {};
}

std::optional<std::vector<std::byte>> read_bytes(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary | std::ios::ate);
    if (!in)
        return std::nullopt;
    std::vector<std::byte> bytes(static_cast<std::size_t>(in.tellg()));
    in.seekg(0);
    if (!in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size())))
        return std::nullopt;
    return bytes;
}

}  // namespace

ScaleWorld::ScaleWorld(int side_km, const std::filesystem::path& kept_boxes)
    : m_kept(kept_boxes / (std::string("land-") + kVersionOfBoxes + "-" + std::to_string(kSeed))) {
    if (side_km < 1 || side_km > 100)
        throw util::Error("make a land of " + std::to_string(side_km) + " km; allowed: 1 to 100");
    const std::int32_t half = side_km * 500;
    m_info.title = "synthetic landscape of " + std::to_string(side_km) + " x " +
                   std::to_string(side_km) + " km";
    m_info.bounds = {{-half, 0, -half}, {half, Land::kHighest, half}};
    m_info.levels = kLevels;
    std::filesystem::create_directories(m_kept);
}

bool ScaleWorld::inside(std::int32_t x, std::int32_t z) const noexcept {
    const auto& b = m_info.bounds;
    return x >= b.min[0] && x < b.max[0] && z >= b.min[2] && z < b.max[2];
}

voxel::ColumnExtent ScaleWorld::column(int level, std::int32_t bx, std::int32_t bz) {
    return boxes_over(m_info.bounds, level).contains({level, bx, 0, bz}) ? voxel::ColumnExtent{0, 1}
                                                                         : voxel::ColumnExtent{};
}

std::filesystem::path ScaleWorld::file_of(const BoxKey& key) const {
    const std::int32_t side = voxel::kBoxSizeX << key.level;
    const std::int32_t x = key.bx * side;
    const std::int32_t z = key.bz * side;
    const bool whole = inside(x - 1, z - 1) && inside(x + side, z + side);
    const std::string size = whole ? "all" : std::to_string(m_info.bounds.max[0] / 500) + "km";
    return m_kept / size / std::to_string(key.level) / std::to_string(key.bx) /
           (std::to_string(key.bz) + ".box");
}

std::shared_ptr<const Box> ScaleWorld::box(const BoxKey& key) {
    if (key.level < 0 || key.level >= kLevels)
        throw util::Error("make the box " + to_string(key) + ": its level; allowed: 0 to " +
                          std::to_string(kLevels - 1));
    if (key.by != 0 || column(key.level, key.bx, key.bz).empty())
        return nullptr;
    const auto file = file_of(key);
    if (const auto bytes = read_bytes(file)) {
        try {
            return bytes->empty() ? nullptr : Box::from_blob(*bytes, file.string());
        } catch (const util::Error&) {  // cut off or damaged: made again
        }
    }
    auto made = make(key);
    util::AtomicFile out(file);
    std::ofstream stream(out.temporary_path(), std::ios::binary);
    if (made)
        stream.write(reinterpret_cast<const char*>(made->blob().data()),
                     static_cast<std::streamsize>(made->blob().size()));
    stream.close();
    if (!stream)
        throw util::Error("keep the box " + to_string(key) + " as " + file.string() +
                          ": writing failed");
    out.commit(util::AtomicFile::Flush::kNo);
    return made;
}

std::shared_ptr<const Box> ScaleWorld::make(const BoxKey& key) {
    ++m_made;
    if (key.level == 0)
        return make_finest(key);
    std::array<std::shared_ptr<const Box>, 8> children;
    for (int i = 0; i < 4; ++i)
        children[static_cast<std::size_t>(i)] =
            box({key.level - 1, 2 * key.bx + (i & 1), 0, 2 * key.bz + (i >> 1)});
    return voxel::downsample(key, children);
}

std::shared_ptr<const Box> ScaleWorld::make_finest(const BoxKey& key) const {
    const std::int32_t x0 = key.bx * voxel::kBoxSizeX;
    const std::int32_t z0 = key.bz * voxel::kBoxSizeZ;
    const auto columns = m_land.columns(x0 - 1, z0 - 1, kSideWithMargin);
    const auto at = [&](int x, int z) -> const LandColumn& {
        return columns[static_cast<std::size_t>((z + 1) * kSideWithMargin + x + 1)];
    };
    voxel::BoxBuilder builder;
    for (int z = -1; z <= voxel::kBoxSizeZ; ++z)
        for (int x = -1; x <= voxel::kBoxSizeX; ++x)
            if (inside(x0 + x, z0 + z))
                add_column(builder, x, z, at(x, z));
    return builder.build(key, [&](int x, int y, int z) {
        return look_at(at(x, z), y,
                       place_hash(kSeed + 1 + static_cast<std::uint64_t>(y), x0 + x, z0 + z));
    });
}

ScaleWorld::Prepared ScaleWorld::prepare(int threads,
                                         const std::function<void(const std::string&)>& said) {
    Prepared out;
    const std::size_t made_before = m_made;
    for (int level = 0; level < kLevels; ++level) {
        const auto range = boxes_over(m_info.bounds, level);
        const auto width = static_cast<std::size_t>(range.max.bx - range.min.bx);
        const auto count = width * static_cast<std::size_t>(range.max.bz - range.min.bz);
        std::atomic<std::size_t> bytes{0};
        std::atomic<std::size_t> done{0};
        thread::parallel_for(count, threads, [&](std::size_t i) {
            const BoxKey key{level, range.min.bx + static_cast<std::int32_t>(i % width), 0,
                             range.min.bz + static_cast<std::int32_t>(i / width)};
            std::error_code missing;
            const std::size_t kept = std::filesystem::file_size(file_of(key), missing);
            if (!missing)
                bytes += kept;
            else if (const auto made = box(key))
                bytes += made->blob().size();
            if (const std::size_t ended = ++done; ended % 1000 == 0)
                said(m_info.title + ": level " + std::to_string(level) + ", " +
                     std::to_string(ended) + " of " + std::to_string(count) + " boxes");
        });
        out.boxes[level] = count;
        out.bytes[level] = bytes;
    }
    out.made = m_made - made_before;
    return out;
}

}  // namespace terravox::bench
