#include "tests/bench/entries/neutral_scene.hpp"

#include <fstream>
#include <map>
#include <tuple>

#include "common/util/error.hpp"
#include "common/voxel/box_builder.hpp"

namespace terravox::bench {
namespace {

using voxel::Box;
using voxel::BoxKey;
using voxel::Material;

Material material_of(std::uint8_t code) noexcept {
    switch (code) {
        case 5: return Material::kHighVegetation;
        case 6: return Material::kRoof;
        case 9: return Material::kWater;
        default: return Material::kGround;
    }
}

std::shared_ptr<const Box> build_box(const NeutralScene& scene, const BoxKey& key) {
    const int x0 = key.bx * voxel::kBoxSizeX, z0 = key.bz * voxel::kBoxSizeZ;
    voxel::BoxBuilder builder;
    for (int z = -1; z <= voxel::kBoxSizeZ; ++z)
        for (int x = -1; x <= voxel::kBoxSizeX; ++x)
            for (int y = 0, end = 0; y < NeutralScene::kHeight; y = end) {
                const std::uint8_t code = scene.at(x0 + x, y, z0 + z);
                for (end = y + 1; end < NeutralScene::kHeight && scene.at(x0 + x, end, z0 + z) == code;) ++end;
                if (code != 0) builder.add(x, z, y, end, !see_through(material_of(code)));
            }
    return builder.build(key, [&](int x, int y, int z) {
        voxel::VoxelAttr attr;
        attr.source_class = scene.at(x0 + x, y, z0 + z);
        attr.material = material_of(attr.source_class);
        return attr;
    });
}

class NeutralWorld final : public voxel::World {
public:
    explicit NeutralWorld(const NeutralScene& scene) {
        m_info.title = "neutral scene";
        m_info.bounds = NeutralScene::bounds();
        for (std::int32_t bx = 0; bx < NeutralScene::kSide / voxel::kBoxSizeX; ++bx)
            for (std::int32_t bz = 0; bz < NeutralScene::kSide / voxel::kBoxSizeZ; ++bz)
                m_boxes[{0, bx, 0, bz}] = build_box(scene, {0, bx, 0, bz});
    }
    [[nodiscard]] const voxel::WorldInfo& info() const noexcept override { return m_info; }
    [[nodiscard]] std::shared_ptr<const Box> box(const BoxKey& key) override {
        const auto found = m_boxes.find(key);
        return found == m_boxes.end() ? nullptr : found->second;
    }
    [[nodiscard]] voxel::ColumnExtent column(int level, std::int32_t bx, std::int32_t bz) override {
        return m_boxes.contains({level, bx, 0, bz}) ? voxel::ColumnExtent{0, 1} : voxel::ColumnExtent{};
    }

private:
    voxel::WorldInfo m_info;
    std::map<BoxKey, std::shared_ptr<const Box>> m_boxes;
};

std::filesystem::path script_of(const Context& c) { return c.data.parent_path() / "bench" / "voxel_scene.py"; }

/// The first Python that has NumPy; empty without one. A Python of one's own in PATH often lacks what the system's has.
std::string python_with_numpy(const Context& c) {
    for (const char* python : {"python3", "/usr/bin/python3"})
        if (c.children.run({python, "-c", "import numpy"}, c.scratch / "numpy.txt").exit_code == 0) return python;
    return {};
}

VoxelCoord in_front_of(const Hit& hit) noexcept {
    std::int32_t v[3] = {hit.voxel.x, hit.voxel.y, hit.voxel.z};
    if (hit.face != Face::kNone) v[axis_of(hit.face)] += sign_of(hit.face);
    return {v[0], v[1], v[2]};
}

}  // namespace

std::string NeutralScene::missing(const Context& c) {
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(script_of(c), ignored)) return "no " + script_of(c).string() + " beside the data (--data)";
    return python_with_numpy(c).empty() ? "no Python with NumPy (Debian package python3-numpy)" : "";
}

NeutralScene::NeutralScene(const Context& c) : m_voxels(std::size_t{kSide} * kSide * kHeight) {
    const auto raw = c.scratch / "neutral.raw", said = c.scratch / "neutral.txt";
    if (!std::filesystem::exists(raw)) {
        const auto outcome =
            c.children.run({python_with_numpy(c), script_of(c).string(), std::to_string(kSide), std::to_string(kSeed), raw.string()}, said);
        if (outcome.exit_code != 0)
            throw Error("make the neutral scene: exit code " + std::to_string(outcome.exit_code) + ": " + last_line(said));
    }
    std::ifstream file(raw, std::ios::binary);
    if (!file.read(reinterpret_cast<char*>(m_voxels.data()), static_cast<std::streamsize>(m_voxels.size())) ||
        file.peek() != std::ifstream::traits_type::eof())
        throw Error("read the neutral scene " + raw.string() + ": not " + std::to_string(m_voxels.size()) + " bytes");
}

std::unique_ptr<voxel::World> NeutralScene::make_world() const { return std::make_unique<NeutralWorld>(*this); }

std::array<NamedCamera, 3> neutral_cameras() {
    constexpr double kN = NeutralScene::kSide;
    constexpr int kW = NeutralScene::kWidthPx, kH = NeutralScene::kHeightPx;
    return {NamedCamera{"bird", Camera({kN * 0.5, 500, -200}, {kN * 0.5, 60, kN * 0.45}, 40, kW, kH)},
            NamedCamera{"oblique", Camera({kN * 0.1, 220, kN * 0.1}, {kN * 0.6, 60, kN * 0.6}, 60, kW, kH)},
            NamedCamera{"ground", Camera({kN * 0.5, 190, kN * 0.5}, {kN * 0.9, 150, kN * 0.8}, 70, kW, kH)}};
}

Vec3 neutral_sun() noexcept { return normalized({0.5, 0.7, 0.3}); }

ViewTimes walk_view(BlockReader& reader, const Camera& camera) {
    constexpr int kW = NeutralScene::kWidthPx, kH = NeutralScene::kHeightPx;
    Walker walker(reader, NeutralScene::bounds());
    std::vector<std::optional<Hit>> hits(std::size_t{kW} * kH);
    ViewTimes out;
    out.primary_s = seconds_of([&] {
        for (int y = 0; y < kH; ++y)
            for (int x = 0; x < kW; ++x) hits[static_cast<std::size_t>(y * kW + x)] = walker.first_hit(camera.ray(x + 0.5, y + 0.5));
    });
    out.primary_steps = walker.steps();
    const Vec3 sun = neutral_sun();
    out.shadow_s = seconds_of([&] {
        for (int y = 0; y < kH; ++y)
            for (int x = 0; x < kW; ++x) {
                const auto& hit = hits[static_cast<std::size_t>(y * kW + x)];
                if (!hit) continue;
                ++out.hits;
                const Ray ray = camera.ray(x + 0.5, y + 0.5);
                if (walker.first_hit_from({ray.origin + ray.direction * hit->t, sun}, in_front_of(*hit))) ++out.shadowed;
            }
    });
    return out;
}

}  // namespace terravox::bench
